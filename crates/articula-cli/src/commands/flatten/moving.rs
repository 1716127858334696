//! `articula flatten movie`: an animated SVG as GIF, WebP or PNG pictures, for software that does
//! not play SVG.

use super::arguments::MovieArgs;
use super::frame;
use crate::console::Console;
use crate::fault;
use crate::files::{self, Files};
use anyhow::Context;
use articula::flat::vector::{self, AnimatedSvg, raster};
use articula::flat::{Picture, PictureError};
use serde::Serialize;

/// Maximum number of frames of a movie.
const MAX_FRAMES: f64 = 5000.0;
/// Maximum number of pixels of all frames together; a gigabyte.
const MAX_PIXELS: u64 = 1 << 28;

#[derive(Debug, Serialize)]
struct Movie {
    out: String,
    frames: usize,
    fps: f64,
    duration_secs: f64,
    bytes: usize,
}

/// Renders all frames and prints what was written.
pub(super) fn run(args: &MovieArgs, console: &Console) -> anyhow::Result<()> {
    check_ending(args)?;
    let single = (!is_folder(args)).then_some(args.out.as_path());
    console.files.plan([args.file.as_path()], single)?;
    let moving = frame::read(&args.file)?;
    let place = || files::shown(&args.file);
    let duration = moving.duration_secs;
    let background = args.background.unwrap_or([255; 4]);
    let moments = pictures(&moving, args.fps, background, &place(), console)?;
    let bytes = write(args, &moments, &console.files)?;
    let movie = Movie {
        out: files::shown(&args.out),
        frames: moments.len(),
        fps: moments.len() as f64 / duration,
        duration_secs: duration,
        bytes,
    };
    console.result(&movie, |m| {
        format!(
            "{}: {} frames, {:.2} s, {:.1} kB\n",
            m.out,
            m.frames,
            m.duration_secs,
            m.bytes as f64 / 1e3
        )
    })
}

/// Draws all frames of an animated SVG of this name, each with its duration in seconds.
pub(super) fn pictures(
    moving: &AnimatedSvg,
    fps: f32,
    background: [u8; 4],
    name: &str,
    console: &Console,
) -> anyhow::Result<Vec<(Picture, f64)>> {
    let duration = moving.duration_secs;
    let steps = (duration * f64::from(fps)).round().max(1.0);
    if steps > MAX_FRAMES {
        let what =
            format!("{steps} frames, at most {MAX_FRAMES} are allowed; lower the frame rate");
        return Err(fault::usage(format!("--fps {fps}: {what}")));
    }
    if duration <= 0.0 {
        let what = "nothing moves in this file; render it with flatten frame";
        anyhow::bail!("{name}: {what}");
    }
    let place = || name.to_owned();
    let bar = console.progress("drawing frames", steps as usize);
    let mut pixels = 0;
    let mut moments: Vec<(Picture, f64)> = Vec::with_capacity(steps as usize);
    // The last frame is left out, since a repeating movie continues with the first.
    for f in 0..steps as u32 {
        let text = moving
            .at(duration * f64::from(f) / steps)
            .with_context(place)?;
        let picture = raster(&text, background).with_context(place)?;
        pixels += u64::from(picture.width()) * u64::from(picture.height());
        if pixels > MAX_PIXELS {
            let what = "more than 268 million pixels in all; lower the frame rate";
            return Err(fault::usage(format!("--fps {fps}: {what}")));
        }
        moments.push((picture, duration / steps));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(moments)
}

/// Encodes pictures as a movie of this extension; `None` if it is that of no movie.
pub(super) fn encoded(
    ending: &str,
    moments: &[(Picture, f64)],
) -> Result<Option<Vec<u8>>, PictureError> {
    Ok(match ending {
        "gif" => Some(vector::gif(moments)?),
        "webp" => Some(vector::webp(moments)?),
        _ => None,
    })
}

/// Refuses a name that is neither a movie nor a folder, before anything is drawn.
fn check_ending(args: &MovieArgs) -> anyhow::Result<()> {
    if ["", "gif", "webp"].contains(&files::extension(&args.out).as_str()) {
        return Ok(());
    }
    let what = "name a .gif or .webp file, or a folder";
    let out = files::shown(&args.out);
    Err(fault::usage(format!("{out}: {what}")))
}

/// Whether the output is a folder of pictures.
fn is_folder(args: &MovieArgs) -> bool {
    args.out.extension().is_none()
}

/// Writes the pictures in the format of the name; returns the total number of bytes.
fn write(args: &MovieArgs, moments: &[(Picture, f64)], files: &Files) -> anyhow::Result<usize> {
    let place = || files::shown(&args.out);
    let movie = encoded(&files::extension(&args.out), moments).with_context(place)?;
    let Some(bytes) = movie else {
        files.make_folder(&args.out)?;
        let name = |f: usize| args.out.join(format!("{f:04}.png"));
        (0..moments.len()).try_for_each(|f| files.check_output(&name(f)))?;
        let mut all = 0;
        for (f, (picture, _)) in moments.iter().enumerate() {
            let bytes = picture.to_png().with_context(place)?;
            files.write(&name(f), &bytes)?;
            all += bytes.len();
        }
        return Ok(all);
    };
    files.write(&args.out, &bytes)?;
    Ok(bytes.len())
}
