//! `articula flatten frame`: one frame of an animated SVG, for renderers that draw only the
//! initial state.

use super::arguments::FrameArgs;
use crate::console::Console;
use crate::{fault, files};
use anyhow::Context;
use articula::flat::vector::AnimatedSvg;
use articula::flat::vector::raster;
use serde::Serialize;
use std::path::Path;

/// Maximum size of an SVG to read in bytes.
pub(super) const MAX_BYTES: u64 = 256 << 20;

#[derive(Debug, Serialize)]
struct Rendered {
    out: String,
    at_secs: f64,
    duration_secs: f64,
    bytes: usize,
}

/// Renders the frame and prints what was written.
pub(super) fn run(args: &FrameArgs, console: &Console) -> anyhow::Result<()> {
    let ending = files::extension(&args.out);
    let is_svg = ending == "svg";
    if !is_svg && ending != "png" {
        let out = files::shown(&args.out);
        return Err(fault::usage(format!("{out}: name the file .png or .svg")));
    }
    let files = &console.files;
    files.plan([args.file.as_path()], [args.out.as_path()])?;
    let moving = read(&args.file)?;
    let place = || files::shown(&args.file);
    let at = f64::from(args.at);
    let text = moving.at(at).with_context(place)?;
    let bytes = if is_svg {
        text.into_bytes()
    } else {
        let picture = raster(&text, args.background.unwrap_or([0; 4])).with_context(place)?;
        picture.to_png().with_context(place)?
    };
    files.write(&args.out, &bytes)?;
    let rendered = Rendered {
        out: files::shown(&args.out),
        at_secs: at,
        duration_secs: moving.duration_secs,
        bytes: bytes.len(),
    };
    console.result(&rendered, |r| {
        format!(
            "{}: frame at {:.3} s of {:.3} s, {:.1} kB\n",
            r.out,
            r.at_secs,
            r.duration_secs,
            r.bytes as f64 / 1e3
        )
    })
}

/// Reads an SVG that `flatten` wrote; errors name the file and the expected input.
pub(super) fn read(path: &Path) -> anyhow::Result<AnimatedSvg> {
    let bytes = files::read(path, MAX_BYTES)?;
    let place = || files::shown(path);
    let text = String::from_utf8(bytes)
        .ok()
        .with_context(|| format!("{}: not text; give an SVG that flatten wrote", place()))?;
    AnimatedSvg::read(&text).with_context(place)
}
