//! The memory that palettes are written to, made once, and reading them again.

use super::player::CrowdPlayer;
use articula_core::f32_from_half;
use articula_core::palette::{PaletteForm, PaletteRows};
use articula_core::pose_cache::BlendRecord;
use glam::{Affine3A, Mat3, Quat, Vec3, Vec4};

/// Offset and factor of the 64-bit hash of Fowler, Noll and Vo, variant 1a.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

/// Palettes as they were written: rows of four numbers, [`PaletteForm::rows`] for each matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PaletteSlice<'a> {
    /// The forms in f32.
    Float(&'a [[f32; 4]]),
    /// The forms in half floats, as bits.
    Half(&'a [[u16; 4]]),
}

/// Rows for all palettes of a frame.
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
    /// Room for so many matrices.
    pub(super) fn new(form: PaletteForm, matrices: usize) -> Self {
        let rows = matrices * form.rows();
        let rows = if form.is_half() {
            Rows::Half(vec![[0; 4]; rows])
        } else {
            Rows::Float(vec![[0.0; 4]; rows])
        };
        Self { form, rows }
    }

    /// The rows of the first so many matrices.
    pub(super) fn first(&mut self, matrices: usize) -> PaletteRows<'_> {
        let rows = matrices * self.form.rows();
        match &mut self.rows {
            Rows::Float(all) => PaletteRows::Float(&mut all[..rows]),
            Rows::Half(all) => PaletteRows::Half(&mut all[..rows]),
        }
    }

    /// One matrix.
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

    /// The rows of the first so many matrices, to be read.
    pub(super) fn written(&self, matrices: usize) -> PaletteSlice<'_> {
        let rows = matrices * self.form.rows();
        match &self.rows {
            Rows::Float(all) => PaletteSlice::Float(&all[..rows]),
            Rows::Half(all) => PaletteSlice::Half(&all[..rows]),
        }
    }
}

/// Splits rows into those of the first so many matrices and the rest.
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

/// A hash over every bit that was written, in order.
///
/// Source: Fowler, Noll and Vo, FNV-1a; differs: by eight bytes at a time instead of one.
#[derive(Debug, Clone, Copy)]
pub struct PaletteHash(u64);

impl Default for PaletteHash {
    /// Of nothing yet.
    fn default() -> Self {
        Self(FNV_OFFSET)
    }
}

impl PaletteHash {
    /// Goes on with what a player shows by now: palettes, then records.
    pub fn add(&mut self, player: &CrowdPlayer) {
        let matrices = player.crowd().matrices();
        self.add_rows(matrices, player.palettes());
        self.add_records(player.crowd().records());
    }

    /// Goes on with palettes.
    fn add_rows(&mut self, matrices: usize, rows: PaletteSlice<'_>) {
        self.add_word(matrices as u64);
        match rows {
            PaletteSlice::Float(rows) => {
                for [x, y, z, w] in rows.iter().map(|r| r.map(f32::to_bits)) {
                    self.add_word(u64::from(x) | u64::from(y) << 32);
                    self.add_word(u64::from(z) | u64::from(w) << 32);
                }
            }
            PaletteSlice::Half(rows) => {
                for [x, y, z, w] in rows.iter().map(|r| r.map(u64::from)) {
                    self.add_word(x | y << 16 | z << 32 | w << 48);
                }
            }
        }
    }

    /// Goes on with the records of those whom the GPU blends.
    fn add_records(&mut self, records: &[BlendRecord]) {
        for bytes in records.iter().map(|r| r.to_le_bytes()) {
            let (words, _) = bytes.as_chunks::<8>();
            words
                .iter()
                .for_each(|w| self.add_word(u64::from_le_bytes(*w)));
        }
    }

    fn add_word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(FNV_PRIME);
        // The product moves bits up only; this brings them down again.
        self.0 ^= self.0 >> 32;
    }

    /// As 16 digits.
    pub fn text(&self) -> String {
        format!("{:016x}", self.0)
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
        // Turned a quarter about z: x goes to y, y to -x.
        let mut floats = Palettes::new(PaletteForm::Matrix, 2);
        if let PaletteRows::Float(rows) = floats.first(2) {
            rows[3] = [0.0, -1.0, 0.0, 1.0];
            rows[4] = [1.0, 0.0, 0.0, 2.0];
            rows[5] = [0.0, 0.0, 1.0, 3.0];
        }
        assert!(floats.matrix(1).abs_diff_eq(expected, 1e-6));
        let mut halves = Palettes::new(PaletteForm::HalfRigid, 1);
        if let PaletteRows::Half(rows) = halves.first(1) {
            let h = std::f32::consts::FRAC_1_SQRT_2;
            rows[0] = [0.0, 0.0, h, h].map(half_from_f32);
            rows[1] = [1.0, 2.0, 3.0, 1.0].map(half_from_f32);
        }
        assert!(halves.matrix(0).abs_diff_eq(expected, 1e-3));
    }

    #[test]
    fn every_bit_counts() {
        let hashed = |at: usize, value: f32| {
            let mut output = Palettes::new(PaletteForm::Matrix, 4);
            if let PaletteRows::Float(rows) = output.first(4) {
                rows[at / 4][at % 4] = value;
            }
            let mut hash = PaletteHash::default();
            hash.add_rows(4, output.written(4));
            hash.text()
        };
        let mut all: Vec<String> = (0..48).map(|at| hashed(at, 1.0)).collect();
        all.extend([hashed(0, 0.0), hashed(0, -0.0), hashed(7, f32::EPSILON)]);
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 51);
    }
}
