//! Motions of an item: all of one kind get the same level of articulation and tier, since one of them
//! plays at a time.

use super::option_of_part::OptionOfPart;
use crate::item::part::{ItemLayer, ItemPart};
use articula_stream::decide::{MAX_OPTIONS, PartOption};
use std::collections::BTreeSet;

/// What a joint or parameter costs in a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost {
    ns: f64,
}

impl Cost {
    /// By the number that a device evaluates in a millisecond; nothing if it is unknown.
    pub(super) fn per_ms(number: Option<f64>) -> Self {
        let known = number.filter(|n| *n > 0.0);
        Self {
            ns: known.map_or(0.0, |n| 1e6 / n),
        }
    }
}

/// Level of articulation and tier of a layer.
fn place(layer: &ItemLayer) -> (u32, u32) {
    let of = |scheme: &str| layer.keep.get(scheme).copied();
    let loa = of("loa").or_else(|| of("face_loa")).unwrap_or(0);
    (loa, of("tier").unwrap_or(0))
}

/// The options of some motions: each level of articulation and tier, and none of their layers.
pub(super) fn options(
    parts: Vec<(usize, &ItemPart)>,
    finest_tier: u32,
    cost: Cost,
) -> Vec<OptionOfPart> {
    if parts.is_empty() {
        return Vec::new();
    }
    let layers = parts.iter().flat_map(|(_, part)| &part.layers);
    let mut places: BTreeSet<(u32, u32)> = layers.map(place).collect();
    let coarsest = places.iter().map(|(_, tier)| *tier).max().unwrap_or(0);
    places.retain(|(_, tier)| *tier >= finest_tier.min(coarsest));
    let at_rest = parts.iter().all(|(_, part)| part.base_error_m.is_some());
    let none = at_rest.then_some(None);
    let all = none.into_iter().chain(places.into_iter().map(Some));
    let made = all.map(|place| option(&parts, place, cost));
    made.take(MAX_OPTIONS).collect()
}

fn option(parts: &[(usize, &ItemPart)], wanted: Option<(u32, u32)>, cost: Cost) -> OptionOfPart {
    let mut option = PartOption {
        name: match wanted {
            None => "held".into(),
            Some((loa, tier)) => format!("loa {loa}, tier {tier}"),
        },
        // Where there is no motion, its tolerance does not matter.
        level: wanted.map_or(0, |(_, tier)| tier),
        loa: Some(wanted.map_or(0, |(loa, _)| loa)),
        ..PartOption::default()
    };
    let mut layers = Vec::with_capacity(parts.len());
    let mut joints = 0_u64;
    for (index, part) in parts {
        let found = wanted.and_then(|wanted| nearest(part, wanted));
        let kept = part.closure(found.as_slice());
        let layer = found.and_then(|i| part.layers.get(i));
        let error = layer.map_or(part.base_error_m.unwrap_or(0.0), |layer| layer.error_m);
        option.error_m = option.error_m.max(error);
        option.bytes_once += part.bytes_of(&kept);
        joints = joints.max(layer.and_then(|layer| layer.joints).unwrap_or(0));
        layers.push((*index, kept));
    }
    option.frame_ns = (joints as f64 * cost.ns).min(1e12) as u64;
    OptionOfPart { option, layers }
}

/// The layer of a motion for a level of articulation and tier: the finest level up to it, and of that
/// the finest tier from it on.
fn nearest(part: &ItemPart, (loa, tier): (u32, u32)) -> Option<usize> {
    let places = part.layers.iter().map(place).enumerate();
    let allowed = places.filter(|(_, (l, t))| *l <= loa && *t >= tier);
    let finest = allowed.max_by_key(|(_, (l, t))| (*l, u32::MAX - *t));
    finest.map(|(i, _)| i)
}
