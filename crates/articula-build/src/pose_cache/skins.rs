//! The skins of all levels and their watched vertices.

use super::CacheOptions;
use super::level_error::{BoundedSkin, LevelError};
use crate::character::Asset;
use crate::joint_lods::{MergedLevels, Watched};
use articula_core::{Mesh, skin_points};
use glam::{Affine3A, Vec3};

/// The skins of all levels and the vertices to measure.
pub(super) struct Skins {
    meshes: Vec<Mesh>,
    /// Patches of each level.
    bounded: Vec<BoundedSkin>,
    watched: Watched,
    palette: Vec<Affine3A>,
}

impl Skins {
    /// Draws the vertices that level errors are measured at, if the seed is the same, and adds the tip
    /// of each joint's skin.
    pub(super) fn new(asset: &Asset, levels: &MergedLevels, opts: &CacheOptions) -> Self {
        let full = &asset.mesh;
        let all = 0..levels.skins.levels.len();
        let meshes: Vec<Mesh> = all.map(|level| levels.skins.mesh(level, full)).collect();
        let watched = Watched::tips(full, opts.vertices, opts.seed);
        let drawn = watched.vertices.iter().zip(&watched.drawn);
        let sample: Vec<u32> = drawn.filter(|(_, d)| **d).map(|(v, _)| *v).collect();
        let bounded = meshes.iter().map(|m| BoundedSkin::new(m, &sample));
        Self {
            bounded: bounded.collect(),
            meshes,
            watched,
            palette: Vec::new(),
        }
    }

    /// Mesh of a level.
    pub(super) fn mesh(&self, level: usize) -> &Mesh {
        &self.meshes[level]
    }

    /// The error of nothing yet at a level.
    pub(super) fn error(&self, level: usize) -> LevelError<'_> {
        LevelError::new(&self.meshes[level], &self.bounded[level])
    }

    /// Whether each watched vertex belongs to the sample over which percentiles are computed.
    pub(super) fn drawn(&self) -> &[bool] {
        &self.watched.drawn
    }

    /// Posed positions of the watched vertices of a level; the palette may hold more matrices than
    /// the level needs.
    pub(super) fn points(&mut self, level: usize, rows: &[[f32; 4]], out: &mut Vec<Vec3>) {
        let mesh = &self.meshes[level];
        self.palette.clear();
        let matrices = rows.chunks_exact(3).take(mesh.bindings.len());
        self.palette.extend(matrices.map(matrix));
        out.resize(self.watched.vertices.len(), Vec3::ZERO);
        skin_points(mesh, &self.palette, &self.watched.vertices, out);
    }
}

pub(super) fn matrix(rows: &[[f32; 4]]) -> Affine3A {
    let column = |c: usize| Vec3::new(rows[0][c], rows[1][c], rows[2][c]).into();
    Affine3A::from_cols(column(0), column(1), column(2), column(3))
}
