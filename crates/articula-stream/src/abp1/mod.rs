//! Body animations in a BBA-style form, profile ABP-1, from which bones can be cut.
//!
//! The units, their order and their lengths are those that the annex of the thesis shows of a stream
//! of bone-based animation; what it does not show is defined in `docs/formats/abp1.md`. It is not
//! the form of ISO/IEC 14496-16.
//!
//! An access unit has 16 frames. In it each bone has a mask, which tells its components, and values
//! that depend on no other bone and no other access unit, so that [`crate::cut()`] can remove both
//! by the map of [`unit()`].
//!
//! - [`Abp1Clip`], [`Bone`], [`BoneTracks`]: the plain form
//! - [`write()`], [`read`]: to bytes and back
//! - [`unit()`]: the map of the bytes
//! - [`write_text`], [`read_text`]: the ASCII twin
//!
//! ```
//! use articula_stream::abp1::{
//!     AbsentBone, Abp1Clip, Abp1Options, Bone, BoneTracks, TrackKind, read, unit, write,
//! };
//! use articula_stream::{CutRule, FrameRate, StreamLimits, cut};
//!
//! let bone = |name: &str, parent, loa| Bone {
//!     name: name.into(),
//!     parent,
//!     center: [0.0, f32::from(loa), 0.0],
//!     loa,
//!     region: 4,
//! };
//! let turn: Vec<_> = (0..40).map(|frame| [0.0, frame as f32 / 40.0, 0.0]).collect();
//! let clip = Abp1Clip {
//!     name: "turn".into(),
//!     bones: vec![bone("root", None, 0), bone("spine", Some(0), 3)],
//!     rate: FrameRate::nearest(25.0).ok_or("25 Hz")?,
//!     frames: turn.len(),
//!     tracks: vec![BoneTracks::default().with(TrackKind::Rotation, turn); 2],
//! };
//! let bytes = write(&clip, &Abp1Options::default())?;
//!
//! let limits = StreamLimits::default();
//! let coarse = CutRule::default().at_most("loa", 2);
//! let cut = cut(&bytes, &unit(&bytes, &limits)?, |unit| coarse.keeps(unit))?;
//! let read = read(&cut.bytes, AbsentBone::Rest, &limits)?;
//! assert_eq!(read.frames, 40);
//! assert!(read.tracks[0].get(TrackKind::Rotation).is_some());
//! assert!(read.tracks[1].get(TrackKind::Rotation).is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod access_unit;
mod clip;
mod head;
mod read;
mod text;
mod write;

pub use clip::{Abp1Clip, Bone, BoneTracks, Track, TrackKind};
pub(crate) use read::frames_of;
pub use read::{AbsentBone, read, unit};
pub use text::{read_text, write_text};
pub use write::{Abp1Options, write};
