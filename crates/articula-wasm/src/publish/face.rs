//! Motions of faces, moved to the face of a character.

use super::Publisher;
use crate::error::Fault;
use crate::opening::{open_alone, open_options};
use crate::progress::{ProgressCallback, run};
use articula::convert::write;
use articula::face::{FittedFace, add_face_shapes, fit_motion};
use articula::speech::{Sound, SpeechOptions, VisemeTrack, fit_speech};
use articula::{CharacterFile, DataFormat, Format, open_data};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Publisher {
    /// Adds a motion of a face to a character, and returns it as a GLB or VRM file: facial animation parameters
    /// (.fap, .afp, .fba) or a capture of Live Link Face (.csv). A character without morph targets and expressions
    /// is given blend shapes, made from its feature points.
    #[wasm_bindgen(js_name = addFaceClip)]
    pub fn add_face_clip(
        bytes: &[u8],
        name: &str,
        motion: &[u8],
        #[wasm_bindgen(js_name = motionName)] motion_name: &str,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        let format = DataFormat::from_name(motion_name).filter(|f| f.animates_a_face());
        let Some(format) = format else {
            let what = "motions of faces are .fap, .afp, .fba and .csv files";
            return Err(Fault::argument(format!("{motion_name}: {what}")).into());
        };
        with_face_clip(bytes, name, progress, |character| {
            let read = open_data(motion, motion_name, format, &open_options())?;
            fit_motion(&read.data, motion_name, character)
        })
    }

    /// Adds what a face does while it speaks a recording, a WAV file of one voice, and returns the character as a GLB
    /// or VRM file. Faces without blend shapes are given some, as by `addFaceClip`.
    #[wasm_bindgen(js_name = addVoice)]
    pub fn add_voice(
        bytes: &[u8],
        name: &str,
        voice: &[u8],
        #[wasm_bindgen(js_name = voiceName)] voice_name: &str,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        let sound = Sound::from_wav(voice)
            .map_err(|error| Fault::invalid(voice_name, &error.to_string()))?;
        with_face_clip(bytes, name, progress, |character| {
            let track = VisemeTrack::recognised(&sound);
            fit_speech(&track, voice_name, character, &SpeechOptions::default())
        })
    }
}

/// The file of a character with one more clip, after it has been given a face if it has none.
fn with_face_clip(
    bytes: &[u8],
    name: &str,
    progress: Option<ProgressCallback>,
    fit: impl FnOnce(&CharacterFile) -> articula::Result<FittedFace>,
) -> Result<Vec<u8>, JsValue> {
    run(progress, name, |_| {
        let mut character = open_alone(bytes, name)?;
        if !has_face(&character) {
            add_face_shapes(&mut character, &[])?;
        }
        let fitted = fit(&character)?;
        character.put_clips(vec![fitted.fitted], true);
        write_as(&character)
    })
}

fn has_face(character: &CharacterFile) -> bool {
    let character = character.character();
    let mut primitives = character.meshes.iter().flat_map(|mesh| &mesh.primitives);
    !character.expressions.is_empty() || primitives.any(|p| !p.morphs.is_empty())
}

pub(super) fn write_as(character: &CharacterFile) -> articula::Result<Vec<u8>> {
    let format = match character.format() {
        Format::Vrm => Format::Vrm,
        _ => Format::Glb,
    };
    Ok(write(character, format)?.bytes)
}
