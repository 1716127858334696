//! Characters in fewer bytes.

use super::Publisher;
use super::measured::MeasuredFile;
use crate::error::{Fault, Result};
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::optimize::{
    Compression, ErrorBound, OptimizeOptions, TextureFormat, TextureOptions, optimize,
};
use serde::Deserialize;
use wasm_bindgen::prelude::*;

/// Extension of compressed arrays.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Compress {
    #[default]
    Ext,
    Khr,
    Quantize,
    None,
}

/// Options of `optimize`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Optimize {
    error_px: Option<f32>,
    error_mm: Option<f32>,
    compress: Compress,
    keep_keys: bool,
    keep_triangles: bool,
    keep_textures: bool,
    keep_attributes: bool,
}

impl Optimize {
    fn options(&self) -> Result<OptimizeOptions> {
        let usual = OptimizeOptions::default();
        let error = match (self.error_px, self.error_mm) {
            (Some(_), Some(_)) => {
                let what = "give errorPx or errorMm, not both";
                return Err(Fault::argument(what.to_owned()));
            }
            (Some(px), None) => ErrorBound::Pixels {
                px,
                height_px: 720.0,
            },
            (None, Some(mm)) => ErrorBound::Metres(1e-3 * mm),
            (None, None) => usual.error,
        };
        Ok(OptimizeOptions {
            error,
            compression: match self.compress {
                Compress::Ext => Compression::Ext,
                Compress::Khr => Compression::Khr,
                Compress::Quantize => Compression::Quantized,
                Compress::None => Compression::None,
            },
            reduce_keys: !self.keep_keys,
            simplify: !self.keep_triangles,
            keep_attributes: self.keep_attributes,
            textures: TextureOptions {
                format: match self.keep_textures {
                    true => TextureFormat::Keep,
                    false => TextureFormat::default(),
                },
                ..TextureOptions::default()
            },
            ..usual
        })
    }
}

#[wasm_bindgen]
impl Publisher {
    /// Writes a character in fewer bytes, at an error in motion that is measured on what is written. `options` is
    /// JSON: `{errorPx?: number, errorMm?: number, compress?: string, keepKeys?: boolean,
    /// keepTriangles?: boolean, keepTextures?: boolean, keepAttributes?: boolean}`: pixels of a picture of 720 lines that the figure at rest fills (1 if left out) or millimetres; "ext", "khr",
    /// "quantize" or "none". A GLB that cannot be made smaller comes back as it is. The report is that of `articula optimize --json`.
    pub fn optimize(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<MeasuredFile, JsValue> {
        let options = read::<Optimize>(options.as_deref())?.options()?;
        let made = run(progress, name, |work| {
            optimize(&open_alone(bytes, name)?, &options, work)
        })?;
        let made = made.or_source(bytes);
        Ok(MeasuredFile::new(made.glb, &made.report, name)?)
    }
}
