//! The hash by which stored data knows what it was computed from: BLAKE3 over numbers in the order
//! in which they are given, the same on every platform.
//!
//! It finds data that is out of date; it is no protection against tampering.

use articula_core::{Rig, Transform};

/// Hash of some bytes: the first 8 of BLAKE3, as a little-endian number.
pub fn hash_bytes(bytes: &[u8]) -> u64 {
    first_bytes(&blake3::hash(bytes))
}

/// Hash of a rig: for each joint its parent (`u64::MAX` for none), its name and its rest pose.
///
/// Form: `docs/formats/motion-tables.md`.
pub fn rig_hash(rig: &Rig) -> u64 {
    let mut hash = SourceHash::default();
    for joint in 0..rig.len() {
        hash.index(rig.parent(joint));
        hash.text(rig.name(joint));
        hash.transform(&rig.rest_pose().get(joint));
    }
    hash.finish()
}

/// Hashes numbers and text one after another.
///
/// Numbers are 64-bit, floats and indices 32-bit, all little-endian; text and arrays begin with their
/// length, so that no two sequences of arrays have the same bytes.
#[derive(Default)]
pub struct SourceHash {
    /// What is not hashed yet: BLAKE3 is fast over long runs only.
    bytes: Vec<u8>,
    hasher: blake3::Hasher,
}

impl SourceHash {
    const RUN_BYTES: usize = 1 << 15;

    fn flush(&mut self) {
        self.hasher.update(&self.bytes);
        self.bytes.clear();
    }

    fn put(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
        if self.bytes.len() >= Self::RUN_BYTES {
            self.flush();
        }
    }

    /// Adds a number.
    pub fn number(&mut self, value: usize) {
        self.put(&(value as u64).to_le_bytes());
    }

    /// Adds an index; `u64::MAX`, on any platform, for none.
    pub fn index(&mut self, index: Option<usize>) {
        let index = index.map_or(u64::MAX, |index| index as u64);
        self.put(&index.to_le_bytes());
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.number(text.len());
        self.put(text.as_bytes());
    }

    /// Adds an array of floats.
    pub fn floats(&mut self, values: impl ExactSizeIterator<Item = f32>) {
        self.number(values.len());
        let mut words = Words::of(self);
        values.for_each(|value| words.put(value.to_le_bytes()));
        words.finish();
    }

    /// Adds an array of vectors.
    pub fn vectors<const N: usize>(&mut self, values: impl ExactSizeIterator<Item = [f32; N]>) {
        self.number(values.len());
        let mut words = Words::of(self);
        values.for_each(|value| value.iter().for_each(|x| words.put(x.to_le_bytes())));
        words.finish();
    }

    /// Adds an array of indices.
    pub fn indices(&mut self, values: impl ExactSizeIterator<Item = u32>) {
        self.number(values.len());
        let mut words = Words::of(self);
        values.for_each(|value| words.put(value.to_le_bytes()));
        words.finish();
    }

    /// Adds translation, rotation and scale as arrays of floats.
    pub fn transform(&mut self, transform: &Transform) {
        self.floats(transform.translation.to_array().into_iter());
        self.floats(transform.rotation.to_array().into_iter());
        self.floats(transform.scale.to_array().into_iter());
    }

    /// Returns the first 8 bytes of BLAKE3, as a little-endian number.
    pub fn finish(mut self) -> u64 {
        self.flush();
        first_bytes(&self.hasher.finalize())
    }
}

/// Numbers that are added together.
const RUN: usize = 256;

/// Numbers of an array that are added together: one at a time takes longer than hashing them.
struct Words<'a> {
    hash: &'a mut SourceHash,
    kept: [[u8; 4]; RUN],
    count: usize,
}

impl<'a> Words<'a> {
    fn of(hash: &'a mut SourceHash) -> Self {
        Self {
            hash,
            kept: [[0; 4]; RUN],
            count: 0,
        }
    }

    #[inline]
    fn put(&mut self, word: [u8; 4]) {
        if self.count == RUN {
            self.flush();
        }
        self.kept[self.count] = word;
        self.count += 1;
    }

    fn flush(&mut self) {
        self.hash.put(self.kept[..self.count].as_flattened());
        self.count = 0;
    }

    fn finish(mut self) {
        self.flush();
    }
}

fn first_bytes(hash: &blake3::Hash) -> u64 {
    let [a, b, c, d, e, f, g, h, ..] = *hash.as_bytes();
    u64::from_le_bytes([a, b, c, d, e, f, g, h])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_published_vectors() {
        // Test vectors of BLAKE3: no input, and 2,048 bytes that count to 250 and begin again.
        let bytes = |hash: u64| hash.to_le_bytes();
        assert_eq!(
            bytes(hash_bytes(b"")),
            [0xaf, 0x13, 0x49, 0xb9, 0xf5, 0xf9, 0xa1, 0xa6]
        );
        let counted: Vec<u8> = (0..2048u32).map(|i| (i % 251) as u8).collect();
        let first = [0xe7, 0x76, 0xb6, 0x02, 0x8c, 0x7c, 0xd2, 0x2a];
        assert_eq!(bytes(hash_bytes(&counted)), first);
    }

    #[test]
    fn values_are_hashed_in_the_bytes_that_are_told() {
        let mut hash = SourceHash::default();
        hash.number(3);
        hash.text("ab");
        hash.floats([1.0, -2.0].into_iter());
        hash.transform(&Transform::IDENTITY);
        let mut bytes = vec![3, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, b'a', b'b'];
        bytes.extend([2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0]);
        for array in [&[0.0_f32; 3][..], &[0.0, 0.0, 0.0, 1.0], &[1.0; 3]] {
            bytes.extend((array.len() as u64).to_le_bytes());
            array.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        assert_eq!(hash.finish(), hash_bytes(&bytes));
        // Longer than one run.
        let mut hash = SourceHash::default();
        hash.indices(0..20_000);
        let mut bytes = 20_000u64.to_le_bytes().to_vec();
        (0..20_000u32).for_each(|i| bytes.extend(i.to_le_bytes()));
        assert_eq!(hash.finish(), hash_bytes(&bytes));
    }
}
