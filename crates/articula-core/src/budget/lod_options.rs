//! LOD option sets: the options of a kind of character on the lower convex hull of (cost, error).
//!
//! Source: `docs/methods/motion-lod.md` part 7; the hull is what remains of a multiple-choice
//! knapsack once dominated options are removed (Kellerer, Pferschy, Pisinger, *Knapsack Problems*,
//! 2004, 11.2). Errors are metres of skin, so one option set serves all characters that play the
//! same clip: a character's error is that of the set times its weight, and a factor preserves the
//! hull.

use crate::Mismatch;

/// Fixed-point parts of one unit of cost. Sums of integers are exact, so they neither drift from
/// frame to frame nor depend on the order of the characters.
const PARTS: f64 = 64.0;
/// Errors above this count as this, which is more than the size of any character.
const ERROR_CEILING_METRES: f32 = 1e6;
/// Maximum number of options of a set.
const MAX_OPTIONS: usize = 255;

/// Cost and error of a character at one level of detail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LodOption {
    /// Cost in the units of the budget, usually nanoseconds; counted in steps of 1/64, up to 67
    /// million.
    pub cost: f32,
    /// Distance of the skin from its true position, metres; infinite where nothing is shown.
    pub error_metres: f32,
}

/// Identifier of an option set of a [`BudgetAllocator`](super::BudgetAllocator).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LodOptionSetId(pub(super) u32);

/// An option on the lower hull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// Index among the options of the set.
    pub option: u8,
    /// Error, metres of skin.
    pub error_metres: f32,
    /// Cost in fixed point.
    pub(super) cost: u32,
}

/// Upgrade from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// Decrease of the error in metres per part of cost.
    pub(super) gain_per_cost: f32,
    /// Cost of the upgrade in fixed point.
    pub(super) cost: u32,
}

/// Options and their lower convex hull: cost rises, error falls, and the gain per cost does not
/// rise from step to step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LodOptionSet {
    lod_options: Vec<LodOption>,
    points: Vec<Point>,
    steps: Vec<Step>,
}

impl LodOptionSet {
    /// Finds the hull of some options.
    ///
    /// # Errors
    /// If there are no options or more than 255, a cost is negative or not finite, or an error is
    /// negative or NaN.
    pub(crate) fn new(lod_options: &[LodOption]) -> Result<Self, Mismatch> {
        if lod_options.is_empty() || lod_options.len() > MAX_OPTIONS {
            let what = format!(
                "{} LOD options, expected 1 to {MAX_OPTIONS}",
                lod_options.len()
            );
            return Err(Mismatch::new("lod_options", what));
        }
        let odd = |o: &LodOption| !(o.cost >= 0.0 && o.cost.is_finite() && o.error_metres >= 0.0);
        if let Some(i) = lod_options.iter().position(odd) {
            let what = format!(
                "{:?}: cost must be finite and at least 0, error_metres at least 0",
                lod_options[i]
            );
            return Err(Mismatch::new(format!("lod_options[{i}]"), what));
        }
        let mut option_set = Self {
            lod_options: lod_options.to_vec(),
            points: Vec::with_capacity(lod_options.len()),
            steps: Vec::with_capacity(lod_options.len()),
        };
        option_set.find_hull();
        Ok(option_set)
    }

    /// Options on the lower hull, the cheapest first; at least one.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Sets the cost of every option by its index and finds the hull again. NaN makes an option too
    /// expensive to be chosen, a negative cost makes it free. Does not allocate.
    pub(crate) fn reprice(&mut self, mut cost: impl FnMut(usize) -> f32) {
        for (i, lod_option) in self.lod_options.iter_mut().enumerate() {
            let new = cost(i);
            lod_option.cost = if new.is_nan() { f32::MAX } else { new.max(0.0) };
        }
        self.find_hull();
    }

    /// `steps()[i]` leads from point `i` to point `i + 1`.
    pub(super) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Monotone chain over the options by rising cost (O(k²) in their number: sets are small, and
    /// selection needs no second buffer).
    fn find_hull(&mut self) {
        self.points.clear();
        self.steps.clear();
        while let Some(point) = self.next_better() {
            // Drops points that lie above the line from the one before them to the new one.
            while let (Some(before), Some(last)) = (self.steps.last(), self.points.last()) {
                if step(last, &point).gain_per_cost <= before.gain_per_cost {
                    break;
                }
                self.points.pop();
                self.steps.pop();
            }
            if let Some(last) = self.points.last() {
                self.steps.push(step(last, &point));
            }
            self.points.push(point);
        }
    }

    /// The cheapest option with a smaller error than the last point: of equal cost the one with the
    /// least error, of equal options the first.
    fn next_better(&self) -> Option<Point> {
        let reached = self.points.last().map_or(f32::INFINITY, |p| p.error_metres);
        let points = self
            .lod_options
            .iter()
            .enumerate()
            .map(|(i, lod_option)| Point {
                option: i as u8,
                error_metres: lod_option.error_metres.min(ERROR_CEILING_METRES),
                cost: to_fixed(lod_option.cost).min(u64::from(u32::MAX)) as u32,
            });
        points.filter(|p| p.error_metres < reached).min_by(|a, b| {
            let by_cost = a.cost.cmp(&b.cost);
            by_cost.then(a.error_metres.total_cmp(&b.error_metres))
        })
    }
}

fn step(from: &Point, to: &Point) -> Step {
    let cost = to.cost - from.cost;
    let drop = f64::from(from.error_metres) - f64::from(to.error_metres);
    Step {
        gain_per_cost: (drop / f64::from(cost)) as f32,
        cost,
    }
}

/// Converts units to parts; NaN and negative values give 0, too large values saturate.
pub(super) fn to_fixed(units: f32) -> u64 {
    (f64::from(units) * PARTS).round() as u64
}

/// Converts parts to units.
pub(super) fn from_fixed(parts: u64) -> f64 {
    parts as f64 / PARTS
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn option_set(lod_options: &[(f32, f32)]) -> Result<LodOptionSet, Mismatch> {
        let lod_option = |&(cost, error_metres): &(f32, f32)| LodOption { cost, error_metres };
        LodOptionSet::new(&lod_options.iter().map(lod_option).collect::<Vec<_>>())
    }

    fn kept(option_set: &LodOptionSet) -> Vec<u8> {
        option_set.points().iter().map(|p| p.option).collect()
    }

    #[test]
    fn a_hull_by_hand() {
        // From (1, 10): to (2, 6) 4 a unit, to (3, 5) 1, to (5, 0) 2.5 a unit. So (3, 5) lies above
        // the line from (2, 6) to (5, 0); (4, 7) is worse than (2, 6) and more expensive; (1, 12)
        // is worse at the same cost; (6, 0) is more expensive at the same error.
        let lod_options = [
            (6.0, 0.0),
            (1.0, 12.0),
            (5.0, 0.0),
            (3.0, 5.0),
            (1.0, 10.0),
            (4.0, 7.0),
            (2.0, 6.0),
        ];
        let found = option_set(&lod_options).unwrap();
        assert_eq!(kept(&found), [4, 6, 2]);
        let gains: Vec<f32> = found
            .steps()
            .iter()
            .map(|s| s.gain_per_cost * 64.0)
            .collect();
        assert_eq!(gains, [4.0, 2.0]);
        assert_eq!(from_fixed(u64::from(found.points()[2].cost)), 5.0);
        // Points on the line stay: they make smaller upgrades.
        let line = option_set(&[(0.0, 3.0), (1.0, 2.0), (2.0, 1.0)]).unwrap();
        assert_eq!(kept(&line), [0, 1, 2]);
        // Of equal options the first.
        assert_eq!(kept(&option_set(&[(1.0, 1.0), (1.0, 1.0)]).unwrap()), [0]);
    }

    #[test]
    fn nothing_shown_is_an_offer_and_nonsense_is_none() {
        let hidden = option_set(&[(0.0, f32::INFINITY), (10.0, 0.1)]).unwrap();
        assert_eq!(kept(&hidden), [0, 1]);
        let refused: [&[(f32, f32)]; 5] = [
            &[],
            &[(f32::NAN, 0.0)],
            &[(f32::INFINITY, 0.0)],
            &[(1.0, 0.0), (-1.0, 0.0)],
            &[(1.0, f32::NAN)],
        ];
        for lod_options in refused {
            assert!(option_set(lod_options).is_err(), "{lod_options:?}");
        }
        assert!(option_set(&[(1.0, 1.0); 256]).is_err());
        assert!(option_set(&[(f32::MAX, 0.0), (f32::MAX, 1.0)]).is_ok());
    }

    proptest! {
        #[test]
        fn a_hull_is_convex_and_nothing_lies_below_it(
            lod_options in prop::collection::vec((0.0_f32..1000.0, 0.0_f32..2.0), 1..20),
        ) {
            let option_set = option_set(&lod_options).unwrap();
            let points = option_set.points();
            for pair in points.windows(2) {
                prop_assert!(pair[0].cost < pair[1].cost);
                prop_assert!(pair[0].error_metres > pair[1].error_metres);
            }
            for pair in option_set.steps().windows(2) {
                prop_assert!(pair[0].gain_per_cost >= pair[1].gain_per_cost);
            }
            // Below every line through two neighbours of the hull there is no option.
            let fixed = |cost| to_fixed(cost) as f64;
            for (from, step) in points.iter().zip(option_set.steps()) {
                for (cost, error) in &lod_options {
                    let along = fixed(*cost) - f64::from(from.cost);
                    let line = f64::from(from.error_metres)
                        - along * f64::from(step.gain_per_cost);
                    prop_assert!(f64::from(*error) >= line - 1e-5);
                }
            }
            // The ends: nothing is cheaper than the first, nothing better than the last.
            let (first, last) = (&points[0], &points[points.len() - 1]);
            for (cost, error) in &lod_options {
                prop_assert!(fixed(*cost) >= f64::from(first.cost));
                prop_assert!(*error >= last.error_metres);
            }
        }

        #[test]
        fn new_costs_give_the_hull_of_a_new_menu(
            lod_options in prop::collection::vec((0.0_f32..1000.0, 0.0_f32..2.0), 1..12),
            factors in prop::collection::vec(0.5_f32..2.0, 12),
        ) {
            let mut repriced = option_set(&lod_options).unwrap();
            repriced.reprice(|i| lod_options[i].0 * factors[i]);
            let new: Vec<(f32, f32)> = lod_options.iter().zip(&factors).map(|(o, f)| (o.0 * f, o.1)).collect();
            prop_assert_eq!(repriced, option_set(&new).unwrap());
        }
    }
}
