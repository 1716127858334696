//! Properties of the budget allocator: acceptance test 10 of `docs/methods/motion-lod.md` part 10,
//! agreement with the heap of its part 7 and with brute force, no allocation in a frame.

use articula_core::budget::{BudgetAllocator, BudgetPolicy, LodOption, LodOptionSetId, LodRequest};
use proptest::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The knapsack alone, without cap and ageing.
const PLAIN: BudgetPolicy = BudgetPolicy {
    cap_px: f32::INFINITY,
    target_px: 0.0,
    patience_frames: 0,
    hold_frames: 0,
};

/// Option set, weight and pixels per metre of a character; `None` if it is hidden.
type Wish = Option<(usize, f32, f32)>;

#[derive(Debug, Clone)]
struct Crowd {
    option_sets: Vec<Vec<LodOption>>,
    wishes: Vec<Wish>,
}

impl Crowd {
    fn budget(&self, policy: BudgetPolicy) -> (BudgetAllocator, Vec<LodOptionSetId>) {
        let mut budget = BudgetAllocator::new(self.wishes.len(), policy);
        let ids = self
            .option_sets
            .iter()
            .map(|m| budget.add_options(m).unwrap());
        let ids: Vec<LodOptionSetId> = ids.collect();
        self.ask(&mut budget, &ids);
        (budget, ids)
    }

    fn ask(&self, budget: &mut BudgetAllocator, ids: &[LodOptionSetId]) {
        for (c, wish) in self.wishes.iter().enumerate() {
            match *wish {
                None => budget.hide(c),
                Some((option_set, weight, pixels_per_metre)) => budget.request(
                    c,
                    LodRequest {
                        option_set: ids[option_set],
                        weight,
                        pixels_per_metre,
                    },
                ),
            }
        }
    }

    fn lod_option(&self, budget: &BudgetAllocator, c: usize) -> Option<LodOption> {
        let (option_set, ..) = self.wishes[c]?;
        Some(self.option_sets[option_set][budget.choice(c).unwrap()])
    }

    /// Cost and weighted error of the chosen options.
    fn totals(&self, budget: &BudgetAllocator) -> (f64, f64) {
        let mut totals = (0.0, 0.0);
        for c in 0..self.wishes.len() {
            if let (Some(lod_option), Some((_, weight, _))) =
                (self.lod_option(budget, c), self.wishes[c])
            {
                totals.0 += f64::from(lod_option.cost);
                totals.1 += f64::from(weight) * f64::from(lod_option.error_metres);
            }
        }
        totals
    }

    fn cheapest_cost(&self) -> f64 {
        let option_sets = self.wishes.iter().flatten().map(|w| &self.option_sets[w.0]);
        option_sets.map(|m| f64::from(hull(m)[0].cost)).sum()
    }

    /// The largest weighted error that any single upgrade removes.
    fn largest_upgrade(&self) -> f64 {
        let wishes = self.wishes.iter().flatten();
        let gains = wishes.flat_map(|(option_set, weight, _)| {
            let hull = hull(&self.option_sets[*option_set]);
            let drops = hull
                .windows(2)
                .map(|p| p[0].error_metres - p[1].error_metres);
            drops
                .map(|d| f64::from(d) * f64::from(*weight))
                .collect::<Vec<_>>()
        });
        gains.fold(0.0, f64::max)
    }
}

/// Lower hull by gift wrapping: from the cheapest option on to the one with the steepest slope.
fn hull(lod_options: &[LodOption]) -> Vec<LodOption> {
    let by_cost = |a: &&LodOption, b: &&LodOption| {
        let by_cost = a.cost.total_cmp(&b.cost);
        by_cost.then(a.error_metres.total_cmp(&b.error_metres))
    };
    let mut hull = vec![*lod_options.iter().min_by(by_cost).unwrap()];
    loop {
        let at = hull[hull.len() - 1];
        let slope = |o: &LodOption| {
            (f64::from(at.error_metres) - f64::from(o.error_metres))
                / (f64::from(o.cost) - f64::from(at.cost))
        };
        let better = lod_options
            .iter()
            .filter(|o| o.error_metres < at.error_metres);
        let next = better.max_by(|a, b| {
            slope(a)
                .total_cmp(&slope(b))
                .then(b.cost.total_cmp(&a.cost))
        });
        match next {
            Some(next) => hull.push(*next),
            None => return hull,
        }
    }
}

#[derive(PartialEq)]
struct Upgrade {
    urgent: bool,
    rate: f64,
    character: usize,
}

impl Eq for Upgrade {}

impl PartialOrd for Upgrade {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Upgrade {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_rate = self
            .urgent
            .cmp(&other.urgent)
            .then(self.rate.total_cmp(&other.rate));
        by_rate.then(other.character.cmp(&self.character))
    }
}

/// The plain form of `docs/methods/motion-lod.md` part 7: all at their cheapest option, then the
/// best upgrade from a heap until the next one does not fit. Returns the chosen options.
fn plain(crowd: &Crowd, cap_px: f32, budget: f64) -> Vec<Option<LodOption>> {
    let hulls: Vec<_> = crowd.option_sets.iter().map(|m| hull(m)).collect();
    let mut at = vec![0; crowd.wishes.len()];
    let upgrade = |character: usize, at: usize| {
        let (option_set, weight, scale) = crowd.wishes[character]?;
        let (from, to) = (hulls[option_set][at], hulls[option_set].get(at + 1)?);
        let drop = f64::from(from.error_metres) - f64::from(to.error_metres);
        Some(Upgrade {
            urgent: from.error_metres * scale > cap_px,
            rate: f64::from(weight) * drop / (f64::from(to.cost) - f64::from(from.cost)),
            character,
        })
    };
    let mut heap: BinaryHeap<Upgrade> = (0..at.len()).filter_map(|c| upgrade(c, 0)).collect();
    let mut left = budget - crowd.cheapest_cost();
    while let Some(best) = heap.pop() {
        let c = best.character;
        let hull = &hulls[crowd.wishes[c].unwrap().0];
        let cost = f64::from(hull[at[c] + 1].cost) - f64::from(hull[at[c]].cost);
        if cost > left {
            break;
        }
        left -= cost;
        at[c] += 1;
        heap.extend(upgrade(c, at[c]));
    }
    let chosen = crowd.wishes.iter().zip(&at);
    chosen
        .map(|(wish, at)| wish.map(|w| hulls[w.0][*at]))
        .collect()
}

/// Costs in steps of 0.25, which the fixed point represents exactly.
fn lod_options() -> impl Strategy<Value = Vec<LodOption>> {
    let lod_option = (0_u16..400, 0_u16..2000).prop_map(|(cost, error)| LodOption {
        cost: 0.25 * f32::from(cost),
        error_metres: 1e-4 * f32::from(error),
    });
    prop::collection::vec(lod_option, 1..6)
}

fn wish(option_sets: usize) -> impl Strategy<Value = Wish> {
    let scale = 1.0_f32..2000.0;
    prop::option::weighted(0.85, (0..option_sets, 0.01_f32..100.0, scale))
}

fn crowd(most: usize) -> impl Strategy<Value = Crowd> {
    let option_sets = prop::collection::vec(lod_options(), 1..4);
    option_sets.prop_flat_map(move |option_sets| {
        let wishes = prop::collection::vec(wish(option_sets.len()), 0..most);
        wishes.prop_map(move |wishes| Crowd {
            option_sets: option_sets.clone(),
            wishes,
        })
    })
}

/// Minimum weighted error of all combinations within the budget.
fn brute_force(crowd: &Crowd, budget: f64) -> f64 {
    fn least(crowd: &Crowd, c: usize, left: f64) -> f64 {
        let Some(wish) = crowd.wishes.get(c) else {
            return 0.0;
        };
        let Some((option_set, weight, _)) = *wish else {
            return least(crowd, c + 1, left);
        };
        let affordable = crowd.option_sets[option_set]
            .iter()
            .filter(|o| f64::from(o.cost) <= left);
        let errors = affordable.map(|o| {
            f64::from(weight) * f64::from(o.error_metres)
                + least(crowd, c + 1, left - f64::from(o.cost))
        });
        errors.fold(f64::INFINITY, f64::min)
    }
    least(crowd, 0, budget)
}

proptest! {
    #[test]
    fn the_budget_is_never_exceeded_and_more_of_it_never_hurts(
        crowd in crowd(40), cap_px in 0.5_f32..50.0, steps in prop::collection::vec(0.0_f32..400.0, 1..8),
    ) {
        let (mut budget, _) = crowd.budget(BudgetPolicy { cap_px, ..PLAIN });
        let (mut units, mut before) = (0.0, f64::INFINITY);
        let mut costs = vec![0.0; crowd.wishes.len()];
        for more in steps {
            units += more;
            let report = budget.solve(units);
            let (cost, error) = crowd.totals(&budget);
            prop_assert!((report.used - cost).abs() < 1e-6);
            prop_assert!(cost <= f64::from(units).max(crowd.cheapest_cost()) + 1.0 / 64.0);
            prop_assert!(error <= before, "{error} after {before}");
            before = error;
            for (c, cost) in costs.iter_mut().enumerate() {
                if let Some(lod_option) = crowd.lod_option(&budget, c) {
                    prop_assert!(lod_option.cost >= *cost, "nobody loses");
                    *cost = lod_option.cost;
                }
            }
        }
    }

    #[test]
    fn at_most_one_upgrade_from_the_best(crowd in crowd(6), units in 0.0_f32..500.0) {
        let (mut budget, _) = crowd.budget(PLAIN);
        budget.solve(units);
        let (cost, error) = crowd.totals(&budget);
        // If even the cheapest options do not fit, compare at their cost.
        let best = brute_force(&crowd, cost.max(f64::from(units)));
        prop_assert!(error >= best - 1e-6);
        prop_assert!(error <= best + crowd.largest_upgrade() + 1e-6, "{error} for {best}");
    }

    #[test]
    fn agrees_with_the_heap(crowd in crowd(40), units in 0.0_f32..3000.0, cap_px in 0.5_f32..50.0) {
        let (mut budget, _) = crowd.budget(BudgetPolicy { cap_px, ..PLAIN });
        budget.solve(units);
        let chosen = plain(&crowd, cap_px, f64::from(units));
        // Rounding may order equal gains per cost differently, which changes one upgrade of one
        // character.
        let others = (0..chosen.len()).filter(|c| {
            let cost = |o: Option<LodOption>| o.map(|o| o.cost);
            cost(crowd.lod_option(&budget, *c)) != cost(chosen[*c])
        });
        prop_assert!(others.count() <= 2);
        let total: f64 = crowd.wishes.iter().zip(&chosen)
            .filter_map(|(w, o)| Some(f64::from(w.as_ref()?.1) * f64::from(o.as_ref()?.error_metres)))
            .sum();
        prop_assert!((crowd.totals(&budget).1 - total).abs() <= crowd.largest_upgrade() + 1e-6);
    }

    #[test]
    fn a_repair_gives_what_solving_anew_gives(
        crowd in crowd(40),
        frames in prop::collection::vec(
            (prop::collection::vec((0_usize..40, wish(1)), 0..5), 0.0_f32..3000.0), 1..12),
    ) {
        let mut crowd = crowd;
        let policy = BudgetPolicy { cap_px: 5.0, ..PLAIN };
        let (mut repaired, ids) = crowd.budget(policy);
        for (changes, units) in frames {
            for (c, wish) in changes {
                if let Some(slot) = crowd.wishes.get_mut(c) {
                    // Powers of two: either the same scale or one beyond the hysteresis.
                    *slot = wish.map(|(option_set, weight, scale)| (option_set, weight, scale.log2().round().exp2()));
                }
            }
            // Requests within the hysteresis would be ignored, so discard the history.
            for c in 0..crowd.wishes.len() {
                repaired.force_update(c);
            }
            crowd.ask(&mut repaired, &ids);
            let found = repaired.solve(units);
            let (mut anew, _) = crowd.budget(policy);
            let expected = anew.solve(units);
            for c in 0..crowd.wishes.len() {
                prop_assert_eq!(repaired.choice(c), anew.choice(c));
            }
            prop_assert_eq!(found.used, expected.used);
            prop_assert_eq!(found.demand, expected.demand);
            prop_assert_eq!((found.visible, found.above_cap), (expected.visible, expected.above_cap));
            prop_assert_eq!((found.worst_px, found.mean_px), (expected.worst_px, expected.mean_px));
            prop_assert_eq!(repaired.per_option(), anew.per_option());
        }
    }

    #[test]
    fn a_report_says_what_is_shown(crowd in crowd(40), units in prop::collection::vec(0.0_f32..3000.0, 1..4)) {
        let (mut budget, _) = crowd.budget(BudgetPolicy { cap_px: 5.0, ..PLAIN });
        let mut known = vec![None; crowd.wishes.len()];
        for units in units {
            let report = budget.solve(units);
            for change in budget.changes() {
                let slot = &mut known[change.character as usize];
                prop_assert_eq!(*slot, change.from);
                prop_assert!(change.from != change.to);
                *slot = change.to;
            }
            let shown: Vec<_> = (0..known.len()).map(|c| budget.choice(c)).collect();
            let told: Vec<_> = known.iter().map(|k| k.map(usize::from)).collect();
            prop_assert_eq!(&shown, &told);
            prop_assert_eq!(report.changes, budget.changes().len());
            prop_assert_eq!(report.budget, f64::from((units * 64.0).round()) / 64.0);
            let px: Vec<f32> = (0..known.len())
                .filter_map(|c| Some(crowd.lod_option(&budget, c)?.error_metres * crowd.wishes[c]?.2))
                .collect();
            prop_assert_eq!(report.visible, px.len());
            prop_assert_eq!(report.above_cap, px.iter().filter(|px| **px > 5.0).count());
            prop_assert_eq!(report.worst_px, px.iter().copied().fold(0.0, f32::max));
            let mean = px.iter().sum::<f32>() / px.len().max(1) as f32;
            prop_assert!((report.mean_px - mean).abs() <= 1e-4 * mean);
            let counted = budget.per_option().iter().sum::<u32>() as usize;
            prop_assert_eq!(counted, px.len());
        }
    }
}

/// `n` equal characters with two options: 10 units with an error of 100 mm, 110 without error.
fn equals(n: usize) -> Crowd {
    let lod_option = |cost, error_metres| LodOption { cost, error_metres };
    Crowd {
        option_sets: vec![vec![lod_option(10.0, 0.1), lod_option(110.0, 0.0)]],
        wishes: vec![Some((0, 1.0, 100.0)); n],
    }
}

fn fine(budget: &BudgetAllocator, n: usize) -> Vec<usize> {
    (0..n).filter(|c| budget.choice(*c) == Some(1)).collect()
}

#[test]
fn ties_go_to_the_first_and_a_permutation_changes_nothing_else() {
    let crowd = equals(10);
    let (mut budget, _) = crowd.budget(PLAIN);
    // 100 for the cheapest options, 3 upgrades, and 99 that remain unused.
    let report = budget.solve(100.0 + 300.0 + 99.0);
    assert_eq!(fine(&budget, 10), [0, 1, 2]);
    assert_eq!((report.used, report.demand), (400.0, 1100.0));
    assert_eq!(budget.per_option(), [7, 3]);

    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let lod_option = |cost: f32, error_metres: f32| LodOption { cost, error_metres };
    let option_set = |f: f32| {
        vec![
            lod_option(20.0, 0.2 * f),
            lod_option(60.0, 0.05 * f),
            lod_option(180.0, 0.0),
        ]
    };
    let crowd = Crowd {
        option_sets: vec![option_set(1.0), option_set(0.7)],
        wishes: (0..500)
            .map(|i| Some((i % 2, 0.1 + random(), 10.0 + 300.0 * random())))
            .collect(),
    };
    let mut turned = crowd.clone();
    turned.wishes.rotate_left(123);
    turned.wishes.reverse();
    let policy = BudgetPolicy {
        cap_px: 3.0,
        ..PLAIN
    };
    let ((mut a, _), (mut b, _)) = (crowd.budget(policy), turned.budget(policy));
    for units in [15_000.0, 30_000.0, 50_000.0] {
        assert_eq!(a.solve(units).used, b.solve(units).used);
        for c in 0..500 {
            assert_eq!(a.choice((c + 123) % 500), b.choice(499 - c));
        }
    }
}

#[test]
fn who_is_above_the_cap_comes_first() {
    let lod_option = |cost, error_metres| LodOption { cost, error_metres };
    let crowd = Crowd {
        option_sets: vec![vec![
            lod_option(0.0, 0.10),
            lod_option(10.0, 0.01),
            lod_option(100.0, 0.0),
        ]],
        // The first has 100 times the weight, but is within the cap of 2 px.
        wishes: vec![Some((0, 100.0, 15.0)), Some((0, 1.0, 100.0))],
    };
    let policy = BudgetPolicy {
        cap_px: 2.0,
        ..PLAIN
    };
    let (mut budget, ids) = crowd.budget(policy);
    assert_eq!(budget.solve(10.0).above_cap, 0);
    assert_eq!([budget.choice(0), budget.choice(1)], [Some(0), Some(1)]);
    // With `target_px` at the cap no further upgrade is taken.
    budget.set_policy(BudgetPolicy {
        target_px: 2.0,
        ..policy
    });
    let report = budget.solve(1e6);
    assert_eq!((report.used, report.demand), (10.0, 10.0));
    budget.set_policy(policy);
    assert_eq!(budget.solve(1e6).used, 200.0);
    // A character without weight is brought to the cap and no further.
    let dull = |weight| LodRequest {
        option_set: ids[0],
        weight,
        pixels_per_metre: 100.0,
    };
    for weight in [0.0, -1.0, f32::NAN] {
        budget.request(1, dull(1.0));
        budget.request(1, dull(weight));
        budget.solve(1e6);
        assert_eq!(budget.choice(1), Some(1));
    }
}

#[test]
fn small_changes_of_scale_touch_nothing() {
    let crowd = equals(2);
    let policy = BudgetPolicy {
        cap_px: 9.0,
        target_px: 9.0,
        ..PLAIN
    };
    let (mut budget, ids) = crowd.budget(policy);
    let at = |pixels_per_metre| LodRequest {
        option_set: ids[0],
        weight: 1.0,
        pixels_per_metre,
    };
    // 10 px at 100 px/m; the cap is 9 px.
    assert_eq!(budget.solve(1e6).changes, 2);
    for scale in [99.0, 95.0, 91.0, 109.0, 100.0] {
        budget.request(0, at(scale));
        assert_eq!(budget.solve(1e6).changes, 0, "{scale}");
    }
    budget.request(0, at(85.0));
    assert_eq!(budget.solve(1e6).changes, 1);
    assert_eq!(budget.choice(0), Some(0));
    // The report uses the current scale: 8.5 px, and 9.2 px just before the update.
    budget.request(0, at(92.0));
    let report = budget.solve(1e6);
    assert_eq!((report.changes, report.above_cap), (0, 1));
    assert!((report.worst_px - 9.2).abs() < 1e-4);
    // A requeued character is updated in any case.
    budget.force_update(0);
    budget.request(0, at(92.0));
    assert_eq!(budget.solve(1e6).changes, 1);
}

#[test]
fn nobody_waits_for_ever() {
    let (n, k) = (60, 7);
    let policy = BudgetPolicy {
        cap_px: 1.0,
        patience_frames: 8,
        hold_frames: 12,
        ..PLAIN
    };
    let units = 10.0 * n as f32 + 100.0 * k as f32;
    // Equal weights, then weights that differ by up to a factor of 1000.
    for spread in [1.0_f32, 1000.0] {
        let mut crowd = equals(n);
        for (c, wish) in crowd.wishes.iter_mut().enumerate() {
            wish.as_mut().unwrap().1 = spread.powf(c as f32 / n as f32);
        }
        let (mut budget, _) = crowd.budget(policy);
        let (mut last, mut longest) = (vec![0; n], 0);
        let mut changes = 0;
        for frame in 1..3000 {
            let report = budget.solve(units);
            assert!(report.used <= f64::from(units));
            assert_eq!(report.above_cap, n - k);
            changes += report.changes;
            for c in fine(&budget, n) {
                longest = longest.max(frame - last[c]);
                last[c] = frame;
            }
        }
        longest = last.iter().map(|l| 3000 - l).fold(longest, i32::max);
        // A round lasts n / k holds, each with its delay; a character with a thousandth of the
        // weight must wait ten times as long (10 cubed is 1000) to be equal.
        let round = (n as i32 / k as i32 + 1) * (12 + 2 * 8);
        let bound = if spread > 1.0 { 10 * round } else { round };
        assert!(longest <= bound, "{longest} frames, {bound} allowed");
        // Choices are held for a while: two changes per hold.
        assert!(changes <= 2 * k * 3000 / 12, "{changes} changes");
    }
}

#[test]
fn who_comes_late_has_not_waited() {
    let crowd = equals(2);
    let policy = BudgetPolicy {
        cap_px: 1.0,
        patience_frames: 4,
        hold_frames: 8,
        ..PLAIN
    };
    // Whichever of two equal characters appears late; both wait until the budget allows one of them.
    for (late, first) in [(0, 1), (1, 0)] {
        let (mut budget, ids) = crowd.budget(policy);
        budget.hide(late);
        for _ in 0..60 {
            assert_eq!(budget.solve(20.0).above_cap, 1);
        }
        let request = LodRequest {
            option_set: ids[0],
            weight: 1.0,
            pixels_per_metre: 100.0,
        };
        budget.request(late, request);
        for _ in 0..8 {
            assert_eq!(budget.solve(20.0).above_cap, 2);
        }
        budget.solve(120.0);
        assert_eq!(fine(&budget, 2), [first]);
    }
}

#[test]
fn hostile_numbers_behave() {
    let crowd = equals(3);
    let (mut budget, ids) = crowd.budget(BudgetPolicy::default());
    for units in [0.0, -5.0, f32::NAN, f32::NEG_INFINITY] {
        let report = budget.solve(units);
        assert_eq!((report.used, report.budget), (30.0, 0.0), "{units}");
    }
    assert_eq!(budget.solve(f32::INFINITY).used, 330.0);
    assert_eq!(budget.solve(f32::MAX).used, 330.0);
    for odd in [
        f32::NAN,
        f32::INFINITY,
        -1.0,
        f32::MAX,
        f32::MIN_POSITIVE,
        0.0,
    ] {
        let request = |weight, pixels_per_metre| LodRequest {
            option_set: ids[0],
            weight,
            pixels_per_metre,
        };
        budget.request(0, request(odd, 100.0));
        budget.request(1, request(1.0, odd));
        budget.request(2, request(odd, odd));
        for _ in 0..40 {
            let report = budget.solve(130.0);
            assert_eq!(report.used, 130.0);
            assert!(report.worst_px.is_finite() && report.mean_px.is_finite());
        }
    }
    for c in 0..3 {
        budget.hide(c);
        budget.hide(c);
    }
    let report = budget.solve(100.0);
    assert_eq!((report.visible, report.changes), (0, 3));
    assert_eq!(
        (report.used, report.demand, report.mean_px),
        (0.0, 0.0, 0.0)
    );
    let report = BudgetAllocator::new(0, BudgetPolicy::default()).solve(100.0);
    assert_eq!((report.visible, report.used), (0, 0.0));
}

#[test]
fn new_costs_move_everyone_and_keep_their_names() {
    let crowd = equals(4);
    let (mut budget, _) = crowd.budget(PLAIN);
    budget.solve(240.0);
    assert_eq!(fine(&budget, 4), [0, 1]);
    // The fine option costs half now, so all fit.
    budget.reprice(|_, option| [10.0, 55.0][option]);
    let report = budget.solve(240.0);
    assert_eq!((report.used, report.changes), (220.0, 2));
    // The fine option becomes the cheaper one: the hull is that one point, under its old index.
    budget.reprice(|_, option| [10.0, 5.0][option]);
    for plenty_or_not in [0.0, 1e6] {
        let report = budget.solve(plenty_or_not);
        assert_eq!((report.used, report.changes), (20.0, 0));
    }
    // An option with a NaN cost is never chosen.
    budget.reprice(|_, option| [10.0, f32::NAN][option]);
    assert_eq!(budget.solve(1e6).used, 40.0);
}

#[test]
fn the_same_costs_again_change_nothing_and_no_patience_forgets_who_waited() {
    let crowd = equals(10);
    let policy = BudgetPolicy {
        cap_px: 1.0,
        patience_frames: 4,
        hold_frames: 6,
        ..PLAIN
    };
    let ((mut plain, _), (mut renewed, _)) = (crowd.budget(policy), crowd.budget(policy));
    // The cheapest options and three upgrades, which go around.
    let mut served = vec![false; 10];
    for frame in 0..60 {
        match frame % 3 {
            0 => renewed.reprice(|_, option| [10.0, 110.0][option]),
            1 => renewed.set_policy(policy),
            _ => {}
        }
        plain.solve(400.0);
        renewed.solve(400.0);
        for (c, served) in served.iter_mut().enumerate() {
            assert_eq!(renewed.choice(c), plain.choice(c), "frame {frame}");
            *served |= plain.choice(c) == Some(1);
        }
    }
    assert_eq!(served, [true; 10]);
    let impatient = BudgetPolicy {
        patience_frames: 0,
        ..policy
    };
    plain.set_policy(impatient);
    for _ in 0..20 {
        plain.solve(400.0);
        assert_eq!(fine(&plain, 10), [0, 1, 2]);
    }
}

#[test]
fn a_frame_allocates_nothing() {
    let crowd = equals(1000);
    let (mut budget, ids) = crowd.budget(BudgetPolicy::default());
    let counted = allocation_counter::measure(|| {
        for frame in 0..50_u16 {
            for c in 0..1000 {
                let pixels_per_metre = 50.0 + f32::from(frame) * (c % 17) as f32;
                if (c + usize::from(frame)) % 13 == 0 {
                    budget.hide(c);
                } else {
                    budget.request(
                        c,
                        LodRequest {
                            option_set: ids[0],
                            weight: 1.0,
                            pixels_per_metre,
                        },
                    );
                }
            }
            if frame % 10 == 0 {
                budget.reprice(|_, option| [10.0, 110.0][option] + f32::from(frame));
            }
            budget.solve(1000.0 * f32::from(frame));
        }
    });
    assert_eq!(counted.count_total, 0);
}
