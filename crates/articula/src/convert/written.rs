//! Encoding of a character, format by format.
//!
//! **A new format is one arm of [`written`] and one function below it.**

use super::left_out::{EncodedFile, LossyPart, counted, mesh_levels, meshes};
use super::{ClipEdited, ConvertOptions, body, faps, joint_names, khr_character};
use crate::error::{Error, Result};
use crate::open::{CharacterFile, Data, DataFormat, Format};
use crate::resampling::{ClipResampling, clip_resampling, first_clip_rate_hz, keyed_mm, told_mm};
use articula_build::sampling_rate_hz;
use articula_formats::gltf::Document;
use articula_formats::x3d::{self, Site};
use articula_formats::{acclaim, bvh, live_link};

/// Writes a character; formats that hold one clip get the first.
///
/// Other contents of a glTF document are preserved in glTF formats.
///
/// # Errors
/// An [`Error`] that names the data that does not fit the format; see
/// [`ConvertOptions::check`] for the formats that can be written.
pub fn write(opened: &CharacterFile, format: Format) -> Result<EncodedFile> {
    ConvertOptions::default().check(opened.format(), format)?;
    if format.needs_a_clip() && opened.character().clips.is_empty() {
        let what = "clips: the file has no clip to write; give a file that has one";
        return Err(Error::unsuited(what));
    }
    written(opened, format, &ConvertOptions::default())
}

/// Writes a data file without a character. In FAP files, masks select the parameters that change.
///
/// # Errors
/// [`Error::Unsupported`] for formats that can only be read.
pub fn write_data(data: &Data) -> Result<EncodedFile> {
    let format = match data {
        Data::Fap(clip) => return Ok(faps::written(clip)),
        Data::LiveLink(capture) => {
            return Ok(EncodedFile::new(live_link::write(capture), None));
        }
        Data::Epf(_) => DataFormat::Epf,
        Data::Fdp(_) => DataFormat::Fdp,
    };
    Err(Error::unsuited(format.advice()))
}

/// As [`write`], after the format and the required clip have been checked.
pub(super) fn written(
    opened: &CharacterFile,
    format: Format,
    options: &ConvertOptions,
) -> Result<EncodedFile> {
    match format {
        Format::Bvh => motion(opened),
        Format::Bap => body::written(opened),
        Format::X3d => humanoid(opened),
        Format::Asf | Format::Amc => acclaim_pair(opened, format),
        #[cfg(feature = "streams")]
        Format::Abp | Format::Abpt | Format::Mp4 => {
            super::streams::written(opened, format, options)
        }
        #[cfg(not(feature = "streams"))]
        Format::Abp | Format::Abpt | Format::Mp4 => Err(Error::needs_streams(format.name())),
        _ => container(opened, options.khr_character),
    }
}

/// How far the frames of each written clip are from its keys; of formats that keep keys, what a change of
/// the rate did.
pub(super) fn resampling(
    opened: &CharacterFile,
    format: Format,
    options: &ConvertOptions,
    edits: &[ClipEdited],
) -> Result<Vec<ClipResampling>> {
    let character = opened.character();
    let is_frames = match format {
        Format::Bvh | Format::Asf | Format::Amc | Format::Abp | Format::Abpt | Format::Mp4 => true,
        Format::Bap => opened.parameters().is_none() || opened.clips_changed(),
        _ => false,
    };
    let mut all = if options.writes_motion_stream(format) {
        clip_resampling(character)?
    } else {
        let measured = character.clips.iter().map(|clip| {
            let rate_hz = is_frames.then(|| sampling_rate_hz(clip, &character.skeleton));
            Ok(ClipResampling {
                clip: clip.name.clone(),
                resampling_mm: match rate_hz {
                    Some(rate_hz) => keyed_mm(character, clip, rate_hz)?,
                    None => 0.0,
                },
                rate_hz,
                told_mm: told_mm(&character.skeleton),
            })
        });
        measured.collect::<Result<_>>()?
    };
    for (clip, edited) in all.iter_mut().zip(edits) {
        if let Some(resampled) = &edited.rate {
            clip.rate_hz = clip.rate_hz.or(Some(resampled.rate_hz));
            clip.resampling_mm += resampled.resampling_mm;
        }
    }
    Ok(all)
}

/// An ASF skeleton and, if there is a clip, an AMC motion; the requested one is the main file.
fn acclaim_pair(opened: &CharacterFile, format: Format) -> Result<EncodedFile> {
    let clips = &opened.character().clips;
    let options = acclaim::WriteOptions {
        rate_hz: first_clip_rate_hz(opened.character()),
        end_sites: opened.end_sites().to_vec(),
    };
    let clip = (!clips.is_empty()).then_some(0);
    let (character, renamed) = joint_names::for_names_alone(opened);
    let made = acclaim::write(&character, clip, &options)?;
    let (bytes, beside) = match (format, made.motion) {
        (Format::Amc, Some(motion)) => (motion, Some((Format::Asf, made.bytes))),
        (_, motion) => (made.bytes, motion.map(|motion| (Format::Amc, motion))),
    };
    let notes = made.left_out.into_iter().map(LossyPart::Note);
    Ok(EncodedFile {
        beside,
        ..EncodedFile::new(
            bytes,
            meshes(opened).into_iter().chain(renamed).chain(notes),
        )
    })
}

/// A BVH file of the first clip.
fn motion(opened: &CharacterFile) -> Result<EncodedFile> {
    let options = bvh::WriteOptions {
        rate_hz: first_clip_rate_hz(opened.character()),
        end_sites: opened.end_sites().to_vec(),
        ..bvh::WriteOptions::default()
    };
    let (character, renamed) = joint_names::for_names_alone(opened);
    let bytes = bvh::write(&character, 0, &options)?;
    Ok(EncodedFile::new(
        bytes,
        meshes(opened).into_iter().chain(renamed),
    ))
}

/// An X3D file with an H-Anim figure.
fn humanoid(opened: &CharacterFile) -> Result<EncodedFile> {
    let site = |(joint, offset): &(usize, glam::Vec3)| Site {
        joint: *joint,
        name: String::new(),
        offset: *offset,
    };
    let sites: Vec<Site> = opened.end_sites().iter().map(site).collect();
    let written = x3d::write(opened.character(), &opened.articulation(), &sites)?;
    let notes = written.left_out.into_iter().map(LossyPart::Note);
    let left_out = mesh_levels(opened).into_iter().chain(notes);
    Ok(EncodedFile::new(written.bytes, left_out))
}

/// The glTF document with the current clips, or a new one.
fn container(opened: &CharacterFile, khr_character: bool) -> Result<EncodedFile> {
    let (mut document, nodes, left_out) = match opened.gltf() {
        None => {
            let document = Document::from_character(opened.character())?;
            let sites = counted(opened.end_sites().len(), LossyPart::EndSites);
            let nodes = (0..opened.character().skeleton.joints.len()).collect();
            (document, nodes, sites)
        }
        Some(behind) => {
            let mut document = behind.document.clone();
            if opened.clips_changed() {
                let (joints, meshes) = (&behind.node_of_joint, &behind.node_of_mesh);
                document.replace_clips(&opened.character().clips, joints, meshes)?;
            }
            (document, behind.node_of_joint.clone(), None)
        }
    };
    if khr_character {
        khr_character::write(opened, &mut document, &nodes)?;
    }
    Ok(EncodedFile::new(document.write_glb()?, left_out))
}
