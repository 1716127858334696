//! The output of every writer, opened again and compared with the original.

use super::compare::{Apart, JointFilter, apart};
use crate::open::{self, Told};
use anyhow::{Context, Result};
use articula::convert::{EncodedFile, write};
use articula::{CharacterFile, Format};
use articula_build::bake;
use articula_core::source::{Character, RawClip};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Maximum distance of a joint or vertex of a GLB from the original, millimetres: the numbers are
/// the same 32-bit floats, multiplied in another order.
const GLB_MM: f32 = 0.001;
/// Maximum distance in a text format, millimetres: six decimals of a degree and a unit over the
/// whole chain.
const TEXT_MM: f32 = 0.1;

/// One of the writers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Writer {
    /// The document that was read, unchanged.
    Through,
    /// The document with its clips written again.
    Clips,
    /// A new GLB from the character.
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
    /// Number of joints and clips that the format should hold.
    pub(super) joints: usize,
    pub(super) clips: usize,
    /// The comparison with the original, or why the file could not be read.
    pub(super) apart: Result<Apart>,
    /// Path of the file, if the validator can check it.
    pub(super) path: Option<PathBuf>,
}

impl Trip {
    /// Maximum distance of a joint or vertex; infinite if the file could not be read.
    pub(super) fn worst_mm(&self) -> f32 {
        let worst = |a: &Apart| a.joints_mm.max(a.skin_mm.unwrap_or(0.0));
        self.apart.as_ref().map_or(f32::INFINITY, worst)
    }

    /// Whether all joints and clips were read again.
    pub(super) fn is_complete(&self) -> bool {
        let found = |apart: &Apart| (apart.joints, apart.clips) == (self.joints, self.clips);
        self.apart.as_ref().is_ok_and(found)
    }

    /// Whether all joints and clips were read again within the bound.
    pub(super) fn holds(&self) -> bool {
        self.is_complete() && self.worst_mm() <= self.writer.bound_mm()
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

    /// Name of the writer in the table.
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

    /// Whether the Khronos validator can check the output.
    pub(super) fn is_glb(self) -> bool {
        matches!(self, Self::Through | Self::Clips | Self::Anew)
    }

    fn holds_all_clips(self) -> bool {
        self.is_glb() || self == Self::X3d
    }

    /// Maximum distance of a joint from the original, millimetres.
    pub(super) fn bound_mm(self) -> f32 {
        if self.is_glb() { GLB_MM } else { TEXT_MM }
    }

    /// Format of the output.
    fn format(self) -> Format {
        match self {
            Self::Through | Self::Clips | Self::Anew => Format::Glb,
            Self::Bvh => Format::Bvh,
            Self::Acclaim => Format::Asf,
            Self::X3d => Format::X3d,
        }
    }

    /// The written file; `None` if the writer has nothing to write of the character.
    fn written(self, opened: &CharacterFile) -> Result<Option<EncodedFile>> {
        let clips = !opened.character().clips.is_empty();
        let has = match self {
            Self::Through => opened.gltf().is_some(),
            Self::Clips => opened.gltf().is_some() && clips,
            // A skeleton without a motion does not store the height of its root.
            Self::Bvh | Self::Acclaim => clips,
            Self::Anew | Self::X3d => true,
        };
        if !has {
            return Ok(None);
        }
        let mut opened = Cow::Borrowed(opened);
        if matches!(self, Self::Clips | Self::Anew | Self::X3d) {
            let baked = baked(opened.character())?;
            *opened.to_mut().clips_mut() = baked;
        }
        if self == Self::Anew {
            opened.to_mut().detach_document();
        }
        Ok(Some(write(&opened, self.format())?))
    }
}

/// The clips with their expressions written as morph weights, as a document holds them.
fn baked(character: &Character) -> Result<Vec<RawClip>> {
    let clips = character.clips.iter();
    let baked = clips.map(|clip| Ok(bake(character, clip)?.into_owned()));
    baked.collect()
}

/// Writes a character with every writer, and reads each file again. Files for the validator are
/// kept at `stem` with the number of the writer appended.
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
        let clips = opened.character().clips.len();
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

/// Reads a written file, and compares it with the original.
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
        (was.character(), &was.mapping().articulation),
        (is.character(), &is.mapping().articulation),
        kept,
    )
}

/// Number of joints that a writer keeps: all or, in formats of joints only, those of skins. In X3D
/// only joints that correspond to one of the standard are compared.
fn joints(opened: &CharacterFile, writer: Writer) -> usize {
    let joints = &opened.character().skeleton.joints;
    let skin = joints.iter().filter(|j| j.in_skin);
    match skin.count() {
        _ if writer == Writer::X3d => opened.mapping().articulation.mapped(),
        0 => joints.len(),
        _ if writer.is_glb() => joints.len(),
        skin => skin,
    }
}
