//! Errors of a clip by the metric of the thesis, with weights that files do not store.

use super::Publisher;
use super::evaluate::weight;
use crate::error::{Fault, Result};
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Figure;
use articula::build::evaluate::{ThesisMetricOptions, error_matrix_with};
use serde::Deserialize;
use wasm_bindgen::prelude::*;

/// Options of `errorMatrix`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct ErrorMatrixOptions {
    clip: Option<String>,
    beta: Option<f32>,
}

#[wasm_bindgen]
impl Publisher {
    /// The error matrix of a clip: for each of its keys the normalised error of each joint, as `Figure.setErrors` takes
    /// it. `options` is JSON: `{clip?: string, beta?: number}`; without a clip the first, and beta weighs orientation
    /// against angular velocity, 0 to 1, without it as files store it.
    #[wasm_bindgen(js_name = errorMatrix)]
    pub fn error_matrix(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<f32>, JsValue> {
        let options: ErrorMatrixOptions = read(options.as_deref())?;
        let usual = ThesisMetricOptions::default();
        let beta = weight(options.beta)?.unwrap_or(usual.beta);
        let weights = ThesisMetricOptions { beta, ..usual };
        let found = run(progress, name, |_| {
            let figure = Figure::new(open_alone(bytes, name)?)?;
            let clip = figure.clip(options.clip.as_deref())?;
            Ok(clip.map(|clip| {
                let asset = &figure.asset;
                let matrix = error_matrix_with(asset, &asset.clips[clip], &weights);
                let frames = 0..matrix.frames();
                frames
                    .flat_map(|frame| matrix.frame(frame).to_vec())
                    .collect()
            }))
        })?;
        let none = || Fault::argument(format!("{name}: the file has no clip"));
        found.ok_or_else(|| none().into())
    }
}
