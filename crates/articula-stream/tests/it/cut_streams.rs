//! What holds of every stream that is cut by its map.

use articula_core::push_varint;
use articula_stream::abp2::{MotionHead, motion_map};
use articula_stream::{Cut, CutRule, Meaning, StreamLimits, Unit, cut, read_index, write_index};
use std::path::Path;

/// Cuts a stream and checks what holds of all cuts: the map is sound and describes the bytes, a
/// second cut by the same rule changes nothing, the map survives as an index, and the names of units
/// do not matter.
pub(crate) fn cut_checked(stream: &[u8], map: &Unit, rule: &CutRule) -> Cut {
    map.check().unwrap();
    map.check_values(stream).unwrap();
    let once = cut(stream, map, |unit| rule.keeps(unit)).unwrap();
    once.unit.check().unwrap();
    once.unit.check_values(&once.bytes).unwrap();
    let twice = cut(&once.bytes, &once.unit, |unit| rule.keeps(unit)).unwrap();
    assert_eq!(once, twice);
    let index = read_index(&write_index(&renamed(map))).unwrap();
    let by_index = cut(stream, &index, |unit| rule.keeps(unit)).unwrap();
    assert_eq!(by_index.bytes, once.bytes);
    once
}

pub(crate) fn renamed(unit: &Unit) -> Unit {
    let other = |name: &str| format!("x{}", name.to_uppercase());
    let mut renamed = unit.clone();
    renamed.label = other(&unit.label).into();
    for field in &mut renamed.fields {
        field.name = "number".into();
        if let Meaning::CountOf(label) = &mut field.meaning {
            *label = other(label).into();
        }
    }
    renamed.children = unit.children.iter().map(self::renamed).collect();
    renamed
}

/// Compares bytes with a file of the golden ones, or renews it.
pub(crate) fn check_golden(name: &str, bytes: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let path = path.join(name);
    if std::env::var_os("ARTICULA_GOLDEN").is_some_and(|v| v == "renew") {
        std::fs::write(&path, bytes).unwrap();
    }
    let stored = std::fs::read(&path).unwrap();
    assert!(bytes == stored, "{name} has other bytes");
}

/// The bits of all units with a label, as text.
pub(crate) fn bits_of(stream: &[u8], map: &Unit, label: &str) -> Vec<(Vec<u32>, String)> {
    let mut found = Vec::new();
    map.visit(&mut |unit| {
        if unit.label == label {
            let bit = |b: u64| char::from(b'0' + (stream[(b / 8) as usize] >> (7 - b % 8) & 1));
            let markers = unit.markers.iter().map(|m| m.value).collect();
            found.push((markers, unit.bits.clone().map(bit).collect()));
        }
    });
    found
}

/// A stream of version 2 of ABP-2 or AFP-2, without a skeleton, in the form of version 1: without
/// checksums, number and length of a unit each for itself, the frames of each access unit.
pub(crate) fn as_version_1(stream: &[u8]) -> Vec<u8> {
    let limits = StreamLimits::default();
    let head = MotionHead::open(stream, &limits).unwrap();
    let map = motion_map(stream, &limits).unwrap();
    let bytes = |unit: &Unit| unit.bits.start as usize / 8..unit.bits.end as usize / 8;
    let units = |out: &mut Vec<u8>, of: &Unit, count: usize| {
        for unit in &of.children {
            let range = bytes(unit);
            let (first, header) = varint(&stream[range.clone()]);
            push_varint(out, (first % count) as u64);
            push_varint(out, (first / count) as u64);
            out.extend(&stream[range.start + header..range.end - 1]);
        }
    };
    let sized = |mut part: Vec<u8>, at: usize| {
        let length = (part.len() - at - 4) as u32;
        part[at..at + 4].copy_from_slice(&length.to_be_bytes());
        part
    };
    let of_head = &map.children[0];
    let fields = of_head
        .children
        .first()
        .map_or(of_head.bits.end, |unit| unit.bits.start);
    let mut part = stream[..fields as usize / 8 - 2].to_vec();
    part[8] = 1;
    let mut levels: Vec<u8> = head.groups.iter().map(|group| group.loa).collect();
    levels.sort_unstable();
    levels.dedup();
    units(
        &mut part,
        of_head,
        levels.len() + head.morph_groups.len() + 1,
    );
    let mut out = sized(part, 4);
    let count = (head.groups.len() + head.morph_groups.len()) * head.tiers;
    for (number, access_unit) in map.children[1..].iter().enumerate() {
        let mut part = vec![0; 4];
        push_varint(&mut part, head.frames_of(number).len() as u64);
        units(&mut part, access_unit, count);
        out.extend(sized(part, 0));
    }
    out
}

/// A variable-length number, and its bytes.
fn varint(bytes: &[u8]) -> (usize, usize) {
    let last = bytes.iter().position(|byte| *byte < 0x80).unwrap();
    let value = bytes[..=last].iter().rev();
    let value = value.fold(0, |value, byte| value << 7 | usize::from(byte & 0x7f));
    (value, last + 1)
}
