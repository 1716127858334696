//! Vector graphics, still and moving: what is written, and what reads it back.
//!
//! Source: thesis 4.2, `spec/vector.md` 7 to 11.
//!
//! - [`keyed_clip`]: shapes with keys, what the key-framed writers take

pub mod keyed_clip;

pub use keyed_clip::{KeyedClip, KeyedPaint, KeyedShape, KeyedTrack};
