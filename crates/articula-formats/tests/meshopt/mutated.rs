//! Seeded mutations: whatever the bytes and the shape, decoding ends with as many bytes as the
//! shape says, or an error.

use crate::vectors;
use articula_formats::Limits;
use articula_formats::meshopt::{Filter, Mode, Shape, decode};

/// A 64-bit xorshift generator (Marsaglia 2003): the same numbers on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(6) {
            0 => bytes.truncate(at),
            1 => bytes.insert(at, random.below(256) as u8),
            2 if !bytes.is_empty() => drop(bytes.remove(at)),
            _ if !bytes.is_empty() => bytes[at] = random.below(256) as u8,
            _ => {}
        }
    }
}

fn other_shape(shape: &mut Shape, random: &mut Random) {
    match random.below(4) {
        0 => shape.mode = random.of(&[Mode::Attributes, Mode::Triangles, Mode::Indices]),
        1 => {
            let filters = [Filter::None, Filter::Octahedral, Filter::Quaternion];
            shape.filter =
                random.of(&[&filters[..], &[Filter::Exponential, Filter::Color]].concat());
        }
        2 => shape.count = random.of(&[0, 1, 3, 17, 300, 1 << 20, u64::MAX]),
        _ => shape.stride = random.of(&[0, 1, 2, 4, 8, 12, 256, 260, u64::MAX]),
    }
}

#[test]
fn mutants_neither_panic_nor_grow() {
    let limits = Limits {
        bytes: 1 << 16,
        ..Limits::default()
    };
    let mut random = Random(20071);
    let mut decoded = 0;
    for vector in vectors::all() {
        for round in 0..3000 {
            let mut bytes = vector.encoded.clone();
            let mut shape = vector.shape;
            mutate(&mut bytes, &mut random);
            if round % 4 == 0 {
                other_shape(&mut shape, &mut random);
            }
            if let Ok(out) = decode(&bytes, &shape, &limits) {
                assert_eq!(out.len() as u64, shape.count * shape.stride);
                assert!(out.len() <= 1 << 16);
                decoded += 1;
            }
        }
    }
    // One in ten at least must be decoded, or the test would test little.
    assert!(decoded > 6300, "only {decoded} mutants were decoded");
}
