//! The recipe: a source character becomes the read-only nouns of the frame.

use crate::clip::{ClipOptions, MAX_NUMBERS, resample};
use crate::expression::bake;
use articula_core::source::Character;
use articula_core::{Articulation, Clip, Mesh, Mismatch, Rig};

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

/// Builds rig, mesh and clips; clips that drive expressions become clips of morph weights and
/// joints. The articulation is the one given (a name map's), or else the
/// one that the source stores.
///
/// # Errors
/// A [`Mismatch`] that names the part of the character that does not fit, for example one
/// without any joint, without an articulation from either side, or with more motion than memory
/// should hold.
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
    let mut clips = Vec::with_capacity(source.clips.len());
    let mut numbers = 0usize;
    for c in &source.clips {
        let c = bake(source, c)?;
        let clip = resample(&c, &source.skeleton, &mesh.morph_slots, &counts, opts)?;
        numbers += numbers_of(&clip);
        if numbers > MAX_NUMBERS {
            let what = format!("all clips together hold more than {MAX_NUMBERS} numbers");
            return Err(Mismatch::new(format!("clip \"{}\"", c.name), what));
        }
        clips.push(clip);
    }
    Ok(Asset { rig, mesh, clips })
}

/// Numbers that the tracks of a clip hold.
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
