//! A bandwidth that changes over time, as a slider that is moved.

use std::str::FromStr;

/// Bandwidths from times on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slider(Vec<(f64, Option<f64>)>);

impl Slider {
    /// The bandwidth at a time in bits per second; `None` without a bound.
    pub(super) fn at(&self, secs: f64) -> Option<f64> {
        let past = self.0.iter().take_while(|(from, _)| *from <= secs);
        past.last().and_then(|(_, bps)| *bps)
    }
}

impl FromStr for Slider {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = |word: &str| format!("{word}: expected SECONDS:KBPS or SECONDS:full");
        let mut steps: Vec<(f64, Option<f64>)> = Vec::new();
        for word in text.split(',') {
            let (secs, kbps) = word.split_once(':').ok_or_else(|| expected(word))?;
            let secs: f64 = secs.trim().parse().map_err(|_| expected(word))?;
            let bps = match kbps.trim() {
                "full" => None,
                kbps => Some(1e3 * kbps.parse::<f64>().map_err(|_| expected(word))?),
            };
            let is_positive = |bps: f64| bps > 0.0 && bps.is_finite();
            let rises = steps.last().is_none_or(|(before, _)| *before < secs);
            if !(secs >= 0.0 && secs.is_finite() && bps.is_none_or(is_positive)) {
                return Err(expected(word));
            }
            if !rises {
                return Err(format!("{word}: times must rise"));
            }
            steps.push((secs, bps));
        }
        Ok(Self(steps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slider_is_where_it_was_last_moved() {
        let slider: Slider = "1:full,2.5:64, 4:512".parse().unwrap();
        let at = |secs| slider.at(secs);
        assert_eq!((at(0.0), at(1.0), at(2.5)), (None, None, Some(64e3)));
        assert_eq!((at(3.9), at(100.0)), (Some(64e3), Some(512e3)));
        for wrong in [
            "", "1", "1:", "x:1", "1:-5", "1:0", "2:1,1:2", "nan:1", "0:inf",
        ] {
            assert!(wrong.parse::<Slider>().is_err(), "{wrong}");
        }
    }
}
