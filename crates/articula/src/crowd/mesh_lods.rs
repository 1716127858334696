//! Mesh levels of a crowd's character, chosen together with its joint levels.

use crate::error::{Context, Result};
use crate::figure::Figure;
#[cfg(feature = "prepare")]
use crate::mesh_levels;
use crate::mesh_levels::MeshLevelOptions;
use crate::prepared::stored::Stored;
use articula_build::{Asset, Borders, JointLodOptions, MergedLevels, SkinPoint, attach, compact};
use articula_build::{PoseOptions, figure_levels, paired_levels, poses, positions};
use articula_core::{FigureLevel, Mesh};
use glam::Vec3;
use std::sync::OnceLock;

/// Levels of joints and mesh, combined.
#[derive(Debug)]
pub(crate) struct MeshLods {
    /// Joints, mesh and influences of each crowd level.
    pub(crate) levels: Vec<FigureLevel>,
    seed: u64,
    /// Computed when a measurement first needs them.
    poses: OnceLock<(Vec<Vec<Vec3>>, Borders)>,
}

/// Levels of a crowd with their meshes.
pub(crate) struct LevelledMeshes {
    /// The pairs of joint and mesh levels, if there are coarser meshes.
    pub(crate) mesh_lods: Option<MeshLods>,
    /// The levels.
    pub(crate) levels: MergedLevels,
    /// Mesh of each level.
    pub(crate) meshes: Vec<Mesh>,
    /// Whether they are those that the asset stores.
    pub(crate) is_stored: bool,
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
    /// Pairs joint levels with mesh levels, given as triangles over the vertices of the asset's
    /// mesh. Stored pairs are used if they fit.
    pub(crate) fn paired(
        asset: &Asset,
        merged: &MergedLevels,
        triangles: Vec<Vec<[u32; 3]>>,
        opts: &JointLodOptions,
        stored: Option<&Stored<'_>>,
    ) -> Result<LevelledMeshes> {
        let levels: Vec<&[[u32; 3]]> = triangles.iter().map(Vec::as_slice).collect();
        let mut lods = Self {
            levels: Vec::new(),
            seed: opts.seed,
            poses: OnceLock::new(),
        };
        let (lods_of, clips) = (&merged.joint_lods, asset.clips.len());
        let known = stored.and_then(|s| s.paired_levels(lods_of, clips, levels.len()));
        let is_stored = known.is_some();
        let found = match known {
            Some(known) => paired_levels(asset, merged, known.levels, known.errors),
            None => {
                let (poses, _) = lods.poses(asset).context("poses")?;
                figure_levels(asset, merged, &levels, poses, opts)
            }
        };
        let found = found.context("levels")?;
        let all = 0..found.levels.len();
        let meshes = all.map(|l| found.mesh(l, &asset.mesh, &levels)).collect();
        lods.levels = found.levels;
        Ok(LevelledMeshes {
            mesh_lods: Some(lods),
            levels: found.merged,
            meshes,
            is_stored,
        })
    }

    /// Poses by which points of the levels correspond to vertices, the rest pose first, and the borders of materials.
    fn poses(&self, asset: &Asset) -> Result<&(Vec<Vec<Vec3>>, Borders)> {
        if let Some(known) = self.poses.get() {
            return Ok(known);
        }
        let options = PoseOptions {
            seed: self.seed,
            ..PoseOptions::default()
        };
        let mut found = poses(asset, &options)?;
        found.shaping.append(&mut found.measuring);
        let poses = positions(asset, &found.shaping);
        let borders = Borders::of(&asset.mesh, &poses[0]);
        // A second thread would have computed the same.
        Ok(self.poses.get_or_init(|| (poses, borders)))
    }

    /// Finds the points that correspond to vertices of the full mesh on the mesh of a level.
    pub(super) fn watch(
        &self,
        asset: &Asset,
        level: usize,
        mesh: &Mesh,
        vertices: &[u32],
    ) -> Watch {
        let (poses, borders) = match self.poses(asset) {
            Ok(known) if self.levels[level].mesh_level != self.levels[0].mesh_level => known,
            // Poses cannot fail for an asset whose levels were made.
            _ => return Watch::plain(vertices),
        };
        let points = attach(&mesh.triangles, vertices, poses, &mesh.parts, borders);
        let (vertices, points) = compact(&points);
        Watch {
            points: Some(points),
            vertices,
        }
    }
}

/// Triangles of each mesh level of a character, of which there may be fewer than wanted.
pub(super) struct MeshLevelTriangles {
    /// The finest level first, as [`canonical`] returns them.
    pub(super) levels: Vec<Vec<[u32; 3]>>,
    /// Whether they are those of the file.
    pub(super) are_stored: bool,
}

/// Triangles of at most `most` mesh levels: those of the file, unless it has none or more, or
/// those that `prepare` would make with the options; none if this build does not prepare.
pub(super) fn mesh_level_triangles(
    figure: Option<&Figure>,
    asset: &Asset,
    most: usize,
    options: &MeshLevelOptions,
) -> Result<MeshLevelTriangles> {
    let stored = figure.filter(|f| f.stored_mesh_level_count() <= most);
    let mut stored = stored.and_then(Figure::stored_mesh_levels);
    if let Some(levels) = &mut stored {
        // Of a character without some of its meshes the coarsest levels may be empty.
        let filled = levels.iter().take_while(|level| !level.is_empty());
        levels.truncate(filled.count());
    }
    let are_stored = stored.is_some();
    let triangles = match stored {
        Some(stored) => stored,
        None => made(figure, asset, options)?,
    };
    Ok(MeshLevelTriangles {
        levels: canonical(triangles),
        are_stored,
    })
}

#[cfg(feature = "prepare")]
fn made(
    figure: Option<&Figure>,
    asset: &Asset,
    options: &MeshLevelOptions,
) -> Result<Vec<Vec<[u32; 3]>>> {
    match figure {
        Some(figure) => mesh_levels::triangles(figure, options),
        None => mesh_levels::triangles_of(asset, options),
    }
}

#[cfg(not(feature = "prepare"))]
fn made(_: Option<&Figure>, asset: &Asset, _: &MeshLevelOptions) -> Result<Vec<Vec<[u32; 3]>>> {
    Ok(vec![asset.mesh.triangles.clone()])
}

/// Triangles of levels in one order, since simplification and storage order them differently.
pub(crate) fn canonical(mut levels: Vec<Vec<[u32; 3]>>) -> Vec<Vec<[u32; 3]>> {
    for level in &mut levels {
        for triangle in level.iter_mut() {
            let least = (0..3).min_by_key(|c| triangle[*c]).unwrap_or(0);
            triangle.rotate_left(least);
        }
        level.sort_unstable();
    }
    levels
}
