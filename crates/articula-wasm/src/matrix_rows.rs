//! Matrices as three rows of four numbers (`docs/formats/crowd-buffers.md`).

use articula::glam::Affine3A;

/// Twelve numbers of a matrix, row by row.
pub(crate) type Rows = [f32; 12];

/// The rows of the identity.
pub(crate) const IDENTITY: Rows = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Returns the rows of a matrix.
pub(crate) fn rows(matrix: &Affine3A) -> Rows {
    let (m, t) = (matrix.matrix3, matrix.translation);
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    [x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z]
}

/// Byte offset of a slice in the memory of the module.
pub(crate) fn offset<T>(slice: &[T]) -> usize {
    slice.as_ptr().addr()
}
