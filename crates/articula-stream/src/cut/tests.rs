//! Cuts of maps made by hand, and of random ones.

use super::*;
use crate::coding::Coding;
use proptest::prelude::*;

fn unit(label: &'static str, bits: Range<u64>) -> Unit {
    Unit {
        bits,
        ..Unit::of_bytes(label, 0..0)
    }
}

fn field(name: &'static str, bits: Range<u64>, value: u64, meaning: Meaning) -> Field {
    Field {
        name: name.into(),
        bits,
        value,
        coding: Coding::BigEndian,
        meaning,
    }
}

/// `1010 | 010 | 11 | 0011 | 011 | 11111111`: 4 bits, a count of 2, two units, padding, an end.
fn counted() -> (Vec<u8>, Unit) {
    let stream = vec![0b1010_0101, 0b1001_1011, 0b1111_1111];
    let padding = Unit {
        padding: true,
        ..unit("padding", 13..16)
    };
    let map = Unit {
        fields: vec![field("count", 4..7, 2, Meaning::CountOf("a".into()))],
        children: vec![
            unit("a", 7..9).marked("loa", 0),
            unit("a", 9..13).marked("loa", 1).marked("region", 3),
            padding,
            unit("end", 16..24),
        ],
        ..unit("whole", 0..24)
    };
    (stream, map)
}

#[test]
fn counts_and_padding_are_renewed() {
    let (stream, map) = counted();
    map.check_values(&stream).unwrap();
    let kept = cut(&stream, &map, |_| true).unwrap();
    assert_eq!((&kept.bytes, &kept.unit), (&stream, &map));
    let coarse = CutRule::default().at_most("loa", 0);
    let shorter = cut(&stream, &map, |unit| coarse.keeps(unit)).unwrap();
    // 1010 | 001 | 11 | 7 in seven bits | the end
    assert_eq!(shorter.bytes, [0b1010_0011, 0b1000_0111, 0b1111_1111]);
    shorter.unit.check().unwrap();
    shorter.unit.check_values(&shorter.bytes).unwrap();
    assert_eq!(shorter.unit.children[1].bits, 9..16);
    let none = cut(&stream, &map, |unit| unit.label != "a").unwrap();
    assert_eq!(none.bytes, [0b1010_0001, 0b1111_1111]);
    assert_eq!(none.unit.fields[0].value, 0);
}

#[test]
fn rules_see_the_markers_that_they_name() {
    let (_, map) = counted();
    let [zero, one] = [&map.children[0], &map.children[1]];
    let keeps = |rule: CutRule| (rule.keeps(zero), rule.keeps(one));
    assert_eq!(keeps(CutRule::default()), (true, true));
    assert_eq!(keeps(CutRule::default().at_least("loa", 1)), (false, true));
    assert_eq!(
        keeps(CutRule::default().in_mask("region", 0b0111)),
        (true, false)
    );
    assert_eq!(
        keeps(CutRule::default().in_mask("region", 0b1000)),
        (true, true)
    );
    assert_eq!(
        keeps(CutRule::default().among("loa", vec![5, 1])),
        (false, true)
    );
    let both = CutRule::default().in_mask("region", 8).at_most("loa", 0);
    assert_eq!(keeps(both), (true, false));
}

#[test]
fn lengths_told_elsewhere_become_zero() {
    let stream = [2, 1, 7, 7, 9];
    let map = Unit {
        children: vec![
            Unit {
                fields: vec![
                    field("length", 0..8, 2, Meaning::BytesOf(2)),
                    field("length", 8..16, 1, Meaning::BytesOf(3)),
                ],
                ..Unit::of_bytes("head", 0..2)
            },
            Unit::of_bytes("chunk", 2..4).marked("level", 1),
            Unit::of_bytes("chunk", 4..5).marked("level", 0),
        ],
        ..Unit::of_bytes("whole", 0..5)
    };
    let coarse = cut(&stream, &map, |unit| unit.marker("level") != Some(0)).unwrap();
    assert_eq!(coarse.bytes, [2, 0, 7, 7]);
    assert_eq!(coarse.unit.children[2].bits, 32..32);
    let fine = cut(&stream, &map, |unit| unit.marker("level") != Some(1)).unwrap();
    assert_eq!(fine.bytes, [0, 1, 9]);
    let again = cut(&fine.bytes, &fine.unit, |_| true).unwrap();
    assert_eq!(again, fine);
}

#[test]
fn units_around_those_whose_length_is_told_elsewhere_stay_empty() {
    let stream = [2, 1, 7, 7, 9];
    let chunks = [
        Unit::of_bytes("chunk", 2..4).marked("level", 0),
        Unit::of_bytes("chunk", 4..5).marked("level", 0),
    ];
    let map = Unit {
        children: vec![
            Unit {
                fields: vec![
                    field("length", 0..8, 2, Meaning::BytesOf(3)),
                    field("length", 8..16, 1, Meaning::BytesOf(4)),
                ],
                ..Unit::of_bytes("head", 0..2)
            },
            Unit {
                children: chunks.into(),
                ..Unit::of_bytes("level", 2..5).marked("level", 0)
            },
        ],
        ..Unit::of_bytes("whole", 0..5)
    };
    let none = cut(&stream, &map, |unit| unit.marker("level").is_none()).unwrap();
    assert_eq!(none.bytes, [0, 0]);
    none.unit.check().unwrap();
    none.unit.check_values(&none.bytes).unwrap();
    assert_eq!(none.unit.children[1].children.len(), 2);
    let again = cut(&none.bytes, &none.unit, |_| true).unwrap();
    assert_eq!(again, none);
}

#[test]
fn numbers_that_cannot_be_written_are_refused() {
    let (stream, map) = counted();
    let at = |map: &Unit, label: &str| {
        cut(&stream, map, |unit| unit.label != label)
            .unwrap_err()
            .at
    };
    let mut inside = map.clone();
    inside.fields[0].bits = 7..9;
    assert_eq!(at(&inside, "a"), "count");
    let mut across = map.clone();
    across.fields[0].bits = 6..8;
    assert_eq!(at(&across, "padding"), "count");
    let mut odd = map.clone();
    odd.bits.end = 32;
    assert_eq!(at(&odd, "end"), "whole");
}

/// A tree of units with two marks over random bytes, each with its length in a byte before it.
fn tree(stream: &mut Vec<u8>, shape: &[(u8, u8, Vec<u8>)]) -> Unit {
    let mut children = Vec::new();
    for (loa, tier, body) in shape {
        let start = stream.len();
        stream.push(body.len() as u8);
        stream.extend(body);
        let length = field(
            "length",
            8 * start as u64..8 * start as u64 + 8,
            body.len() as u64,
            Meaning::BytesAfter,
        );
        let inner =
            Unit::of_bytes("body", start + 1..stream.len()).marked("tier", u32::from(*tier));
        children.push(
            Unit {
                fields: vec![length],
                children: vec![inner],
                ..Unit::of_bytes("unit", start..stream.len())
            }
            .marked("loa", u32::from(*loa)),
        );
    }
    Unit {
        children,
        ..Unit::of_bytes("whole", 0..stream.len())
    }
}

/// Neither the names of units nor a codec are needed: the test also runs without the feature.
#[test]
fn a_stream_of_a_codec_is_cut_by_its_index_alone() {
    let stream = include_bytes!("../../tests/golden/wave.abp");
    let map = crate::read_index(include_bytes!("../../tests/golden/wave.auix")).unwrap();
    let coarse = CutRule::default().at_most("loa", 0);
    let cut = cut(stream, &map, |unit| coarse.keeps(unit)).unwrap();
    assert_eq!(
        cut.bytes,
        include_bytes!("../../tests/golden/wave-loa-0.abp")
    );
}

proptest! {
    #[test]
    fn cutting_twice_is_cutting_once(
        shape in prop::collection::vec(
            (0u8..4, 0u8..4, prop::collection::vec(any::<u8>(), 0..9)), 0..12),
        loa in 0u32..4,
        tier in 0u32..4,
    ) {
        let mut stream = Vec::new();
        let map = tree(&mut stream, &shape);
        let by_loa = CutRule::default().at_most("loa", loa);
        let by_tier = CutRule::default().at_least("tier", tier);
        let both = by_loa.clone().at_least("tier", tier);
        let once = cut(&stream, &map, |unit| both.keeps(unit)).unwrap();
        let first = cut(&stream, &map, |unit| by_loa.keeps(unit)).unwrap();
        let twice = cut(&first.bytes, &first.unit, |unit| by_tier.keeps(unit)).unwrap();
        prop_assert_eq!(&once, &twice);
        once.unit.check().unwrap();
        once.unit.check_values(&once.bytes).unwrap();
        let expected: Vec<u8> = shape.iter().filter(|(l, _, _)| u32::from(*l) <= loa).flat_map(|(_, t, body)| {
            let body = if u32::from(*t) >= tier { &body[..] } else { &[] };
            [&[body.len() as u8][..], body].concat()
        }).collect();
        prop_assert_eq!(&once.bytes, &expected);
    }
}
