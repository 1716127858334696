//! Mesh levels of a crowd's character, chosen together with those of its joints.

use crate::error::{Context, Result};
use articula_build::Asset;
use articula_build::{FigureLevel, figure_levels};
use articula_build::{LevelOptions, MergedLevels};
use articula_build::{PoseOptions, poses, positions};
use articula_build::{SimplifyOptions, simplify};
use articula_build::{SkinPoint, attach, compact};
use articula_core::Mesh;
use glam::Vec3;

/// Most mesh levels that can be asked for.
pub const MAX_MESH_LEVELS: usize = 5;

/// What joints and mesh together come to.
#[derive(Debug)]
pub(super) struct MeshLods {
    /// What each level of the crowd shows.
    pub(super) levels: Vec<FigureLevel>,
    /// Poses that the mesh was simplified by, the rest pose first.
    poses: Vec<Vec<Vec3>>,
}

/// Where the vertices of the full mesh are looked for on a level.
#[derive(Debug)]
pub(super) struct Watch {
    /// Vertices that are skinned.
    pub(super) vertices: Vec<u32>,
    /// Points between them, one for each vertex of the full mesh that is looked at; `None` if
    /// they are these vertices themselves.
    points: Option<Vec<SkinPoint>>,
}

impl Watch {
    /// The vertices themselves.
    pub(super) fn plain(vertices: &[u32]) -> Self {
        Self {
            vertices: vertices.to_vec(),
            points: None,
        }
    }

    /// Puts the points in the place of the skinned vertices.
    pub(super) fn place(&self, skinned: &mut Vec<Vec3>) {
        if let Some(points) = &self.points {
            let placed: Vec<Vec3> = points.iter().map(|p| p.posed(skinned)).collect();
            *skinned = placed;
        }
    }
}

impl MeshLods {
    /// Simplifies the mesh by the character's own poses to so many levels, and chooses pairs.
    /// Gives the levels of the crowd and their meshes too.
    pub(super) fn new(
        asset: &Asset,
        merged: &MergedLevels,
        mesh_levels: usize,
        opts: &LevelOptions,
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

    /// Where some vertices of the full mesh are looked for on the mesh of a level.
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
