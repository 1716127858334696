//! Preparation and conversion: for a worker, so that the page goes on.

mod options;

use crate::error::Fault;
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::convert::write;
use articula::inspect::inspect;
use articula::{Figure, Format, convert, prepare};
use wasm_bindgen::prelude::*;

/// Long operations on characters of all formats: files go in as bytes and come out as bytes. Each may take seconds;
/// call them in a worker.
///
/// All throw an `ArticulaError` for files that cannot be read, for options that they do not know, and with the code
/// "cancelled" when `progress` returns `false`.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Tools {}

#[wasm_bindgen]
impl Tools {
    /// Computes what crowds and figures of a character read, and returns it as a GLB file with it. `options` is
    /// JSON: `{meshLevels?: number}`, 1 to 16; 1 makes none. Without it the asset has the mesh levels of the file or, if it has
    /// none, those that crowds are shown with.
    pub fn prepare(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        let options = read::<options::Prepare>(options.as_deref())?.options()?;
        run(progress, name, |work| {
            Ok(prepare(open_alone(bytes, name)?, &options, work)?.glb)
        })
    }

    /// Converts a character to another format, named by its ending: "glb", "bvh", "x3d" and others. `options` is
    /// JSON: `{clip?: string, loa?: string, passive?: "hold" | "rest" | "key-pose"}`, the one clip to keep, an expression
    /// of the joints that keep their motion, and the pose of the others.
    pub fn convert(
        bytes: &[u8],
        name: &str,
        to: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        let options = read::<options::Convert>(options.as_deref())?.options()?;
        let format = Format::of_extension(to).ok_or_else(|| {
            Fault::argument(format!(
                "there is no format \"{to}\"; give an ending such as \"glb\""
            ))
        })?;
        run(progress, name, |work| {
            let made = convert(open_alone(bytes, name)?, format, &options, work)?;
            Ok(made.written.bytes)
        })
    }

    /// Adds the clips of another file to a character, retargeted if the skeletons differ, and returns it as a GLB or
    /// VRM file. `options` is JSON: `{clip?: string, keepOwn?: boolean, prefix?: string}`.
    #[wasm_bindgen(js_name = addClips)]
    pub fn add_clips(
        bytes: &[u8],
        name: &str,
        motion: &[u8],
        #[wasm_bindgen(js_name = motionName)] motion_name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<u8>, JsValue> {
        let options = read::<options::AddClips>(options.as_deref())?.options();
        run(progress, name, |work| {
            let mut character = open_alone(bytes, name)?;
            let motion = open_alone(motion, motion_name)?;
            character.add_clips(&[motion], &options, work)?;
            let format = match character.format() {
                Format::Vrm => Format::Vrm,
                _ => Format::Glb,
            };
            Ok(write(&character, format)?.bytes)
        })
    }

    /// Describes a file as JSON: joints and what they were recognised as, clips, meshes, face, warnings.
    pub fn inspect(bytes: &[u8], name: &str) -> Result<String, JsValue> {
        run(None, name, |work| {
            let figure = Figure::new(open_alone(bytes, name)?)?;
            let clips: Vec<usize> = (0..figure.asset.clips.len()).collect();
            let found = inspect(&figure, &clips, work)?;
            serde_json::to_string(&found).map_err(|error| articula::Error::Write(Box::new(error)))
        })
    }
}
