//! Seeded mutations: for any bytes and layout, decoding returns the number of bytes that the layout
//! requires, or an error.

use super::vectors;
use articula_formats::Limits;
use articula_formats::meshopt::{Filter, Mode, ViewLayout, decode};
use articula_mutate::{Dice, Edit, Mutations};

const MUTATIONS: Mutations<'_> = Mutations {
    edits: &[
        Edit::Truncate,
        Edit::InsertByte,
        Edit::RemoveByte,
        Edit::SetByte,
        Edit::SetByte,
        Edit::SetByte,
    ],
    most: 4,
};

fn other_shape(shape: &mut ViewLayout, dice: &mut Dice) {
    match dice.roll(4) {
        0 => shape.mode = dice.of(&[Mode::Attributes, Mode::Triangles, Mode::Indices]),
        1 => {
            let filters = [Filter::None, Filter::Octahedral, Filter::Quaternion];
            shape.filter = dice.of(&[&filters[..], &[Filter::Exponential, Filter::Color]].concat());
        }
        2 => shape.count = dice.of(&[0, 1, 3, 17, 300, 1 << 20, u64::MAX]),
        _ => shape.stride = dice.of(&[0, 1, 2, 4, 8, 12, 256, 260, u64::MAX]),
    }
}

#[test]
fn mutants_neither_panic_nor_grow() {
    let limits = Limits {
        bytes: 1 << 16,
        ..Limits::default()
    };
    let mut dice = Dice::new(20071);
    let mut decoded = 0;
    for vector in vectors::all() {
        let mut round = 0;
        decoded += MUTATIONS.read_of(&vector.encoded, 3000, |bytes| {
            let mut shape = vector.shape;
            // The first is the unchanged vector.
            if round % 4 == 1 {
                other_shape(&mut shape, &mut dice);
            }
            round += 1;
            let Ok(out) = decode(bytes, &shape, &limits) else {
                return false;
            };
            assert_eq!(out.len() as u64, shape.count * shape.stride);
            assert!(out.len() <= 1 << 16);
            true
        });
    }
    // At least one in ten must be decoded, or the test would cover little.
    assert!(decoded > 6300, "only {decoded} mutants were decoded");
}
