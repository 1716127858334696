//! `articula flatten --profile portrait`: a face as pictures on a 2D mesh, with its player.

use super::arguments::ConvertArgs;
use super::face;
use crate::console::Console;
use crate::fault;
use crate::files::{self, Files};
use crate::open;
use anyhow::Context;
use articula::Figure;
use articula::core::Progress;
use articula::core::Viewport;
use articula::flat::flatten::{FileSize, Representation};
use articula::flat::portrait::PictureFormat;
use articula::flat::portrait::{EmbeddedFile, PageOptions, page};
use articula::flat::portrait::{HeadPose, Portrait, PortraitError, PortraitOptions, build};
use articula::flatten::{FlatBytes, FramedHead, RepresentationReport, surfaces_shown_otherwise};
use serde::Serialize;
use std::path::Path;

/// Yaw angles of the head at which the portrait is compared with the figure, degrees.
const YAWS_DEG: [f32; 5] = [0.0, 10.0, 20.0, 30.0, 40.0];
/// Error above which eyes and mouths of a portrait fall apart, levels of 0 to 255. Heads that hold together
/// have 4 to 24, those whose eyes do not 36 and more.
const FALLEN_APART_LEVELS: f64 = 30.0;
/// Numbers of triangles that are tried before the greatest, and the error of the front picture with which one is taken,
/// levels of 0 to 255: hair and lips with more are ragged.
const FEWER: [usize; 2] = [1000, 2000];
const MOST: usize = 3000;
const GOOD_LEVELS: f64 = 12.0;
/// Maximum size of an embedded picture or sound in bytes.
const MAX_BYTES: u64 = 64 << 20;

#[derive(Debug, Serialize)]
struct PortraitReport {
    out: String,
    profile: &'static str,
    bytes: FlatBytes,
    views: usize,
    triangles: usize,
    vertices: usize,
    expressions: usize,
    inputs: usize,
    frames: usize,
    size_px: (u32, u32),
    error: Vec<YawError>,
    representation: RepresentationReport,
    written: Vec<String>,
    warnings: Vec<String>,
}

/// Error of the portrait at one yaw angle of the head.
#[derive(Debug, Serialize)]
struct YawError {
    yaw_deg: f32,
    image_rmse_levels: f64,
}

/// Makes the portrait, writes it and reports its error.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let mut opened = open::kept(&console.files, &args.character())?;
    let mut given = face::give(args, &mut opened, console)?;
    if args.special.live {
        face::give_table(&mut opened, &mut given)?;
    }
    let figure = Figure::new(opened)?;
    let place = || figure.opened.name().to_owned();
    let clip = figure.clip(given.clip(args))?;
    let options = options(args)?;
    if clip.is_none() && args.special.audio.is_some() {
        let what = "--audio needs a clip with the motion of the mouth; name one with --clip, or give --motion";
        return Err(fault::usage(what));
    }
    let bar = console.progress("making the portrait", 100);
    let (shot, portrait) = made(args, &figure, clip, &options).with_context(place)?;
    bar.set_position(70);
    let written = write(args, &portrait, &console.files)?;
    let error = YAWS_DEG.iter().map(|yaw_deg| {
        bar.inc(5);
        turned_error(&portrait, &shot, &options, *yaw_deg)
    });
    let error: Vec<YawError> = error.collect::<Result<_, _>>().with_context(place)?;
    bar.finish_and_clear();
    let all: Vec<u8> = written
        .iter()
        .flat_map(|(_, bytes)| bytes)
        .copied()
        .collect();
    let sizes = FileSize::of(&all)?;
    let counts = portrait.counts();
    let warning = fallen_apart(&error);
    let report = PortraitReport {
        out: files::shown(args.out()),
        profile: "portrait",
        bytes: FlatBytes {
            raw: sizes.raw,
            gzip: sizes.gzip,
            brotli: sizes.brotli,
        },
        views: counts.views,
        triangles: counts.triangles,
        vertices: counts.vertices,
        expressions: counts.expressions,
        inputs: portrait.inputs.len(),
        frames: portrait.clips.first().map_or(0, |c| c.poses.len()),
        size_px: portrait.size,
        error,
        representation: RepresentationReport::new(Representation {
            modality: "portrait".into(),
            bytes: sizes.raw,
            error_px: f64::from(options.tolerance_px),
            needs: vec!["script", "canvas", "webp"],
        }),
        written: written.iter().map(|(name, _)| name.clone()).collect(),
        warnings: open::warnings(figure.opened.warnings())
            .into_iter()
            .chain(surfaces_shown_otherwise(&figure))
            .chain(warning)
            .chain(given.warnings.iter().cloned())
            .collect(),
    };
    let face = given.text();
    let report = given.with(report);
    console.result(&report, |told| told.report.text() + &face)
}

/// The portrait with as many triangles as asked for, else with the fewest that look like the figure.
fn made<'a>(
    args: &ConvertArgs,
    figure: &'a Figure,
    clip: Option<usize>,
    options: &PortraitOptions,
) -> anyhow::Result<(FramedHead<'a>, Portrait)> {
    let viewport = Viewport {
        width_px: args.shot.size.0 as f32,
        height_px: args.shot.size.1 as f32,
        fov_y_radians: args.shot.fov_deg.to_radians(),
    };
    let with = |count: usize| -> anyhow::Result<_> {
        let shot = FramedHead::new(figure, clip, count, viewport)?;
        let mut portrait = build(&shot.source(), options, &mut Progress::none())?;
        portrait.inputs = shot.inputs();
        Ok((shot, portrait))
    };
    if let Some(count) = args.shot.triangles {
        return with(count as usize);
    }
    for count in FEWER {
        let (shot, portrait) = with(count)?;
        if turned_error(&portrait, &shot, options, 0.0)?.image_rmse_levels <= GOOD_LEVELS {
            return Ok((shot, portrait));
        }
    }
    with(MOST)
}

/// The error of the portrait with its head turned.
fn turned_error(
    portrait: &Portrait,
    shot: &FramedHead<'_>,
    options: &PortraitOptions,
    yaw_deg: f32,
) -> Result<YawError, PortraitError> {
    let pose = HeadPose {
        yaw_degrees: yaw_deg,
        ..HeadPose::default()
    };
    Ok(YawError {
        yaw_deg,
        image_rmse_levels: portrait.error(&shot.source(), options, &pose, &[])?,
    })
}

/// A warning, if the portrait is far from the figure.
fn fallen_apart(errors: &[YawError]) -> Option<String> {
    let worst = errors
        .iter()
        .map(|e| e.image_rmse_levels)
        .fold(0.0, f64::max);
    (worst > FALLEN_APART_LEVELS).then(|| {
        format!(
            "the portrait is {worst:.0} levels from the figure (bound {FALLEN_APART_LEVELS}), so parts such as \
             the eyes may fall apart; give more --triangles, or show it in 3D"
        )
    })
}

fn options(args: &ConvertArgs) -> anyhow::Result<PortraitOptions> {
    let views = args.special.views as usize;
    if ![1, 3, 5].contains(&views) {
        return Err(fault::usage(format!("--views {views}: expected 1, 3 or 5")));
    }
    let plain = PortraitOptions::default();
    let position_px = args.quality.accuracy().position_px;
    // Without pictures from above and below, large pitch angles would show missing surface.
    let pitch_limit_degrees = if views == 5 {
        plain.pitch_limit_degrees
    } else {
        10.0
    };
    Ok(PortraitOptions {
        views,
        pitch_limit_degrees,
        tolerance_px: position_px.unwrap_or(plain.tolerance_px),
        ..plain
    })
}

/// Writes one page, or the document with its pictures; returns names and bytes.
fn write(
    args: &ConvertArgs,
    portrait: &Portrait,
    files: &Files,
) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let place = || files::shown(args.out());
    let is_page = files::extension(args.out()) == "html";
    let mut all = Vec::new();
    if is_page {
        let file = args.title();
        let clip = portrait.clips.first();
        let options = PageOptions {
            title: clip.map_or_else(|| file.clone(), |c| format!("{file}: {}", c.name)),
            background: enclosed(args.special.background.as_deref())?,
            audio: enclosed(args.special.audio.as_deref())?,
            controls: true,
        };
        let text = page(portrait, &options).with_context(place)?;
        all.push((place(), args.out().to_owned(), text.into_bytes()));
    } else {
        let folder = args.out().parent().unwrap_or(Path::new(""));
        for (name, bytes) in portrait.to_files(PictureFormat::WebP).with_context(place)? {
            let is_document = name == "portrait.json";
            let path = if is_document {
                args.out().to_owned()
            } else {
                folder.join(&name)
            };
            all.push((files::shown(&path), path, bytes));
        }
    }
    let named: Vec<_> = all.iter().map(|(_, path, bytes)| (path, bytes)).collect();
    files.write_all(&named)?;
    Ok(all
        .into_iter()
        .map(|(shown, _, bytes)| (shown, bytes))
        .collect())
}

fn enclosed(path: Option<&Path>) -> anyhow::Result<Option<EmbeddedFile>> {
    let Some(path) = path else {
        return Ok(None);
    };
    let media_type = match files::extension(path).as_str() {
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "mp3" => "audio/mpeg",
        "wav" => "audio/wav",
        "ogg" | "opus" => "audio/ogg",
        "m4a" => "audio/mp4",
        _ => {
            let what = "expected a .png, .jpg or .webp picture, or .mp3, .wav, .ogg or .m4a sound";
            return Err(fault::usage(format!("{}: {what}", files::shown(path))));
        }
    };
    Ok(Some(EmbeddedFile {
        media_type: media_type.into(),
        bytes: files::read(path, MAX_BYTES)?,
    }))
}

impl PortraitReport {
    fn text(&self) -> String {
        let errors: Vec<String> = self
            .error
            .iter()
            .map(|e| format!("{:.1} at {}°", e.image_rmse_levels, e.yaw_deg))
            .collect();
        let mut text = format!(
            "{}: portrait, {} views, {} triangles, {} expressions, {} frames\n\
             {:.1} kB ({:.1} gzip, {:.1} brotli) in {} files\n\
             RMS colour error when turned, levels of 0 to 255: {}\n",
            self.out,
            self.views,
            self.triangles,
            self.expressions,
            self.frames,
            self.bytes.raw as f64 / 1e3,
            self.bytes.gzip as f64 / 1e3,
            self.bytes.brotli as f64 / 1e3,
            self.written.len(),
            errors.join(", "),
        );
        for warning in &self.warnings {
            text.push_str(&format!("warning: {warning}\n"));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_portrait_far_from_the_figure_is_told() {
        let at = |image_rmse_levels| YawError {
            yaw_deg: 0.0,
            image_rmse_levels,
        };
        assert_eq!(fallen_apart(&[at(3.9), at(24.3)]), None);
        let told = fallen_apart(&[at(3.9), at(41.6)]).unwrap();
        assert!(
            told.contains("42 levels") && told.contains("--triangles"),
            "{told}"
        );
    }
}
