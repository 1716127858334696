//! What holds of every stream that is cut by its map.

use articula_stream::{Cut, CutRule, Meaning, Unit, cut, read_index, write_index};

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

fn renamed(unit: &Unit) -> Unit {
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
