//! Range of an axis and the values at which it is labelled.

/// Spacing of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spacing {
    Linear,
    Logarithmic,
}

/// A range of values along a side of a plot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    step: f64,
    spacing: Spacing,
}

impl Axis {
    /// Smallest tidy range that contains the values; 0 to 1 (or 1 to 10) without any.
    pub(super) fn through(values: impl Iterator<Item = f64>, spacing: Spacing) -> Self {
        let (mut low, mut high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        if low > high {
            (low, high) = match spacing {
                Spacing::Linear => (0.0, 1.0),
                Spacing::Logarithmic => (1.0, 10.0),
            };
        }
        match spacing {
            Spacing::Linear => Self::linear(low, high),
            Spacing::Logarithmic => Self {
                // A small margin at both ends, so that no marker is clipped.
                low: low / 1.06,
                high: (high * 1.06).max(low / 1.06 * 1.2),
                step: 0.0,
                spacing,
            },
        }
    }

    fn linear(low: f64, high: f64) -> Self {
        let size = low.abs().max(high.abs());
        let high = if high - low <= 1e-9 * size || high == low {
            low + if size > 0.0 { 0.1 * size } else { 1.0 }
        } else {
            high
        };
        let step = tidy_step(high - low);
        Self {
            low: (low / step + 1e-9).floor() * step,
            high: (high / step - 1e-9).ceil() * step,
            step,
            spacing: Spacing::Linear,
        }
    }

    /// Position of a value between the ends, 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        match self.spacing {
            Spacing::Linear => (value - self.low) / (self.high - self.low),
            Spacing::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        }
    }

    /// Values of the lines of a grid.
    pub(super) fn grid_values(&self) -> Vec<f64> {
        match self.spacing {
            Spacing::Linear => self
                .ticks(std::iter::empty())
                .into_iter()
                .map(|t| t.0)
                .collect(),
            Spacing::Logarithmic => self.round_values(),
        }
    }

    /// Tidy values between the ends of a logarithmic axis: powers of ten, and 2 and 5 times these
    /// where there are few.
    fn round_values(&self) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor(), self.high.log10().ceil());
        let few = last - first <= 3.0;
        let times: &[f64] = if few { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let powers = (first as i32..=last as i32).map(|power| 10_f64.powi(power));
        let all = powers.flat_map(|power| times.iter().map(move |t| t * power));
        all.filter(|v| (self.low..=self.high).contains(v)).collect()
    }

    /// Labelled values with their labels: steps of 1, 2 or 5, or, on a logarithmic axis, as many of
    /// the `own` values as fit.
    pub(super) fn ticks(&self, own: impl Iterator<Item = f64>) -> Vec<(f64, String)> {
        if self.spacing == Spacing::Linear {
            let count = ((self.high - self.low) / self.step).round() as usize;
            let value = |i: usize| {
                let value = self.low + i as f64 * self.step;
                // Rounding leaves 1e-17 instead of zero.
                if value.abs() < 1e-9 * self.step {
                    0.0
                } else {
                    value
                }
            };
            return (0..=count.min(50))
                .map(|i| (value(i), self.label(value(i), 1.0)))
                .collect();
        }
        let mut own: Vec<f64> = own.collect();
        own.sort_by(f64::total_cmp);
        let mut ticks: Vec<(f64, String)> = Vec::new();
        for value in own {
            let has_room = ticks
                .last()
                .is_none_or(|(last, _)| self.share(value) - self.share(*last) > 0.055);
            if has_room {
                ticks.push((value, significant(value)));
            }
        }
        ticks
    }

    /// A value times `scale`, with as many digits as the steps need.
    pub(super) fn label(&self, value: f64, scale: f64) -> String {
        if self.spacing == Spacing::Logarithmic {
            return significant(value * scale);
        }
        let digits = (-(self.step * scale).log10().floor()).clamp(0.0, 9.0) as usize;
        let (value, step) = (value * scale, self.step * scale);
        if !(1e-6..1e6).contains(&step) {
            return format!("{value:e}");
        }
        format!("{value:.digits$}")
    }
}

/// Step of 1, 2 or 5 times a power of ten that divides a range into four to ten parts.
fn tidy_step(range: f64) -> f64 {
    let raw = range / 6.0;
    let power = 10f64.powi(raw.log10().floor() as i32);
    let step = match raw / power {
        r if r < 1.5 => 1.0,
        r if r < 3.5 => 2.0,
        r if r < 7.5 => 5.0,
        _ => 10.0,
    };
    step * power
}

/// At most three significant digits, no trailing zeros.
fn significant(value: f64) -> String {
    let before = value.abs().log10().floor() as i32;
    let digits = (2 - before).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64], spacing: Spacing) -> Vec<String> {
        let axis = Axis::through(values.iter().copied(), spacing);
        let ticks = axis.ticks(values.iter().copied());
        ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn linear_ticks_by_hand() {
        let expected = ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"];
        assert_eq!(labels(&[0.0, 0.97], Spacing::Linear), expected);
        assert_eq!(
            labels(&[0.0, 300.0], Spacing::Linear).last().unwrap(),
            "300"
        );
        assert_eq!(labels(&[-3.0, 2.0], Spacing::Linear)[3], "0");
        assert!(labels(&[5.0, 5.0], Spacing::Linear).len() > 2);
        assert_eq!(labels(&[], Spacing::Linear).first().unwrap(), "0.0");
    }

    #[test]
    fn logarithmic_ticks_are_the_measured_values() {
        let distances = [3.5, 5.65, 9.05, 16.0, 25.6];
        let expected = ["3.5", "5.65", "9.05", "16", "25.6"];
        assert_eq!(labels(&distances, Spacing::Logarithmic), expected);
        let axis = Axis::through([1.0, 100.0].into_iter(), Spacing::Logarithmic);
        assert!((axis.share(10.0) - 0.5).abs() < 1e-12);
        assert!(labels(&[1.0, 1.001], Spacing::Logarithmic).len() == 1);
    }

    #[test]
    fn round_values_of_a_logarithmic_axis() {
        let of = |low, high| {
            let axis = Axis::through([low, high].into_iter(), Spacing::Logarithmic);
            axis.round_values()
        };
        assert_eq!(of(0.05, 2000.0), [0.1, 1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(of(3.0, 30.0), [5.0, 10.0, 20.0]);
    }

    #[test]
    fn every_value_lies_between_the_ends() {
        for values in [[0.0, 1e-12], [-7.3, 1e9], [1e300, 1.1e300], [-2.0, -1.0]] {
            let axis = Axis::through(values.into_iter(), Spacing::Linear);
            for value in values {
                let share = axis.share(value);
                assert!((-1e-6..=1.0 + 1e-6).contains(&share), "{value}: {share}");
            }
            assert!(axis.ticks(std::iter::empty()).len() < 52);
        }
    }
}
