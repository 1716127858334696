//! Changes of level over time: when to fall, when to rise, and when to wait.
//!
//! State machines on the caller's clock. Source of the thresholds: players of video (hls.js keeps a
//! rate up to 0.95 of the estimate and takes a higher one up to 0.7); `docs/methods/adaptation.md`
//! part 5. Layers are counted: 1 is the base alone.

use articula_core::Libm;

/// Thresholds of a [`LayerSwitch`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwitchRule {
    /// A number of layers is kept while their rate is within this share of the estimate.
    pub stay: f64,
    /// A larger number is taken if its rate is within this share.
    pub rise: f64,
    /// The share must suffice for this long before a rise, seconds.
    pub hold_secs: f64,
    /// Least time between two rises, seconds.
    pub rise_gap_secs: f64,
}

impl Default for SwitchRule {
    /// 0.95, 0.7, 0.5 s, 2 s.
    fn default() -> Self {
        Self {
            stay: 0.95,
            rise: 0.7,
            hold_secs: 0.5,
            rise_gap_secs: 2.0,
        }
    }
}

/// Number of layers that the bandwidth carries, with hysteresis: a fall at once, a rise after a
/// while.
///
/// ```
/// use articula_stream::decide::{LayerSwitch, SwitchRule};
///
/// let rates = [20e3, 60e3, 150e3]; // of one, two and three layers, bits per second
/// let mut switch = LayerSwitch::new(SwitchRule::default());
/// assert_eq!(switch.update(0.0, &rates, 100e3), 1);
/// assert_eq!(switch.update(0.6, &rates, 100e3), 2);
/// assert_eq!(switch.update(0.7, &rates, 50e3), 1);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LayerSwitch {
    rule: SwitchRule,
    layers: usize,
    /// Time since when a rise would be allowed.
    able_since: Option<f64>,
    last_rise: f64,
}

impl LayerSwitch {
    /// Starts with the base alone.
    pub fn new(rule: SwitchRule) -> Self {
        Self {
            rule,
            layers: 1,
            able_since: None,
            last_rise: f64::NEG_INFINITY,
        }
    }

    /// The number of layers at the last update.
    pub fn layers(&self) -> usize {
        self.layers
    }

    /// Returns the number of layers to get now, 1 to the number of rates (1 if there are none).
    ///
    /// `rates` are those of one layer, of two and so on together, bits per second; `estimate` is the
    /// bandwidth. NaN as an estimate counts as 0.
    pub fn update(&mut self, now_secs: f64, rates: &[f64], estimate: f64) -> usize {
        self.update_buffered(now_secs, rates, estimate, 0.0)
    }

    /// The same with a buffer: the margin of a rise is a precaution that a full buffer makes
    /// needless. `fill`, 0 to 1, moves the share for a rise to that for staying.
    pub fn update_buffered(
        &mut self,
        now_secs: f64,
        rates: &[f64],
        estimate: f64,
        fill: f64,
    ) -> usize {
        self.layers = self.layers.clamp(1, rates.len().max(1));
        let within = |share: f64| {
            let fits = |rate: &&f64| **rate <= share * estimate;
            rates.iter().take_while(fits).count().max(1)
        };
        let kept = within(self.rule.stay);
        if kept < self.layers {
            self.layers = kept;
            self.able_since = None;
            return self.layers;
        }
        let fill = if fill > 0.0 { fill.min(1.0) } else { 0.0 };
        let target = within(self.rule.rise + fill * (self.rule.stay - self.rule.rise));
        if target <= self.layers {
            self.able_since = None;
            return self.layers;
        }
        let since = *self.able_since.get_or_insert(now_secs);
        let held = now_secs - since >= self.rule.hold_secs;
        if held && now_secs - self.last_rise >= self.rule.rise_gap_secs {
            self.layers = target;
            self.last_rise = now_secs;
            self.able_since = None;
        }
        self.layers
    }
}

/// Number of layers that the device can show, by measured frame times: fewer while a frame takes
/// longer than the budget, more after it took less than 70 % of it for 2 s.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTimeSwitch {
    budget_ns: f64,
    most: usize,
    layers: usize,
    mean_ns: Option<f64>,
    last_secs: f64,
    last_fall: f64,
    low_since: Option<f64>,
}

impl FrameTimeSwitch {
    /// Half-life of the mean frame time, seconds.
    const HALF_LIFE_SECS: f64 = 0.25;
    /// Time after a fall in which frames say nothing: they still are of the old number of layers.
    const SETTLE_SECS: f64 = 1.0;
    /// Share of the budget below which there is room.
    const ROOM: f64 = 0.7;
    /// Time for which there must be room, seconds.
    const RISE_SECS: f64 = 2.0;

    /// Starts with all layers of `most`.
    pub fn new(budget_ns: f64, most: usize) -> Self {
        Self {
            budget_ns,
            most: most.max(1),
            layers: most.max(1),
            mean_ns: None,
            last_secs: 0.0,
            last_fall: f64::NEG_INFINITY,
            low_since: None,
        }
    }

    /// Adds the time that a frame took and returns the number of layers that are allowed, at least 1.
    /// A time that is no number is left out.
    pub fn update(&mut self, now_secs: f64, frame_ns: f64) -> usize {
        if !frame_ns.is_finite() || now_secs - self.last_fall < Self::SETTLE_SECS {
            return self.layers;
        }
        let old = self.mean_ns.unwrap_or(frame_ns);
        let kept = 0.5_f64.libm_powf((now_secs - self.last_secs).max(0.0) / Self::HALF_LIFE_SECS);
        let mean = frame_ns + kept * (old - frame_ns);
        (self.mean_ns, self.last_secs) = (Some(mean), now_secs);
        if mean > self.budget_ns {
            self.low_since = None;
            if self.layers > 1 {
                self.layers -= 1;
                self.last_fall = now_secs;
                self.mean_ns = None;
            }
        } else if mean >= Self::ROOM * self.budget_ns || self.layers == self.most {
            self.low_since = None;
        } else {
            let since = *self.low_since.get_or_insert(now_secs);
            if now_secs - since >= Self::RISE_SECS {
                self.layers += 1;
                self.low_since = None;
            }
        }
        self.layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES: [f64; 4] = [20e3, 40e3, 80e3, 160e3];

    #[test]
    fn falls_at_once_and_rises_after_a_while() {
        let mut switch = LayerSwitch::new(SwitchRule::default());
        let mut at = |secs: f64, estimate: f64| switch.update(secs, &RATES, estimate);
        assert_eq!(at(0.0, 1e6), 1);
        assert_eq!(at(0.4, 1e6), 1, "not yet held");
        assert_eq!(
            at(0.5, 120e3),
            3,
            "84 kbit/s, 0.7 of the estimate, carry 80"
        );
        assert_eq!(at(0.6, 1e6), 3);
        assert_eq!(at(2.4, 1e6), 3, "within 2 s of the last rise");
        assert_eq!(at(2.5, 1e6), 4);
        assert_eq!(at(2.6, 170e3), 4, "0.95 of it suffice to stay");
        assert_eq!(at(2.7, 168e3), 3);
        assert_eq!(at(2.8, 0.0), 1, "the base stays, whatever comes");
        assert_eq!(at(2.9, f64::NAN), 1);
        assert_eq!(switch.update(9.0, &[], 1e6), 1);
    }

    #[test]
    fn an_estimate_between_the_thresholds_changes_nothing() {
        let mut switch = LayerSwitch::new(SwitchRule::default());
        switch.update(0.0, &RATES, 125e3);
        assert_eq!(switch.update(1.0, &RATES, 125e3), 3);
        // 80 stays down to 84.3; 160 is taken from 228.6 on.
        for i in 0..400_i32 {
            let estimate = if i % 2 == 0 { 85e3 } else { 228e3 };
            assert_eq!(
                switch.update(1.0 + f64::from(i) / 10.0, &RATES, estimate),
                3
            );
        }
    }

    #[test]
    fn frames_that_take_too_long_cost_layers_and_room_gives_them_back() {
        let mut frames = FrameTimeSwitch::new(1e6, 4);
        let mut now = 0.0;
        let mut run = |secs: f64, frame_ns: f64| {
            let mut layers = 0;
            for _ in 0..(secs * 60.0) as usize {
                now += 1.0 / 60.0;
                layers = frames.update(now, frame_ns);
            }
            layers
        };
        assert_eq!(run(3.0, 0.9e6), 4);
        assert_eq!(run(0.4, 2e6), 3, "within half a second");
        assert_eq!(run(3.0, 0.9e6), 3, "between 70 and 100 % nothing changes");
        assert_eq!(run(1.9, 0.5e6), 3);
        assert_eq!(run(0.5, 0.5e6), 4);
        assert_eq!(run(9.0, 2e6), 1, "never below the base");
        assert_eq!(run(9.0, f64::NAN), 1);
    }
}
