//! Impostors: small pictures of a character for who is far away.

use super::Publisher;
use super::packaged::PackagedFile;
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Figure;
use articula::flat::Light;
use articula::flat::impostor::{ImpostorBound, ImpostorOptions};
use articula::impostor::bake;
use serde::Deserialize;
use wasm_bindgen::prelude::*;

/// Names of the files.
const ATLAS: &str = "impostors.png";
const TABLE: &str = "impostors.json";

/// Options of `impostors`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Options {
    clips: Vec<String>,
    max_bytes: Option<usize>,
    pitches_deg: Option<[f32; 2]>,
    unlit: bool,
}

#[wasm_bindgen]
impl Publisher {
    /// Bakes impostors, pictures of every pose from directions all around: "impostors.json", the table that crowds
    /// take, and "impostors.png" (`docs/formats/impostor.md`). `options` is JSON: `{clips?: string[], maxBytes?: number,
    /// pitchesDeg?: [number, number], unlit?: boolean}`; all clips without names, 4 MiB of pixels at most if not told,
    /// eyes from straight below (-90) to straight above (90), and lights that are fixed to the eye.
    pub fn impostors(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<PackagedFile>, JsValue> {
        let options: Options = read(options.as_deref())?;
        let files = run(progress, name, |work| {
            let figure = Figure::new(open_alone(bytes, name)?)?;
            let names = options.clips.iter();
            let clips = names.map(|clip| Ok(figure.clip(Some(clip))?.into_iter()));
            let clips: Vec<_> = clips.collect::<articula::Result<_>>()?;
            let clips: Vec<usize> = clips.into_iter().flatten().collect();
            let baked = bake(&figure, &clips, &options.settings(), work)?;
            let table = baked.plan.to_json(ATLAS).into_bytes();
            let atlas = baked.atlas.to_png()?;
            Ok([(TABLE.to_owned(), table), (ATLAS.to_owned(), atlas)])
        })?;
        Ok(files.into_iter().map(PackagedFile::new).collect())
    }
}

impl Options {
    fn settings(&self) -> ImpostorOptions {
        let usual = ImpostorOptions::default();
        let unlit = Light {
            key: 0.0,
            fill: 0.0,
            ambient: 1.0,
            ..usual.light
        };
        ImpostorOptions {
            bound: self.max_bytes.map_or(usual.bound, ImpostorBound::Bytes),
            pitches_radians: match self.pitches_deg {
                Some(degrees) => degrees.map(f32::to_radians),
                None => usual.pitches_radians,
            },
            light: if self.unlit { unlit } else { usual.light },
        }
    }
}
