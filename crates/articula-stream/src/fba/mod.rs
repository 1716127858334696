//! Face animations as MPEG-4's binary stream of face and body animation (FBA), predictive mode, for
//! interchange with other programs.
//!
//! The form, and what is unclear in it, is described in `docs/formats/fba.md`. Frames are differences
//! to the frame before; only intra frames depend on no other. Body data and the transform (DCT) are
//! refused.
//!
//! ```
//! use articula_stream::fba::{FbaClip, FbaFrame, FbaOptions, read, write};
//! use articula_stream::{FaceFrame, FrameRate, StreamLimits};
//!
//! // The jaw opens, FAP 3.
//! let frame = |number| {
//!     let mut face = FaceFrame::NEUTRAL;
//!     face.low[0] = 20 * number as i32;
//!     FbaFrame { number, face }
//! };
//! let mut coded = [false; 68];
//! coded[3 - 1] = true;
//! let clip = FbaClip {
//!     rate: FrameRate::nearest(25.0).ok_or("25 Hz")?,
//!     time_code: None,
//!     coded,
//!     frames: (0..30).map(frame).collect(),
//! };
//! let read = read(&write(&clip, &FbaOptions::default())?, &StreamLimits::default())?;
//! assert_eq!(read.clip, clip);
//! assert_eq!(read.intra_frames, 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod clip;
mod coder;
mod fields;
mod header;
mod model;
mod quantise;
mod ranges;
mod read;
mod slot;
mod write;

pub use clip::{FbaClip, FbaFrame, TimeCode};
pub use read::{Decoded, read};
pub use write::{FbaOptions, write};
