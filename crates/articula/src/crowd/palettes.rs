//! Preallocated memory of palettes, and reading matrices back.

use articula_core::{PaletteForm, PaletteRows, f32_from_half};
use glam::{Affine3A, Mat3, Quat, Vec3, Vec4};

/// Palettes of a frame: rows of four numbers, [`PaletteForm::rows`] per matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PaletteSlice<'a> {
    /// Rows of 32-bit floats.
    Float(&'a [[f32; 4]]),
    /// Rows of half floats, as bits.
    Half(&'a [[u16; 4]]),
}

impl<'a> PaletteSlice<'a> {
    /// Returns the numbers as they lie in memory, for upload: 4 or 2 bytes each, of the byte order of the
    /// processor.
    pub fn bytes(self) -> &'a [u8] {
        match self {
            Self::Float(rows) => bytemuck::cast_slice(rows),
            Self::Half(rows) => bytemuck::cast_slice(rows),
        }
    }
}

/// Row storage for all palettes of a frame.
#[derive(Debug)]
pub(super) struct Palettes {
    form: PaletteForm,
    rows: Rows,
}

#[derive(Debug)]
enum Rows {
    Float(Vec<[f32; 4]>),
    Half(Vec<[u16; 4]>),
}

impl Palettes {
    /// Allocates space for a number of matrices.
    pub(super) fn new(form: PaletteForm, matrices: usize) -> Self {
        let rows = matrices * form.rows();
        let rows = if form.is_half() {
            Rows::Half(vec![[0; 4]; rows])
        } else {
            Rows::Float(vec![[0.0; 4]; rows])
        };
        Self { form, rows }
    }

    /// Returns the rows of the first `matrices` matrices, to be written.
    pub(super) fn first(&mut self, matrices: usize) -> PaletteRows<'_> {
        let rows = matrices * self.form.rows();
        match &mut self.rows {
            Rows::Float(all) => PaletteRows::Float(&mut all[..rows]),
            Rows::Half(all) => PaletteRows::Half(&mut all[..rows]),
        }
    }

    /// Reads one matrix.
    pub(super) fn matrix(&self, index: usize) -> Affine3A {
        let first = index * self.form.rows();
        let row = |i: usize| -> Vec4 {
            match &self.rows {
                Rows::Float(rows) => rows[first + i].into(),
                Rows::Half(rows) => rows[first + i].map(f32_from_half).into(),
            }
        };
        if self.form.is_rigid() {
            let turn = Quat::from_vec4(row(0)).normalize();
            return Affine3A::from_rotation_translation(turn, row(1).truncate());
        }
        let [x, y, z] = [row(0), row(1), row(2)];
        let linear = Mat3::from_cols(x.truncate(), y.truncate(), z.truncate()).transpose();
        Affine3A::from_mat3_translation(linear, Vec3::new(x.w, y.w, z.w))
    }

    /// Returns the first `matrices` matrices as 3x4 numbers; `None` unless they are stored so.
    pub(super) fn matrices(&self, matrices: usize) -> Option<&[[f32; 12]]> {
        let PaletteSlice::Float(rows) = self.written(matrices) else {
            return None;
        };
        let (whole, _) = rows.as_flattened().as_chunks();
        (self.form == PaletteForm::Matrix).then_some(whole)
    }

    /// Returns the rows of the first `matrices` matrices, to be read.
    pub(super) fn written(&self, matrices: usize) -> PaletteSlice<'_> {
        let rows = matrices * self.form.rows();
        match &self.rows {
            Rows::Float(all) => PaletteSlice::Float(&all[..rows]),
            Rows::Half(all) => PaletteSlice::Half(&all[..rows]),
        }
    }
}

/// The three rows of a transform's 3x4 matrix.
pub(super) fn rows(matrix: &Affine3A) -> [[f32; 4]; 3] {
    let linear = matrix.matrix3.transpose();
    let shift = matrix.translation.to_array();
    let row = |axis: glam::Vec3A, shift| [axis.x, axis.y, axis.z, shift];
    [
        row(linear.x_axis, shift[0]),
        row(linear.y_axis, shift[1]),
        row(linear.z_axis, shift[2]),
    ]
}

/// Splits rows at `at_row`.
pub(super) fn split(rows: PaletteRows<'_>, at_row: usize) -> (PaletteRows<'_>, PaletteRows<'_>) {
    match rows {
        PaletteRows::Float(rows) => {
            let (a, b) = rows.split_at_mut(at_row);
            (PaletteRows::Float(a), PaletteRows::Float(b))
        }
        PaletteRows::Half(rows) => {
            let (a, b) = rows.split_at_mut(at_row);
            (PaletteRows::Half(a), PaletteRows::Half(b))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::half_from_f32;

    #[test]
    fn matrices_are_read_as_they_are_written() {
        let expected = Affine3A::from_rotation_translation(
            Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            Vec3::new(1.0, 2.0, 3.0),
        );
        // A quarter turn about z: x goes to y, y to -x.
        let mut floats = Palettes::new(PaletteForm::Matrix, 2);
        if let PaletteRows::Float(rows) = floats.first(2) {
            rows[3] = [0.0, -1.0, 0.0, 1.0];
            rows[4] = [1.0, 0.0, 0.0, 2.0];
            rows[5] = [0.0, 0.0, 1.0, 3.0];
        }
        assert!(floats.matrix(1).abs_diff_eq(expected, 1e-6));
        let numbers = [0.0, -1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 3.0];
        assert_eq!(floats.matrices(2).unwrap()[1], numbers);
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f32::to_ne_bytes).collect();
        assert_eq!(floats.written(2).bytes()[48..], bytes);
        let mut halves = Palettes::new(PaletteForm::HalfRigid, 1);
        if let PaletteRows::Half(rows) = halves.first(1) {
            let h = std::f32::consts::FRAC_1_SQRT_2;
            rows[0] = [0.0, 0.0, h, h].map(half_from_f32);
            rows[1] = [1.0, 2.0, 3.0, 1.0].map(half_from_f32);
        }
        assert!(halves.matrix(0).abs_diff_eq(expected, 1e-3));
        assert!(halves.matrices(1).is_none());
        assert_eq!(halves.written(1).bytes().len(), 16);
    }

    #[test]
    fn rows_by_hand() {
        // A quarter turn about z, to (1, 2, 3): x goes to y, y to -x.
        let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let matrix = Affine3A::from_rotation_translation(turn, Vec3::new(1.0, 2.0, 3.0));
        let expected = [
            [0.0, -1.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 2.0],
            [0.0, 0.0, 1.0, 3.0],
        ];
        for (row, expected) in rows(&matrix).iter().zip(expected) {
            let near = |(a, b): (&f32, f32)| (a - b).abs() < 1e-6;
            assert!(row.iter().zip(expected).all(near), "{row:?}");
        }
    }
}
