//! `articula flatten --profile portrait`: a face as pictures on a 2D mesh, with its player.

use super::arguments::{ConvertArgs, SlideFile};
use super::face;
use crate::console::Console;
use crate::fault;
use crate::files::{self, Files};
use crate::open;
use anyhow::Context;
use articula::Figure;
use articula::core::Viewport;
use articula::flat::portrait::PictureFormat;
use articula::flat::portrait::{EmbeddedFile, PageOptions, Slide, page};
use articula::flat::portrait::{Portrait, PortraitOptions};
use articula::flatten::{
    PortraitReport, PortraitShot, portrait, portrait_errors, surfaces_shown_otherwise,
};
use std::path::Path;

/// Maximum size of an embedded picture or sound in bytes.
const MAX_BYTES: u64 = 64 << 20;

/// Makes the portrait, writes it and reports its error.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let mut opened = open::kept(&console.files, &args.character())?;
    let mut given = face::give(args, &mut opened, console)?;
    if args.special.live {
        face::give_table(&mut opened, &mut given)?;
    }
    let figure = Figure::new(opened)?;
    let shot = PortraitShot {
        clip: figure.clip(given.clip(args))?,
        triangles: args.shot.triangles.map(|count| count as usize),
        viewport: Viewport {
            width_px: args.shot.size.0 as f32,
            height_px: args.shot.size.1 as f32,
            fov_y_radians: args.shot.fov_deg.to_radians(),
        },
        default_mouth: !args.special.no_default_mouth,
        options: options(args)?,
    };
    if shot.clip.is_none() && args.special.audio.is_some() {
        let what = "--audio needs a clip with the motion of the mouth; name one with --clip, or give --motion";
        return Err(fault::usage(what));
    }
    let behind = &args.special.background;
    if shot.clip.is_none() && behind.len() > 1 {
        let what = "--background is given several times: a slide-show needs a clip to be in step with; name one with --clip, or give --motion";
        return Err(fault::usage(what));
    }
    let timed = behind.iter().filter(|f| f.from_secs.is_some()).count();
    if timed != 0 && timed != behind.len() {
        let what = "--background: give the seconds of all pictures (a.png@0 b.png@2.5), or of none";
        return Err(fault::usage(what));
    }
    let (head, made) = console.work(|work| portrait(&figure, &shot, work))?;
    let written = write(args, &made, &console.files)?;
    let error = console
        .work(|work| portrait_errors(&made, &head, &shot.options, work))
        .with_context(|| figure.opened.name().to_owned())?;
    let out = files::shown(args.out());
    let mut report = PortraitReport::new(out, &made, &head, &written, error, &shot.options)?;
    let far = std::mem::take(&mut report.warnings);
    report.warnings = open::warnings(figure.opened.warnings())
        .into_iter()
        .chain(surfaces_shown_otherwise(&figure))
        .chain(far)
        .chain(given.warnings.iter().cloned())
        .collect();
    let face = given.text();
    let report = given.with(report);
    console.result(&report, |told| text(&told.report) + &face)
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
            background: slides(&args.special.background, portrait)?,
            audio: args.special.audio.as_deref().map(enclosed).transpose()?,
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

/// The pictures behind the portrait, the earliest first.
fn slides(files: &[SlideFile], portrait: &Portrait) -> anyhow::Result<Vec<Slide>> {
    let clip = portrait.clips.first();
    let secs = clip.map_or(0.0, |c| {
        c.poses.len().saturating_sub(1) as f64 / f64::from(c.rate_hz)
    });
    let slide = |(index, file): (usize, &SlideFile)| {
        let share = index as f64 / files.len() as f64;
        Ok(Slide {
            from_secs: file.from_secs.unwrap_or(share * secs),
            picture: enclosed(&file.path)?,
        })
    };
    let mut slides: Vec<Slide> = files
        .iter()
        .enumerate()
        .map(slide)
        .collect::<anyhow::Result<_>>()?;
    slides.sort_by(|a, b| a.from_secs.total_cmp(&b.from_secs));
    Ok(slides)
}

fn enclosed(path: &Path) -> anyhow::Result<EmbeddedFile> {
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
    Ok(EmbeddedFile {
        media_type: media_type.into(),
        bytes: files::read(path, MAX_BYTES)?,
    })
}

/// The report for people.
fn text(report: &PortraitReport) -> String {
    let errors: Vec<String> = report
        .error
        .iter()
        .map(|e| format!("{:.1} at {}°", e.image_rmse_levels, e.yaw_deg))
        .collect();
    let mut text = format!(
        "{}: portrait, {} views, {} triangles, {} expressions, {} frames\n\
             {:.1} kB ({:.1} gzip, {:.1} brotli) in {} files\n\
             RMS colour error when turned, levels of 0 to 255: {}\n",
        report.out,
        report.views,
        report.triangles,
        report.expressions,
        report.frames,
        report.bytes.raw as f64 / 1e3,
        report.bytes.gzip as f64 / 1e3,
        report.bytes.brotli as f64 / 1e3,
        report.written.len(),
        errors.join(", "),
    );
    if let Some(line) = report.teeth_and_tongue.line() {
        text.push_str(&format!("{line}\n"));
    }
    for warning in &report.warnings {
        text.push_str(&format!("warning: {warning}\n"));
    }
    text
}
