//! Attention: intervals of a clip that matter more than usual, and how they and a character's
//! importance scale the tolerance.
//!
//! Source: `docs/methods/motion-lod.md` 4.3 (`m`, the multiplier of the tolerance) and 4.6
//! (contacts). Made ahead of time; its factor scales the tolerance of a joint or a level.

use crate::Mismatch;
use crate::sample::Wrap;

/// Minimum multiplier of a tolerance.
pub(crate) const MIN_MULTIPLIER: f32 = 1.0 / 64.0;

/// Maximum multiplier of a tolerance, so that a character of no importance still moves like a body.
pub(crate) const GREATEST_MULTIPLIER: f32 = 64.0;

/// A time interval of a clip with a factor on the error tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttentionInterval {
    /// Start of the interval in seconds of the clip.
    pub start_secs: f32,
    /// End of the interval in seconds of the clip, included.
    pub end_secs: f32,
    /// Multiplier of the tolerance: below 1 where errors are noticed more (0.25 for a standing
    /// foot, perhaps 0.5 for a talking character), above 1 where less.
    pub factor: f32,
}

/// Factor on the error tolerance over the time of a clip, piecewise constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Attention {
    duration_secs: f64,
    /// Times at which the factor changes, rising, and the factor from there on; the first applies
    /// from the start.
    starts_secs: Vec<f32>,
    factors: Vec<f32>,
}

impl Attention {
    /// Combines intervals of a clip: the smallest factor counts where some overlap, and 1 where
    /// there is none. Parts beyond the clip have no effect.
    ///
    /// # Errors
    /// A [`Mismatch`] if the duration is negative or not finite, an interval is not finite or ends
    /// before it starts, or a factor is not positive and finite.
    pub fn new(duration_secs: f32, intervals: &[AttentionInterval]) -> Result<Self, Mismatch> {
        if !(duration_secs.is_finite() && duration_secs >= 0.0) {
            let what = format!("must be finite and at least 0, found {duration_secs}");
            return Err(Mismatch::new("duration_secs", what));
        }
        for (i, interval) in intervals.iter().enumerate() {
            let (start, end) = (interval.start_secs, interval.end_secs);
            if !(start.is_finite() && end.is_finite() && start <= end) {
                let what = format!(
                    "from {start} to {end} s; both times must be finite, and the start not after \
                     the end"
                );
                return Err(Mismatch::new(format!("intervals[{i}]"), what));
            }
            if !(interval.factor > 0.0 && interval.factor.is_finite()) {
                let what = format!("{} is not positive and finite", interval.factor);
                return Err(Mismatch::new(format!("intervals[{i}].factor"), what));
            }
        }
        let mut starts_secs: Vec<f32> = intervals
            .iter()
            // An interval includes its end.
            .flat_map(|i| [i.start_secs, i.end_secs.next_up()])
            .chain([f32::NEG_INFINITY])
            .collect();
        starts_secs.sort_by(f32::total_cmp);
        starts_secs.dedup();
        let factor = |at: &f32| {
            intervals
                .iter()
                .filter(|i| i.start_secs <= *at && *at <= i.end_secs)
                .map(|i| i.factor)
                .reduce(f32::min)
                .unwrap_or(1.0)
        };
        Ok(Self {
            duration_secs: f64::from(duration_secs),
            factors: starts_secs.iter().map(factor).collect(),
            starts_secs,
        })
    }

    /// Returns the factor at a playback time, which wraps as that of the clip does; a time that is
    /// not finite counts as 0. O(log of the number of intervals); does not allocate.
    pub fn at(&self, time_secs: f64, wrap: Wrap) -> f32 {
        let time = if time_secs.is_finite() {
            time_secs
        } else {
            0.0
        };
        let time = match wrap {
            Wrap::Loop if self.duration_secs > 0.0 => time.rem_euclid(self.duration_secs),
            _ => time.clamp(0.0, self.duration_secs),
        };
        let time = time as f32;
        let after = self.starts_secs.partition_point(|start| *start <= time);
        // The first entry starts before every time.
        self.factors[after.max(1) - 1]
    }
}

/// Returns the multiplier `m` of a tolerance, from the factor of the clip and the importance of the
/// character: 1 is neutral, 2 halves the tolerance.
///
/// Stays between [`MIN_MULTIPLIER`] and [`GREATEST_MULTIPLIER`]. Importance 0 and below gives the
/// maximum, infinite importance the minimum; NaN counts as 1.
pub(crate) fn multiplier(factor: f32, importance: f32) -> f32 {
    let or_one = |v: f32| if v.is_nan() { 1.0 } else { v };
    let m = or_one(factor).max(0.0) / or_one(importance).max(0.0);
    // 0 / 0 and infinity / infinity count as 1.
    or_one(m).clamp(MIN_MULTIPLIER, GREATEST_MULTIPLIER)
}

/// Returns the tolerance in metres at a joint: `epsilon_px * attention / pixels_per_metre`.
///
/// `attention` is the multiplier: below 1 where errors are noticed more (contacts, faces), above 1
/// where less; 1 is neutral.
pub(crate) fn tolerance_metres(epsilon_px: f32, attention: f32, pixels_per_metre: f32) -> f32 {
    epsilon_px * attention / pixels_per_metre.max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn interval(start_secs: f32, end_secs: f32, factor: f32) -> AttentionInterval {
        AttentionInterval {
            start_secs,
            end_secs,
            factor,
        }
    }

    #[test]
    fn validity_table() {
        let at = |duration, i| Attention::new(duration, &[i]).unwrap_err().at;
        let good = interval(0.0, 1.0, 0.5);
        assert_eq!(at(f32::NAN, good), "duration_secs");
        assert_eq!(at(-1.0, good), "duration_secs");
        assert_eq!(at(1.0, interval(2.0, 1.0, 0.5)), "intervals[0]");
        assert_eq!(at(1.0, interval(f32::NAN, 1.0, 0.5)), "intervals[0]");
        for factor in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(at(1.0, interval(0.0, 1.0, factor)), "intervals[0].factor");
        }
        assert!(Attention::new(0.0, &[]).is_ok());
    }

    #[test]
    fn a_walk_by_hand() {
        // Two steps that overlap, and speech meanwhile.
        let steps = [
            interval(0.0, 0.6, 0.25),
            interval(0.5, 1.0, 0.25),
            interval(0.4, 1.5, 0.5),
            interval(1.8, 1.9, 3.0),
        ];
        let walk = Attention::new(2.0, &steps).unwrap();
        for (secs, factor) in [
            (0.0, 0.25),
            (0.55, 0.25),
            (1.0, 0.25),
            (1.01, 0.5),
            (1.5, 0.5),
            (1.6, 1.0),
            (1.85, 3.0),
            (1.95, 1.0),
        ] {
            assert_eq!(walk.at(secs, Wrap::Clamp), factor, "{secs} s");
            assert_eq!(walk.at(secs + 40.0, Wrap::Loop), factor, "{secs} s");
        }
        assert_eq!(walk.at(-9.0, Wrap::Clamp), 0.25);
        assert_eq!(walk.at(9.0, Wrap::Clamp), 1.0);
        assert_eq!(walk.at(-0.15, Wrap::Loop), 3.0);
        assert_eq!(walk.at(f64::NAN, Wrap::Loop), 0.25);
        let pose = Attention::new(0.0, &[]).unwrap();
        assert_eq!(pose.at(5.0, Wrap::Loop), 1.0);
    }

    #[test]
    fn importance_by_hand() {
        assert_eq!(multiplier(1.0, 1.0), 1.0);
        assert_eq!(multiplier(0.5, 2.0), 0.25);
        assert_eq!(multiplier(1.0, 0.0), GREATEST_MULTIPLIER);
        assert_eq!(multiplier(1.0, -3.0), GREATEST_MULTIPLIER);
        assert_eq!(multiplier(1.0, f32::INFINITY), MIN_MULTIPLIER);
        assert_eq!(multiplier(1.0, f32::NAN), 1.0);
        assert_eq!(multiplier(f32::NAN, 2.0), 0.5);
        assert_eq!(multiplier(0.0, 0.0), 1.0);
        // A standing character, twice as important: a pixel at 100 px/m tolerates 1.25 mm.
        let metres = tolerance_metres(1.0, multiplier(0.25, 2.0), 100.0);
        assert!((metres - 1.25e-3).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn any_two_numbers_give_a_multiplier(factor in any::<f32>(), importance in any::<f32>()) {
            let m = multiplier(factor, importance);
            prop_assert!((MIN_MULTIPLIER..=GREATEST_MULTIPLIER).contains(&m));
        }

        #[test]
        fn agrees_with_looking_through_all_intervals(
            intervals in prop::collection::vec((0.0f32..5.0, 0.0f32..3.0, 0.1f32..4.0), 0..8),
            secs in 0.0f32..5.0,
        ) {
            let intervals: Vec<AttentionInterval> = intervals
                .iter()
                .map(|(start, length, factor)| interval(*start, start + length, *factor))
                .collect();
            let attention = Attention::new(5.0, &intervals).unwrap();
            let plain = intervals
                .iter()
                .filter(|i| i.start_secs <= secs && secs <= i.end_secs)
                .map(|i| i.factor)
                .reduce(f32::min);
            let found = attention.at(f64::from(secs), Wrap::Clamp);
            prop_assert_eq!(found, plain.unwrap_or(1.0));
        }
    }

    #[test]
    fn tolerance_by_hand() {
        // One pixel at 100 px/m is a centimetre; half the attention halves it.
        assert!((tolerance_metres(1.0, 1.0, 100.0) - 0.01).abs() < 1e-9);
        assert!((tolerance_metres(1.0, 0.5, 100.0) - 0.005).abs() < 1e-9);
    }
}
