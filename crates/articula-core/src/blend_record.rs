//! What a vertex shader reads of a character whose palette it blends from two cached ones.
//!
//! Source: `docs/methods/runtime.md` 4.1.

/// Blend of two cached palettes for one character: the 16 bytes that leave the CPU when the GPU
/// blends.
///
/// The cached palettes ([`PoseCache::rows`](crate::PoseCache::rows)) are uploaded once, three rows of four numbers per
/// matrix. Each frame a vertex shader then reads the record of its instance and computes, for a
/// vertex that is bound to entry `b` of the palette,
///
/// ```text
/// let r = records[instance];
/// let m = mix(palettes[r.before + b], palettes[r.after + b], r.blend);   // row by row
/// let model_position = m * rest_position;              // summed over influences as usual
/// let world_position = characters[r.character] * model_position;
/// ```
///
/// Blending the two skinned positions instead gives the same point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct BlendRecord {
    /// Index of the first matrix of the cached palette at or before the time.
    pub before: u32,
    /// Index of the first matrix of the cached palette after it; `before` at the last key.
    pub after: u32,
    /// Blend between the two, 0 to 1.
    pub blend: f32,
    /// Index of the character, for example into its world transforms.
    pub character: u32,
}

const _: () = assert!(size_of::<BlendRecord>() == 16);

impl BlendRecord {
    /// Returns the record that shows a cached palette as it is, for character 0.
    pub fn of_key(first_matrix: u32) -> Self {
        Self {
            before: first_matrix,
            after: first_matrix,
            ..Self::default()
        }
    }

    /// Returns the record for a character.
    #[must_use]
    pub(crate) fn of(self, character: u32) -> Self {
        Self { character, ..self }
    }

    /// Returns the bytes that a GPU reads: four little-endian words in the order of the fields.
    pub fn to_le_bytes(self) -> [u8; 16] {
        let words = [
            self.before,
            self.after,
            self.blend.to_bits(),
            self.character,
        ];
        let mut bytes = [0; 16];
        for (to, word) in bytes.chunks_exact_mut(4).zip(words) {
            to.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_a_record() {
        let record = BlendRecord {
            before: 1,
            after: 0x0203,
            blend: 1.0,
            ..BlendRecord::default()
        };
        let bytes = [1, 0, 0, 0, 3, 2, 0, 0, 0, 0, 0x80, 0x3f, 9, 0, 0, 0];
        assert_eq!(record.of(9).to_le_bytes(), bytes);
    }
}
