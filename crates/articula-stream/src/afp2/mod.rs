//! AFP-2: face animations within a tolerance, in the units of [`abp2`](crate::abp2).
//!
//! The form is described in `docs/formats/afp2.md`. The facial animation parameters (FAP) are coded as
//! the weights of morph targets are: in units of one group, the parameters of one level of articulation
//! and region of the face, and one tier of tolerance. Dropping units leaves a valid stream
//! ([`motion_map`](crate::abp2::motion_map), [`crate::cut()`]), in which the parameters that are gone
//! copy others or are neutral, as the table of levels says. Any prefix of a stream decodes.
//!
//! - [`write()`], [`Afp2Options`]: a clip within a tolerance in metres of feature points
//! - [`read`], [`FaceReceiver`]: decodes what has arrived
//!
//! ```
//! use articula_stream::afp2::{Afp2Options, read, write};
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
//!     frames: (0..30).map(|i| frame(30 * i)).collect(),
//! };
//! let coded = write(&clip, &Afp2Options::default())?;
//!
//! // At the level very low one eyelid is sent, which the other copies.
//! let coarse = CutRule::default().at_most("face_loa", 0);
//! let cut = cut(&coded.bytes, &coded.unit, |unit| coarse.keeps(unit))?;
//! let read = read(&cut.bytes, &FaceReadOptions::default(), &StreamLimits::default())?;
//! assert_eq!((read.coded[19 - 1], read.coded[20 - 1]), (false, true));
//! // A unit of an eyelid is 8 µm on an average face, the tolerance 0.1 mm.
//! assert!((read.clip.frames[9].low[19 - 3] - 270).abs() <= 13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod points;
mod receiver;
mod write;

pub use receiver::{FaceReceiver, read};
pub use write::{Afp2Options, write};
