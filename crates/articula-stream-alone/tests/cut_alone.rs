//! The cut without any codec.
//!
//! A stored motion stream is cut by its stored index, and by hand after `docs/formats/abp2.md`.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use articula_stream::{
    ByteRanges, CutRule, Meaning, Unit, cut, cut_by_index, difference, read_index, selected,
    write_index,
};

const STREAM: &[u8] = include_bytes!("../../articula-stream/tests/golden/walk.abp");
const INDEX: &[u8] = include_bytes!("../../articula-stream/tests/golden/walk.auix");
/// Of the stored stream, whose groups are joints.
const TIERS: usize = 5;
const GROUPS: usize = 89;

/// A variable-length number at `at`, which moves behind it.
fn varint(bytes: &[u8], at: &mut usize) -> usize {
    let mut value = 0;
    for shift in (0..35).step_by(7) {
        let byte = bytes[*at];
        *at += 1;
        value |= usize::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            break;
        }
    }
    value
}

fn length(bytes: &[u8], at: usize) -> usize {
    let field: [u8; 4] = bytes[at..at + 4].try_into().unwrap();
    u32::from_be_bytes(field) as usize
}

/// Deletes the units of finer tiers and sets the lengths of the access units.
fn by_hand(stream: &[u8], keeps: impl Fn(usize, usize) -> bool) -> Vec<u8> {
    let mut at = 8 + length(stream, 4);
    let mut out = stream[..at].to_vec();
    while at < stream.len() {
        let end = at + 4 + length(stream, at);
        let start = out.len();
        out.extend([0; 4]);
        at += 4;
        while at < end {
            let first = at;
            let header = varint(stream, &mut at);
            let id = header % (TIERS * GROUPS);
            // The body and its checksum.
            at += header / (TIERS * GROUPS) + 1;
            if keeps(id / TIERS, TIERS - 1 - id % TIERS) {
                out.extend(&stream[first..at]);
            }
        }
        let bytes = (out.len() - start - 4) as u32;
        out[start..start + 4].copy_from_slice(&bytes.to_be_bytes());
    }
    out
}

#[test]
fn a_stored_stream_is_cut_by_its_index() {
    let map = read_index(INDEX).unwrap();
    map.check().unwrap();
    map.check_values(STREAM).unwrap();
    for tier in 0..=TIERS {
        let rule = CutRule::default().at_least("tier", tier as u32);
        let part = cut(STREAM, &map, |unit| rule.keeps(unit)).unwrap();
        assert_eq!(part.bytes, by_hand(STREAM, |_, t| t >= tier), "tier {tier}");
        part.unit.check_values(&part.bytes).unwrap();
    }
    // Groups of this stream are joints.
    let rule = CutRule::default().among("joint", vec![3, 14, 15]);
    let part = cut(STREAM, &map, |unit| rule.keeps(unit)).unwrap();
    assert_eq!(
        part.bytes,
        by_hand(STREAM, |joint, _| [3, 14, 15].contains(&joint))
    );
}

#[test]
fn a_cut_by_records_is_that_by_the_tree() {
    let map = read_index(INDEX).unwrap();
    for rule in [
        CutRule::default(),
        CutRule::default().at_least("tier", 2),
        CutRule::default().at_most("loa", 1).at_least("tier", 1),
        CutRule::default().among("joint", vec![0, 3, 17]),
        CutRule::default().within("access_unit", 1..=1),
    ] {
        let by_tree = cut(STREAM, &map, |unit| rule.keeps(unit)).unwrap();
        let made = cut_by_index(STREAM, INDEX, |unit| rule.keeps(unit)).unwrap();
        assert!(made.bytes == by_tree.bytes, "{rule:?}");
        assert!(made.index == write_index(&by_tree.unit), "{rule:?}");
    }
    // An index of another stream.
    let mut other = STREAM.to_vec();
    other[length(STREAM, 4) + 11] ^= 1;
    let why = cut_by_index(&other, INDEX, |_| true)
        .unwrap_err()
        .to_string();
    assert!(why.contains("au_bytes: the stream holds"), "{why}");
}

#[test]
fn a_stored_stream_is_fetched_tier_by_tier_by_its_index() {
    let map = read_index(INDEX).unwrap();
    let mut have = ByteRanges::default();
    let mut fetched = vec![0_u8; STREAM.len()];
    for tier in (0..TIERS).rev() {
        let rule = CutRule::default().at_least("tier", tier as u32);
        let want = selected(&map, |unit| rule.keeps(unit)).unwrap();
        // As many bytes as the cut has, whose lengths are other numbers.
        let by_hand = by_hand(STREAM, |_, t| t >= tier);
        assert_eq!(want.bytes(), by_hand.len() as u64);
        for range in difference(&have, &want).ranges() {
            let bytes = range.start as usize..range.end as usize;
            fetched[bytes].iter_mut().for_each(|times| *times += 1);
        }
        have = have.union(&want);
    }
    assert!(fetched.iter().all(|times| *times == 1));
    // The finest units are the last of each access unit: one range for each, the first with the head.
    let coarse = selected(&map, |unit| unit.marker("tier") != Some(0)).unwrap();
    assert_eq!(coarse.ranges().len(), map.children.len() - 1);
    assert_eq!(difference(&have, &coarse).ranges(), []);
}

/// Gives every label, field and scheme another name.
fn renamed(unit: &Unit) -> Unit {
    let other = |name: &str| name.chars().rev().collect::<String>() + "?";
    let mut unit = unit.clone();
    unit.label = other(&unit.label).into();
    for marker in &mut unit.markers {
        marker.scheme = other(&marker.scheme).into();
    }
    for field in &mut unit.fields {
        field.name = other(&field.name).into();
        if let Meaning::CountOf(label) = &mut field.meaning {
            *label = other(label).into();
        }
    }
    unit.children = unit.children.iter().map(renamed).collect();
    unit
}

#[test]
fn names_do_not_matter() {
    let map = read_index(INDEX).unwrap();
    let rule = CutRule::default().at_least("tier", 2).at_most("loa", 1);
    let other = CutRule::default().at_least("reit?", 2).at_most("aol?", 1);
    let part = cut(STREAM, &map, |unit| rule.keeps(unit)).unwrap();
    let same = cut(STREAM, &renamed(&map), |unit| other.keeps(unit)).unwrap();
    assert!(part.bytes.len() < STREAM.len() / 2);
    assert_eq!(part.bytes, same.bytes);
    assert_eq!(renamed(&part.unit), same.unit);
}

#[test]
fn memory_of_a_cut_follows_the_units_and_the_output() {
    const UNITS: usize = 100_000;
    const BYTES: usize = 64;
    let stream = vec![7; UNITS * BYTES];
    let part = |unit: usize| {
        let bytes = unit * BYTES..(unit + 1) * BYTES;
        Unit::of_bytes("unit", bytes).marked("loa", (unit % 6) as u32)
    };
    let map = Unit {
        children: (0..UNITS).map(part).collect(),
        ..Unit::of_bytes("abp2", 0..stream.len())
    };
    let index = write_index(&map);
    let reading = allocation_counter::measure(|| drop(read_index(&index).unwrap()));
    let rule = CutRule::default().at_most("loa", 2);
    let mut kept = 0;
    let cutting = allocation_counter::measure(|| {
        kept = cut(&stream, &map, |unit| rule.keeps(unit))
            .unwrap()
            .bytes
            .len();
    });
    assert_eq!(
        kept,
        BYTES * (0..UNITS).filter(|unit| unit % 6 <= 2).count()
    );
    let by_records = allocation_counter::measure(|| {
        drop(cut_by_index(&stream, &index, |unit| rule.keeps(unit)).unwrap());
    });
    let of_unit = |bytes: u64| bytes / UNITS as u64;
    println!(
        "reading {} bytes a unit, cutting {}, by records {}",
        of_unit(reading.bytes_max),
        of_unit(cutting.bytes_max),
        of_unit(by_records.bytes_max)
    );
    // Room for all of the stream and two indices at once.
    assert!(of_unit(by_records.bytes_max) <= (BYTES + 2 * (32 + 8)) as u64 + 2);
    // A unit in memory is below 150 bytes, its label 32; a list that grows has up to three times its
    // length at once.
    assert!(of_unit(reading.bytes_max) <= 3 * 150 + 32, "{reading:?}");
    let beyond_output = cutting.bytes_max.saturating_sub(2 * kept as u64);
    assert!(of_unit(beyond_output) <= 3 * 150 + 32, "{cutting:?}");
}
