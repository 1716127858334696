//! One choice of levels as a mesh of its own: each region of the body at a level.
//!
//! Source: thesis figure 6.2 (head fine, body coarse), `docs/methods/clustered-mesh.md` part 4.

use super::{MeasurementPoses, MeshLevelOptions, reordered};
use crate::character::Asset;
use crate::clusters::{ClusterOrder, Clustered, cluster};
use crate::poses::{Poses, SkinPose, poses, positions};
use crate::surface_distance::{DistanceOptions, LevelDistances, surface_distances};
use articula_core::source::{Character, RawMesh};
use articula_core::{ClusteredTriangles, Mesh, Mismatch};

/// The triangles of a character with each region at a level, and the vertices that they use.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionMix {
    /// One object of a single level for each primitive, counted over all meshes.
    pub objects: Vec<Clustered>,
}

impl RegionMix {
    /// Selects the triangles of a character with stored levels. `levels` has one level for each
    /// region of its table of levels.
    ///
    /// # Errors
    /// A [`Mismatch`] if the character has no levels, or its table does not allow the mix
    /// ([`LevelTable::check_mix`](articula_core::LevelTable::check_mix)).
    pub fn new(character: &Character, levels: &[u16]) -> Result<Self, Mismatch> {
        let Some(table) = &character.mesh_levels else {
            return Err(Mismatch::new("meshes", "the character has no mesh levels"));
        };
        table.check_mix(levels)?;
        let mut objects = Vec::new();
        for mesh in &character.meshes {
            for (p, primitive) in mesh.primitives.iter().enumerate() {
                let shown = match mesh.clustered.get(p) {
                    None => primitive.triangles.clone(),
                    Some(stored) => stored.mix(own(stored, levels)?)?.collect(),
                };
                let vertices = primitive.positions.len();
                objects.push(cluster(&[shown], vertices, &[], ClusterOrder::Store)?);
            }
        }
        Ok(Self { objects })
    }

    /// Returns the character with these triangles alone: vertices that none of them uses are
    /// removed, and so are all other levels.
    ///
    /// # Errors
    /// A [`Mismatch`] if the meshes are not those that the triangles were selected from.
    pub fn character(&self, source: &Character) -> Result<Character, Mismatch> {
        let mut meshes = reordered::meshes(&source.meshes, &self.objects)?;
        let stored = |mesh: &mut RawMesh| mesh.clustered.clear();
        meshes.iter_mut().for_each(stored);
        Ok(Character {
            meshes,
            mesh_levels: None,
            ..source.clone()
        })
    }
}

/// Levels of the regions of one object, which may lack the last regions of the character.
fn own<'a>(stored: &ClusteredTriangles, levels: &'a [u16]) -> Result<&'a [u16], Mismatch> {
    let regions = stored.clusters.regions();
    levels.get(..regions).ok_or_else(|| {
        let what = format!("{regions} regions, the table has {}", levels.len());
        Mismatch::new("clusters", what)
    })
}

/// Measures the distance of the surface of an asset from other triangles over its vertices, in the
/// poses on which [`mesh_levels`](super::mesh_levels) measures with the same options.
///
/// # Errors
/// A [`Mismatch`] if a triangle names a vertex that the mesh does not have, or the asset's parts
/// belong to another character.
pub fn measure_levels(
    asset: &Asset,
    levels: &[&[[u32; 3]]],
    opts: &MeshLevelOptions,
) -> Result<(Vec<LevelDistances>, MeasurementPoses), Mismatch> {
    let poses = poses(asset, &opts.poses)?;
    let all: Vec<&[[u32; 3]]> = std::iter::once(asset.mesh.triangles.as_slice())
        .chain(levels.iter().copied())
        .collect();
    let mut distances = measured(asset, &all, &poses, &opts.distance)?;
    distances.remove(0);
    Ok((distances, MeasurementPoses::new(&poses.measuring)))
}

/// Measures the distance of the surface of an asset from that of another mesh of the same character,
/// such as a decoded one, at several choices of the other mesh's triangles. Poses are those of
/// [`measure_levels`].
///
/// # Errors
/// A [`Mismatch`] if the other mesh has other morph targets, a triangle names a vertex that it does
/// not have, or the asset's parts belong to another character.
pub fn measure_mesh(
    asset: &Asset,
    other: &Mesh,
    levels: &[&[[u32; 3]]],
    opts: &MeshLevelOptions,
) -> Result<(Vec<LevelDistances>, MeasurementPoses), Mismatch> {
    let (found, wanted) = (other.morph_weights.len(), asset.mesh.morph_weights.len());
    let joints = other.bindings.iter().map(|b| usize::from(b.joint));
    if found != wanted || joints.max().is_some_and(|j| j >= asset.rig.len()) {
        let what = format!("{found} morph targets, expected {wanted}, or joints of another rig");
        return Err(Mismatch::new("mesh", what));
    }
    let poses = poses(asset, &opts.poses)?;
    let both = |pose: &SkinPose| {
        let mut all = pose.positions(asset);
        all.extend(pose.positions_of(asset, other));
        all
    };
    let rest = both(&poses.shaping[0]);
    let motion: Vec<_> = poses.measuring.iter().map(both).collect();
    let first = asset.mesh.len() as u32;
    let moved = |level: &&[[u32; 3]]| -> Vec<[u32; 3]> {
        level
            .iter()
            .map(|t| t.map(|v| v.saturating_add(first)))
            .collect()
    };
    let levels: Vec<Vec<[u32; 3]>> = levels.iter().map(moved).collect();
    let levels: Vec<&[[u32; 3]]> = levels.iter().map(Vec::as_slice).collect();
    let original = &asset.mesh.triangles;
    let distances = surface_distances(original, &levels, &rest, &motion, &opts.distance)?;
    Ok((distances, MeasurementPoses::new(&poses.measuring)))
}

/// Distances of each of several levels from the first, whose own distance is 0.
pub(super) fn measured(
    asset: &Asset,
    levels: &[&[[u32; 3]]],
    poses: &Poses,
    opts: &DistanceOptions,
) -> Result<Vec<LevelDistances>, Mismatch> {
    let Some((original, coarser)) = levels.split_first() else {
        return Ok(Vec::new());
    };
    let rest = positions(asset, &poses.shaping[..1]);
    let motion = positions(asset, &poses.measuring);
    let coarser = surface_distances(original, coarser, &rest[0], &motion, opts)?;
    // The original has no error.
    let original = std::iter::once(LevelDistances::default());
    Ok(original.chain(coarser).collect())
}
