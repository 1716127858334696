//! MP4 files (ISO base media file format, ISO/IEC 14496-12) around streams of animations.
//!
//! Each stream is a track of timed metadata: its access units are the samples, its head is the
//! initialisation data of the sample entry, and a URI says which stream it is. A box of ours has checksums
//! of the file. The form, and why it was
//! chosen, are described in `docs/formats/mp4.md`.
//!
//! - [`write()`]: streams to a file, each its own track
//! - [`read`], [`Mp4Track`]: the tracks of a file, and the streams in them
//!
//! ```
//! use articula_stream::afp1::{Afp1Options, write};
//! use articula_stream::{FaceClip, FaceFrame, FrameRate, StreamKind, StreamLimits, mp4};
//!
//! let clip = FaceClip {
//!     name: "still".into(),
//!     bridge: None,
//!     rate: FrameRate::nearest(25.0).ok_or("25 Hz")?,
//!     frames: vec![FaceFrame::NEUTRAL; 30],
//! };
//! let stream = write(&clip, &Afp1Options::default())?;
//! let limits = StreamLimits::default();
//! let file = mp4::write(&[&stream], &limits)?;
//! let tracks = mp4::read(&file, &limits)?;
//! assert_eq!(tracks[0].kind, Some(StreamKind::Afp1));
//! // 16 frames and 14 frames.
//! assert_eq!((tracks[0].samples, tracks[0].secs()), (2, 1.2));
//! assert_eq!(tracks[0].stream(&file)?, stream);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod checksums;
mod read;
mod samples;
mod urim;
mod write;

pub use read::{Mp4Track, is_mp4, read};
pub use write::write;
