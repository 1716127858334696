//! Weights of influences in 8 or 16 bits that still sum to 1.
//!
//! Source: glTF 2.0, 3.7.3.3: the weights of a vertex, over all sets, must sum to 1, in 8 bits
//! to 255.

use super::super::place::Place;
use super::super::reader::Reader;
use super::WeightPrecision;
use super::element::Elements;
use crate::error::ReadError;
use std::collections::{BTreeMap, BTreeSet};

/// Component types of glTF.
const U8: u32 = 5121;
const U16: u32 = 5123;

/// The weights of all primitives, by accessor; without those that are integers, sum to nothing, or
/// belong to different sets in different primitives.
pub(super) fn weights(
    reader: &mut Reader<'_>,
    precision: WeightPrecision,
) -> Result<BTreeMap<usize, Elements>, ReadError> {
    let (whole, size, component) = match precision {
        WeightPrecision::Byte => (255, 1, U8),
        WeightPrecision::Short => (65_535, 2, U16),
        WeightPrecision::Exact => return Ok(BTreeMap::new()),
    };
    let mut groups: BTreeSet<Vec<usize>> = BTreeSet::new();
    for mesh in reader.root.entries("meshes")? {
        for primitive in mesh.entries("primitives")? {
            groups.insert(sets(&primitive));
        }
    }
    let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
    for accessor in groups.iter().flatten() {
        *uses.entry(*accessor).or_default() += 1;
    }
    let mut out = BTreeMap::new();
    for group in groups
        .iter()
        .filter(|group| group.iter().all(|a| uses[a] == 1))
    {
        if let Some(sets) = rounded(reader, group, whole)? {
            let elements = sets.iter().map(|set| {
                let bytes = set.iter().flat_map(|w| w.to_le_bytes()[..size].to_vec());
                let bytes: Vec<u8> = bytes.collect();
                Elements::padded(&bytes, 4 * size, component, true)
            });
            out.extend(group.iter().copied().zip(elements));
        }
    }
    Ok(out)
}

/// Accessors of the weights of a primitive, set by set.
fn sets(primitive: &Place<'_>) -> Vec<usize> {
    let attributes = primitive.get("attributes");
    let set = |i: usize| {
        let weights = attributes.as_ref()?.get(&format!("WEIGHTS_{i}"))?;
        weights.whole().ok().map(|i| i as usize)
    };
    (0..).map_while(set).collect()
}

/// The weights of each set as parts of a whole.
fn rounded(
    reader: &mut Reader<'_>,
    group: &[usize],
    whole: u32,
) -> Result<Option<Vec<Vec<u32>>>, ReadError> {
    let mut floats = Vec::with_capacity(group.len());
    for accessor in group {
        let Some(place) = reader.root.entry("accessors", *accessor) else {
            return Ok(None);
        };
        let accessor = reader.accessor_at(place)?;
        if !accessor.is_float() || accessor.width() != 4 {
            return Ok(None);
        }
        floats.push(reader.floats(&accessor)?);
    }
    let length = floats.first().map_or(0, Vec::len);
    if length == 0 || floats.iter().any(|set| set.len() != length) {
        return Ok(None);
    }
    let mut out = vec![vec![0; length]; group.len()];
    for v in (0..length).step_by(4) {
        let of_vertex: Vec<f32> = floats
            .iter()
            .flat_map(|set| set[v..v + 4].to_vec())
            .collect();
        let Some(parts) = of_whole(&of_vertex, whole) else {
            return Ok(None);
        };
        for (set, four) in out.iter_mut().zip(parts.chunks(4)) {
            set[v..v + 4].copy_from_slice(four);
        }
    }
    Ok(Some(out))
}

/// Weights as parts of a whole: rounded down, and the rest where most was lost. `None` if they
/// sum to nothing.
fn of_whole(weights: &[f32], whole: u32) -> Option<Vec<u32>> {
    let sum: f32 = weights.iter().map(|w| w.max(0.0)).sum();
    if !(sum.is_finite() && sum > 1e-6) {
        return None;
    }
    let wanted: Vec<f32> = weights
        .iter()
        .map(|w| w.max(0.0) / sum * whole as f32)
        .collect();
    let mut parts: Vec<u32> = wanted.iter().map(|w| w.floor() as u32).collect();
    let rest = whole.saturating_sub(parts.iter().sum());
    let mut order: Vec<usize> = (0..weights.len()).collect();
    let lost = |i: &usize| wanted[*i] - wanted[*i].floor();
    order.sort_by(|a, b| lost(b).total_cmp(&lost(a)).then(a.cmp(b)));
    for i in order.into_iter().cycle().take(rest as usize) {
        parts[i] = parts[i].saturating_add(1).min(whole);
    }
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn weights_sum_to_the_whole_and_stay_within_one_step(
            weights in prop::collection::vec(0.0f32..1.0, 1..9),
        ) {
            let sum: f32 = weights.iter().sum();
            prop_assume!(sum > 1e-3);
            for whole in [255, 65_535] {
                let parts = of_whole(&weights, whole).unwrap();
                prop_assert_eq!(parts.iter().sum::<u32>(), whole);
                for (w, part) in weights.iter().zip(parts) {
                    prop_assert!((w / sum * whole as f32 - part as f32).abs() < 1.05);
                }
            }
        }
    }

    #[test]
    fn a_weight_of_nothing_stays_nothing() {
        assert_eq!(
            of_whole(&[0.5, 0.5, 0.0, 0.0], 255).unwrap(),
            [128, 127, 0, 0]
        );
        assert_eq!(
            of_whole(&[0.0, 0.0, 1.0, 0.0], 255).unwrap(),
            [0, 0, 255, 0]
        );
        assert_eq!(of_whole(&[0.0; 4], 255), None);
    }
}
