//! Vector graphics, still and moving: what is written, and what reads it back.
//!
//! Source: thesis 4.2, `spec/vector.md` 7 to 11.
//!
//! - [`keyed_clip`]: shapes with keys, what the key-framed writers take
//! - [`path`]: the shortest text for outlines, numbers, colours and ids
//! - [`raster`]: still SVG to pixels

pub mod keyed_clip;
pub mod path;
pub mod raster;

pub use keyed_clip::{KeyedClip, KeyedPaint, KeyedShape, KeyedTrack};
