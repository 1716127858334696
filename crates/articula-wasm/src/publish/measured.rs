//! A moving picture with what it costs and shows.

use super::{Publisher, flattened};
use crate::error::Fault;
use crate::progress::ProgressCallback;
use wasm_bindgen::prelude::*;

/// A moving picture, and its report.
#[wasm_bindgen]
#[derive(Debug)]
pub struct MeasuredPicture {
    bytes: Vec<u8>,
    report: String,
}

#[wasm_bindgen]
impl MeasuredPicture {
    /// The file, copied.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> Vec<u8> {
        self.bytes.clone()
    }

    /// Sizes, errors and settings as JSON, as `articula flatten --json` prints them.
    #[wasm_bindgen(getter)]
    pub fn report(&self) -> String {
        self.report.clone()
    }
}

#[wasm_bindgen]
impl Publisher {
    /// Makes a moving picture as `flatten` does, and measures it.
    #[wasm_bindgen(js_name = flattenMeasured)]
    pub fn flatten_measured(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<MeasuredPicture, JsValue> {
        let (bytes, report) = flattened(bytes, name, options.as_deref(), progress)?;
        let report = serde_json::to_string(&report).map_err(|error| {
            let error = articula::Error::Write(Box::new(error));
            Fault::of_file(&error, name)
        })?;
        Ok(MeasuredPicture { bytes, report })
    }
}
