//! Policies on versions of which each is coded alone, as in streaming of video.
//!
//! Sources: hls.js (rate), BOLA (Spiteri, Urgaonkar, Sitaraman, *BOLA: near-optimal bitrate adaptation
//! for online videos*, 2016, the basic form), dash.js (a download that takes longer than 1.8 segments is
//! given up).

use super::view::{Action, Delivery, PlayerView, Policy, Request};
use crate::decide::switching::{LayerSwitch, SwitchRule};
use crate::decide::throughput::{ThroughputEstimator, ThroughputOptions, Transfer};
use articula_core::Libm;

/// Seconds to which versions are buffered.
const BUFFER_SECS: f64 = 10.0;
/// Segments of time after which a download of a better version than the least is given up.
const PATIENCE_SEGMENTS: f64 = 1.8;

/// A request of the first missing segment, given up as in video unless it is for the least version.
fn fetch(view: &PlayerView<'_>, segment: usize, version: usize) -> Action {
    let patience = PATIENCE_SEGMENTS * view.content.segment_secs();
    Action::Fetch(Request {
        segment,
        layers: version,
        give_up_secs: if version > 1 {
            view.now_secs + patience
        } else {
            f64::INFINITY
        },
    })
}

/// The first missing segment, unless the buffer is full.
fn wanted(view: &PlayerView<'_>) -> Option<usize> {
    let missing = view.first_missing()?;
    (view.until_start(missing) < BUFFER_SECS).then_some(missing)
}

/// Always the same version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedVersion {
    /// The version, from 1, the least.
    pub version: usize,
}

impl Policy for FixedVersion {
    fn name(&self) -> String {
        format!("fixed, version {}", self.version)
    }

    fn delivery(&self) -> Delivery {
        Delivery::Versions
    }

    fn next(&mut self, view: &PlayerView<'_>) -> Action {
        wanted(view).map_or(Action::WAIT, |segment| Action::fetch(segment, self.version))
    }
}

/// The version whose rate the estimate carries, with the hysteresis of hls.js.
#[derive(Debug, Clone)]
pub struct RateBased {
    throughput: ThroughputEstimator,
    switch: LayerSwitch,
}

impl Default for RateBased {
    /// Knows nothing yet.
    fn default() -> Self {
        let rule = SwitchRule {
            hold_secs: 0.0,
            rise_gap_secs: 0.0,
            ..SwitchRule::default()
        };
        Self {
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
            switch: LayerSwitch::new(rule),
        }
    }
}

impl RateBased {
    fn version(&mut self, view: &PlayerView<'_>) -> usize {
        let rates = view.content.version_rates(view.next_segment);
        let estimate = self.throughput.bits_per_second();
        self.switch.update(view.now_secs, &rates, estimate)
    }
}

impl Policy for RateBased {
    fn name(&self) -> String {
        "versions by rate".to_owned()
    }

    fn delivery(&self) -> Delivery {
        Delivery::Versions
    }

    fn next(&mut self, view: &PlayerView<'_>) -> Action {
        let version = self.version(view);
        let Some(segment) = wanted(view) else {
            return Action::WAIT;
        };
        let is_low = view.buffer_secs() < view.content.segment_secs();
        fetch(view, segment, if is_low { 1 } else { version })
    }

    fn transferred(&mut self, transfer: &Transfer) {
        self.throughput.add(*transfer);
    }
}

/// The version by the fill of the buffer alone, as BOLA does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BufferBased;

/// Weight of playing on against quality, in segments.
const GAMMA: f64 = 5.0;

impl Policy for BufferBased {
    fn name(&self) -> String {
        "versions by buffer".to_owned()
    }

    fn delivery(&self) -> Delivery {
        Delivery::Versions
    }

    fn next(&mut self, view: &PlayerView<'_>) -> Action {
        let Some(segment) = wanted(view) else {
            return Action::WAIT;
        };
        let secs = view.content.segment_secs();
        let sizes = &view.content.segments()[segment].version_bytes;
        let size = |v: usize| sizes[v].max(1) as f64;
        let utility = |v: usize| (size(v) / size(0)).libm_ln();
        let most = (BUFFER_SECS / secs - 1.0).max(1.0);
        let v = most / (utility(sizes.len() - 1) + GAMMA);
        let buffer = view.buffer_secs() / secs;
        let score = |i: usize| (v * (utility(i) + GAMMA) - buffer) / size(i);
        let best = (0..sizes.len()).max_by(|a, b| score(*a).total_cmp(&score(*b)));
        match best {
            Some(best) if score(best) >= 0.0 => fetch(view, segment, best + 1),
            _ => Action::WAIT,
        }
    }
}

/// Our thresholds on versions: the nearest segments are fetched again where a better version has
/// become possible, which wastes what was there.
#[derive(Debug, Clone)]
pub struct Versions {
    throughput: ThroughputEstimator,
    switch: LayerSwitch,
}

impl Default for Versions {
    /// Knows nothing yet.
    fn default() -> Self {
        Self {
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
            switch: LayerSwitch::new(SwitchRule::default()),
        }
    }
}

/// Versions of what starts within this time are replaced.
const REPLACED_SECS: f64 = 4.0;
/// Share of the time until a segment starts that its replacement may take by the estimate.
const DEADLINE: f64 = 0.9;

impl Policy for Versions {
    fn name(&self) -> String {
        "versions, replaced".to_owned()
    }

    fn delivery(&self) -> Delivery {
        Delivery::Versions
    }

    fn next(&mut self, view: &PlayerView<'_>) -> Action {
        let rates = view.content.version_rates(view.next_segment);
        let estimate = self.throughput.bits_per_second();
        let version = self.switch.update(view.now_secs, &rates, estimate);
        let missing = wanted(view);
        let buffer = view.buffer_secs();
        let secs = view.content.segment_secs();
        if let Some(segment) = missing.filter(|_| buffer < REPLACED_SECS) {
            return fetch(view, segment, if buffer < secs { 1 } else { version });
        }
        for segment in view.next_segment..view.have.len() {
            let ahead = view.until_start(segment);
            if ahead > REPLACED_SECS {
                break;
            }
            let bytes = view.content.segments()[segment].version_bytes[version - 1];
            let takes = 8.0 * bytes as f64 / estimate.max(1.0);
            if (1..version).contains(&view.have[segment]) && takes <= DEADLINE * ahead {
                return fetch(view, segment, version);
            }
        }
        missing.map_or(Action::WAIT, |segment| fetch(view, segment, version))
    }

    fn transferred(&mut self, transfer: &Transfer) {
        self.throughput.add(*transfer);
    }
}
