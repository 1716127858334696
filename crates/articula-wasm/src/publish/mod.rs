//! What is made and measured of an opened character: moving pictures, portraits, impostors, streams with their descriptions, digital items, lighter files, motions of its
//! face, evaluation of motion level of detail, what the device can play. For a worker, as `tools`.

mod benchmark;
mod encode;
mod error_matrix;
mod evaluate;
mod face;
mod impostors;
mod measured;
mod optimize;
mod options;
mod packaged;
mod portrait;
mod recording;

use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Figure;
use articula::flat::flatten::PrepareClipOptions;
use articula::flatten::{FlattenReport, FramedCharacter, flatten_within};
use articula::item::package;
use packaged::PackagedFile;
use wasm_bindgen::prelude::*;

/// What is made and measured of a character that is a GLB or VRM file. Each call may take seconds; call it in a worker.
///
/// All throw an `ArticulaError` for files that cannot be read, for options that they do not know, and with the code
/// "cancelled" when `progress` returns `false`.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Publisher {}

#[wasm_bindgen]
impl Publisher {
    /// Makes a moving picture of a clip: an animated SVG ("svg"), a JavaScript module ("player") or Lottie JSON
    /// ("lottie"). `options` is JSON: `{form?: string, clip?: string, yawDeg?: number, triangles?: number, maxBytes?:
    /// number, camera?: {eye: [x, y, z], target: [x, y, z], fovDeg: number}}`; without a clip the first that walks, else
    /// runs, else idles. A clip that travels is shown on the spot, unless a camera is told where to stand, in metres.
    pub fn flatten(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        Ok(flattened(bytes, name, options.as_deref(), progress)?.0)
    }

    /// Packages a character as a digital item, the files of a folder from which a server sends parts. `options` is
    /// JSON: `{meshLevels?: number, clips?: string[], flat?: boolean}`.
    pub fn package(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<PackagedFile>, JsValue> {
        let options = read::<options::Package>(options.as_deref())?.options()?;
        let item = run(progress, name, |work| {
            package(open_alone(bytes, name)?, &options, work)
        })?;
        Ok(item.files().into_iter().map(PackagedFile::new).collect())
    }
}

/// A moving picture of a file, and its report.
fn flattened(
    bytes: &[u8],
    name: &str,
    options: Option<&str>,
    progress: Option<ProgressCallback>,
) -> Result<(Vec<u8>, FlattenReport), JsValue> {
    let options: options::Flatten = read(options)?;
    run(progress, name, |work| {
        let mut opened = open_alone(bytes, name)?;
        if options.is_in_place() {
            opened.put_in_place();
        }
        let figure = Figure::new(opened)?;
        let framed = FramedCharacter::new(&figure, options.shot(&figure)?, work)?;
        let (clip, settings) = (PrepareClipOptions::default(), options.settings(name));
        let (framed, flat) = flatten_within(framed, &clip, &settings, work)?;
        let report = FlattenReport::new(name.to_owned(), &flat, &framed, settings.max_bytes);
        Ok((flat.bytes, report))
    })
}
