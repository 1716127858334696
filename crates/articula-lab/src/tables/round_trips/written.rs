//! Every writer's output, opened again: how far it lies from what was written.

use super::compare::{Apart, JointFilter, apart};
use crate::open::{self, Told};
use anyhow::{Context, Result};
use articula::convert::{EncodedFile, write};
use articula::{CharacterFile, Format};
use articula_build::bake;
use articula_core::source::{Character, RawClip};
use std::borrow::Cow;
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

    /// The format that it writes.
    fn format(self) -> Format {
        match self {
            Self::Through | Self::Clips | Self::Anew => Format::Glb,
            Self::Bvh => Format::Bvh,
            Self::Acclaim => Format::Asf,
            Self::X3d => Format::X3d,
        }
    }

    /// The bytes; `None` if this writer has nothing to write of the character.
    fn written(self, opened: &CharacterFile) -> Result<Option<EncodedFile>> {
        let clips = !opened.character.clips.is_empty();
        let has = match self {
            Self::Through => opened.gltf.is_some(),
            Self::Clips => opened.gltf.is_some() && clips,
            // A skeleton alone does not say how high its root is.
            Self::Bvh | Self::Acclaim => clips,
            Self::Anew | Self::X3d => true,
        };
        if !has {
            return Ok(None);
        }
        let mut opened = Cow::Borrowed(opened);
        if matches!(self, Self::Clips | Self::Anew | Self::X3d) {
            let baked = baked(&opened.character)?;
            let opened = opened.to_mut();
            opened.character.clips = baked;
            opened.clips_changed = true;
        }
        if self == Self::Anew {
            opened.to_mut().gltf = None;
        }
        Ok(Some(write(&opened, self.format())?))
    }
}

/// The clips with their expressions written out, as a document holds them.
fn baked(character: &Character) -> Result<Vec<RawClip>> {
    let clips = character.clips.iter();
    let baked = clips.map(|clip| Ok(bake(character, clip)?.into_owned()));
    baked.collect()
}

/// Writes a character in every way that there is, and reads each again. What the validator
/// can judge is left at `stem` with the writer's number behind it.
pub(super) fn trips(opened: &CharacterFile, path: &Path, stem: &Path) -> Result<Vec<Trip>> {
    let mut trips = Vec::new();
    for (number, writer) in Writer::ALL.into_iter().enumerate() {
        let written = match writer.written(opened) {
            Ok(None) => continue,
            Ok(Some(written)) => Ok(written),
            Err(fault) => Err(fault),
        };
        let mut kept = None;
        if let (Ok(written), true) = (&written, writer.is_glb()) {
            let path = stem.with_extension(format!("{number}.glb"));
            std::fs::write(&path, &written.bytes).with_context(|| path.display().to_string())?;
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
            apart: written.and_then(|written| again(opened, writer, written, path)),
            path: kept,
        });
    }
    Ok(trips)
}

/// Reads what was written, and compares.
fn again(was: &CharacterFile, writer: Writer, written: EncodedFile, path: &Path) -> Result<Apart> {
    let (told, format) = match writer {
        Writer::Bvh | Writer::Acclaim => (Told::AsWritten, writer.format()),
        _ => (Told::Nothing, writer.format()),
    };
    let is = match written.beside {
        None => open::figure((&written.bytes, None), format, path, told)?,
        Some((beside, bytes)) => open::figure((&bytes, Some(written.bytes)), beside, path, told)?,
    };
    let kept = match writer {
        _ if writer.is_glb() => JointFilter::All,
        Writer::X3d => JointFilter::Twins,
        _ => JointFilter::Skin,
    };
    apart(
        (&was.character, &was.mapping.articulation),
        (&is.character, &is.mapping.articulation),
        kept,
    )
}

/// Joints that a writer keeps: all or, in formats of joints alone, those of skins. In X3D those
/// are compared that stand for a joint of the standard; read again, a lone hand has none.
fn joints(opened: &CharacterFile, writer: Writer) -> usize {
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
