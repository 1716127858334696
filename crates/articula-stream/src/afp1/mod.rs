//! Face animations of which single parameters can be cut, profile AFP-1.
//!
//! The form is described in `docs/formats/afp1.md`. An access unit has up to 16 frames. In it each
//! facial animation parameter (FAP) has values that depend on no other parameter and no other access
//! unit, so that [`crate::cut()`] can remove both by the map of [`unit()`]. Parameters that copy others
//! at the level of their region are not written; a reader restores them.
//!
//! - [`write()`], [`read`]: to bytes and back
//! - [`unit()`]: the map of the bytes
//!
//! ```
//! use articula_stream::afp1::{Afp1Options, read, unit, write};
//! use articula_stream::{CutRule, FaceClip, FaceFrame, FaceReadOptions, FrameRate, StreamLimits, cut};
//!
//! // Both upper eyelids, FAP 19 and 20, close.
//! let frame = |value| {
//!     let mut frame = FaceFrame::NEUTRAL;
//!     (frame.low[19 - 3], frame.low[20 - 3]) = (value, value);
//!     frame
//! };
//! let clip = FaceClip {
//!     name: "blink".into(),
//!     bridge: None,
//!     rate: FrameRate::nearest(25.0).ok_or("25 Hz")?,
//!     frames: (0..30).map(|i| frame(10 * i)).collect(),
//! };
//! let bytes = write(&clip, &Afp1Options::default())?;
//!
//! // At the level very low one eyelid is sent, which the other copies.
//! let limits = StreamLimits::default();
//! let coarse = CutRule::default().at_most("loa", 0);
//! let cut = cut(&bytes, &unit(&bytes, &limits)?, |unit| coarse.keeps(unit))?;
//! let read = read(&cut.bytes, &FaceReadOptions::default(), &limits)?;
//! assert_eq!((read.coded[19 - 1], read.coded[20 - 1]), (false, true));
//! assert_eq!(read.clip.frames[9].low[19 - 3], 90);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod access_unit;
mod head;
mod read;
mod write;

pub(crate) use read::frames_of;
pub use read::{read, unit};
pub use write::{Afp1Options, write};
