//! Portraits: a head as pictures on a 2D mesh.

use super::Publisher;
use super::packaged::PackagedFile;
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Figure;
use articula::core::Viewport;
use articula::flat::portrait::{PageOptions, PictureFormat, PortraitOptions, page};
use articula::flatten::{PortraitReport, PortraitShot, portrait, portrait_errors};
use serde::Deserialize;
use wasm_bindgen::prelude::*;

/// The picture that `articula flatten` makes.
const SIZE_PX: f32 = 400.0;
const FOV_DEG: f32 = 25.0;

/// Name of the page among the files, and of the report about it.
const PAGE: &str = "portrait.html";
const REPORT: &str = "report.json";

/// Options of `portrait`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Options {
    clip: Option<String>,
    triangles: Option<usize>,
}

#[wasm_bindgen]
impl Publisher {
    /// Makes a portrait, a head in 2D that turns and speaks. The files are "portrait.html", which is a page of its own,
    /// what is in it ("portrait.json", "view0.webp" and further, "player.js"), and "report.json", sizes and errors of
    /// the page as `articula flatten --json` tells them. `options` is JSON: `{clip?: string, triangles?: number}`;
    /// without a clip the first.
    pub fn portrait(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<Vec<PackagedFile>, JsValue> {
        let options: Options = read(options.as_deref())?;
        let files = run(progress, name, |work| {
            let figure = Figure::new(open_alone(bytes, name)?)?;
            let shot = options.shot(&figure)?;
            let (head, made) = portrait(&figure, &shot, work)?;
            let title = made.clips.first().map(|clip| clip.name.clone());
            let page = page(
                &made,
                &PageOptions {
                    title: title.map_or_else(|| name.to_owned(), |clip| format!("{name}: {clip}")),
                    controls: true,
                    ..PageOptions::default()
                },
            )?;
            let written = [(PAGE.to_owned(), page.into_bytes())];
            let error = portrait_errors(&made, &head, &shot.options, work)?;
            let report = PortraitReport::new(
                PAGE.to_owned(),
                &made,
                &head,
                &written,
                error,
                &shot.options,
            )?;
            let report = serde_json::to_vec(&report)
                .map_err(|error| articula::Error::Write(Box::new(error)))?;
            let mut files = made.to_files(PictureFormat::WebP)?;
            files.extend(written);
            files.push((REPORT.to_owned(), report));
            Ok(files)
        })?;
        Ok(files.into_iter().map(PackagedFile::new).collect())
    }
}

impl Options {
    fn shot(&self, figure: &Figure) -> articula::Result<PortraitShot> {
        let options = PortraitOptions::default();
        Ok(PortraitShot {
            clip: figure.clip(self.clip.as_deref())?,
            triangles: self.triangles,
            viewport: Viewport {
                width_px: SIZE_PX,
                height_px: SIZE_PX,
                fov_y_radians: FOV_DEG.to_radians(),
            },
            default_mouth: true,
            // Three views do not show a head from above.
            options: PortraitOptions {
                pitch_limit_degrees: 10.0,
                ..options
            },
        })
    }
}
