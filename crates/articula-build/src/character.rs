//! The recipe: a source character becomes the read-only nouns of the frame.

use crate::clip::{ClipOptions, resample};
use articula_core::Mismatch;
use articula_core::articulation::Articulation;
use articula_core::clip::Clip;
use articula_core::mesh::Mesh;
use articula_core::rig::Rig;
use articula_core::source::Character;

/// A character that is ready to be played.
#[derive(Debug, Clone, PartialEq)]
pub struct Asset {
    /// Joint tree, rest pose, level of articulation data.
    pub rig: Rig,
    /// All triangles with their skin.
    pub mesh: Mesh,
    /// Motions, in the order of the source.
    pub clips: Vec<Clip>,
}

/// Builds rig, mesh and clips. The articulation is the one given (a name map's), or else the
/// one that the source stores.
///
/// # Errors
/// A [`Mismatch`] that names the part of the character that does not fit, for example one
/// without any joint, or without an articulation from either side.
pub fn character(
    source: &Character,
    articulation: Option<Articulation>,
    opts: &ClipOptions,
) -> Result<Asset, Mismatch> {
    let articulation = articulation
        .or_else(|| source.articulation.clone())
        .ok_or_else(|| Mismatch::new("articulation", "neither the file nor a profile gives one"))?;
    let rig = Rig::new(&source.skeleton, articulation)?;
    let mesh = Mesh::new(&source.meshes, rig.len())?;
    let counts: Vec<usize> = source
        .meshes
        .iter()
        .map(|m| m.morph_weights.len())
        .collect();
    let clips = source
        .clips
        .iter()
        .map(|c| resample(c, &source.skeleton, &mesh.morph_slots, &counts, opts))
        .collect::<Result<_, _>>()?;
    Ok(Asset { rig, mesh, clips })
}
