//! How a virtual human travels: what is coded so that any prefix shows something, and the map of
//! a coded stream that a cut reads.
//!
//! - [`Unit`], [`Marker`], [`Field`], [`Coding`]: which bits of a stream are what, without knowing
//!   its codec; a number in them can be written anew
//! - `mesh`: mesh levels as a stream that refines (the cargo feature `codecs`, on by default)
//! - [`StreamError`], [`StreamLimits`]: what can be wrong, and how much is too much
//!
//! A program that only cuts streams leaves the feature `codecs` out: then there is neither a codec
//! nor a hash in it.
//!
//! ```
//! use articula_stream::{Coding, Field, Unit};
//!
//! // A length of one byte, then so many bytes.
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
//! // Without its body, the packet says that it has none.
//! let length = &unit.fields[0];
//! length.coding.write(&mut stream, &length.bits, 0)?;
//! stream.truncate(1);
//! assert_eq!(stream, [0]);
//! # Ok::<(), articula_core::Mismatch>(())
//! ```
//!
//! Level 0 is the finest in every number here; the bytes come coarsest level first.
//!
//! What is deliberately absent: files, sockets, clocks and threads (bytes come in and go out), and
//! any choice of what to send; nothing here panics for any bytes.

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
