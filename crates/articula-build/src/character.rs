//! Builds the runtime rig, mesh and clips of a source character.

use crate::clip::{ClipOptions, MAX_NUMBERS, resample};
use crate::expression::bake;
use articula_core::source::{Character, RawClip, RawMesh, Skeleton};
use articula_core::{Articulation, Clip, Mesh, Mismatch, Rig};
use std::sync::Arc;

/// A character in runtime form: rig, mesh and clips.
///
/// Its parts are shared: an asset, a player or a crowd that is made of them copies no vertex and no
/// track. Another rig or mesh takes the place of one; `Arc::make_mut` copies before a change.
#[derive(Debug, Clone, PartialEq)]
pub struct Asset {
    /// Joint tree, rest pose and articulation.
    pub rig: Arc<Rig>,
    /// Mesh of all triangles, with its skin.
    pub mesh: Arc<Mesh>,
    /// Clips, in the order of the source.
    pub clips: Vec<Clip>,
}

/// Builds the rig, the mesh and the clips of a source character.
///
/// Clips that drive expressions become clips of morph weights and joints. `articulation`, for
/// example that of a joint map, takes precedence over the one that the source stores.
///
/// # Errors
/// A [`Mismatch`] that names the inconsistent part of the character: for example no joint at all,
/// no articulation from either side, or more clip data than the memory limit allows.
pub fn character(
    source: &Character,
    articulation: Option<Articulation>,
    opts: &ClipOptions,
) -> Result<Asset, Mismatch> {
    let articulation = articulation
        .or_else(|| source.articulation.clone())
        .ok_or_else(|| {
            Mismatch::new(
                "articulation",
                "missing in the file, and no joint map is given",
            )
        })?;
    let (rig, mesh) = rig_and_mesh(&source.skeleton, &source.meshes, articulation)?;
    let mut clips = Vec::with_capacity(source.clips.len());
    let mut numbers = 0usize;
    for c in &source.clips {
        let clip = sampled_clip(source, c, &mesh, opts)?;
        numbers += numbers_of(&clip);
        if numbers > MAX_NUMBERS {
            let what = format!("all clips together hold more than {MAX_NUMBERS} numbers");
            return Err(Mismatch::new(format!("clip \"{}\"", c.name), what));
        }
        clips.push(clip);
    }
    Ok(Asset {
        rig: rig.into(),
        mesh: mesh.into(),
        clips,
    })
}

/// Builds one clip of a source character, at a uniform rate; `mesh` is that of the character.
///
/// # Errors
/// A [`Mismatch`] if the clip names something that does not exist, or would exceed the memory limit.
///
/// # Panics
/// If the mesh is of another character.
pub fn sampled_clip(
    source: &Character,
    clip: &RawClip,
    mesh: &Mesh,
    opts: &ClipOptions,
) -> Result<Clip, Mismatch> {
    let meshes = source.meshes.iter();
    let counts: Vec<usize> = meshes.map(|m| m.morph_weights.len()).collect();
    let baked = bake(source, clip)?;
    resample(&baked, &source.skeleton, &mesh.morph_slots, &counts, opts)
}

/// Builds the rig and the mesh of a source character.
///
/// # Errors
/// A [`Mismatch`] that names the inconsistent part of the character.
pub fn rig_and_mesh(
    skeleton: &Skeleton,
    meshes: &[RawMesh],
    articulation: Articulation,
) -> Result<(Rig, Mesh), Mismatch> {
    let rig = Rig::new(skeleton, articulation)?;
    let mesh = Mesh::new(meshes, rig.len())?;
    Ok((rig, mesh))
}

/// Number of floats in the tracks of a clip.
fn numbers_of(clip: &Clip) -> usize {
    let vectors = clip
        .tracks()
        .translations
        .iter()
        .chain(&clip.tracks().scales);
    3 * vectors.map(|t| t.values.len()).sum::<usize>()
        + 4 * clip
            .tracks()
            .rotations
            .iter()
            .map(|t| t.values.len())
            .sum::<usize>()
        + clip
            .tracks()
            .morphs
            .iter()
            .map(|t| t.values.len())
            .sum::<usize>()
}

/// The reference human with the fewest triangles, for the tests of this crate.
#[cfg(test)]
pub(crate) mod small_human {
    use super::{Asset, ClipOptions, character};
    use articula_human::{HumanOptions, human};
    use std::sync::OnceLock;

    /// Created once, because its body takes seconds.
    pub(crate) fn small_human() -> &'static Asset {
        static HUMAN: OnceLock<Asset> = OnceLock::new();
        HUMAN.get_or_init(|| {
            let source = human(&HumanOptions::mannequin(2000)).unwrap();
            character(&source, None, &ClipOptions::default()).unwrap()
        })
    }
}
