//! Selects which prefixes of the joint order become levels.
//!
//! A level is kept if its error is about twice that of the level before, so that it suits a more
//! distant view, and if it drops a significant share of the joints.

use super::JointLodOptions;
use super::order::Order;

/// Minimum share of the joints of the previous level that a level drops.
const MIN_STEP: f32 = 0.12;

/// Numbers of joints that near and far levels keep, finest first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct KeptCounts {
    /// Starts with all joints.
    pub(super) near: Vec<u16>,
    /// Empty if there are no far levels.
    pub(super) far: Vec<u16>,
}

/// A joint order and the minimum number of its joints that a level may keep.
pub(super) struct Choice<'a> {
    pub(super) order: &'a Order,
    pub(super) floor: usize,
}

/// Returns the smallest joint counts within a series of doubling tolerances: of the near order up
/// to `far_from_metres`, of the far order, if given, beyond.
pub(super) fn levels(
    near: &Choice<'_>,
    far: Option<&Choice<'_>>,
    opts: &JointLodOptions,
) -> KeptCounts {
    let all = near.order.joints.len();
    let mut kept = vec![(all, false)];
    let mut tolerance = opts.first_metres.max(1e-6);
    // Beyond a kilometre there is nothing left to drop.
    while tolerance < 1e3 {
        let far = far.filter(|_| tolerance >= opts.far_from_metres);
        let choice = far.unwrap_or(near);
        let floor = choice.floor.max(opts.min_joints).clamp(1, all);
        let within = |n: &usize| choice.order.errors_metres[*n] <= tolerance;
        let fewest = (floor..=all).find(within).unwrap_or(all);
        let (last, _) = kept[kept.len() - 1];
        let least = ((last as f32 * MIN_STEP).ceil() as usize).max(1);
        if fewest + least <= last {
            kept.push((fewest, far.is_some()));
        }
        tolerance *= 2.0;
    }
    // Too many levels: drop the inner level whose neighbours have the most similar counts.
    while kept.len() > opts.max_levels.max(1) {
        let ratio = |i: usize| kept[i + 1].0 as f32 / kept[i - 1].0 as f32;
        let inner = 1..kept.len() - 1;
        match inner.max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)).then(b.cmp(a))) {
            Some(at) => kept.remove(at),
            None => kept.remove(kept.len() - 1),
        };
    }
    let of = |is_far: bool| {
        let kept = kept.iter().filter(|k| k.1 == is_far);
        kept.map(|k| k.0 as u16).collect()
    };
    KeptCounts {
        near: of(false),
        far: of(true),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(errors: &[f32]) -> Order {
        Order {
            joints: (0..errors.len() as u16 - 1).collect(),
            errors_metres: errors.to_vec(),
        }
    }

    fn levels(order: &Order, floor: usize, opts: &JointLodOptions) -> Vec<u16> {
        super::levels(&Choice { order, floor }, None, opts).near
    }

    #[test]
    fn far_levels_take_over_from_a_tolerance_on() {
        let mm = |errors: [f32; 7]| order(&errors.map(|e| e / 1000.0));
        let (near, far) = (
            mm([99.0, 90.0, 80.0, 60.0, 30.0, 0.9, 0.0]),
            mm([99.0, 40.0, 7.0, 3.0, 2.0, 1.0, 0.0]),
        );
        let opts = JointLodOptions {
            first_metres: 1e-3,
            far_from_metres: 4e-3,
            min_joints: 1,
            ..JointLodOptions::default()
        };
        let choice = |order| Choice { order, floor: 1 };
        // Near, 1 mm: 5. Far, 4 mm: 3, 8 mm: 2, 64 mm: 1.
        let kept = super::levels(&choice(&near), Some(&choice(&far)), &opts);
        assert_eq!((kept.near, kept.far), (vec![6, 5], vec![3, 2, 1]));
    }

    #[test]
    fn levels_follow_doubling_tolerances_by_hand() {
        // Kept 0 to 10; tolerances 1, 2, 4, 8 … mm.
        let mm = [99.0, 50.0, 40.0, 30.0, 9.0, 8.0, 3.0, 2.5, 0.9, 0.5, 0.0];
        let order = order(&mm.map(|e| e / 1000.0));
        let opts = JointLodOptions {
            first_metres: 1e-3,
            min_joints: 2,
            ..JointLodOptions::default()
        };
        // 1 mm: 8. 2 mm: 8. 4 mm: 6. 8 mm: 5. 16 mm: 4. 32 mm: 3. 64 mm: 2, the floor.
        assert_eq!(levels(&order, 0, &opts), [10, 8, 6, 5, 4, 3, 2]);
        assert_eq!(levels(&order, 5, &opts), [10, 8, 6, 5], "a floor");
        let few = JointLodOptions {
            max_levels: 3,
            ..opts
        };
        let some = levels(&order, 0, &few);
        assert_eq!((some.len(), some[0], some[2]), (3, 10, 2), "both ends stay");
        let one = JointLodOptions {
            max_levels: 1,
            ..opts
        };
        assert_eq!(levels(&order, 0, &one), [10]);
    }

    #[test]
    fn nothing_to_drop_leaves_one_level() {
        let opts = JointLodOptions::default();
        assert_eq!(levels(&order(&[0.0, 0.0]), 0, &opts), [1]);
        // Without motion everything above the floor goes at once.
        assert_eq!(
            levels(&order(&[0.0; 31]), 0, &opts),
            [30, opts.min_joints as u16]
        );
        let endless = [f32::INFINITY; 31];
        assert_eq!(levels(&order(&endless), 0, &opts), [30]);
    }
}
