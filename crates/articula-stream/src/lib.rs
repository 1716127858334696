//! How a virtual human travels: what is coded so that any prefix shows something, and the map of
//! a coded stream that a cut reads.
//!
//! - [`Unit`], [`Marker`], [`Field`], [`Coding`]: which bits of a stream are what, without knowing
//!   its codec; a number in them can be written anew
//! - `mesh`: mesh levels as a stream that refines
//! - [`StreamError`], [`StreamLimits`]: what can be wrong, and how much is too much
//!
//! Level 0 is the finest in every number here; the bytes come coarsest level first.
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
