//! The skins of all levels and their watched vertices.

use super::CacheOptions;
use crate::character::Asset;
use crate::joint_lods::{MergedLevels, Watched};
use articula_core::{Mesh, skin_points};
use glam::{Affine3A, Vec3};

/// The skins of all levels and the vertices to measure.
pub(super) struct Skins {
    meshes: Vec<Mesh>,
    watched: Watched,
    palette: Vec<Affine3A>,
}

impl Skins {
    /// Draws the vertices that level errors are measured at, if the seed is the same, and adds the tip
    /// of each joint's skin.
    pub(super) fn new(asset: &Asset, levels: &MergedLevels, opts: &CacheOptions) -> Self {
        let full = &asset.mesh;
        let all = 0..levels.skins.levels.len();
        Self {
            meshes: all.map(|level| levels.skins.mesh(level, full)).collect(),
            watched: Watched::tips(full, opts.vertices, opts.seed),
            palette: Vec::new(),
        }
    }

    /// Number of levels.
    pub(super) fn levels(&self) -> usize {
        self.meshes.len()
    }

    /// Mesh of a level.
    pub(super) fn mesh(&self, level: usize) -> &Mesh {
        &self.meshes[level]
    }

    /// Whether each watched vertex belongs to the sample over which percentiles are computed.
    pub(super) fn drawn(&self) -> &[bool] {
        &self.watched.drawn
    }

    /// Posed positions of the watched vertices of a level; the palette may hold more matrices than
    /// the level needs.
    pub(super) fn points(&mut self, level: usize, rows: &[[f32; 4]], out: &mut Vec<Vec3>) {
        let mut palette = std::mem::take(&mut self.palette);
        self.matrices(level, rows, &mut palette);
        self.posed(level, &palette, out);
        self.palette = palette;
    }

    /// Matrices of a level's bindings.
    pub(super) fn matrices(&self, level: usize, rows: &[[f32; 4]], out: &mut Vec<Affine3A>) {
        out.clear();
        let matrices = rows.chunks_exact(3).take(self.meshes[level].bindings.len());
        out.extend(matrices.map(matrix));
    }

    /// Posed positions of the watched vertices of a level.
    pub(super) fn posed(&self, level: usize, palette: &[Affine3A], out: &mut Vec<Vec3>) {
        out.resize(self.watched.vertices.len(), Vec3::ZERO);
        skin_points(&self.meshes[level], palette, &self.watched.vertices, out);
    }
}

fn matrix(rows: &[[f32; 4]]) -> Affine3A {
    let column = |c: usize| Vec3::new(rows[0][c], rows[1][c], rows[2][c]).into();
    Affine3A::from_cols(column(0), column(1), column(2), column(3))
}
