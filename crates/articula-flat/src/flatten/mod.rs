//! One call from a planar clip to a file with its size and error; with a byte budget, the best
//! setting that fits.
//!
//! Source: `docs/methods/vector.md` 1, 4 and 9.
//!
//! - [`PreparedClip`]: what is drawn, in which order, and what that leaves wrong, worked out once
//! - [`Settings`]: a [`Profile`], and how near to the truth it comes ([`Quality`])
//! - [`ReferenceFrames`]: what the character really looks like
//! - [`flatten()`]: the best setting of a ladder under a byte budget; [`flatten_live`]: a file
//!   that a host drives
//! - [`Flattened`]: bytes, [`Sizes`], [`Errors`], and the [`Representation`] of what can stand for a
//!   character
//!
//! Work that takes a while tells its progress and can be ended ([`articula_core::Progress`]).

mod live;
mod pages;
mod prepared;
mod reference_frames;
mod report;
mod search;
mod settings;
mod written;

pub use live::flatten_live;
pub use prepared::{PrepareClipOptions, PreparedClip};
pub use reference_frames::{ImageError, ReferenceFrames, sampled_frames};
pub use report::{Errors, Representation, Sizes};
pub use search::{Flattened, Trial, flatten};
pub use settings::{Profile, Quality, Settings};
