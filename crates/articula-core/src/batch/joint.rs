//! Working memory of one joint of a batch.

use super::lane_math::{load4, store4};
use crate::simd::{Rows, Tile};

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
    pub(super) fn rows<L: Rows<W>>(&self) -> [[L; 4]; 3] {
        let [x, y, z] = &self.matrix;
        [load4(x), load4(y), load4(z)]
    }

    #[inline(always)]
    pub(super) fn set_rows<L: Rows<W>>(&mut self, rows: [[L; 4]; 3]) {
        let [x, y, z] = &mut self.matrix;
        store4(rows[0], x);
        store4(rows[1], y);
        store4(rows[2], z);
    }

    /// The last column: the local translation before [`Batch::chain`], the model-space position
    /// after it.
    #[inline(always)]
    pub(super) fn translation<L: Rows<W>>(&self) -> [L; 3] {
        let [x, y, z] = &self.matrix;
        [L::load(&x[3].0), L::load(&y[3].0), L::load(&z[3].0)]
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
    pub(super) fn scale<L: Rows<W>>(&self) -> [L; 3] {
        let [x, y, z, _] = &self.matrix[0];
        [L::load(&x.0), L::load(&y.0), L::load(&z.0)]
    }

    #[inline(always)]
    pub(super) fn set_scale<L: Rows<W>>(&mut self, v: [L; 3]) {
        let [x, y, z, _] = &mut self.matrix[0];
        v[0].store(x);
        v[1].store(y);
        v[2].store(z);
    }
}
