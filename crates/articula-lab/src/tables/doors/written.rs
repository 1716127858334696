//! Every writer's output, opened again: how far it lies from what was written.

use super::compare::{Apart, apart};
use crate::open::{self, Format, Opened, Told};
use anyhow::{Context, Result};
use articula_build::clip::source_rate_hz;
use articula_core::source::Character;
use articula_formats::bvh;
use articula_formats::gltf::Document;
use std::path::{Path, PathBuf};

/// Farthest that a joint or vertex of a GLB may be from where it was, millimetres: its numbers
/// are the same 32-bit floats, multiplied in another order.
const GLB_MM: f32 = 0.001;
/// The same of a BVH file: six decimals of a degree and a centimetre over the whole chain.
const BVH_MM: f32 = 0.1;

/// One way to write a character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Writer {
    /// The document that was read, as it is.
    Through,
    /// The same with its clips written anew.
    Clips,
    /// A new GLB from the character alone.
    Anew,
    /// A BVH file of the first clip.
    Bvh,
}

/// A written file that was opened again.
pub(super) struct Trip {
    pub(super) writer: Writer,
    /// Joints and clips that the format should hold.
    pub(super) joints: usize,
    pub(super) clips: usize,
    /// What came back, or why nothing did.
    pub(super) apart: Result<Apart>,
    /// Where it lies for the validator, if that can judge it.
    pub(super) path: Option<PathBuf>,
}

impl Trip {
    /// Whether everything came back within the bound.
    pub(super) fn holds(&self) -> bool {
        let bound = self.writer.bound_mm();
        self.apart.as_ref().is_ok_and(|apart| {
            (apart.joints, apart.clips) == (self.joints, self.clips)
                && apart.joints_mm <= bound
                && apart.skin_mm.is_none_or(|mm| mm <= bound)
        })
    }
}

impl Writer {
    pub(super) const ALL: [Self; 4] = [Self::Through, Self::Clips, Self::Anew, Self::Bvh];

    /// Name as the table has it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Through => "GLB, passed through",
            Self::Clips => "GLB, clips anew",
            Self::Anew => "GLB, all anew",
            Self::Bvh => "BVH, first clip",
        }
    }

    /// Whether the Khronos validator can judge it.
    pub(super) fn is_glb(self) -> bool {
        self != Self::Bvh
    }

    /// Farthest that a joint may be from where it was, millimetres.
    pub(super) fn bound_mm(self) -> f32 {
        if self.is_glb() { GLB_MM } else { BVH_MM }
    }

    /// The bytes; `None` if this writer has nothing to write of the character.
    fn bytes(self, opened: &Opened) -> Result<Option<Vec<u8>>> {
        let character = &opened.character;
        Ok(match (self, &opened.behind) {
            (Self::Through, Some(file)) => Some(file.document.write_glb()?),
            (Self::Clips, Some(file)) if !character.clips.is_empty() => {
                let mut document = file.document.clone();
                let (joints, meshes) = (&file.node_of_joint, &file.node_of_mesh);
                document.replace_clips(&character.clips, joints, meshes)?;
                Some(document.write_glb()?)
            }
            (Self::Anew, _) => Some(Document::from_character(character)?.write_glb()?),
            (Self::Bvh, _) if !character.clips.is_empty() => {
                let options = bvh::WriteOptions {
                    rate_hz: source_rate_hz(&character.clips[0]),
                    end_sites: opened.end_sites.clone(),
                    ..bvh::WriteOptions::default()
                };
                Some(bvh::write(character, 0, &options)?)
            }
            _ => None,
        })
    }
}

/// Writes a character in every way that there is, and reads each again. What the validator
/// can judge is left at `stem` with the writer's number behind it.
pub(super) fn trips(opened: &Opened, path: &Path, stem: &Path) -> Result<Vec<Trip>> {
    let mut trips = Vec::new();
    for (number, writer) in Writer::ALL.into_iter().enumerate() {
        let bytes = match writer.bytes(opened) {
            Ok(None) => continue,
            Ok(Some(bytes)) => Ok(bytes),
            Err(fault) => Err(fault),
        };
        let mut kept = None;
        if let (Ok(bytes), true) = (&bytes, writer.is_glb()) {
            let path = stem.with_extension(format!("{number}.glb"));
            std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
            kept = Some(path);
        }
        let clips = opened.character.clips.len();
        trips.push(Trip {
            writer,
            joints: joints(&opened.character, writer),
            clips: if writer.is_glb() { clips } else { clips.min(1) },
            apart: bytes.and_then(|bytes| again(opened, writer, &bytes, path)),
            path: kept,
        });
    }
    Ok(trips)
}

/// Reads what was written, and compares.
fn again(was: &Opened, writer: Writer, bytes: &[u8], path: &Path) -> Result<Apart> {
    let format = if writer.is_glb() {
        Format::Glb
    } else {
        Format::Bvh
    };
    let is = open::opened(bytes, format, path, Told::Centimetres)?;
    apart(
        (&was.character, &was.mapping.articulation),
        (&is.character, &is.mapping.articulation),
    )
}

/// Joints that a writer keeps: all, or in BVH those of skins and what stands above them.
fn joints(character: &Character, writer: Writer) -> usize {
    let joints = &character.skeleton.joints;
    let any_skin = joints.iter().any(|j| j.in_skin);
    if writer.is_glb() || !any_skin {
        return joints.len();
    }
    let mut kept: Vec<bool> = joints.iter().map(|j| j.in_skin).collect();
    for (j, joint) in joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            kept[parent] |= kept[j];
        }
    }
    kept.iter().filter(|k| **k).count()
}
