//! Every writer's output, opened again: how far it lies from what was written.

use super::compare::{Apart, Kept, apart};
use crate::open::{self, Format, Opened, Told};
use anyhow::{Context, Result};
use articula_build::expression::bake;
use articula_build::source_rate_hz;
use articula_core::source::{Character, Clip};
use articula_formats::gltf::Document;
use articula_formats::{acclaim, bvh, x3d};
use std::path::{Path, PathBuf};

/// Farthest that a joint or vertex of a GLB may be from where it was, millimetres: its numbers
/// are the same 32-bit floats, multiplied in another order.
const GLB_MM: f32 = 0.001;
/// The same of a text format: six decimals of a degree and a unit over the whole chain.
const TEXT_MM: f32 = 0.1;

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
    /// An Acclaim skeleton, and a motion of the first clip.
    Acclaim,
    /// An H-Anim figure in X3D.
    X3d,
}

/// What a writer made.
enum Bytes {
    One(Vec<u8>),
    Pair(Vec<u8>, Option<Vec<u8>>),
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
    /// The greatest distance of a joint or vertex; endless if nothing came back.
    pub(super) fn worst_mm(&self) -> f32 {
        let worst = |a: &Apart| a.joints_mm.max(a.skin_mm.unwrap_or(0.0));
        self.apart.as_ref().map_or(f32::INFINITY, worst)
    }

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
    pub(super) const ALL: [Self; 6] = [
        Self::Through,
        Self::Clips,
        Self::Anew,
        Self::Bvh,
        Self::Acclaim,
        Self::X3d,
    ];

    /// Name as the table has it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Through => "GLB, passed through",
            Self::Clips => "GLB, clips anew",
            Self::Anew => "GLB, all anew",
            Self::Bvh => "BVH, first clip",
            Self::Acclaim => "ASF and AMC, first clip",
            Self::X3d => "X3D",
        }
    }

    /// Whether the Khronos validator can judge it.
    pub(super) fn is_glb(self) -> bool {
        matches!(self, Self::Through | Self::Clips | Self::Anew)
    }

    fn holds_all_clips(self) -> bool {
        self.is_glb() || self == Self::X3d
    }

    /// Farthest that a joint may be from where it was, millimetres.
    pub(super) fn bound_mm(self) -> f32 {
        if self.is_glb() { GLB_MM } else { TEXT_MM }
    }

    /// The bytes; `None` if this writer has nothing to write of the character.
    fn bytes(self, opened: &Opened) -> Result<Option<Bytes>> {
        let character = &opened.character;
        let clip = character.clips.first();
        let rate_hz = clip.map_or(30.0, source_rate_hz);
        let end_sites = opened.end_sites.clone();
        Ok(match (self, &opened.behind) {
            (Self::Through, Some(file)) => Some(Bytes::One(file.document.write_glb()?)),
            (Self::Clips, Some(file)) if clip.is_some() => {
                let mut document = file.document.clone();
                let (joints, meshes) = (&file.node_of_joint, &file.node_of_mesh);
                let clips = baked(character)?;
                document.replace_clips(&clips, joints, meshes)?;
                Some(Bytes::One(document.write_glb()?))
            }
            (Self::Anew, _) => {
                let baked = Character {
                    clips: baked(character)?,
                    ..character.clone()
                };
                let document = Document::from_character(&baked)?;
                Some(Bytes::One(document.write_glb()?))
            }
            (Self::Bvh, _) if clip.is_some() => {
                let options = bvh::WriteOptions {
                    rate_hz,
                    end_sites,
                    ..bvh::WriteOptions::default()
                };
                Some(Bytes::One(bvh::write(character, 0, &options)?))
            }
            // A skeleton alone does not say how high its root is.
            (Self::Acclaim, _) if clip.is_some() => {
                let options = acclaim::WriteOptions { rate_hz, end_sites };
                let made = acclaim::write(character, Some(0), &options)?;
                Some(Bytes::Pair(made.asf, made.amc))
            }
            (Self::X3d, _) => {
                let baked = Character {
                    clips: baked(character)?,
                    ..character.clone()
                };
                let articulation = &opened.mapping.articulation;
                let made = x3d::write(&baked, articulation, &x3d::WriteOptions::default())?;
                Some(Bytes::One(made.bytes))
            }
            _ => None,
        })
    }
}

/// The clips with their expressions written out, as a document holds them.
fn baked(character: &Character) -> Result<Vec<Clip>> {
    let clips = character.clips.iter();
    let baked = clips.map(|clip| Ok(bake(character, clip)?.into_owned()));
    baked.collect()
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
        if let (Ok(Bytes::One(bytes)), true) = (&bytes, writer.is_glb()) {
            let path = stem.with_extension(format!("{number}.glb"));
            std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
            kept = Some(path);
        }
        let clips = opened.character.clips.len();
        trips.push(Trip {
            writer,
            joints: joints(opened, writer),
            clips: if writer.holds_all_clips() {
                clips
            } else {
                clips.min(1)
            },
            apart: bytes.and_then(|bytes| again(opened, writer, &bytes, path)),
            path: kept,
        });
    }
    Ok(trips)
}

/// Reads what was written, and compares.
fn again(was: &Opened, writer: Writer, bytes: &Bytes, path: &Path) -> Result<Apart> {
    let is = match bytes {
        Bytes::One(bytes) if writer.is_glb() => {
            open::figure(bytes, Format::Glb, path, Told::Nothing)?
        }
        Bytes::One(bytes) if writer == Writer::X3d => {
            open::figure(bytes, Format::X3d, path, Told::Nothing)?
        }
        Bytes::One(bytes) => open::figure(bytes, Format::Bvh, path, Told::AsWritten)?,
        Bytes::Pair(asf, amc) => open::pair(asf, amc.as_deref(), Told::AsWritten)?,
    };
    let kept = match writer {
        _ if writer.is_glb() => Kept::All,
        Writer::X3d => Kept::Twins,
        _ => Kept::Skin,
    };
    apart(
        (&was.character, &was.mapping.articulation),
        (&is.character, &is.mapping.articulation),
        kept,
    )
}

/// Joints that a writer keeps: all or, in formats of joints alone, those of skins. In X3D those
/// are compared that stand for a joint of the standard; read again, a lone hand has none.
fn joints(opened: &Opened, writer: Writer) -> usize {
    let joints = &opened.character.skeleton.joints;
    let skin = joints.iter().filter(|j| j.in_skin);
    match skin.count() {
        _ if writer == Writer::X3d && !opened.mapping.humanoid => 0,
        _ if writer == Writer::X3d => opened.mapping.articulation.mapped(),
        0 => joints.len(),
        _ if writer.is_glb() => joints.len(),
        skin => skin,
    }
}
