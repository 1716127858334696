//! Which units of a stream belong to which layers of a part.

use super::part::{ItemLayer, ItemPart, PartKind};
use articula_stream::{ByteRanges, Unit, difference};
use std::collections::BTreeSet;
use std::ops::Range;

/// Which units a choice of layers keeps.
///
/// A unit belongs to the layers whose markers it has: of each scheme that both have, the same value.
/// It is kept if it belongs to a kept layer, or has no marker of any layer.
pub(super) struct Governed<'a> {
    schemes: BTreeSet<&'a str>,
    kept: Vec<&'a ItemLayer>,
}

impl<'a> Governed<'a> {
    pub(super) fn of(part: &'a ItemPart, kept: &[bool]) -> Self {
        let layers = part.layers.iter();
        Self {
            schemes: layers
                .clone()
                .flat_map(|l| l.keep.keys())
                .map(String::as_str)
                .collect(),
            kept: layers
                .zip(kept)
                .filter(|(_, kept)| **kept)
                .map(|(l, _)| l)
                .collect(),
        }
    }

    pub(super) fn keeps(&self, unit: &Unit) -> bool {
        let mut markers = unit.markers.iter();
        if !markers.any(|m| self.schemes.contains(m.scheme.as_ref())) {
            return true;
        }
        self.kept.iter().any(|layer| belongs(unit, layer))
    }
}

/// Whether a unit belongs to a layer.
pub(super) fn belongs(unit: &Unit, layer: &ItemLayer) -> bool {
    let differs =
        |(scheme, value): (&String, &u32)| unit.marker(scheme).is_some_and(|v| v != *value);
    !layer.keep.iter().any(differs)
}

impl ItemPart {
    /// Sets the bytes of the part, its base and its layers, and where they lie in the stream: each
    /// outermost unit that belongs to a layer counts for the first one, the base has the rest.
    pub(super) fn charge(&mut self, unit: &Unit, bytes: usize) {
        let bits = charged(unit, &self.layers);
        let is_aligned =
            |bits: &Range<u64>| bits.start.is_multiple_of(8) && bits.end.is_multiple_of(8);
        let are_bytes = bits.iter().flatten().all(is_aligned);
        let listed = |bytes: &ByteRanges| match are_bytes {
            true => bytes
                .ranges()
                .iter()
                .map(|r| [r.start, r.end - r.start])
                .collect(),
            false => Vec::new(),
        };
        self.bytes = bytes as u64;
        let of_layers = bits.iter().flatten().map(bits_to_bytes);
        self.base_bytes = self.bytes.saturating_sub(of_layers.sum());
        let places = bits.iter().flatten().map(bytes_of).collect();
        let whole = std::iter::once(0..self.bytes).collect();
        self.base_ranges = listed(&difference(&places, &whole));
        for (layer, bits) in self.layers.iter_mut().zip(bits) {
            layer.bytes = bits.iter().map(bits_to_bytes).sum();
            layer.ranges = listed(&bits.iter().map(bytes_of).collect());
        }
    }
}

/// For each layer the bits of its units.
fn charged(unit: &Unit, layers: &[ItemLayer]) -> Vec<Vec<Range<u64>>> {
    let schemes: BTreeSet<&String> = layers.iter().flat_map(|l| l.keep.keys()).collect();
    let is_governed = |unit: &Unit| {
        let mut markers = unit.markers.iter();
        markers.any(|m| schemes.iter().any(|s| ***s == *m.scheme))
    };
    let mut open = vec![unit];
    let mut charged = vec![Vec::new(); layers.len()];
    while let Some(unit) = open.pop() {
        // What has parts is left out with the last of them.
        if !is_governed(unit) || !unit.children.is_empty() {
            open.extend(&unit.children);
            continue;
        }
        let of = layers.iter().position(|layer| belongs(unit, layer));
        if let Some(layer) = of {
            charged[layer].push(unit.bits.clone());
        }
    }
    charged
}

/// The bytes that bits lie in.
fn bytes_of(bits: &Range<u64>) -> Range<u64> {
    bits.start / 8..bits.end.div_ceil(8)
}

fn bits_to_bytes(bits: &Range<u64>) -> u64 {
    (bits.end - bits.start).div_ceil(8)
}

/// Numbers of the regions that units of the stream of a part have. A motion of the body may have units
/// of the face too, whose regions are numbered apart.
pub(super) fn numbers_of_regions(kind: PartKind, unit: &Unit) -> BTreeSet<u32> {
    let of_face = |unit: &Unit| match kind {
        PartKind::FaceMotion => unit.marker("face_region"),
        _ => None,
    };
    let mut numbers = BTreeSet::new();
    unit.visit(&mut |unit| {
        numbers.extend(unit.marker("region").or_else(|| of_face(unit)));
    });
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item::part::PartKind;

    fn layer(tier: u32) -> ItemLayer {
        ItemLayer {
            keep: [("tier".to_owned(), tier)].into(),
            ..ItemLayer::default()
        }
    }

    #[test]
    fn layers_and_base_share_the_bytes_of_a_stream() {
        let of = |tier, bytes| Unit::of_bytes("unit", bytes).marked("tier", tier);
        let access_unit = |start: usize| Unit {
            children: vec![
                of(1, start + 2..start + 5),
                of(1, start + 5..start + 6),
                of(0, start + 6..start + 9),
            ],
            ..Unit::of_bytes("access_unit", start..start + 9)
        };
        let stream = Unit {
            children: vec![
                Unit::of_bytes("head", 0..4),
                access_unit(4),
                access_unit(13),
            ],
            ..Unit::of_bytes("stream", 0..22)
        };
        let mut part = ItemPart::new("walk", PartKind::BodyMotion);
        part.layers = vec![layer(1), layer(0)];
        part.charge(&stream, 22);
        // Four bytes of head, and two before the units of each access unit.
        assert_eq!((part.bytes, part.base_bytes), (22, 8));
        assert_eq!(part.base_ranges, [[0, 6], [13, 2]]);
        assert_eq!((part.layers[0].bytes, part.layers[1].bytes), (8, 6));
        assert_eq!(part.layers[0].ranges, [[6, 4], [15, 4]]);
        assert_eq!(part.layers[1].ranges, [[10, 3], [19, 3]]);
        // Units that share bytes have no ranges of their own.
        let mut shared = stream;
        shared.children[1].children[0].bits.end -= 3;
        part.charge(&shared, 22);
        assert!(part.base_ranges.is_empty() && part.layers[0].ranges.is_empty());
    }
}
