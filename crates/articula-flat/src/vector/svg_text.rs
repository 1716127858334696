//! Titles and times in animated SVG.
//!
//! Source: the grammars of SMIL 3.0 clock values and key times, XML 1.0 characters.

use crate::markup::push_escaped;

/// Appends `<title>` with an escaped name; nothing for an empty one.
pub(super) fn push_title(out: &mut String, name: &str) {
    if name.is_empty() {
        return;
    }
    out.push_str("<title>");
    push_escaped(out, name);
    out.push_str("</title>");
}

/// Converts half frames to key times, and holds the clip's duration.
#[derive(Debug, Clone)]
pub(super) struct Clock {
    end: u32,
    digits: usize,
    dur: String,
}

impl Clock {
    pub(super) fn new(frames: u32, fps: f32) -> Self {
        let end = 2 * frames.saturating_sub(1);
        // Adjacent half frames must have different times.
        let digits = (3..).find(|d| 10u64.pow(*d) >= u64::from(end));
        let secs = f64::from(end) / 2.0 / f64::from(fps);
        Self {
            end,
            digits: digits.unwrap_or(10) as usize,
            dur: seconds(secs),
        }
    }

    /// The last frame, in half frames.
    pub(super) fn end(&self) -> u32 {
        self.end
    }

    /// Duration of the clip for `dur`; seconds need no unit.
    pub(super) fn dur(&self) -> &str {
        &self.dur
    }

    /// A key time: 0 to 1 without leading and trailing zeros.
    pub(super) fn push_time(&self, out: &mut String, half: u32) {
        if half == 0 || self.end == 0 {
            out.push('0');
        } else if half >= self.end {
            out.push('1');
        } else {
            let share = f64::from(half) / f64::from(self.end);
            let text = format!("{share:.*}", self.digits);
            out.push_str(text.trim_start_matches('0').trim_end_matches('0'));
        }
    }
}

/// Seconds to six significant digits.
fn seconds(secs: f64) -> String {
    let whole = secs.max(1e-12).log10().floor();
    let decimals = (5.0 - whole).clamp(0.0, 15.0) as usize;
    let text = format!("{secs:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    // Unlike a key time, a clock value needs a digit before its point.
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_safe() {
        let mut out = String::new();
        push_title(&mut out, "a<b>&\"c\u{1}\r");
        assert_eq!(out, "<title>a&lt;b&gt;&amp;&quot;c\u{fffd}&#13;</title>");
        out.clear();
        push_title(&mut out, "");
        assert!(out.is_empty());
    }

    #[test]
    fn times_stay_apart_and_rise() {
        for frames in [2u32, 3, 26, 126, 500, 502, 6000, 20_000] {
            let clock = Clock::new(frames, 25.0);
            let mut last = -1.0;
            for half in 0..=clock.end() {
                let mut text = String::new();
                clock.push_time(&mut text, half);
                let time: f64 = text.parse().unwrap();
                assert!(time > last, "{text} at {half} of {frames} frames");
                last = time;
            }
            assert_eq!(last, 1.0);
        }
        let mut text = String::new();
        Clock::new(126, 25.0).push_time(&mut text, 50);
        assert_eq!(text, ".2");
    }

    #[test]
    fn lengths_are_short() {
        let dur = |frames, fps| Clock::new(frames, fps).dur().to_owned();
        assert_eq!(dur(125, 25.0), "4.96");
        assert_eq!(dur(126, 25.0), "5");
        assert_eq!(dur(251, 25.0), "10");
        assert_eq!(dur(11, 25.0), "0.4");
        assert_eq!(dur(100, 29.97), "3.3033");
        assert_eq!(dur(20_000, 1.0), "19999");
    }
}
