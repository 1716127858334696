//! Hash of all written palettes and morph target weights, to compare runs bit by bit.

use super::palettes::PaletteSlice;
use super::player::CrowdPlayer;

/// Offset and prime of the 64-bit hash FNV-1a.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

/// A hash over all written palette bits, in order.
///
/// Source: Fowler, Noll and Vo, FNV-1a; differs: processes eight bytes at a time instead of one.
#[derive(Debug, Clone, Copy)]
pub struct PaletteHash(u64);

impl Default for PaletteHash {
    /// The hash of no data.
    fn default() -> Self {
        Self(FNV_OFFSET)
    }
}

impl PaletteHash {
    /// Adds the palettes, blend records, stepped draws, impostors and morph target weights of a
    /// player's current frame.
    pub fn add(&mut self, player: &CrowdPlayer) {
        let matrices = player.crowd().draw_list().matrices;
        self.add_rows(matrices, player.palettes());
        player.cached_words().for_each(|word| self.add_word(word));
        for weight in player.morph_weights() {
            self.add_word(u64::from(weight.to_bits()));
        }
    }

    /// Adds palettes.
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

    fn add_word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(FNV_PRIME);
        // The product moves bits up only; this moves them down again.
        self.0 ^= self.0 >> 32;
    }

    /// Returns the hash as 16 hexadecimal digits.
    pub fn text(&self) -> String {
        format!("{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::palettes::Palettes;
    use articula_core::{PaletteForm, PaletteRows};

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
