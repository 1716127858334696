//! Motions of an item: one of them plays at a time, so the greatest of their errors counts, and each
//! gets the level of articulation and tier that keeps it for the fewest bytes.

use super::memory;
use super::option_of_part::OptionOfPart;
use crate::item::part::{ItemLayer, ItemPart};
use articula_stream::decide::{MAX_OPTIONS, PartOption};
use std::collections::BTreeSet;

/// Most clips whose level and tier are told by name.
const MOST_NAMED: usize = 3;

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

/// Level of articulation and tier.
type Place = (u32, u32);

fn place(layer: &ItemLayer) -> Place {
    let of = |scheme: &str| layer.keep.get(scheme).copied();
    let loa = of("loa").or_else(|| of("face_loa")).unwrap_or(0);
    (loa, of("tier").unwrap_or(0))
}

/// A way to send a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cut {
    /// Its layer; `None` for a motion that is not sent, or whose first pose is held.
    layer: Option<usize>,
    place: Option<Place>,
    bytes: u64,
    error_m: f64,
    joints: u64,
    memory: u64,
}

impl Cut {
    fn loa(&self) -> u32 {
        self.place.map_or(0, |(loa, _)| loa)
    }
}

/// A motion with the ways to send it.
struct Motion<'a> {
    index: usize,
    part: &'a ItemPart,
    cuts: Vec<Cut>,
}

impl<'a> Motion<'a> {
    /// All cuts up to a finest tier; a motion whose error at rest is known may be left out, and costs nothing
    /// then, or if it is the `first` of all, at rest.
    fn new(
        (index, part): (usize, &'a ItemPart),
        is_first: bool,
        (finest_tier, targets): (u32, u64),
    ) -> Self {
        let held = part.base_error_m.map(|error_m| Cut {
            layer: None,
            place: None,
            bytes: if is_first { part.base_bytes } else { 0 },
            error_m,
            joints: 0,
            memory: 0,
        });
        let layers = part.layers.iter().enumerate();
        let allowed = layers.filter(|(_, layer)| place(layer).1 >= finest_tier);
        let moving = allowed.map(|(i, layer)| Cut {
            layer: Some(i),
            place: Some(place(layer)),
            bytes: part.bytes_of(&part.closure(&[i])),
            error_m: layer.error_m,
            joints: layer.joints.unwrap_or(0),
            memory: memory::motion(part, layer, targets),
        });
        Self {
            index,
            part,
            cuts: held.into_iter().chain(moving).collect(),
        }
    }

    /// The cut for a level of articulation and tier: the finest level up to it, and of that the finest
    /// tier from it on. What nothing is known of stays whole.
    fn nearest(&self, wanted: Option<Place>) -> Option<Cut> {
        let moving = self.cuts.iter().filter_map(|cut| Some((cut.place?, *cut)));
        let held = self.cuts.iter().find(|cut| cut.place.is_none()).copied();
        let Some((loa, tier)) = wanted else {
            return held;
        };
        let allowed = moving.filter(|((l, t), _)| *l <= loa && *t >= tier);
        let finest = allowed.max_by_key(|((l, t), _)| (*l, u32::MAX - *t));
        finest.map(|(_, cut)| cut).or(held)
    }

    /// The cut of the fewest bytes, up to a level of articulation, with at most this error.
    fn within(&self, loa: u32, error_m: f64) -> Option<Cut> {
        let fitting = |cut: &&Cut| cut.loa() <= loa && cut.error_m <= error_m;
        let by = |a: &&Cut, b: &&Cut| {
            let by_bytes = a.bytes.cmp(&b.bytes);
            by_bytes.then(a.error_m.total_cmp(&b.error_m))
        };
        self.cuts.iter().filter(fitting).min_by(by).copied()
    }
}

/// The options of some motions: each level of articulation and tier for all of them, none of their
/// layers, and for each greatest error the fewest bytes. None is worse than another that costs no
/// more and has no higher level of articulation.
///
/// A motion without a layer is left out; `first` is there all the same, at rest.
pub(super) fn options(
    parts: Vec<(usize, &ItemPart)>,
    first: Option<usize>,
    (finest_tier, morph_targets): (u32, u64),
    cost: Cost,
) -> Vec<OptionOfPart> {
    let layers = parts.iter().flat_map(|(_, part)| &part.layers);
    let coarsest = layers.map(|layer| place(layer).1).max().unwrap_or(0);
    let finest = finest_tier.min(coarsest);
    let motions: Vec<Motion<'_>> = parts
        .into_iter()
        .map(|(index, part)| {
            let is_first = first == Some(index);
            Motion::new((index, part), is_first, (finest, morph_targets))
        })
        .collect();
    if motions.is_empty() {
        return Vec::new();
    }
    let mut even = undominated(even(&motions));
    even.truncate(MAX_OPTIONS);
    let most = MAX_OPTIONS - even.len();
    let mut mixed = match motions.len() {
        1 => Vec::new(),
        _ => undominated(mixed(&motions, most)),
    };
    mixed.retain(|mix| !even.contains(mix));
    let even = even.into_iter().map(|mix| (mix, true));
    let all = even.chain(mixed.into_iter().map(|mix| (mix, false)));
    all.map(|(mix, is_even)| OptionOfPart {
        is_even,
        ..option(&motions, &mix, cost)
    })
    .collect()
}

/// A cut of each motion.
type Mix = Vec<Cut>;

/// Each level of articulation and tier for all motions, and all of them held.
fn even(motions: &[Motion<'_>]) -> Vec<Mix> {
    let cuts = motions.iter().flat_map(|motion| &motion.cuts);
    let places: BTreeSet<Option<Place>> = cuts.map(|cut| cut.place).collect();
    let of = |place: Option<Place>| motions.iter().map(|m| m.nearest(place)).collect();
    places.into_iter().filter_map(of).collect()
}

/// The fewest bytes for each of some greatest errors and levels of articulation, at most so many mixes.
fn mixed(motions: &[Motion<'_>], most: usize) -> Vec<Mix> {
    let cuts = || motions.iter().flat_map(|motion| &motion.cuts);
    let levels: BTreeSet<u32> = cuts().map(Cut::loa).collect();
    let mut errors: Vec<f64> = cuts().map(|cut| cut.error_m).collect();
    errors.sort_by(f64::total_cmp);
    errors.dedup();
    let of_level = (most / levels.len().max(1)).max(1);
    let every = errors.len().div_ceil(of_level).max(1);
    let errors: Vec<f64> = errors.into_iter().step_by(every).collect();
    let of = |loa: u32, error_m: f64| -> Option<Mix> {
        motions.iter().map(|m| m.within(loa, error_m)).collect()
    };
    let all = levels.into_iter().flat_map(|loa| {
        let errors = errors.iter();
        errors.filter_map(move |error_m| of(loa, *error_m))
    });
    all.take(most).collect()
}

/// What a mix costs, and its error.
#[derive(PartialEq)]
struct Sums {
    bytes: u64,
    error_m: f64,
    joints: u64,
    loa: u32,
    memory: u64,
}

impl Sums {
    fn of(mix: &[Cut]) -> Self {
        Self {
            bytes: mix.iter().map(|cut| cut.bytes).fold(0, u64::saturating_add),
            error_m: mix.iter().map(|cut| cut.error_m).fold(0.0, f64::max),
            joints: mix.iter().map(|cut| cut.joints).max().unwrap_or(0),
            loa: mix.iter().map(Cut::loa).max().unwrap_or(0),
            memory: mix
                .iter()
                .map(|cut| cut.memory)
                .fold(0, u64::saturating_add),
        }
    }

    /// Whether another one is worse in nothing.
    fn is_dominated_by(&self, other: &Self) -> bool {
        other.bytes <= self.bytes
            && other.error_m <= self.error_m
            && other.joints <= self.joints
            && other.loa <= self.loa
            && other.memory <= self.memory
    }
}

/// The mixes that no other one dominates; of equal ones the first.
fn undominated(mixes: Vec<Mix>) -> Vec<Mix> {
    let sums: Vec<Sums> = mixes.iter().map(|mix| Sums::of(mix)).collect();
    let is_best = |i: usize| {
        let mut others = sums.iter().enumerate().filter(|(j, _)| *j != i);
        !others.any(|(j, other)| sums[i].is_dominated_by(other) && (j < i || sums[i] != *other))
    };
    let numbered = mixes.into_iter().enumerate();
    let best = numbered.filter(|(i, _)| is_best(*i));
    best.map(|(_, mix)| mix).collect()
}

fn option(motions: &[Motion<'_>], mix: &[Cut], cost: Cost) -> OptionOfPart {
    let sums = Sums::of(mix);
    let tiers = mix.iter().filter_map(|cut| cut.place).map(|(_, tier)| tier);
    let layers = motions.iter().zip(mix).map(|(motion, cut)| {
        let kept = motion.part.closure(cut.layer.as_slice());
        (motion.index, kept)
    });
    OptionOfPart {
        option: PartOption {
            name: name(motions, mix),
            // Where there is no motion, its tolerance does not matter.
            level: tiers.min().unwrap_or(0),
            loa: Some(sums.loa),
            error_m: sums.error_m,
            bytes_once: sums.bytes,
            frame_ns: (sums.joints as f64 * cost.ns).min(1e12) as u64,
            memory_bytes: sums.memory.min(memory::MOST),
            ..PartOption::default()
        },
        layers: layers.collect(),
        is_even: true,
    }
}

/// One level and tier, those of each of a few motions, or the range of many.
fn name(motions: &[Motion<'_>], mix: &[Cut]) -> String {
    let of = |cut: &Cut| match cut.place {
        None if cut.bytes > 0 => "at rest".to_owned(),
        None => "left out".to_owned(),
        Some((loa, tier)) => format!("loa {loa}, tier {tier}"),
    };
    let names: BTreeSet<String> = mix.iter().map(of).collect();
    let loas = || mix.iter().filter_map(|cut| cut.place).map(|(loa, _)| loa);
    let range = |least: Option<u32>, most: Option<u32>| match (least, most) {
        (Some(least), Some(most)) if least < most => format!("{least} to {most}"),
        (least, _) => least.unwrap_or(0).to_string(),
    };
    let tiers = || mix.iter().filter_map(|cut| cut.place).map(|(_, tier)| tier);
    let resting = mix.iter().filter(|cut| cut.place.is_none()).count();
    match names.len() {
        1 => names.into_iter().next().unwrap_or_default(),
        _ if motions.len() <= MOST_NAMED => {
            let pairs = motions.iter().zip(mix);
            let each = pairs.map(|(motion, cut)| format!("{} {}", motion.part.name, of(cut)));
            each.collect::<Vec<_>>().join("; ")
        }
        _ if resting == motions.len() => format!("one at rest, {} left out", resting - 1),
        _ => {
            let resting = match resting {
                0 => String::new(),
                some => format!(", {some} without motion"),
            };
            format!(
                "by clip: loa {}, tier {}{resting}",
                range(loas().min(), loas().max()),
                range(tiers().min(), tiers().max())
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item::part::PartKind;

    /// A motion of layers with level of articulation, tier, bytes of the layer alone, and error.
    fn motion(name: &str, layers: &[(u32, u32, u64, f64)]) -> ItemPart {
        let mut part = ItemPart::new(name, PartKind::BodyMotion);
        part.base_bytes = 10;
        part.base_error_m = Some(1.0);
        for (loa, tier, bytes, error_m) in layers {
            let below = part.layers.iter().rposition(|l| l.keep["loa"] < *loa);
            let coarser = part.layers.last().filter(|l| l.keep["loa"] == *loa);
            let coarser = coarser.map(|_| part.layers.len() - 1);
            part.layers.push(ItemLayer {
                keep: [("loa".to_owned(), *loa), ("tier".to_owned(), *tier)].into(),
                needs: below.into_iter().chain(coarser).collect(),
                bytes: *bytes,
                error_m: *error_m,
                ..ItemLayer::default()
            });
        }
        part
    }

    fn found(parts: &[ItemPart]) -> Vec<OptionOfPart> {
        let parts = parts.iter().enumerate().collect();
        options(parts, Some(0), (0, 0), Cost::per_ms(None))
    }

    #[test]
    fn a_level_that_is_worse_than_a_coarser_one_is_no_option() {
        // Level 2 moves a spine whose arms, of level 3, would turn against it.
        let layers = [
            (1, 0, 100, 0.709),
            (2, 0, 100, 0.746),
            (3, 1, 50, 0.05),
            (3, 0, 50, 0.01),
        ];
        let options = found(&[motion("walk", &layers)]);
        let of: Vec<(u32, u64)> = options
            .iter()
            .map(|o| (o.option.loa.unwrap(), o.option.bytes_once))
            .collect();
        assert_eq!(of, [(0, 10), (1, 110), (3, 310), (3, 260)]);
        let errors: Vec<f64> = options.iter().map(|o| o.option.error_m).collect();
        assert_eq!(errors, [1.0, 0.709, 0.01, 0.05]);
    }

    #[test]
    fn a_clip_without_a_layer_costs_nothing_but_for_the_first() {
        let layers = [(1, 0, 100, 0.5)];
        let options = found(&[motion("a", &layers), motion("b", &layers)]);
        let least = options.iter().min_by_key(|o| o.option.bytes_once).unwrap();
        assert_eq!(
            (&*least.option.name, least.option.bytes_once),
            ("a at rest; b left out", 10)
        );
        // It shows the rest pose where the clip is wanted.
        assert_eq!(least.option.error_m, 1.0);
        let both = options
            .iter()
            .min_by(|a, b| a.option.error_m.total_cmp(&b.option.error_m));
        assert_eq!(both.unwrap().option.bytes_once, 220);
    }

    #[test]
    fn each_clip_has_its_own_level_and_tier() {
        // At rest, `idle` is off by little; `jump` needs all of its bytes.
        let mut idle = motion("idle", &[(1, 1, 500, 0.004), (1, 0, 500, 0.001)]);
        idle.base_error_m = Some(0.02);
        let jump = motion("jump", &[(1, 1, 300, 0.05), (1, 0, 300, 0.015)]);
        let options = found(&[idle, jump]);
        let best = options.iter().filter(|o| o.option.error_m <= 0.02);
        let best = best.min_by_key(|o| o.option.bytes_once).unwrap();
        assert_eq!((best.option.bytes_once, best.option.error_m), (620, 0.02));
        assert_eq!(best.option.name, "idle at rest; jump loa 1, tier 0");
        assert!(!best.is_even);
        assert_eq!(
            best.layers,
            [(0, vec![false, false]), (1, vec![true, true])]
        );
        // The same for all costs 500 bytes more.
        let even = options
            .iter()
            .filter(|o| o.is_even && o.option.error_m <= 0.02);
        assert_eq!(even.map(|o| o.option.bytes_once).min(), Some(1620));
        for (i, a) in options.iter().enumerate() {
            let worse = |b: &OptionOfPart| {
                b.option.bytes_once <= a.option.bytes_once && b.option.error_m < a.option.error_m
            };
            let same_kind = |b: &&OptionOfPart| b.is_even == a.is_even;
            assert!(!options.iter().filter(same_kind).any(worse), "{i}");
        }
    }
}
