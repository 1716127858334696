//! The files that a conversion makes, format by format.
//!
//! **A new format is one arm of [`written`] and one function below it.**

use super::{body, khr_character};
use crate::load::{Format, Loaded};
use crate::prepared::articulation_of;
use crate::table::counted;
use articula_build::source_rate_hz;
use articula_formats::gltf::Document;
use articula_formats::x3d::{self, Site};
use articula_formats::{acclaim, bvh};
use std::path::{Path, PathBuf};

/// What will be written.
#[derive(Debug)]
pub(super) struct Written {
    /// The file that was asked for, then those that must lie beside it.
    pub(super) files: Vec<(PathBuf, Vec<u8>)>,
    /// What the format cannot hold.
    pub(super) left_out: Vec<String>,
}

/// Whether a file of the format holds a single clip.
pub(super) fn holds_one_clip(format: Format) -> bool {
    needs_a_clip(format) || format == Format::Asf
}

/// Whether a file of the format is nothing without a clip.
pub(super) fn needs_a_clip(format: Format) -> bool {
    matches!(format, Format::Bvh | Format::Amc | Format::Bap)
}

/// What is asked of a container beside the character.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// Whether the clips are other than the document has.
    pub(super) clips_changed: bool,
    /// Whether the draft extensions for characters are written.
    pub(super) khr_character: bool,
}

/// Whether a file of the format holds every joint in every frame.
pub(super) fn holds_frames(format: Format) -> bool {
    holds_one_clip(format)
}

/// Makes the files.
pub(super) fn written(
    loaded: &Loaded,
    out: &Path,
    format: Format,
    asked: Asked,
) -> anyhow::Result<Written> {
    let (bytes, left_out) = match format {
        Format::Bvh => motion(loaded)?,
        Format::Bap => body::written(loaded, asked.clips_changed)?,
        Format::X3d => humanoid(loaded)?,
        Format::Asf | Format::Amc => return acclaim_pair(loaded, out, format),
        _ => container(loaded, asked)?,
    };
    Ok(Written {
        files: vec![(out.to_owned(), bytes)],
        left_out,
    })
}

/// A skeleton and, if there is a clip, a motion; the one that was asked for stands first.
fn acclaim_pair(loaded: &Loaded, out: &Path, format: Format) -> anyhow::Result<Written> {
    let clips = &loaded.character.clips;
    let options = acclaim::WriteOptions {
        rate_hz: clips.first().map_or(30.0, source_rate_hz),
        end_sites: loaded.end_sites.clone(),
    };
    let clip = (!clips.is_empty()).then_some(0);
    let made = acclaim::write(&loaded.character, clip, &options)?;
    let motion = made.amc.map(|amc| (out.with_extension("amc"), amc));
    let skeleton = Some((out.with_extension("asf"), made.asf));
    let files = match format {
        Format::Amc => [motion, skeleton],
        _ => [skeleton, motion],
    };
    let mut files: Vec<_> = files.into_iter().flatten().collect();
    // The name that was given may be in capitals.
    files[0].0 = out.to_owned();
    let meshes = loaded.character.meshes.len();
    let meshes = left(
        (meshes, "mesh", "meshes"),
        "ASF and AMC hold joints and one clip",
    );
    Ok(Written {
        files,
        left_out: meshes.into_iter().chain(made.left_out).collect(),
    })
}

/// A BVH file of the first clip.
fn motion(loaded: &Loaded) -> anyhow::Result<(Vec<u8>, Vec<String>)> {
    let rate_hz = loaded.character.clips.first().map_or(30.0, source_rate_hz);
    let options = bvh::WriteOptions {
        rate_hz,
        end_sites: loaded.end_sites.clone(),
        ..bvh::WriteOptions::default()
    };
    let bytes = bvh::write(&loaded.character, 0, &options)?;
    let meshes = loaded.character.meshes.len();
    let meshes = left((meshes, "mesh", "meshes"), "BVH holds joints and one clip");
    Ok((bytes, meshes.into_iter().collect()))
}

/// An H-Anim figure with everything that X3D holds.
fn humanoid(loaded: &Loaded) -> anyhow::Result<(Vec<u8>, Vec<String>)> {
    let site = |(joint, offset): &(usize, glam::Vec3)| Site {
        joint: *joint,
        name: String::new(),
        offset: *offset,
    };
    let options = x3d::WriteOptions {
        sites: loaded.end_sites.iter().map(site).collect(),
    };
    let written = x3d::write(&loaded.character, &articulation_of(loaded), &options)?;
    let notes = written.warnings.into_iter();
    let notes = notes.map(|note| format!("{}: {}", note.at, note.what));
    Ok((written.bytes, notes.collect()))
}

/// The document as it was but for its clips, or a new one.
fn container(loaded: &Loaded, asked: Asked) -> anyhow::Result<(Vec<u8>, Vec<String>)> {
    let (mut document, nodes, left_out) = match &loaded.behind {
        None => {
            let document = Document::from_character(&loaded.character)?;
            let sites = loaded.end_sites.len();
            let sites = left((sites, "end site", "end sites"), "GLB has no such thing");
            let nodes = (0..loaded.character.skeleton.joints.len()).collect();
            (document, nodes, sites)
        }
        Some(behind) => {
            let mut document = behind.document.clone();
            if asked.clips_changed {
                let (joints, meshes) = (&behind.node_of_joint, &behind.node_of_mesh);
                document.replace_clips(&loaded.character.clips, joints, meshes)?;
            }
            (document, behind.node_of_joint.clone(), None)
        }
    };
    if asked.khr_character {
        khr_character::write(loaded, &mut document, &nodes)?;
    }
    Ok((document.write_glb()?, left_out.into_iter().collect()))
}

/// How many of something are left out, and why; `None` if none is.
pub(super) fn left((count, one, many): (usize, &str, &str), why: &str) -> Option<String> {
    (count > 0).then(|| format!("{} ({why})", counted(count, one, many)))
}
