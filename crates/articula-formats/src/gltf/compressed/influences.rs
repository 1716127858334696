//! Influences with weights in 8 or 10 bits that still sum to 1, the greatest four in the first set.
//!
//! Source: glTF 2.0, 3.7.3.3: the weights of a vertex, over all sets, must sum to 1, in 8 bits
//! to 255; joints of weight 0 should be 0.

use super::super::accessor::Component;
use super::super::place::Place;
use super::super::reader::Reader;
use super::WeightPrecision;
use super::element::Elements;
use crate::error::ReadError;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// Accessors of the joints and weights of a set of four influences.
type Set = (usize, usize);
/// A joint, and its weight as a part of a whole.
type Influence = (u32, u32);

/// The joints and weights of all primitives, by accessor; without those whose weights are integers or
/// sum to nothing, or whose sets differ between primitives.
pub(super) fn influences(
    reader: &mut Reader<'_>,
    precision: WeightPrecision,
) -> Result<BTreeMap<usize, Elements>, ReadError> {
    let whole = match precision {
        WeightPrecision::Byte => 255,
        WeightPrecision::TenBits => 1 << 10,
        WeightPrecision::Exact => return Ok(BTreeMap::new()),
    };
    let mut groups: BTreeSet<Vec<Set>> = BTreeSet::new();
    for mesh in reader.root.entries("meshes")? {
        for primitive in mesh.entries("primitives")? {
            groups.insert(sets(&primitive));
        }
    }
    let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
    for (joints, weights) in groups.iter().flatten() {
        *uses.entry(*joints).or_default() += 1;
        *uses.entry(*weights).or_default() += 1;
    }
    let is_own = |(joints, weights): &Set| uses[joints] == 1 && uses[weights] == 1;
    let mut out = BTreeMap::new();
    for group in groups.iter().filter(|group| group.iter().all(is_own)) {
        let Some(sorted) = sorted(reader, group, whole)? else {
            continue;
        };
        let is_short = sorted.iter().flatten().any(|(joint, _)| *joint > 255);
        let joint_size = if is_short { 2 } else { 1 };
        for ((joints, weights), set) in group.iter().zip(sorted) {
            let of_joints = set.iter().map(|(joint, _)| *joint);
            out.insert(*joints, integers(of_joints, joint_size, false));
            let parts = set.iter().map(|(_, part)| *part);
            let of_weights = match precision {
                WeightPrecision::Byte => integers(parts, 1, true),
                _ => fractions(parts, whole),
            };
            out.insert(*weights, of_weights);
        }
    }
    Ok(out)
}

/// Parts of a whole that is a power of two as floats, four to an element. Their sum is 1, to the bit.
fn fractions(parts: impl Iterator<Item = u32>, whole: u32) -> Elements {
    let part_of = 1.0 / whole as f32;
    let floats: Vec<f32> = parts.map(|part| part as f32 * part_of).collect();
    Elements::stepped(&floats, 4, part_of)
}

/// Numbers of 1 or 2 bytes, four to an element.
fn integers(numbers: impl Iterator<Item = u32>, size: usize, normalized: bool) -> Elements {
    let bytes: Vec<u8> = numbers
        .flat_map(|number| number.to_le_bytes()[..size].to_vec())
        .collect();
    let component = match size {
        1 => Component::U8,
        _ => Component::U16,
    };
    Elements::padded(&bytes, 4 * size, component, normalized)
}

fn sets(primitive: &Place<'_>) -> Vec<Set> {
    let attributes = primitive.get("attributes");
    let accessor = |name: String| {
        let index = attributes.as_ref()?.get(&name)?;
        index.whole().ok().map(|i| i as usize)
    };
    let set = |i: usize| {
        Some((
            accessor(format!("JOINTS_{i}"))?,
            accessor(format!("WEIGHTS_{i}"))?,
        ))
    };
    (0..).map_while(set).collect()
}

/// The influences of each set, of each vertex the greatest four in the first set. `None` if they are not
/// four floats each.
fn sorted(
    reader: &mut Reader<'_>,
    group: &[Set],
    whole: u32,
) -> Result<Option<Vec<Vec<Influence>>>, ReadError> {
    let mut read = Vec::with_capacity(group.len());
    for set in group {
        match numbers(reader, set)? {
            Some(numbers) => read.push(numbers),
            None => return Ok(None),
        }
    }
    let length = read.first().map_or(0, |set| set.joints.len());
    let is_long = |set: &Numbers| set.joints.len() == length && set.weights.len() == length;
    if length == 0 || !read.iter().all(is_long) {
        return Ok(None);
    }
    let mut out = vec![Vec::with_capacity(length); group.len()];
    for v in (0..length).step_by(4) {
        let weights = read.iter().flat_map(|set| &set.weights[v..v + 4]).copied();
        let Some(parts) = of_whole(&weights.collect::<Vec<f32>>(), whole) else {
            return Ok(None);
        };
        let joints = read.iter().flat_map(|set| &set.joints[v..v + 4]).copied();
        let mut influences: Vec<Influence> = joints
            .zip(parts)
            .map(|(joint, part)| (if part == 0 { 0 } else { joint }, part))
            .collect();
        influences.sort_by_key(|(joint, part)| (Reverse(*part), *joint));
        for (set, four) in out.iter_mut().zip(influences.as_chunks().0) {
            let before = set.last_chunk().copied().unwrap_or_default();
            set.extend_from_slice(&in_places(four, &before));
        }
    }
    Ok(Some(out))
}

/// Four influences, each in the place that its joint had with the vertex before. Neighbours follow the same
/// joints, and the codec stores what changes from one to the next: a seventh less than in the order of weights.
fn in_places(four: &[Influence; 4], before: &[Influence; 4]) -> [Influence; 4] {
    let mut placed: [Option<Influence>; 4] = [None; 4];
    let mut others = Vec::with_capacity(4);
    for influence in four.iter().filter(|(_, part)| *part > 0) {
        let had_it = |i: &usize| before[*i].0 == influence.0 && before[*i].1 > 0;
        match (0..4).find(|i| placed[*i].is_none() && had_it(i)) {
            Some(place) => placed[place] = Some(*influence),
            None => others.push(*influence),
        }
    }
    let mut others = others.into_iter();
    placed.map(|influence| influence.or_else(|| others.next()).unwrap_or((0, 0)))
}

/// The numbers of a set, four joints and weights for each vertex.
struct Numbers {
    joints: Vec<u32>,
    weights: Vec<f32>,
}

fn numbers(reader: &mut Reader<'_>, (joints, weights): &Set) -> Result<Option<Numbers>, ReadError> {
    let places = [joints, weights].map(|i| reader.root.entry("accessors", *i));
    let [Some(joints), Some(weights)] = places else {
        return Ok(None);
    };
    let (joints, weights) = (reader.accessor_at(joints)?, reader.accessor_at(weights)?);
    let is_usual = !joints.is_float() && weights.is_float();
    if !is_usual || joints.width() != 4 || weights.width() != 4 {
        return Ok(None);
    }
    Ok(Some(Numbers {
        joints: reader.integers(&joints)?,
        weights: reader.floats(&weights)?,
    }))
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
            for whole in [255, 1024] {
                let parts = of_whole(&weights, whole).unwrap();
                prop_assert_eq!(parts.iter().sum::<u32>(), whole);
                for (w, part) in weights.iter().zip(parts) {
                    prop_assert!((w / sum * whole as f32 - part as f32).abs() < 1.05);
                }
            }
        }
    }

    #[test]
    fn influences_stay_in_the_place_of_their_joint() {
        let before = [(7, 200), (3, 55), (0, 0), (0, 0)];
        // The joint 0 had no place, since a weight of nothing names no joint.
        let four = [(3, 150), (0, 80), (7, 25), (0, 0)];
        assert_eq!(
            in_places(&four, &before),
            [(7, 25), (3, 150), (0, 80), (0, 0)]
        );
        let four = [(9, 255), (0, 0), (0, 0), (0, 0)];
        assert_eq!(in_places(&four, &before), four);
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
