//! Mesh levels of a crowd's character, chosen together with its joint levels.

use crate::error::{Context, Result};
use articula_build::Asset;
use articula_build::{FigureLevel, figure_levels};
use articula_build::{JointLodOptions, MergedLevels};
use articula_build::{PoseOptions, poses, positions};
use articula_build::{SimplifyOptions, simplify};
use articula_build::{SkinPoint, attach, compact};
use articula_core::Mesh;
use glam::Vec3;

/// Maximum number of mesh levels.
pub const MAX_MESH_LEVELS: usize = 5;

/// Levels of joints and mesh, combined.
#[derive(Debug)]
pub(super) struct MeshLods {
    /// Joints, mesh and influences of each crowd level.
    pub(super) levels: Vec<FigureLevel>,
    /// Poses that the mesh was simplified for, rest pose first.
    poses: Vec<Vec<Vec3>>,
}

/// Points on a level's mesh that correspond to vertices of the full mesh.
#[derive(Debug)]
pub(super) struct Watch {
    /// Vertices to be skinned.
    pub(super) vertices: Vec<u32>,
    /// Points between them, one for each compared vertex of the full mesh; `None` if they are these
    /// vertices.
    points: Option<Vec<SkinPoint>>,
}

impl Watch {
    /// Compares the vertices themselves.
    pub(super) fn plain(vertices: &[u32]) -> Self {
        Self {
            vertices: vertices.to_vec(),
            points: None,
        }
    }

    /// Replaces skinned vertices by the points between them.
    pub(super) fn place(&self, skinned: &mut Vec<Vec3>) {
        if let Some(points) = &self.points {
            let placed: Vec<Vec3> = points.iter().map(|p| p.posed(skinned)).collect();
            *skinned = placed;
        }
    }
}

impl MeshLods {
    /// Simplifies the mesh to a number of levels, using the character's own poses, and chooses
    /// pairs of joint and mesh levels. Also returns the levels of the crowd and their meshes.
    pub(super) fn new(
        asset: &Asset,
        merged: &MergedLevels,
        mesh_levels: usize,
        opts: &JointLodOptions,
    ) -> Result<(Self, MergedLevels, Vec<Mesh>)> {
        let pose_options = PoseOptions {
            seed: opts.seed,
            ..PoseOptions::default()
        };
        let shaping = poses(asset, &pose_options).context("poses")?.shaping;
        let poses = positions(asset, &shaping);
        let mut options = SimplifyOptions::default();
        options.targets.truncate(mesh_levels);
        let simplified = simplify(&asset.mesh, &poses, &options).context("mesh levels")?;
        let levels = simplified.levels.iter().map(|l| l.triangles.as_slice());
        let levels: Vec<&[[u32; 3]]> = levels.collect();
        let found = figure_levels(asset, merged, &levels, &poses, opts).context("levels")?;
        let all = 0..found.levels.len();
        let meshes = all.map(|l| found.mesh(l, &asset.mesh, &levels)).collect();
        let lods = Self {
            levels: found.levels,
            poses,
        };
        Ok((lods, found.merged, meshes))
    }

    /// Finds the points that correspond to vertices of the full mesh on the mesh of a level.
    pub(super) fn watch(&self, level: usize, mesh: &Mesh, vertices: &[u32]) -> Watch {
        if self.levels[level].mesh_level == self.levels[0].mesh_level {
            return Watch::plain(vertices);
        }
        let points = attach(&mesh.triangles, vertices, &self.poses, &mesh.parts);
        let (vertices, points) = compact(&points);
        Watch {
            points: Some(points),
            vertices,
        }
    }
}
