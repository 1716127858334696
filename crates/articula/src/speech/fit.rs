//! A voice on a character.

use super::spoken::{SpeechOptions, speech_to_capture, speech_to_faps};
use crate::error::{Error, Result};
use crate::face::{FaceRig, FittedFace, fit_capture, fit_face};
use crate::open::CharacterFile;
use articula_speech::VisemeTrack;

/// Makes a face speak: a clip of a character, which is not changed.
///
/// Blend shapes of ARKit get their weights from the table of visemes directly; a face animation
/// table, joints and expressions get the parameters of MPEG-4. `file` names the recording, and the clip.
///
/// # Errors
/// As [`fit_face`]; [`Error::Unsupported`] if the recording is shorter than a frame.
pub fn fit_speech(
    track: &VisemeTrack,
    file: &str,
    character: &CharacterFile,
    options: &SpeechOptions,
) -> Result<FittedFace> {
    if track.frames.is_empty() {
        return Err(Error::unsuited(
            "the recording is shorter than a hundredth of a second",
        ));
    }
    let rig = FaceRig::new(character)?;
    if rig.capture_bridge(character).is_some() {
        return fit_capture(&speech_to_capture(track, options), file, character);
    }
    fit_face(&speech_to_faps(track, file, options), file, character)
}
