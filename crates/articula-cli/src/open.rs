//! From the flags of a command to an opened file: joint maps and skeletons are read here, the
//! rest is done by the library.

use crate::arguments::{CharacterArgs, ReadArgs};
use crate::files::{self, Files};
use anyhow::Context;
use articula::clip_streams::{StreamKind, mp4, unit_tree};
use articula::core::face_control::FaceMap;
use articula::core::feature_points::PointId;
use articula::core::joint_names::JointMap;
use articula::face::fdp_points;
use articula::formats::{
    Assumption, Limits, UpAxis, Warning, face_map, face_points as points_file, joint_map, mpeg4,
};
use articula::inspect::{TrackInspection, inspect_mp4};
use articula::stream::StreamLimits;
use articula::stream::description::{GbsdOptions, write_gbsd};
use articula::{CharacterFile, Data, DataFile, DataFormat, Figure, Format, OpenOptions, open_data};
use glam::Vec3;
use std::path::{Path, PathBuf};

/// Opens a character; a joint map of the user is used instead of all others if it fits.
pub(crate) fn character(
    files: &Files,
    path: &Path,
    args: &ReadArgs,
) -> anyhow::Result<CharacterFile> {
    Ok(files.open(path, &options(args)?)?)
}

/// Opens a character whose clips are what it is read for.
pub(crate) fn motion(files: &Files, path: &Path, args: &ReadArgs) -> anyhow::Result<CharacterFile> {
    let mut opened = character(files, path, args)?;
    if args.settings().skip_first_frame {
        opened.skip_first_frames()?;
    }
    Ok(opened)
}

/// Opens a GLB that was made of a file, as that file was opened.
pub(crate) fn again(glb: &[u8], name: &str, args: &ReadArgs) -> anyhow::Result<CharacterFile> {
    let beside = &mut |uri: &str| Err(format!("{uri}: not in the file"));
    // Lengths and the direction up are those of glTF by now.
    let options = OpenOptions {
        unit_metres: None,
        up: UpAxis::default(),
        skeleton: None,
        ..options(args)?
    };
    Ok(articula::open(glb, name, &options, beside)?)
}

/// A stream that was read.
pub(crate) struct Stream {
    /// Which one it is, by how it begins.
    pub(crate) kind: Option<StreamKind>,
    pub(crate) bytes: Vec<u8>,
    /// Size of the file.
    pub(crate) file_bytes: usize,
    /// Warnings about the file around it, if there is one.
    pub(crate) warnings: Vec<Warning>,
}

/// Reads a stream: the file itself, or the first stream of a body, or of a face, in an MP4 file.
pub(crate) fn stream(path: &Path, of_face: bool) -> anyhow::Result<Stream> {
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    if files::format(path) != Some(Format::Mp4) {
        return Ok(Stream {
            kind: StreamKind::of(&bytes),
            file_bytes: bytes.len(),
            bytes,
            warnings: Vec::new(),
        });
    }
    let place = || files::shown(path);
    let fits = |kind: StreamKind| kind.is_of_face() == of_face;
    let taken = mp4::take(&bytes, &limits, fits).with_context(place)?;
    let which = if of_face { "face" } else { "body" };
    let taken = taken.with_context(|| format!("no track of the MP4 file moves a {which}"));
    let taken = taken.with_context(place)?;
    Ok(Stream {
        kind: Some(taken.kind),
        warnings: taken.warnings(),
        bytes: taken.bytes,
        file_bytes: bytes.len(),
    })
}

/// The description (gBSD) of a stream in a file of its own, or in an MP4 file.
pub(crate) fn description(path: &Path) -> anyhow::Result<String> {
    let bytes = match files::format(path) {
        Some(Format::Mp4) => stream(path, false)?.bytes,
        _ => files::read(path, Limits::default().bytes)?,
    };
    let place = || files::shown(path);
    let unit = unit_tree(&bytes, &StreamLimits::default()).with_context(place)?;
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    let options = GbsdOptions { bitstream: name };
    write_gbsd(&unit, &options).with_context(place)
}

/// A motion stream (ABP-2); `None` if the file is not one.
pub(crate) fn motion_stream(path: &Path) -> anyhow::Result<Option<Stream>> {
    if !matches!(files::format(path), Some(Format::Abp | Format::Mp4)) {
        return Ok(None);
    }
    let stream = stream(path, false)?;
    Ok(Some(stream).filter(|stream| stream.kind == Some(StreamKind::Abp2)))
}

/// The streams in a file that is named as an MP4 file, in their order; `None` for other files.
pub(crate) fn streams_in(path: &Path) -> anyhow::Result<Option<Vec<StreamKind>>> {
    if files::format(path) != Some(Format::Mp4) {
        return Ok(None);
    }
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    let tracks = mp4::tracks(&bytes, &limits).with_context(|| files::shown(path))?;
    Ok(Some(tracks.iter().filter_map(|track| track.kind).collect()))
}

/// The format without a character of a file to read: by its name, of an MP4 file by its first stream.
pub(crate) fn data_format(path: &Path) -> anyhow::Result<Option<DataFormat>> {
    let Some(streams) = streams_in(path)? else {
        return Ok(files::data_format(path));
    };
    let is_face = streams.first().is_some_and(|kind| kind.is_of_face());
    Ok(is_face.then_some(DataFormat::Mp4))
}

/// The tracks of a file that is named as an MP4 file; none of other files.
pub(crate) fn tracks(path: &Path) -> anyhow::Result<Vec<TrackInspection>> {
    if files::format(path) != Some(Format::Mp4) {
        return Ok(Vec::new());
    }
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    Ok(inspect_mp4(&bytes, &files::shown(path), &limits)?)
}

/// Opens a character and leaves out unwanted meshes.
pub(crate) fn kept(files: &Files, args: &CharacterArgs) -> anyhow::Result<CharacterFile> {
    let mut opened = motion(files, &args.file, &args.names)?;
    opened.keep_meshes(&args.only, &args.hide)?;
    Ok(opened)
}

/// Opens a character, leaves out unwanted meshes and builds the figure.
pub(crate) fn figure(files: &Files, args: &CharacterArgs) -> anyhow::Result<Figure> {
    Ok(Figure::new(kept(files, args)?)?)
}

/// Opens a file that holds data without a character.
pub(crate) fn data(path: &Path, format: DataFormat, args: &ReadArgs) -> anyhow::Result<DataFile> {
    let options = options(args)?;
    let bytes = files::read(path, options.limits.bytes)?;
    Ok(open_data(&bytes, &files::shown(path), format, &options)?)
}

/// Opens a motion of a face without a character, parameters or a capture.
pub(crate) fn face_motion(
    path: &Path,
    format: DataFormat,
    args: &ReadArgs,
) -> anyhow::Result<DataFile> {
    let mut read = data(path, format, args)?;
    if !format.animates_a_face() {
        anyhow::bail!("{}: {}", files::shown(path), format.advice());
    }
    if args.settings().skip_first_frame {
        match &mut read.data {
            Data::Fap(clip) if clip.frames.len() > 1 => drop(clip.frames.remove(0)),
            Data::LiveLink(capture) if capture.frames.len() > 1 => capture.skip_first_frame(),
            _ => {}
        }
    }
    Ok(read)
}

/// The options of the library that correspond to the flags.
fn options(args: &ReadArgs) -> anyhow::Result<OpenOptions> {
    let limits = Limits::default();
    let given = args.settings();
    let skeleton = given.skeleton.map(|path| files::read(&path, limits.bytes));
    Ok(OpenOptions {
        joint_maps: joint_maps(args)?,
        face_map: given_face_map(args)?,
        unit_metres: given.unit_metres,
        up: given.up,
        skeleton: skeleton.transpose()?,
        amc_rate_hz: given.amc_rate_hz,
        absent: given.absent,
        limits,
    })
}

/// The user's own joint maps.
fn joint_maps(args: &ReadArgs) -> anyhow::Result<Vec<JointMap>> {
    let limits = Limits::default();
    let profile = |path: &PathBuf| {
        let bytes = files::read(path, limits.bytes)?;
        joint_map::parse(&bytes, &limits).with_context(|| files::shown(path))
    };
    args.joint_map.iter().map(profile).collect()
}

/// The user's own face map.
fn given_face_map(args: &ReadArgs) -> anyhow::Result<Option<FaceMap>> {
    let limits = Limits::default();
    let read = |path: &PathBuf| {
        let bytes = files::read(path, limits.bytes)?;
        face_map::parse(&bytes, &limits).with_context(|| files::shown(path))
    };
    args.face_map.as_ref().map(read).transpose()
}

/// The warnings of the reader, each with its place in the file.
pub(crate) fn warnings(warnings: &[Warning]) -> Vec<String> {
    warnings
        .iter()
        .map(|w| format!("{}: {}", w.at, advised(w)))
        .collect()
}

/// The text of a warning; where the reader had to guess, the flag that overrides the guess is
/// added.
pub(crate) fn advised(warning: &Warning) -> String {
    let flag = match warning.guess {
        None => return warning.what.clone(),
        Some(Assumption::Unit) => "--read unit-metres=M",
        Some(Assumption::UpAxis) => "--read up=y or up=z",
        Some(Assumption::Rate) => "--read amc-rate-hz=HZ",
        Some(Assumption::Skeleton) => "--read skeleton=F.asf",
        Some(Assumption::FirstFrame) => {
            return format!("{}; --read first-frame=skip leaves it out", warning.what);
        }
    };
    format!("{}; give {flag} if that is wrong", warning.what)
}

/// Reads the feature points of a file: JSON, or an FDP file made for the character's mesh.
pub(crate) fn face_points(
    character: &CharacterFile,
    path: &Path,
) -> anyhow::Result<Vec<(PointId, Vec3)>> {
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    if files::extension(path) == "fdp" {
        let fdp = mpeg4::fdp::read(&bytes, &limits).with_context(|| files::shown(path))?;
        return fdp_points(character, &fdp.value).with_context(|| files::shown(path));
    }
    points_file::read(&bytes, &limits).with_context(|| files::shown(path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault;

    #[test]
    fn a_guess_names_its_flag() {
        let warned = |what: &str, guess| {
            advised(&Warning {
                at: "file".to_owned(),
                what: what.to_owned(),
                guess,
            })
        };
        let guessed = |guess| warned("inches", Some(guess));
        let said = "inches; give --read unit-metres=M if that is wrong";
        assert_eq!(guessed(Assumption::Unit), said);
        let said = "inches; give --read up=y or up=z if that is wrong";
        assert_eq!(guessed(Assumption::UpAxis), said);
        let said = "inches; give --read amc-rate-hz=HZ if that is wrong";
        assert_eq!(guessed(Assumption::Rate), said);
        assert_eq!(warned("odd", None), "odd");
    }

    #[test]
    fn a_wrong_name_is_wrong_usage() {
        let why = articula::choose("clip", "fly", ["walk"].into_iter()).unwrap_err();
        assert_eq!(fault::status(&why.into()), 2);
    }
}
