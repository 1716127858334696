//! Encoding of a character, format by format.
//!
//! **A new format is one arm of [`written`] and one function below it.**

use super::left_out::{EncodedFile, LossyPart, counted, mesh_levels, meshes};
use super::{AbpProfile, AfpProfile, ClipEdited, ConvertOptions, body, joint_names, khr_character};
use crate::clip_streams::{abp1, abp2, afp1, afp2, fba};
use crate::error::{Error, Result};
use crate::open::{CharacterFile, Data, DataFormat, Format};
use crate::resampling::{ClipResampling, clip_resampling, keyed_mm};
use articula_build::sampling_rate_hz;
use articula_core::fap_table::FAP_COUNT;
use articula_formats::gltf::Document;
use articula_formats::mpeg4::fap::{self, FapClip};
use articula_formats::x3d::{self, Site};
use articula_formats::{acclaim, bvh, live_link};
use articula_stream::StreamLimits;
use articula_stream::abp2::MotionOptions;
use articula_stream::fba::FbaOptions;

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
        Data::Fap(clip) => return write_faps(clip, DataFormat::Fap, &AfpProfile::default()),
        Data::LiveLink(capture) => {
            return Ok(EncodedFile {
                bytes: live_link::write(capture),
                ..EncodedFile::default()
            });
        }
        Data::Epf(_) => DataFormat::Epf,
        Data::Fdp(_) => DataFormat::Fdp,
    };
    Err(Error::unsuited(format.advice()))
}

/// Writes a FAP clip as a FAP file, an FBA stream, or an AFP stream of the given profile, which alone
/// has options, as such or in an MP4 file.
///
/// # Errors
/// An [`Error`] if the rate, the frames or a value cannot be written, or the format is of another
/// kind of data.
pub fn write_faps(clip: &FapClip, format: DataFormat, profile: &AfpProfile) -> Result<EncodedFile> {
    if format == DataFormat::Mp4 {
        return boxed(write_faps(clip, DataFormat::Afp, profile)?);
    }
    let mut tiers = Vec::new();
    let (bytes, left_out) = match (format, profile) {
        (DataFormat::Fap, _) => (fap::write(clip), still(clip)),
        (DataFormat::Fba, _) => (fba::write(clip, &FbaOptions::default())?, columns(clip)),
        (DataFormat::Afp, AfpProfile::Afp1(options)) => (afp1::write(clip, options)?, None),
        (DataFormat::Afp, AfpProfile::Afp2(options)) => {
            let coded = afp2::write(clip, options)?;
            tiers = abp2::tiers(&coded, options.tolerance_metres)?;
            (coded.bytes, None)
        }
        _ => return Err(Error::unsuited(format.advice())),
    };
    Ok(EncodedFile {
        bytes,
        tiers,
        left_out: left_out.into_iter().collect(),
        ..EncodedFile::default()
    })
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
        Format::Abp | Format::Abpt => stream(opened, format, options),
        Format::Mp4 => boxed(stream(opened, Format::Abp, options)?),
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
    let is_blended = matches!(format, Format::Abp | Format::Mp4)
        && !matches!(options.abp, Some(AbpProfile::Abp1(_)));
    let mut all = if is_blended {
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

/// The name of the columns by which blend shapes became parameters, which FBA cannot hold.
fn columns(clip: &FapClip) -> Option<LossyPart> {
    let name = clip.bridge.as_ref()?;
    let what =
        format!("the name of the columns of the blend shapes, {name} (.fap and .afp hold it)");
    Some(LossyPart::Note(what))
}

/// Parameters that the masks select but that never change.
fn still(clip: &FapClip) -> Option<LossyPart> {
    let moving = clip.moving();
    let still = (0..FAP_COUNT).filter(|fap| clip.coded[*fap] && !moving[*fap]);
    counted(still.count(), LossyPart::StillParameters)
}

/// A stream of the first clip, or its text.
fn stream(opened: &CharacterFile, format: Format, options: &ConvertOptions) -> Result<EncodedFile> {
    let plain = AbpProfile::Abp2(MotionOptions::default());
    match (format, options.abp.as_ref().unwrap_or(&plain)) {
        (Format::Abpt, _) => {
            let clip = abp1::from_character(opened.character(), &opened.articulation(), 0)?;
            let bytes = articula_stream::abp1::write_text(&clip)?.into_bytes();
            Ok(bones(opened, bytes))
        }
        (_, AbpProfile::Abp1(options)) => {
            let articulation = opened.articulation();
            let bytes = abp1::write(opened.character(), &articulation, 0, options)?;
            Ok(bones(opened, bytes))
        }
        (_, AbpProfile::Abp2(options)) => {
            let coded = abp2::write(opened.character(), &opened.articulation(), 0, options)?;
            Ok(EncodedFile {
                tiers: abp2::tiers(&coded, options.tolerance_metres)?,
                bytes: coded.bytes,
                ..EncodedFile::default()
            })
        }
    }
}

/// A stream in an MP4 file.
fn boxed(stream: EncodedFile) -> Result<EncodedFile> {
    let bytes = articula_stream::mp4::write(&[&stream.bytes], &StreamLimits::default())?;
    Ok(EncodedFile { bytes, ..stream })
}

/// A stream of bones, with what it cannot hold.
fn bones(opened: &CharacterFile, bytes: Vec<u8>) -> EncodedFile {
    let sites = opened.end_sites().len();
    let sites = (sites > 0).then(|| format!("the ends of {sites} joints"));
    let channels = opened
        .character()
        .clips
        .iter()
        .flat_map(|clip| &clip.channels);
    let others = channels.filter(|c| !c.property.is_of_joint()).count();
    let others = (others > 0).then(|| "motion of morph targets and expressions".to_owned());
    let notes = sites.into_iter().chain(others).map(LossyPart::Note);
    EncodedFile {
        bytes,
        left_out: meshes(opened).into_iter().chain(notes).collect(),
        ..EncodedFile::default()
    }
}

/// An ASF skeleton and, if there is a clip, an AMC motion; the requested one is the main file.
fn acclaim_pair(opened: &CharacterFile, format: Format) -> Result<EncodedFile> {
    let clips = &opened.character().clips;
    let options = acclaim::WriteOptions {
        rate_hz: rate_hz(opened),
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
        bytes,
        beside,
        left_out: meshes(opened)
            .into_iter()
            .chain(renamed)
            .chain(notes)
            .collect(),
        ..EncodedFile::default()
    })
}

/// The rate of the frames of the first clip.
fn rate_hz(opened: &CharacterFile) -> f32 {
    let character = opened.character();
    match character.clips.first() {
        Some(clip) => sampling_rate_hz(clip, &character.skeleton),
        None => 30.0,
    }
}

/// A BVH file of the first clip.
fn motion(opened: &CharacterFile) -> Result<EncodedFile> {
    let options = bvh::WriteOptions {
        rate_hz: rate_hz(opened),
        end_sites: opened.end_sites().to_vec(),
        ..bvh::WriteOptions::default()
    };
    let (character, renamed) = joint_names::for_names_alone(opened);
    Ok(EncodedFile {
        bytes: bvh::write(&character, 0, &options)?,
        left_out: meshes(opened).into_iter().chain(renamed).collect(),
        ..EncodedFile::default()
    })
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
    Ok(EncodedFile {
        bytes: written.bytes,
        left_out: mesh_levels(opened).into_iter().chain(notes).collect(),
        ..EncodedFile::default()
    })
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
    Ok(EncodedFile {
        bytes: document.write_glb()?,
        left_out: left_out.into_iter().collect(),
        ..EncodedFile::default()
    })
}
