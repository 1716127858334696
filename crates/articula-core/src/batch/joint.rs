//! Working memory of one joint of a batch.

use super::lane_math::{load4, store4};
use crate::simd::{Piece, Rows, Tile};

/// Model-space matrix and rotation of one joint, for every character of a batch.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Joint<const W: usize> {
    /// Rows of the 3x4 model-from-joint matrix.
    pub(super) matrix: [[Tile<W>; 4]; 3],
    /// Rotation of that matrix; undefined at and below a scaled joint, and where matrices
    /// are written and no clip moves the joint nor any below it.
    pub(super) rotation: [Tile<W>; 4],
}

impl<const W: usize> Joint<W> {
    pub(super) const ZERO: Self = Self {
        matrix: [[Tile::ZERO; 4]; 3],
        rotation: [Tile::ZERO; 4],
    };
}

impl<const W: usize> Joint<W> {
    #[inline(always)]
    pub(super) fn rows<P: Piece<W>>(&self, piece: usize) -> [[P; 4]; 3] {
        let [x, y, z] = &self.matrix;
        [load4(x, piece), load4(y, piece), load4(z, piece)]
    }

    #[inline(always)]
    pub(super) fn set_rows<P: Piece<W>>(&mut self, rows: [[P; 4]; 3], piece: usize) {
        let [x, y, z] = &mut self.matrix;
        store4(rows[0], x, piece);
        store4(rows[1], y, piece);
        store4(rows[2], z, piece);
    }

    /// The last column: the local translation before [`Batch::chain`], the model-space position
    /// after it.
    #[inline(always)]
    pub(super) fn translation<P: Piece<W>>(&self, piece: usize) -> [P; 3] {
        let [x, y, z] = &self.matrix;
        [
            P::load_piece(&x[3].0, piece),
            P::load_piece(&y[3].0, piece),
            P::load_piece(&z[3].0, piece),
        ]
    }

    #[inline(always)]
    pub(super) fn set_translation<L: Rows<W>>(&mut self, v: [L; 3]) {
        let [x, y, z] = &mut self.matrix;
        v[0].store(&mut x[3]);
        v[1].store(&mut y[3]);
        v[2].store(&mut z[3]);
    }

    /// The first row, which holds the scale before [`Batch::chain`].
    #[inline(always)]
    pub(super) fn scale<P: Piece<W>>(&self, piece: usize) -> [P; 3] {
        let [x, y, z, _] = &self.matrix[0];
        [
            P::load_piece(&x.0, piece),
            P::load_piece(&y.0, piece),
            P::load_piece(&z.0, piece),
        ]
    }

    #[inline(always)]
    pub(super) fn set_scale<L: Rows<W>>(&mut self, v: [L; 3]) {
        let [x, y, z, _] = &mut self.matrix[0];
        v[0].store(x);
        v[1].store(y);
        v[2].store(z);
    }
}
