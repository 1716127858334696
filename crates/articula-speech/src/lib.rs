//! Visemes from speech: which of 15 mouth shapes a voice makes, a hundred times a second.
//!
//! From a recording or a microphone, by a small network that runs while the sound arrives
//! ([`Recogniser`]); or, where the phones of the speech and their times are known, by rules of
//! coarticulation ([`VisemeTrack::of_phones`]). [`align`] finds these times for known phones.
//!
//! ```
//! use articula_speech::{Recogniser, SAMPLE_RATE_HZ, Viseme};
//!
//! let mut recogniser = Recogniser::new();
//! // A second of silence: 16,000 samples are 100 frames.
//! let mut frames = recogniser.push(&vec![0.0; SAMPLE_RATE_HZ as usize]);
//! frames.extend(recogniser.finish());
//! assert_eq!(frames.len(), 100);
//! assert_eq!(frames[50].strongest(), Viseme::Silence);
//! ```
//!
//! The order of the shapes is that of FAP 1 of MPEG-4 (ISO/IEC 14496-2, annex C) and of OpenXR's
//! `XR_META_face_tracking_visemes`. Method, training and limits: `docs/methods/speech.md`.
//!
//! - `sound`, `resampler`: recordings as samples at 16 kHz
//! - `bands`, `normaliser`: the features of a frame, free of gain and of the channel
//! - `network`: the stored network, frame by frame
//! - `windows`: samples as the bands of a frame
//! - [`training`]: the features and files of weights, for a program that trains a network
//! - `recogniser`: samples in, frames out
//! - `phone`, `phone_times`: phones of the IPA and of ARPAbet, and files of their times
//! - `coarticulation`: phones as weights of visemes
//! - `align`: times of known phones in a recording
//! - `frame`, `track`: the frames of a recording, smoothed

mod align;
mod bands;
mod coarticulation;
mod frame;
mod network;
mod normaliser;
mod phone;
mod phone_times;
mod recogniser;
mod resampler;
mod sound;
mod track;
pub mod training;
mod windows;

pub use align::{AlignError, align};
pub use articula_core::viseme::{VISEME_COUNT, Viseme};
pub use frame::VisemeFrame;
pub use phone::{Phone, phones_of_ipa};
pub use phone_times::{PhoneTimesError, TimedPhone, read_phone_times};
pub use recogniser::{LOOK_AHEAD_SECS, Recogniser};
pub use resampler::Resampler;
pub use sound::{Sound, SoundError};
pub use track::VisemeTrack;

/// Samples a second of what is recognised.
pub const SAMPLE_RATE_HZ: u32 = 16_000;
/// Frames of visemes a second.
pub const FRAME_RATE_HZ: u32 = 100;
/// Samples from one frame to the next.
pub(crate) const HOP: usize = (SAMPLE_RATE_HZ / FRAME_RATE_HZ) as usize;
