//! Progressive streams of virtual humans: coded data of which any prefix is usable, and a
//! codec-independent map of a stream for cutting it.
//!
//! - [`Unit`], [`Marker`], [`Field`], [`Coding`]: which bits of a stream hold what, independent of
//!   the codec; numbers in them can be rewritten
//! - `mesh`: mesh levels as a progressive stream (cargo feature `codecs`, on by default)
//! - [`StreamError`], [`StreamLimits`]: errors, and limits on memory and time
//!
//! A program that only cuts streams disables the feature `codecs` and depends on neither codec nor
//! hash.
//!
//! ```
//! use articula_stream::{Coding, Field, Unit};
//!
//! // A length byte, followed by that number of bytes.
//! let mut stream = vec![3, 10, 20, 30];
//! let unit = Unit {
//!     fields: vec![Field {
//!         name: "length".into(),
//!         bits: 0..8,
//!         value: 3,
//!         coding: Coding::LittleEndian,
//!     }],
//!     children: vec![Unit::of_bytes("body", 1..4)],
//!     ..Unit::of_bytes("packet", 0..4)
//! };
//! unit.check()?;
//! unit.check_values(&stream)?;
//! // Removes the body and sets the length to 0.
//! let length = &unit.fields[0];
//! length.coding.write(&mut stream, &length.bits, 0)?;
//! stream.truncate(1);
//! assert_eq!(stream, [0]);
//! # Ok::<(), articula_core::Mismatch>(())
//! ```
//!
//! Level 0 is the finest in every number; the bytes start with the coarsest level.
//!
//! There are no files, sockets, clocks or threads here (bytes in, bytes out), and no decision on
//! what to send. No input causes a panic.

mod coding;
mod error;
mod limits;
#[cfg(feature = "codecs")]
pub mod mesh;
mod unit;

pub use coding::Coding;
pub use error::StreamError;
pub use limits::StreamLimits;
pub use unit::{Field, Marker, Unit};
