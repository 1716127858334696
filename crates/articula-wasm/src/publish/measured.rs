//! Files with what they cost and show.

use super::{Publisher, flattened};
use crate::error::Fault;
use crate::progress::ProgressCallback;
use serde::Serialize;
use wasm_bindgen::prelude::*;

/// A file, and the report about it.
#[wasm_bindgen]
#[derive(Debug)]
pub struct MeasuredFile {
    bytes: Vec<u8>,
    report: String,
}

#[wasm_bindgen]
impl MeasuredFile {
    /// The file, copied.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> Vec<u8> {
        self.bytes.clone()
    }

    /// Sizes, errors and settings as JSON, as the command of the program prints them with `--json`.
    #[wasm_bindgen(getter)]
    pub fn report(&self) -> String {
        self.report.clone()
    }
}

impl MeasuredFile {
    pub(super) fn new(bytes: Vec<u8>, report: &impl Serialize, name: &str) -> Result<Self, Fault> {
        let report = serde_json::to_string(report).map_err(|error| {
            let error = articula::Error::Write(Box::new(error));
            Fault::of_file(&error, name)
        })?;
        Ok(Self { bytes, report })
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
    ) -> Result<MeasuredFile, JsValue> {
        let (bytes, report) = flattened(bytes, name, options.as_deref(), progress)?;
        Ok(MeasuredFile::new(bytes, &report, name)?)
    }
}
