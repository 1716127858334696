//! What was shown, as a clip.

use super::Publisher;
use super::face::write_as;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Recording;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Publisher {
    /// Adds what a figure of the character showed as a clip, in place of one of the same name, and returns it as a GLB or
    /// VRM file. `times` are those of the frames in seconds, from 0 on; `joints` has for each frame the matrix of
    /// each joint in model space, three rows of four numbers; `morphs` has for each frame the weights of all morph
    /// targets. A camera that moves is told as if the figure moved before it.
    #[wasm_bindgen(js_name = addRecording)]
    #[expect(
        clippy::too_many_arguments,
        reason = "arrays of JavaScript cannot be fields of an object that is read as JSON"
    )]
    pub fn add_recording(
        bytes: &[u8],
        name: &str,
        clip: &str,
        times: Vec<f32>,
        joints: Vec<f32>,
        morphs: Vec<f32>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        run(progress, name, |_| {
            let mut character = open_alone(bytes, name)?;
            character.put_recording(&Recording {
                name: clip.to_owned(),
                times_secs: times,
                joints,
                morphs,
            })?;
            write_as(&character)
        })
    }
}
