//! Morph targets that show one parameter each, over a part of its range: a face animation table as
//! piecewise linear morph targets.

use articula_core::fap_table::{LOW_FAPS, TABLE};
use std::fmt;

/// The part of a parameter's range over which a morph target goes from weight 0 to weight 1.
///
/// Its name is that of the morph target: `fap19_270_540` shows what FAP 19 adds between 270 and 540
/// units. Intervals of one parameter are on one side of 0 each and follow each other; beyond the
/// outermost ends they go on. A parameter with a single interval that starts at 0 is linear on both
/// sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FapInterval {
    /// Number of the parameter, 3 to 68.
    pub fap: usize,
    /// Value at which the weight is 0: the end nearer to 0.
    pub from: i32,
    /// Value at which the weight is 1.
    pub to: i32,
}

impl FapInterval {
    /// Reads the name of a morph target; `None` for any other name, and for intervals that are empty
    /// or lie on both sides of 0.
    pub fn parse(name: &str) -> Option<Self> {
        let mut words = name.strip_prefix("fap")?.split('_');
        let mut next = || words.next().filter(|w| !w.starts_with('+'));
        let fap: usize = next()?.parse().ok()?;
        let (from, to): (i32, i32) = (next()?.parse().ok()?, next()?.parse().ok()?);
        let is_outward = from.signum() != -to.signum()
            && from.unsigned_abs() < to.unsigned_abs()
            && LOW_FAPS.contains(&fap)
            && words.next().is_none();
        is_outward.then_some(Self { fap, from, to })
    }

    /// Returns the weight for a value, among all intervals of the same parameter.
    pub fn weight(&self, value: f32, of_fap: &[Self]) -> f32 {
        let t = (value - self.from as f32) / (self.to - self.from) as f32;
        let is_two_sided = TABLE[self.fap - 1].action.is_some_and(|a| a.two_sided);
        let goes_on = |other: &Self| other.from == self.to;
        let is_linear = of_fap.len() == 1 && self.from == 0 && is_two_sided;
        let least = if is_linear { f32::NEG_INFINITY } else { 0.0 };
        let most = if of_fap.iter().any(goes_on) {
            1.0
        } else {
            f32::INFINITY
        };
        t.clamp(least, most)
    }
}

impl fmt::Display for FapInterval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fap{}_{}_{}", self.fap, self.from, self.to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names() {
        let lid = FapInterval {
            fap: 19,
            from: 270,
            to: 540,
        };
        assert_eq!(lid.to_string(), "fap19_270_540");
        assert_eq!(FapInterval::parse("fap19_270_540"), Some(lid));
        let opened = FapInterval {
            fap: 19,
            from: 0,
            to: -350,
        };
        assert_eq!(FapInterval::parse(&opened.to_string()), Some(opened));
        for name in [
            "",
            "fap",
            "fap19",
            "fap19_0",
            "fap19_0_0",
            "fap19_5_5",
            "fap19_540_270",
            "fap19_-5_5",
            "fap2_0_5",
            "fap69_0_5",
            "fap19_0_5_6",
            "fap19_+0_5",
            "FAP19_0_5",
            "fap19_0_99999999999",
        ] {
            assert_eq!(FapInterval::parse(name), None, "{name}");
        }
    }

    #[test]
    fn a_single_interval_is_linear_where_the_parameter_has_two_sides() {
        let lip = [FapInterval {
            fap: 4,
            from: 0,
            to: 200,
        }];
        assert_eq!(
            [-100.0, 0.0, 50.0, 400.0].map(|v| lip[0].weight(v, &lip)),
            [-0.5, 0.0, 0.25, 2.0]
        );
        // The jaw has one side.
        let jaw = [FapInterval {
            fap: 3,
            from: 0,
            to: 200,
        }];
        assert_eq!(jaw[0].weight(-100.0, &jaw), 0.0);
    }

    proptest! {
        /// Intervals of a lid: together they add up to the polygon through their ends.
        #[test]
        fn intervals_interpolate(value in -1500.0..2500.0_f32) {
            let ends = [(0, 300), (300, 700), (700, 1080), (0, -500)];
            let lid = ends.map(|(from, to)| FapInterval { fap: 19, from, to });
            // A displacement that is some function of the value, given at the ends.
            let at = |v: i32| f64::from(v) * f64::from(v + 4000) / 1e4;
            let sum: f64 = lid.iter().map(|i| f64::from(i.weight(value, &lid)) * (at(i.to) - at(i.from))).sum();
            let v = f64::from(value);
            let line = |a: i32, b: i32| at(a) + (v - f64::from(a)) / f64::from(b - a) * (at(b) - at(a));
            let expected = match value {
                v if v < 0.0 => line(0, -500),
                v if v < 300.0 => line(0, 300),
                v if v < 700.0 => line(300, 700),
                _ => line(700, 1080),
            };
            prop_assert!((sum - expected).abs() < 1e-3 * expected.abs().max(1.0), "{sum}, not {expected}");
        }
    }
}
