//! Random maps that a description can hold.

use articula_mutate::Dice;
use articula_stream::{Coding, Field, Marker, Meaning, Unit};
use std::ops::Range;

const NAMES: &[&str] = &[
    "",
    "unit",
    "BoneMask",
    "bonemask",
    "BoneSegment",
    "AccessUnit",
    ":MG4:Padding",
    ":x:y",
    "a b",
    "<&\"'\n>",
    "ü→",
];
const SCHEMES: &[&str] = &[
    "loa",
    "region",
    "tier",
    "level",
    "L",
    "a:b c",
    "access_unit",
    "",
];

/// A map of the bits of a stream with `bytes` bytes, whose values are any.
pub(crate) fn map(dice: &mut Dice, bytes: u64) -> Unit {
    let mut map = unit(dice, 0..8 * bytes, 0);
    let roots = ["ABP-1", "AFP-1", "abp2", "afp2", "mesh stream", "whole", ""];
    map.label = dice.of(&roots).into();
    map.padding = false;
    let mut count = 0;
    map.visit(&mut |_| count += 1);
    name_units(&mut map, dice, count);
    map
}

fn unit(dice: &mut Dice, bits: Range<u64>, depth: u32) -> Unit {
    let mut unit = Unit {
        label: dice.of(NAMES).into(),
        ..Unit::of_bytes("", 0..0)
    };
    for _ in 0..dice.roll(3) {
        let scheme = dice.of(SCHEMES).into();
        let value = dice.roll(1 << 32) as u32 >> dice.roll(32);
        unit.markers.push(Marker { scheme, value });
    }
    let length = bits.end - bits.start;
    unit.bits = bits.clone();
    unit.padding = length < 8 && dice.roll(4) == 0;
    if unit.padding || depth > 4 {
        return unit;
    }
    let mut at = bits.start;
    for _ in 0..dice.roll(6) {
        let start = at + dice.roll((bits.end - at) as usize / 4 + 1) as u64;
        let end = start + dice.roll((bits.end - start) as usize / 2 + 1) as u64;
        let field = field(dice, start, bits.end).filter(|_| dice.roll(3) == 0);
        if let Some(field) = field {
            at = field.bits.end;
            unit.fields.push(field);
        } else {
            at = end;
            unit.children.push(self::unit(dice, start..end, depth + 1));
        }
    }
    unit
}

fn field(dice: &mut Dice, start: u64, end: u64) -> Option<Field> {
    let coding = dice.of(&[Coding::BigEndian, Coding::LittleEndian, Coding::Varint]);
    let (start, bits) = match coding {
        Coding::BigEndian => (start, 1 + dice.roll(64) as u64),
        Coding::LittleEndian => (start.div_ceil(8) * 8, 8 + 8 * dice.roll(8) as u64),
        Coding::Varint => (start.div_ceil(8) * 8, 8 + 8 * dice.roll(9) as u64),
    };
    let value_bits = if coding == Coding::Varint {
        bits / 8 * 7
    } else {
        bits
    };
    let value = (dice.roll(usize::MAX) as u64) << 1 | dice.roll(2) as u64;
    let meaning = match dice.roll(3) {
        0 => Meaning::BytesAfter,
        1 => Meaning::BytesOf(0),
        _ => Meaning::CountOf(dice.of(NAMES).into()),
    };
    (start + bits <= end).then(|| Field {
        name: dice.of(NAMES).into(),
        bits: start..start + bits,
        value: value & (u64::MAX >> (64 - value_bits)),
        coding,
        meaning,
    })
}

/// Lets fields name any unit.
fn name_units(unit: &mut Unit, dice: &mut Dice, count: usize) {
    for field in &mut unit.fields {
        if let Meaning::BytesOf(number) = &mut field.meaning {
            *number = dice.roll(count) as u32;
        }
    }
    for child in &mut unit.children {
        name_units(child, dice, count);
    }
}
