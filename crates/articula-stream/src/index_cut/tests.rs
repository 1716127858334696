//! The cut by records beside the cut by the tree, on random maps and on damaged indices.

use super::*;
use crate::coding::Coding;
use crate::cut::CutRule;
use crate::unit::{Field, Meaning};
use articula_mutate::{Dice, Edit, Mutations};

/// What the four steps give.
fn by_tree(stream: &[u8], index: &[u8], rule: &CutRule) -> Result<IndexedCut, StreamError> {
    let map = read_index(index)?;
    map.check_values(stream)?;
    let made = cut(stream, &map, |unit| rule.keeps(unit))?;
    Ok(IndexedCut {
        index: write_index(&made.unit),
        bytes: made.bytes,
    })
}

/// A stream with its map: units in units, with gaps, lengths in two codings and names by chance.
fn random(dice: &mut Dice) -> (Vec<u8>, Unit) {
    let mut stream = Vec::new();
    let mut map = part(dice, 0, &mut stream);
    lengths(&mut map, &mut stream);
    (stream, map)
}

fn part(dice: &mut Dice, depth: usize, stream: &mut Vec<u8>) -> Unit {
    const LABELS: [&str; 4] = ["unit", "access_unit", "part", "other"];
    const SCHEMES: [&str; 3] = ["loa", "tier", "mine"];
    let start = stream.len();
    let mut unit = Unit::of_bytes(LABELS[dice.roll(4)], start..start);
    for _ in 0..dice.roll(3) {
        unit = unit.marked(SCHEMES[dice.roll(3)], dice.roll(4) as u32);
    }
    if dice.roll(2) == 0 {
        let coding = [Coding::BigEndian, Coding::LittleEndian][dice.roll(2)];
        let bytes = start..start + 3;
        stream.extend([0; 3]);
        unit.fields.push(Field {
            name: ["bytes", "tier"][dice.roll(2)].into(),
            bits: 8 * bytes.start as u64..8 * bytes.end as u64,
            value: 0,
            coding,
            meaning: Meaning::BytesAfter,
        });
    }
    let parts = if depth < 4 { dice.roll(5) } else { 0 };
    for _ in 0..parts {
        (0..dice.roll(3)).for_each(|_| stream.push(dice.roll(256) as u8));
        unit.children.push(part(dice, depth + 1, stream));
    }
    (0..dice.roll(6)).for_each(|_| stream.push(dice.roll(256) as u8));
    unit.bits.end = 8 * stream.len() as u64;
    unit
}

/// Sets the lengths of a map, and writes them.
fn lengths(unit: &mut Unit, stream: &mut [u8]) {
    for field in &mut unit.fields {
        field.value = (unit.bits.end - field.bits.end) / 8;
        field
            .coding
            .write(stream, &field.bits, field.value)
            .unwrap();
    }
    unit.children
        .iter_mut()
        .for_each(|part| lengths(part, stream));
}

fn rule(dice: &mut Dice) -> CutRule {
    let rule = CutRule::default().at_most("loa", dice.roll(4) as u32);
    match dice.roll(3) {
        0 => rule,
        1 => rule.at_least("tier", dice.roll(4) as u32),
        _ => rule.in_mask("mine", dice.roll(16) as u64),
    }
}

#[test]
fn records_are_cut_as_trees_are() {
    let mut dice = Dice::new(8);
    let mut shorter = 0;
    for case in 0..3000 {
        let (stream, map) = random(&mut dice);
        let index = write_index(&map);
        let rule = rule(&mut dice);
        let keeps = |unit: &Unit| rule.keeps(unit);
        let made = plain(&stream, &index, &keeps);
        let expected = by_tree(&stream, &index, &rule).unwrap();
        assert_eq!(made.as_ref(), Some(&expected), "{case}: {map:?}");
        let again = cut_by_index(&expected.bytes, &expected.index, keeps).unwrap();
        assert_eq!(again, expected, "{case}: a cut of a cut");
        shorter += usize::from(expected.bytes.len() < stream.len());
    }
    assert!(shorter > 1000, "{shorter}");
}

#[test]
fn what_is_not_plain_is_cut_by_its_tree() {
    let mut dice = Dice::new(9);
    let mut by_records = 0;
    for case in 0..1500 {
        let (stream, mut map) = random(&mut dice);
        // Bits, padding, other numbers, fields behind a part, streams that go on.
        match dice.roll(5) {
            0 => map.bits.end = map.bits.end.saturating_sub(3),
            1 => map.padding = true,
            2 => map
                .fields
                .extend(map.fields.clone().into_iter().map(|field| Field {
                    meaning: Meaning::CountOf("unit".into()),
                    ..field
                })),
            3 => {
                let end = map.bits.end;
                map.fields.push(Field {
                    name: "last".into(),
                    bits: end.saturating_sub(8)..end,
                    value: 0,
                    coding: Coding::BigEndian,
                    meaning: Meaning::BytesAfter,
                });
            }
            _ => {}
        }
        let stream = [stream, vec![0; dice.roll(2)]].concat();
        let index = write_index(&map);
        let rule = rule(&mut dice);
        let keeps = |unit: &Unit| rule.keeps(unit);
        by_records += usize::from(plain(&stream, &index, &keeps).is_some());
        let found = cut_by_index(&stream, &index, keeps);
        assert_eq!(found, by_tree(&stream, &index, &rule), "{case}: {map:?}");
    }
    assert!((300..1200).contains(&by_records), "{by_records}");
}

#[test]
fn damaged_indices_are_refused_as_by_their_tree() {
    let mut dice = Dice::new(10);
    let (stream, map) = loop {
        let made = random(&mut dice);
        if made.0.len() > 60 {
            break made;
        }
    };
    let good = write_index(&map);
    let rule = CutRule::default().at_most("loa", 1);
    let edits = [Edit::FlipBit, Edit::Delete(9), Edit::Repeat(32)];
    let mutations = Mutations {
        edits: &edits,
        most: 3,
    };
    let read = |index: &[u8]| {
        let found = cut_by_index(&stream, index, |unit| rule.keeps(unit));
        assert_eq!(found, by_tree(&stream, index, &rule));
        found.is_ok()
    };
    let good = mutations.read_of(&good, 4000, read);
    assert!(good > 100 && good < 3900, "{good}");
}

#[test]
fn alike_units_are_asked_for_once() {
    let part =
        |unit: usize| Unit::of_bytes("unit", unit..unit + 1).marked("loa", (unit % 6) as u32);
    let map = Unit {
        children: (0..600).map(part).collect(),
        ..Unit::of_bytes("whole", 0..600)
    };
    let asked = std::cell::Cell::new(0);
    let stream = vec![7; 600];
    let made = cut_by_index(&stream, &write_index(&map), |unit| {
        asked.set(asked.get() + 1);
        unit.marker("loa").is_none_or(|loa| loa < 3)
    });
    assert_eq!((made.unwrap().bytes.len(), asked.get()), (300, 6));
}
