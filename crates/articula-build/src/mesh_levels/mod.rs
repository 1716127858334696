//! Mesh levels of a character: simplified by its own motion, measured on other poses, stored as
//! index ranges.
//!
//! Source: thesis 3.1.2, `docs/methods/clustered-mesh.md`. One queue covers all parts of the
//! character (`simplify`), each part is clustered as one object (`clusters`), and each level of the
//! whole character has one error (`surface_distance`).

mod between;
mod kept;
mod mix;
mod reordered;

pub use kept::{LeftOutLevel, LeftOutReason};
pub use mix::{RegionMix, measure_levels, measure_mesh};

use crate::character::Asset;
use crate::clusters::{ClusterOrder, Clustered, cluster};
use crate::poses::{PoseOptions, PoseOrigin, Poses, SkinPose, poses, positions};
use crate::simplify::{LevelTriangles, Simplified, SimplifyOptions, simplify};
use crate::surface_distance::{DistanceOptions, LevelDistances};
use articula_core::source::Character;
use articula_core::{LevelRow, LevelTable, Mesh, Mismatch, Part};

/// Options of [`mesh_levels`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshLevelOptions {
    /// Maximum error of a level, at rest or in motion, relative to the longest side of the bounding
    /// box at rest; a level above it and all coarser ones are not made. `None` makes them all.
    pub max_error: Option<f32>,
    /// Where a level is left out for its error, how often the range of triangles between it and the next
    /// finer one is halved to find one that is within [`Self::max_error`]; that level is made instead. Not
    /// between the first two targets.
    pub halvings: u32,
    /// Simplification: targets, weights and constraints.
    pub simplify: SimplifyOptions,
    /// Selection of the poses for simplification and for measurement.
    pub poses: PoseOptions,
    /// Selection of the points that are measured.
    pub distance: DistanceOptions,
}

/// All mesh levels of a character; level 0 is the original, the last the coarsest.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshLevels {
    /// Triangles, vertices and errors of each level, at rest and in poses that simplification did
    /// not use.
    pub table: LevelTable,
    /// One object per part of the character's mesh; vertices are numbered within the part.
    pub objects: Vec<Clustered>,
    /// Triangles of each part at each level, as `parts[part][level]`; vertices are numbered within
    /// the part.
    pub parts: Vec<Vec<Vec<[u32; 3]>>>,
    /// Levels that were wanted and are not made, finest first.
    pub left_out: Vec<LeftOutLevel>,
    /// Longest side of the figure's bounding box at rest, in metres.
    pub size_metres: f32,
    /// Number of poses of each kind that errors in motion were measured on.
    pub measured: MeasurementPoses,
}

/// Number of measured poses by kind; all 0 if errors were measured at rest only.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MeasurementPoses {
    /// Frames of the character's clips.
    pub clips: usize,
    /// Random bends of its joints.
    pub bends: usize,
    /// Single morph targets.
    pub morphs: usize,
}

impl MeasurementPoses {
    fn new(poses: &[SkinPose]) -> Self {
        let mut out = Self::default();
        for pose in poses {
            match pose.origin {
                PoseOrigin::Rest => {}
                PoseOrigin::Clip { .. } => out.clips += 1,
                PoseOrigin::Bend { .. } => out.bends += 1,
                PoseOrigin::Morph { .. } => out.morphs += 1,
            }
        }
        out
    }
}

impl MeshLevels {
    /// Returns the larger of a level's maximum errors at rest and in motion, relative to
    /// [`Self::size_metres`]: what [`MeshLevelOptions::max_error`] limits.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn error_share(&self, level: usize) -> f32 {
        let row = &self.table.levels[level];
        kept::error_share(row.rest.max_metres, row.motion.max_metres, self.size_metres)
    }

    /// Returns the triangles of each level over the vertices of the mesh that the levels were made
    /// from.
    pub fn triangles(&self, mesh: &Mesh) -> Vec<Vec<[u32; 3]>> {
        let level = |l: usize| {
            let parts = mesh.parts.iter().zip(&self.parts);
            let of_part = |(part, levels): (&Part, &Vec<Vec<[u32; 3]>>)| {
                let first = part.vertices.start as u32;
                levels[l]
                    .iter()
                    .map(move |t| t.map(|v| v + first))
                    .collect::<Vec<_>>()
            };
            parts.flat_map(of_part).collect()
        };
        (0..self.table.levels.len()).map(level).collect()
    }

    /// Returns the character with these levels, its vertices in stored order.
    ///
    /// The result equals, bit for bit, what is read back from a document that these levels were
    /// written to, so data bound to the vertex order can be prepared without reading it again.
    /// Vertices that no level uses come last; coarser forms of a mesh in the source file are
    /// removed.
    ///
    /// # Errors
    /// A [`Mismatch`] if the meshes are not those that the levels were made from.
    pub fn character(&self, source: &Character) -> Result<Character, Mismatch> {
        Ok(Character {
            meshes: reordered::meshes(&source.meshes, &self.objects)?,
            mesh_levels: Some(self.table.clone()),
            ..source.clone()
        })
    }
}

/// Computes and measures all mesh levels of a character.
///
/// A level without triangles, one equal to the next finer level and one above
/// [`MeshLevelOptions::max_error`] are left out ([`MeshLevels::left_out`]).
///
/// # Errors
/// A [`Mismatch`] if the options do not fit the mesh, or the asset's parts belong to another
/// character.
pub fn mesh_levels(asset: &Asset, opts: &MeshLevelOptions) -> Result<MeshLevels, Mismatch> {
    let mesh = &asset.mesh;
    let (simplified, poses) = simplified(asset, opts)?;
    let kept::Kept {
        levels: simplified,
        distances,
        left_out,
        size_metres,
    } = kept::kept(asset, simplified, &poses, opts, true)?;
    let mut objects = Vec::with_capacity(mesh.parts.len());
    let mut parts = Vec::with_capacity(mesh.parts.len());
    for (p, part) in mesh.parts.iter().enumerate() {
        let levels = part_levels(&simplified, p, part);
        let of_part = opts.simplify.regions.get(part.vertices.clone());
        let regions: Vec<u16> = of_part.unwrap_or(&[]).iter().map(|r| (*r).into()).collect();
        let count = part.vertices.len();
        let mut object = cluster(&levels, count, &regions, ClusterOrder::Store)?;
        keep_unused(&mut object.vertices, count);
        objects.push(object);
        parts.push(levels);
    }
    let row = |(l, distances): (usize, &LevelDistances)| LevelRow {
        triangles: simplified[l].triangles.len() as u64,
        vertices: objects
            .iter()
            .map(|o: &Clustered| u64::from(o.clusters.vertices(l)))
            .sum(),
        rest: distances.rest,
        motion: distances.motion,
    };
    let table = LevelTable {
        levels: distances.iter().enumerate().map(row).collect(),
        regions: Vec::new(),
        mixable_to: objects.iter().map(|o| o.mixable_to).min().unwrap_or(0),
    };
    Ok(MeshLevels {
        table,
        objects,
        parts,
        left_out,
        size_metres,
        measured: MeasurementPoses::new(&poses.measuring),
    })
}

/// Simplifies the mesh of a character as [`mesh_levels`] does, and returns the triangles of each
/// level.
///
/// # Errors
/// As [`mesh_levels`].
pub fn mesh_level_triangles(
    asset: &Asset,
    opts: &MeshLevelOptions,
) -> Result<Vec<LevelTriangles>, Mismatch> {
    let (simplified, poses) = simplified(asset, opts)?;
    let is_limited = opts.max_error.is_some();
    Ok(kept::kept(asset, simplified, &poses, opts, is_limited)?.levels)
}

fn simplified(asset: &Asset, opts: &MeshLevelOptions) -> Result<(Simplified, Poses), Mismatch> {
    let poses = poses(asset, &opts.poses)?;
    let shaping = positions(asset, &poses.shaping);
    let options = SimplifyOptions {
        between: between::count(opts),
        ..opts.simplify.clone()
    };
    Ok((simplify(&asset.mesh, &shaping, &options)?, poses))
}

/// Appends the vertices that no level uses, so that a stored character has all vertices of its
/// source.
fn keep_unused(vertices: &mut Vec<u32>, count: usize) {
    let mut is_used = vec![false; count];
    for v in vertices.iter() {
        is_used[*v as usize] = true;
    }
    let all = (0..count as u32).zip(is_used);
    vertices.extend(all.filter(|(_, used)| !used).map(|(v, _)| v));
}

/// Triangles of one part at each level, vertices numbered within the part.
fn part_levels(simplified: &[LevelTriangles], p: usize, part: &Part) -> Vec<Vec<[u32; 3]>> {
    let first = part.vertices.start as u32;
    let local = |t: &[u32; 3]| t.map(|v| v - first);
    let of_level = simplified.iter().map(|level| {
        let triangles = &level.triangles[level.parts[p].clone()];
        triangles.iter().map(local).collect()
    });
    of_level.collect()
}
