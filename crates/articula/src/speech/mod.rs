//! Faces that speak: a voice as the motion of a face.
//!
//! The mouth follows the visemes of a [`VisemeTrack`]: those that [`Recogniser`] hears in a recording, or
//! those of phones whose times are known. Loudness opens it more or less; blinks, brows and head
//! move a little, by a seed.
//!
//! A head with blend shapes of ARKit, visemes or VRM vowels gets their weights directly
//! ([`fit_speech`]); a face animation table, a FAP file or a stream gets parameters
//! ([`speech_to_faps`]). `docs/methods/speech.md` tells the tables and what they are measured by.
//!
//! - `mouth`: blend shapes and parameters of visemes
//! - `gestures`: blinks, brows, head
//! - `spoken`: a voice as a capture of blend shapes, and as parameters
//! - `fit`: a voice on a character

mod fit;
mod gestures;
mod mouth;
mod spoken;

pub use articula_speech::{
    AlignError, PhoneTimesError, Recogniser, Resampler, Sound, SoundError, TimedPhone, Viseme,
    VisemeFrame, VisemeTrack, align, phones_of_ipa, read_phone_times,
};
pub use fit::fit_speech;
pub use spoken::{SpeechOptions, speech_to_capture, speech_to_faps};
