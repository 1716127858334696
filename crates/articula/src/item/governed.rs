//! Which units of a stream belong to which layers of a part.

use super::part::{ItemLayer, ItemPart};
use articula_stream::Unit;
use std::collections::BTreeSet;

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

/// Sets the bytes of layers: each outermost unit that belongs to a layer counts for the first one.
/// Returns the bytes of the stream that no layer has.
pub(super) fn charge(unit: &Unit, layers: &mut [ItemLayer], bytes: usize) -> u64 {
    let schemes: BTreeSet<String> = layers.iter().flat_map(|l| l.keep.keys().cloned()).collect();
    let mut open = vec![unit];
    let mut charged = 0;
    while let Some(unit) = open.pop() {
        let is_governed = unit
            .markers
            .iter()
            .any(|m| schemes.contains(m.scheme.as_ref()));
        // What has parts is left out with the last of them.
        if !is_governed || !unit.children.is_empty() {
            open.extend(&unit.children);
            continue;
        }
        let of = layers.iter_mut().find(|layer| belongs(unit, layer));
        if let Some(layer) = of {
            layer.bytes += unit.bytes();
            charged += unit.bytes();
        }
    }
    (bytes as u64).saturating_sub(charged)
}

/// Numbers of the regions that units of a stream have.
pub(super) fn numbers_of_regions(unit: &Unit) -> BTreeSet<u32> {
    let mut numbers = BTreeSet::new();
    unit.visit(&mut |unit| {
        numbers.extend(unit.marker("region").or_else(|| unit.marker("face_region")));
    });
    numbers
}
