//! Streams that are put into MP4 files and taken out of them unchanged: `convert walk.abp walk.mp4`,
//! `convert walk.mp4 walk.abp`, and `--with` for further streams in a file.

use super::ConvertArgs;
use super::report::ConvertReport;
use crate::console::Console;
use crate::files::{self, Files};
use crate::{fault, open};
use anyhow::Context;
use articula::clip_streams::{StreamKind, clip_name, mp4};
use articula::convert::{AfpProfile, write_faps};
use articula::formats::{Limits, Warning};
use articula::{Data, DataFormat, Format};
use std::path::Path;

/// A file to put into a box, by its name.
type Part = (String, Vec<u8>);

/// Whether a single stream is to be written as it is: into an MP4 file, or out of one. With a flag that
/// changes it, it is a motion like any other.
pub(super) fn is_meant(args: &ConvertArgs) -> anyhow::Result<bool> {
    let [input] = args.sources() else {
        return Ok(false);
    };
    let is_stream = |path: &Path| {
        let extension = files::extension(path);
        StreamKind::ALL
            .iter()
            .any(|kind| kind.extension() == extension)
    };
    let boxed = files::format(input) == Some(Format::Mp4);
    if input.is_dir() || args.changes_motions() || !(boxed || is_stream(input)) {
        return Ok(false);
    }
    if is_mp4(args.out()) {
        return Ok(true);
    }
    let wanted = files::extension(args.out());
    let has = |kinds: Vec<StreamKind>| kinds.iter().any(|kind| kind.extension() == wanted);
    Ok(boxed && is_stream(args.out()) && open::streams_in(input)?.is_some_and(has))
}

/// Writes the file.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let input = &args.sources()[0];
    let place = files::shown(input);
    console.files.plan(args.inputs(), [args.out()])?;
    let limits = Limits::default();
    let read = console.files.read(input, limits.bytes)?;
    let bytes_in = read.len();
    let out = files::extension(args.out());
    let (written, left_out) = if is_mp4(args.out()) {
        let left_out = foreign_tracks(&place, &read, &limits)?;
        let parts = with(args, &console.files, (place.clone(), read))?;
        (parts, left_out)
    } else {
        let fits = |kind: StreamKind| kind.extension() == out;
        let taken = mp4::take(&read, &limits, fits).with_context(|| place.clone())?;
        let taken = taken.context("the stream is gone; the file has changed")?;
        let left_out = taken.warnings();
        (taken.bytes, left_out)
    };
    console.files.write(args.out(), &written)?;
    let report = ConvertReport {
        out: files::shown(args.out()),
        format_in: files::extension(input),
        format_out: format_name(args.out()),
        bytes_in,
        bytes_out: written.len(),
        clips: clips(&written, &place, &limits)?,
        warnings: open::warnings(&left_out),
        input: place,
        ..ConvertReport::default()
    };
    console.result(&report, |report| report.text(false))
}

/// Refuses `--with` for files that hold one stream.
pub(super) fn check(args: &ConvertArgs) -> anyhow::Result<()> {
    if args.with.is_empty() || is_mp4(args.out()) {
        return Ok(());
    }
    Err(fault::usage(format!(
        "{}: --with requires an .mp4 output, which holds several streams",
        files::shown(args.out())
    )))
}

/// The MP4 file of a first part and the files of `--with`.
pub(super) fn with(args: &ConvertArgs, files: &Files, first: Part) -> anyhow::Result<Vec<u8>> {
    let mut parts = vec![first];
    for path in &args.with {
        parts.push((files::shown(path), part(args, files, path)?));
    }
    let parts: Vec<(&str, &[u8])> = parts
        .iter()
        .map(|(name, b)| (name.as_str(), &b[..]))
        .collect();
    Ok(mp4::write(&parts, &Limits::default())?)
}

/// A stream, an MP4 file, or a FAP file as a stream.
fn part(args: &ConvertArgs, files: &Files, path: &Path) -> anyhow::Result<Vec<u8>> {
    if files::data_format(path) != Some(DataFormat::Fap) {
        return Ok(files.read(path, Limits::default().bytes)?);
    }
    let read = open::data(path, DataFormat::Fap, &args.names)?;
    let Data::Fap(clip) = read.data else {
        anyhow::bail!("{}: {}", files::shown(path), DataFormat::Fap.advice());
    };
    let written = write_faps(&clip, DataFormat::Afp, &AfpProfile::default());
    Ok(written.with_context(|| files::shown(path))?.bytes)
}

/// The tracks of an MP4 file that are no streams, which are not written again.
fn foreign_tracks(place: &str, bytes: &[u8], limits: &Limits) -> anyhow::Result<Vec<Warning>> {
    if !mp4::is_mp4(bytes) {
        return Ok(Vec::new());
    }
    let taken = mp4::take(bytes, limits, |_| true).with_context(|| place.to_owned())?;
    let mut left_out = taken.map(|taken| taken.left_out).unwrap_or_default();
    left_out.retain(|track| track.kind.is_none());
    Ok(left_out.iter().map(mp4::left_out).collect())
}

/// The names of the clips of a file that was written.
fn clips(bytes: &[u8], place: &str, limits: &Limits) -> anyhow::Result<Vec<String>> {
    let name = |stream: &[u8]| clip_name(stream, limits).with_context(|| place.to_owned());
    if !mp4::is_mp4(bytes) {
        return Ok(vec![name(bytes)?]);
    }
    let tracks = mp4::tracks(bytes, limits)?;
    tracks
        .iter()
        .map(|track| name(&track.stream(bytes)?))
        .collect()
}

/// Whether a file is named as an MP4 file.
pub(super) fn is_mp4(path: &Path) -> bool {
    files::format(path) == Some(Format::Mp4)
}

fn format_name(path: &Path) -> &'static str {
    let of_data = || files::data_format(path).map(DataFormat::name);
    let format = files::format(path).map(Format::name);
    format.or_else(of_data).unwrap_or("mp4")
}
