//! gBSD: the description of one stream, of which an adaptation removes units, and from which the
//! adapted stream is written.
//!
//! Form: `docs/formats/gbsd.md`. Source: ISO/IEC 21000-7 (generic bitstream syntax description),
//! thesis 3.1.1 and annex B.

mod adapt;
mod edits;
mod literal;
mod names;
mod parse;
mod parts;
mod selection;
mod stylesheet;
mod to_bin;
mod tree;
mod write;

pub use adapt::{AdaptMode, adapt_gbsd};
pub use selection::Selection;
pub use stylesheet::stylesheet;
pub use to_bin::{Holes, gbsd_to_bin};
pub use tree::{FixedParameter, Gbsd, read_gbsd};
pub use write::{GbsdOptions, write_gbsd};
