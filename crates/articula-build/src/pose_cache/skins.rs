//! Watched vertices of the skins of all levels.

use super::CacheOptions;
use crate::character::Asset;
use crate::joint_lods::MergedLevels;
use crate::points::draw_vertices;
use articula_core::{Mesh, skin_points};
use glam::{Affine3A, Vec3};

/// The skins of all levels and the sample of vertices to measure.
pub(super) struct Skins {
    meshes: Vec<Mesh>,
    vertices: Vec<u32>,
    palette: Vec<Affine3A>,
}

impl Skins {
    /// Draws the vertices that level errors are measured at, if the seed is the same.
    pub(super) fn new(asset: &Asset, levels: &MergedLevels, opts: &CacheOptions) -> Self {
        let full = &asset.mesh;
        let mut vertices = draw_vertices(full.len(), opts.vertices, opts.seed);
        vertices.retain(|v| full.positions[*v as usize].is_finite());
        let all = 0..levels.skins.levels.len();
        Self {
            meshes: all.map(|level| levels.skins.mesh(level, full)).collect(),
            vertices,
            palette: Vec::new(),
        }
    }

    /// Number of levels.
    pub(super) fn levels(&self) -> usize {
        self.meshes.len()
    }

    /// Posed positions of the watched vertices of a level; the palette may hold more matrices than
    /// the level needs.
    pub(super) fn points(&mut self, level: usize, rows: &[[f32; 4]], out: &mut Vec<Vec3>) {
        let mesh = &self.meshes[level];
        self.palette.clear();
        let matrices = rows.chunks_exact(3).take(mesh.bindings.len());
        self.palette.extend(matrices.map(matrix));
        out.resize(self.vertices.len(), Vec3::ZERO);
        skin_points(mesh, &self.palette, &self.vertices, out);
    }
}

fn matrix(rows: &[[f32; 4]]) -> Affine3A {
    let column = |c: usize| Vec3::new(rows[0][c], rows[1][c], rows[2][c]).into();
    Affine3A::from_cols(column(0), column(1), column(2), column(3))
}
