//! Policies on layers: ours, and the ratio of the thesis.

use super::view::{Action, Delivery, PlayerView, Policy, Request};
use crate::decide::ratio::{NetworkShare, finest_level};
use crate::decide::switching::{FrameTimeSwitch, LayerSwitch, SwitchRule};
use crate::decide::throughput::{ThroughputEstimator, ThroughputOptions, Transfer};

/// Layers by bandwidth, frame time and limits; the base is fetched far ahead, and what is in the
/// buffer is refined in place.
#[derive(Debug, Clone)]
pub struct Layered {
    throughput: ThroughputEstimator,
    network: LayerSwitch,
    frames: Option<FrameTimeSwitch>,
    frame_budget_ns: f64,
    /// What the device can show.
    shown: usize,
    most: usize,
    /// Whether one layer more is fetched than the bandwidth carries for long: since everything was
    /// there, and until the buffer is used up.
    has_spare: bool,
    requested_secs: f64,
    /// Time from the last request to its first byte.
    latency_secs: f64,
}

/// Seconds ahead to which one layer, two, three and more are fetched.
const HORIZONS_SECS: [f64; 4] = [10.0, 6.0, 4.0, 2.0];
/// Base that comes before anything finer, seconds ahead.
const SAFE_SECS: f64 = 4.0;
/// Refinement of what starts within this time comes before the base of what is far.
const NEAR_SECS: f64 = 2.0;
/// Share of the time until a segment starts that its refinement may take by the estimate.
const DEADLINE: f64 = 0.9;
/// Requests for each segment: its base, and its refinement.
const REQUESTS: f64 = 2.0;

impl Layered {
    /// Takes at most `most` layers (what user and view allow) and keeps frames within a budget in
    /// nanoseconds.
    pub fn new(most: usize, frame_budget_ns: f64) -> Self {
        Self {
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
            network: LayerSwitch::new(SwitchRule::default()),
            frames: None,
            frame_budget_ns,
            shown: usize::MAX,
            most: most.max(1),
            has_spare: false,
            requested_secs: 0.0,
            latency_secs: 0.0,
        }
    }

    /// The number of layers to get now.
    fn target(&mut self, view: &PlayerView<'_>) -> usize {
        let rates = view.content.layered_rates(view.next_segment);
        // What goes by between request and first byte carries nothing.
        let idle = REQUESTS * self.latency_secs / view.content.segment_secs();
        let estimate = self.throughput.bits_per_second() * (1.0 - idle).max(0.1);
        let fill = self.fill(view);
        let now = view.now_secs;
        let network = self.network.update_buffered(now, &rates, estimate, fill);
        let all = view.content.layers();
        let budget = self.frame_budget_ns;
        let frames = self
            .frames
            .get_or_insert_with(|| FrameTimeSwitch::new(budget, all));
        if view.frame_ns > 0.0 {
            self.shown = frames.update(now, view.frame_ns);
        }
        if fill < 1.0 {
            self.has_spare = false;
        }
        (network + usize::from(self.has_spare))
            .min(self.shown)
            .min(self.most)
            .min(all)
    }

    /// The share of the horizon of refinements that has as many layers as the network is trusted
    /// with.
    fn fill(&self, view: &PlayerView<'_>) -> f64 {
        let secs = view.content.segment_secs();
        let ahead = view.have.iter().skip(view.next_segment);
        let full = ahead
            .take_while(|have| **have >= self.network.layers())
            .count();
        full as f64 * secs / HORIZONS_SECS[1]
    }

    /// The refinement that takes away most error per second of transfer, of segments that start
    /// within `within` seconds and can still be refined.
    ///
    /// A segment is refined at once to all layers that its distance allows: a request costs a latency.
    /// As what is near is complete, finer layers are fetched as far ahead as the base, against times
    /// when nothing comes.
    fn refinement(&self, view: &PlayerView<'_>, target: usize, within: f64) -> Option<Request> {
        let rate = self.throughput.bits_per_second().max(1.0);
        let fill = self.fill(view).min(1.0);
        let horizon = |layers: usize| {
            let least = HORIZONS_SECS[(layers - 1).min(HORIZONS_SECS.len() - 1)];
            least + fill * (HORIZONS_SECS[0] - least)
        };
        let mut best = (0.0, None);
        for segment in view.next_segment..view.have.len() {
            let ahead = view.until_start(segment);
            let have = view.have[segment];
            if ahead > within || have == 0 {
                break;
            }
            let of = &view.content.segments()[segment];
            let secs = |layers: usize| {
                let bytes = of.layered_bytes[layers - 1] - of.layered_bytes[have - 1];
                self.latency_secs + 8.0 * bytes as f64 / rate
            };
            let fits = |l: &usize| ahead <= horizon(*l) && secs(*l) <= DEADLINE * ahead;
            let Some(layers) = (have + 1..=target).rfind(fits) else {
                continue;
            };
            let value = (of.error_px[have] - of.error_px[layers]) / secs(layers).max(1e-9);
            if value > best.0 {
                let give_up_secs = view.now_secs + ahead;
                let request = Request {
                    segment,
                    layers,
                    give_up_secs,
                };
                best = (value, Some(request));
            }
        }
        best.1
    }
}

impl Policy for Layered {
    fn name(&self) -> String {
        "layers, refined in place".to_owned()
    }

    fn delivery(&self) -> Delivery {
        Delivery::Layers
    }

    fn next(&mut self, view: &PlayerView<'_>) -> Action {
        self.requested_secs = view.now_secs;
        let target = self.target(view);
        let missing = view.first_missing();
        let base_within = |secs: f64| missing.filter(|m| view.until_start(*m) < secs);
        if let Some(segment) = base_within(SAFE_SECS) {
            return Action::fetch(segment, 1);
        }
        if let Some(request) = self.refinement(view, target, NEAR_SECS) {
            return Action::Fetch(request);
        }
        if let Some(segment) = base_within(HORIZONS_SECS[0]) {
            // All that is near has its layers: one request brings what two would.
            let layers = if self.fill(view) >= 1.0 { target } else { 1 };
            return Action::fetch(segment, layers);
        }
        let far = self.refinement(view, target, HORIZONS_SECS[0]);
        if far.is_none() && missing.is_none_or(|m| view.until_start(m) >= HORIZONS_SECS[0]) {
            self.has_spare = true;
        }
        far.map_or(Action::WAIT, Action::Fetch)
    }

    fn most_shown(&self) -> usize {
        self.shown.min(self.most)
    }

    fn transferred(&mut self, transfer: &Transfer) {
        self.latency_secs = (transfer.first_byte_secs - self.requested_secs).max(0.0);
        self.throughput.add(*transfer);
    }
}

/// The decision of the thesis: segment by segment the level that the ratio `R_A` of the bandwidth of
/// the moment allows. The bandwidth is told, as by the network simulator of the thesis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ThesisRatio;

/// Seconds ahead to which it fetches.
const PUSHED_SECS: f64 = 2.0;

impl Policy for ThesisRatio {
    fn name(&self) -> String {
        "ratio of the thesis".to_owned()
    }

    fn delivery(&self) -> Delivery {
        Delivery::Layers
    }

    fn next(&mut self, view: &PlayerView<'_>) -> Action {
        let Some(segment) = view.first_missing() else {
            return Action::WAIT;
        };
        if view.until_start(segment) >= PUSHED_SECS {
            return Action::WAIT;
        }
        // The finest level first, as shares of the whole.
        let bytes = &view.content.segments()[segment].layered_bytes;
        let full = bytes.last().copied().unwrap_or(0) as f64;
        let shares: Vec<f64> = bytes
            .iter()
            .rev()
            .map(|b| *b as f64 / full.max(1.0))
            .collect();
        let share = NetworkShare {
            bits_per_second: view.capacity_bits_per_second,
            window_secs: view.content.segment_secs(),
            content_bits: 8.0 * full,
        };
        let level = finest_level(share.ratio(), &shares);
        let layers = level.map_or(1, |level| bytes.len() - level);
        Action::fetch(segment, layers)
    }
}
