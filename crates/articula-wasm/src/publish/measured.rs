//! A moving picture with what it costs and shows.

use super::Publisher;
use super::options::Flatten;
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Figure;
use articula::flat::flatten::PrepareClipOptions;
use articula::flatten::{FlattenReport, FramedCharacter, flatten_within};
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
        let options: Flatten = read(options.as_deref())?;
        run(progress, name, |work| {
            let mut opened = open_alone(bytes, name)?;
            opened.put_in_place();
            let figure = Figure::new(opened)?;
            let framed = FramedCharacter::new(&figure, options.shot(&figure)?, work)?;
            let (clip, settings) = (PrepareClipOptions::default(), options.settings(name));
            let (framed, flat) = flatten_within(framed, &clip, &settings, work)?;
            let report = FlattenReport::new(name.to_owned(), &flat, &framed, settings.max_bytes);
            let report = serde_json::to_string(&report);
            Ok(MeasuredPicture {
                bytes: flat.bytes,
                report: report.map_err(|e| articula::Error::Write(Box::new(e)))?,
            })
        })
    }
}
