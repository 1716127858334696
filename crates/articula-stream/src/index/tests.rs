//! Indices: round trips, and every refusal of a changed one.

use super::*;
use articula_mutate::{Edit, Mutations};

fn map() -> Unit {
    let field = |name: &'static str, bits, coding, meaning| Field {
        name: name.into(),
        bits,
        value: 3,
        coding,
        meaning,
    };
    let inner = Unit {
        fields: vec![field(
            "count",
            35..43,
            Coding::BigEndian,
            Meaning::CountOf("part".into()),
        )],
        children: vec![Unit {
            padding: true,
            ..Unit::of_bytes("padding", 10..10)
        }],
        ..Unit::of_bytes("inner", 4..10).marked("loa", 2)
    };
    Unit {
        fields: vec![
            field("bytes", 0..16, Coding::Varint, Meaning::BytesAfter),
            field("length", 16..32, Coding::LittleEndian, Meaning::BytesOf(1)),
        ],
        children: vec![
            inner.marked("region", 7),
            Unit::of_bytes("part", 10..12).marked("loa", 2),
        ],
        ..Unit::of_bytes("whole", 0..12)
    }
}

#[test]
fn a_map_comes_back() {
    let map = map();
    map.check().unwrap();
    let bytes = write_index(&map);
    // 4 units, 3 markers, 3 fields; ten names, of which `part` and `loa` occur twice.
    let records = HEAD + 4 * UNIT + 3 * MARKER + 3 * FIELD;
    let names = [
        "whole", "bytes", "length", "inner", "loa", "region", "count", "part", "padding",
    ];
    assert_eq!(
        bytes.len(),
        records + names.concat().len() + 2 * names.len()
    );
    assert_eq!(read_index(&bytes), Ok(map));
}

#[test]
fn what_is_wrong_names_its_byte() {
    let good = write_index(&map());
    let edited = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        read_index(&bytes).unwrap_err().to_string()
    };
    assert!(edited(0, b'B').contains("AUIX"));
    assert!(edited(4, 9).contains("version 9"));
    assert!(edited(8, 200).contains("unexpected end"));
    // The depth of the second unit: 2 does not follow 0.
    assert!(edited(HEAD + UNIT + 26, 2).contains("depth 2"));
    assert!(edited(HEAD + UNIT + 24, 77).contains("name 77"));
    assert!(edited(HEAD + UNIT + 7, 0xff).contains("bits"));
    let short = read_index(&good[..good.len() - 1]).unwrap_err();
    assert!(short.to_string().contains("unexpected end"), "{short}");
}

#[test]
fn no_mutation_panics() {
    let mutations = Mutations {
        edits: &[Edit::SetByte, Edit::Truncate, Edit::Repeat(40)],
        most: 3,
    };
    let stream = [0; 12];
    let read = mutations.read_of(&write_index(&map()), 6000, |bytes| {
        let Ok(map) = read_index(bytes) else {
            return false;
        };
        map.check().unwrap();
        if let Ok(shorter) = crate::cut(&stream, &map, |unit| unit.marker("loa") != Some(2)) {
            shorter.unit.check_values(&shorter.bytes).unwrap();
        }
        true
    });
    assert!(read > 150, "only {read} mutants were read");
}
