//! Motions of faces, moved to the face of a character.

use super::Publisher;
use crate::error::Fault;
use crate::opening::{open_alone, open_options};
use crate::progress::{ProgressCallback, run};
use articula::convert::write;
use articula::face::{add_face_shapes, fit_capture, fit_face};
use articula::{CharacterFile, Data, DataFormat, Format, open_data};
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
        run(progress, name, |_| {
            let mut character = open_alone(bytes, name)?;
            if !has_face(&character) {
                add_face_shapes(&mut character, &[])?;
            }
            let read = open_data(motion, motion_name, format, &open_options())?;
            let fitted = match &read.data {
                Data::LiveLink(capture) => fit_capture(capture, motion_name, &character)?,
                Data::Fap(clip) => fit_face(clip, motion_name, &character)?,
                // Formats that animate no face were refused.
                Data::Epf(_) | Data::Fdp(_) => return write_as(&character),
            };
            character.put_clips(vec![fitted.fitted], true);
            write_as(&character)
        })
    }
}

fn has_face(character: &CharacterFile) -> bool {
    let character = character.character();
    let mut primitives = character.meshes.iter().flat_map(|mesh| &mesh.primitives);
    !character.expressions.is_empty() || primitives.any(|p| !p.morphs.is_empty())
}

fn write_as(character: &CharacterFile) -> articula::Result<Vec<u8>> {
    let format = match character.format() {
        Format::Vrm => Format::Vrm,
        _ => Format::Glb,
    };
    Ok(write(character, format)?.bytes)
}
