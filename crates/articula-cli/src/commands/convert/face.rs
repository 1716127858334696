//! Face clips without a character: FAP files, AFP streams and captures, written as one another.

use super::report::{self, ConvertReport};
use super::{ConvertArgs, boxing, face_level};
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use anyhow::Context;
use articula::convert::{write_data, write_faps};
use articula::face::{
    CaptureBridge, FaceRig, capture_of_clip, capture_to_faps, drives_shapes, expand_face,
    faps_to_capture, faps_to_vrma, measure_faps, presets_to_faps, reduce_face,
};
use articula::formats::Warning;
use articula::{CharacterFile, Data, DataFormat, Figure, Format};
use std::path::Path;

/// Whether the input or output is named as a file of facial data that is to be written; with a
/// character, such a file is a motion like any other.
pub(super) fn is_meant(args: &ConvertArgs) -> anyhow::Result<bool> {
    let only = args.sources().len() == 1 && args.onto.is_none();
    Ok(files::data_format(args.out()).is_some() || only && format_in(args)?.is_some())
}

/// The format of the input, if it has no character. Of the streams of an MP4 file that of a face is
/// meant if the output is one of a face, else the first.
fn format_in(args: &ConvertArgs) -> anyhow::Result<Option<DataFormat>> {
    let input = &args.sources()[0];
    if input.is_dir() {
        return Ok(None);
    }
    if files::data_format(args.out()).is_some_and(DataFormat::animates_a_face)
        && let Some(streams) = open::streams_in(input)?
    {
        let has_face = streams.iter().any(|kind| kind.is_of_face());
        return Ok(has_face.then_some(DataFormat::Mp4));
    }
    open::data_format(input)
}

/// The format of the output, if it holds data of a face.
fn format_out(args: &ConvertArgs) -> Option<DataFormat> {
    if boxing::is_mp4(args.out()) {
        return Some(DataFormat::Mp4);
    }
    files::data_format(args.out())
}

/// What was read: a face clip, and what is reported about its file.
struct FaceSource {
    data: Data,
    /// The blend shapes of the captured face, if its own effect of them is known.
    bridge: CaptureBridge,
    format: &'static str,
    bytes: usize,
    warnings: Vec<Warning>,
}

impl FaceSource {
    /// What a clip of a character shows.
    fn of(data: Data, bridge: CaptureBridge, opened: CharacterFile) -> Self {
        Self {
            data,
            bridge,
            format: opened.format().name(),
            bytes: opened.bytes(),
            warnings: opened.warnings().to_vec(),
        }
    }
}

/// Writes a face clip; anything else is refused with a hint at what is possible.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    if files::format(args.out()) == Some(Format::Vrma) {
        return vrma(args, console);
    }
    let format = check(args)?;
    let input = &args.sources()[0];
    console.files.plan(args.inputs(), [args.out()])?;
    let source = match format_in(args)? {
        Some(own) => {
            let opened = open::data(input, own, &args.names)?;
            FaceSource {
                data: opened.data,
                bridge: CaptureBridge::generic(),
                format: own.name(),
                bytes: opened.bytes,
                warnings: opened.warnings,
            }
        }
        None => of_character(args, input, console)?,
    };
    let place = files::shown(input);
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    let mut face_level = None;
    let (data, capture) = match (source.data, format) {
        (Data::LiveLink(capture), format) if format.has_faps() => {
            let made =
                capture_to_faps(&capture, &stem, &source.bridge).with_context(|| place.clone())?;
            (Data::Fap(made.0), Some(made.1))
        }
        (Data::Fap(clip), DataFormat::Csv) => {
            let (clip, level) = face_level::applied(clip, args, expand_face);
            face_level = level;
            let made = faps_to_capture(&clip).with_context(|| place.clone())?;
            (Data::LiveLink(made.0), Some(made.1))
        }
        (Data::Fap(clip), _) => {
            let (clip, level) = face_level::applied(clip, args, reduce_face);
            face_level = level;
            (Data::Fap(clip), None)
        }
        (data, _) => (data, None),
    };
    let written = match &data {
        Data::Fap(clip) => {
            let profile = args.stream.face_profile();
            let levels = args.face_level;
            let profile = levels.map_or(profile, |levels| profile.with_levels(levels));
            write_faps(clip, format, &profile).with_context(|| place.clone())?
        }
        other => write_data(other)?,
    };
    let mut bytes = written.bytes;
    if !args.with.is_empty() {
        bytes = boxing::with(args, &console.files, (place.clone(), bytes))?;
    }
    console.files.write(args.out(), &bytes)?;
    let clips = match &data {
        Data::Fap(clip) => vec![clip.name.clone()],
        _ => Vec::new(),
    };
    let left_out = written.left_out.iter();
    let report = ConvertReport {
        input: place,
        out: files::shown(args.out()),
        format_in: source.format.to_owned(),
        format_out: format.name(),
        bytes_in: source.bytes,
        bytes_out: bytes.len(),
        left_out: left_out
            .map(|what| report::left_out(what, format.name()))
            .collect(),
        clips,
        capture,
        face_level,
        tiers: written.tiers,
        warnings: open::warnings(&source.warnings),
        ..ConvertReport::default()
    };
    console.result(&report, |report| report.text(false))
}

/// Writes a face clip as a VRM animation.
fn vrma(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let input = &args.sources()[0];
    let place = files::shown(input);
    let format = format_in(args)?;
    let Some(own) = format.filter(|f| f.animates_a_face()) else {
        let advice = format.map_or("", DataFormat::advice);
        return Err(fault::usage(format!("{place}: {advice}")));
    };
    check_flags(args, &place)?;
    console.files.plan(args.inputs(), [args.out()])?;
    let opened = open::data(input, own, &args.names)?;
    let clip = match opened.data {
        Data::LiveLink(capture) => {
            let stem = input.file_stem().unwrap_or_default().to_string_lossy();
            let made = capture_to_faps(&capture, &stem, &CaptureBridge::generic());
            made.with_context(|| place.clone())?.0
        }
        Data::Fap(clip) => clip,
        _ => anyhow::bail!("{place}: {}", own.advice()),
    };
    let (clip, face_level) = face_level::applied(clip, args, expand_face);
    let (bytes, report) = faps_to_vrma(&clip).with_context(|| place.clone())?;
    console.files.write(args.out(), &bytes)?;
    let report = ConvertReport {
        input: place,
        out: files::shown(args.out()),
        format_in: own.name().to_owned(),
        format_out: Format::Vrma.name(),
        bytes_in: opened.bytes,
        bytes_out: bytes.len(),
        clips: vec![clip.name],
        capture: Some(report),
        face_level,
        warnings: open::warnings(&opened.warnings),
        ..ConvertReport::default()
    };
    console.result(&report, |report| report.text(false))
}

/// The blend shapes of a clip of a character, or the parameters that it shows without them.
fn of_character(args: &ConvertArgs, input: &Path, console: &Console) -> anyhow::Result<FaceSource> {
    let opened = open::character(&console.files, input, &args.names)?;
    let clips = &opened.character().clips;
    let clip = match &args.clip {
        Some(name) => clips.iter().find(|c| c.name == *name),
        None => clips.first(),
    };
    let Some(clip) = clip else {
        let names: Vec<&str> = clips.iter().map(|c| c.name.as_str()).collect();
        let place = files::shown(input);
        return Err(match &args.clip {
            Some(name) => fault::usage(format!(
                "{place}: there is no clip \"{name}\"; the file has {}",
                names.join(", ")
            )),
            None => anyhow::anyhow!("{place}: clips: the file has none; give one with a face clip"),
        });
    };
    let generic = CaptureBridge::generic();
    if drives_shapes(opened.character(), clip) {
        let capture = Data::LiveLink(capture_of_clip(&opened, clip)?);
        let bridge = FaceRig::new(&opened)?.capture_bridge(&opened);
        return Ok(FaceSource::of(capture, bridge.unwrap_or(generic), opened));
    }
    if let Some(faps) = presets_to_faps(opened.character(), clip) {
        return Ok(FaceSource::of(Data::Fap(faps), generic, opened));
    }
    let has_mesh = |opened: &CharacterFile| {
        let mut meshes = opened.character().meshes.iter();
        meshes.any(|m| !m.primitives.is_empty())
    };
    if !has_mesh(&opened) {
        // Says what the clip lacks.
        let capture = Data::LiveLink(capture_of_clip(&opened, clip)?);
        return Ok(FaceSource::of(capture, generic, opened));
    }
    let name = clip.name.clone();
    let figure = Figure::new(opened)?;
    let index = figure.clip(Some(&name))?.unwrap_or(0);
    let measured = Data::Fap(measure_faps(&figure, index, &name)?);
    Ok(FaceSource::of(measured, generic, figure.opened))
}

/// The format to write, if it is one that can be written and no other flags are given.
fn check(args: &ConvertArgs) -> anyhow::Result<DataFormat> {
    let [input] = args.sources() else {
        return Err(fault::usage("a face clip is written from one file"));
    };
    let place = files::shown(input);
    let own = format_in(args)?;
    let readable = own.is_none_or(DataFormat::animates_a_face);
    let written = format_out(args);
    let writable = written.filter(|f| f.animates_a_face());
    let (Some(format), true) = (writable, readable) else {
        let format = own.filter(|_| written.is_none() || !readable).or(written);
        let advice = format.map_or("", DataFormat::advice);
        return Err(fault::usage(format!("{place}: {advice}")));
    };
    check_flags(args, &place)?;
    Ok(format)
}

/// Refuses flags about bodies.
fn check_flags(args: &ConvertArgs, place: &str) -> anyhow::Result<()> {
    let own = format_in(args)?;
    let chosen =
        args.loa.is_some() || args.loa_profile.is_some() || own.is_some() && args.clip.is_some();
    let other = args.to.is_some()
        || args.onto.is_some()
        || args.khr_character
        || args.joint_scheme.is_some();
    let is_afp = matches!(format_out(args), Some(DataFormat::Afp | DataFormat::Mp4));
    if let Some(flag) = args.stream.idle_for_a_face(is_afp) {
        let expected = if is_afp { "an .abp" } else { "an .afp" };
        return Err(fault::usage(format!(
            "{place}: {flag} requires {expected} output; leave it out"
        )));
    }
    if chosen || other || args.hygiene.asks() || args.shapes.asks() {
        return Err(fault::usage(format!(
            "{place}: flags that choose or change body clips do not apply to a face clip; leave them out"
        )));
    }
    Ok(())
}
