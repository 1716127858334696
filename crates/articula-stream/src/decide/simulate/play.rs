//! The virtual player.

use super::content::Content;
use super::playback::{ErrorTime, Playback, Shown};
use super::view::{Action, Delivery, PlayerView, Policy, Request};
use crate::decide::bandwidth_trace::BandwidthTrace;
use crate::decide::throughput::Transfer;

/// Options of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationOptions {
    /// Time from a request to its first byte, seconds.
    pub latency_secs: f64,
    /// Factor of the time per frame from a time on, in order; 1 before.
    pub load: Vec<(f64, f64)>,
    /// The simulation ends at this multiple of the content's length, at most 1000.
    pub most_lengths: f64,
}

impl Default for SimulationOptions {
    /// 50 ms, no load, three times the length.
    fn default() -> Self {
        Self {
            latency_secs: 0.05,
            load: Vec::new(),
            most_lengths: 3.0,
        }
    }
}

/// Steps of the virtual clock are at least this long, so that every simulation ends.
const LEAST_SECS: f64 = 1e-3;
/// Longest time without asking a policy.
const MOST_WAIT_SECS: f64 = 0.25;

/// Plays content over a trace as a policy requests it. The same input gives the same playback.
pub fn simulate(
    content: &Content,
    trace: &BandwidthTrace,
    policy: &mut dyn Policy,
    options: &SimulationOptions,
) -> Playback {
    let mut player = Player::new(content, options, policy.delivery());
    while !player.is_over() {
        let view = PlayerView {
            now_secs: player.now,
            position_secs: player.position,
            next_segment: player.started,
            is_playing: player.is_playing,
            have: &player.have,
            content,
            frame_ns: player.frame_ns(),
            capacity_bits_per_second: trace.at(player.now),
        };
        let action = policy.next(&view);
        player.most_shown = policy.most_shown().max(1);
        match action {
            Action::Fetch(request) if player.can_use(&request) => {
                if let Some(transfer) = player.fetch(trace, &request) {
                    policy.transferred(&transfer);
                }
            }
            Action::Wait(secs) if secs < MOST_WAIT_SECS => {
                player.advance(player.now + secs.max(LEAST_SECS));
            }
            Action::Fetch(_) | Action::Wait(_) => player.advance(player.now + MOST_WAIT_SECS),
        }
    }
    player.finish()
}

struct Player<'a> {
    content: &'a Content,
    options: &'a SimulationOptions,
    now: f64,
    end: f64,
    /// Time in the content.
    position: f64,
    /// Number of segments that have started.
    started: usize,
    is_playing: bool,
    most_shown: usize,
    delivery: Delivery,
    have: Vec<usize>,
    /// Bytes of what is there of each segment.
    held_bytes: Vec<u64>,
    shown: Vec<Shown>,
    errors: ErrorTime,
    startup: Option<f64>,
    stalls: usize,
    stall_secs: f64,
    bytes: u64,
    wasted: u64,
}

impl<'a> Player<'a> {
    fn new(content: &'a Content, options: &'a SimulationOptions, delivery: Delivery) -> Self {
        let segments = content.segments().len();
        let lengths = options.most_lengths;
        let lengths = if lengths > 0.0 { lengths.min(1e3) } else { 0.0 };
        Self {
            content,
            options,
            now: 0.0,
            end: content.secs() * lengths,
            position: 0.0,
            started: 0,
            is_playing: false,
            most_shown: usize::MAX,
            delivery,
            have: vec![0; segments],
            held_bytes: vec![0; segments],
            shown: Vec::with_capacity(segments),
            errors: ErrorTime::default(),
            startup: None,
            stalls: 0,
            stall_secs: 0.0,
            bytes: 0,
            wasted: 0,
        }
    }

    fn is_over(&self) -> bool {
        self.now >= self.end || (self.started == self.have.len() && !self.is_playing)
    }

    fn frame_ns(&self) -> f64 {
        let layers = self.shown.last().map_or(0, |s| s.layers);
        let before = |l: &&(f64, f64)| l.0 <= self.now;
        let load = self.options.load.iter().rfind(before).map_or(1.0, |l| l.1);
        load * self.content.frame_ns(layers)
    }

    fn can_use(&self, request: &Request) -> bool {
        let segment = request.segment;
        (self.started..self.have.len()).contains(&segment)
            && match self.delivery {
                Delivery::Layers => self.have[segment] < request.layers,
                Delivery::Versions => self.have[segment] != request.layers,
            }
            && (1..=self.content.layers()).contains(&request.layers)
    }

    /// Plays while a request is in flight. Returns the transfer, if its first byte came.
    fn fetch(&mut self, trace: &BandwidthTrace, request: &Request) -> Option<Transfer> {
        let segment = &self.content.segments()[request.segment];
        let bytes = match self.delivery {
            Delivery::Layers => {
                let held = self.held_bytes[request.segment];
                segment.layered_bytes[request.layers - 1].saturating_sub(held)
            }
            Delivery::Versions => segment.version_bytes[request.layers - 1],
        };
        let first_byte = self.now + self.options.latency_secs.max(LEAST_SECS);
        let finish = trace.finish(first_byte, 8.0 * bytes as f64).max(first_byte);
        let until = finish
            .min(request.give_up_secs.max(first_byte))
            .min(self.end.max(first_byte));
        // What is there already is shown when the segment starts; what comes later is of no use.
        let upgrades = self.have[request.segment] > 0;
        let start = self.time_of_start(request.segment);
        let until = if upgrades { until.min(start) } else { until };
        self.advance(until);
        let is_complete = finish <= until && finish.is_finite();
        let received = if is_complete {
            bytes
        } else {
            (trace.bits(first_byte, until).max(0.0) / 8.0) as u64
        };
        self.bytes += received;
        if !is_complete {
            self.wasted += received;
        } else {
            if self.delivery == Delivery::Versions {
                self.wasted += self.held_bytes[request.segment];
                self.held_bytes[request.segment] = 0;
            }
            self.held_bytes[request.segment] += bytes;
            self.have[request.segment] = request.layers;
            self.resume();
        }
        (until > first_byte).then_some(Transfer {
            bytes: received,
            first_byte_secs: first_byte,
            last_byte_secs: until,
        })
    }

    /// Virtual time at which a segment starts if nothing stalls before; infinite while playback
    /// stands still.
    fn time_of_start(&self, segment: usize) -> f64 {
        if self.is_playing {
            self.now + segment as f64 * self.content.segment_secs() - self.position
        } else {
            f64::INFINITY
        }
    }

    /// Moves the clock, and plays.
    fn advance(&mut self, until: f64) {
        self.resume();
        while self.now < until {
            let left = until - self.now;
            if !self.is_playing {
                if self.startup.is_some() && self.started < self.have.len() {
                    self.stall_secs += left;
                    let frozen = &self.content.segments()[self.started];
                    self.errors.add(frozen.error_px[0], left);
                }
                self.now = until;
                return;
            }
            let border = self.started as f64 * self.content.segment_secs();
            let step = left.min(border - self.position);
            let error = self.shown.last().map_or(0.0, |shown| {
                self.content.segments()[self.started - 1].error_px[shown.layers]
            });
            self.errors.add(error, step);
            if step < left {
                self.now += step;
                self.position = border;
                self.start_segment();
            } else {
                self.now = until;
                self.position += step;
            }
        }
    }

    /// At the end of a segment: starts the next one, or stalls.
    fn start_segment(&mut self) {
        match self.have.get(self.started) {
            Some(0) => {
                self.is_playing = false;
                self.stalls += 1;
            }
            Some(have) => {
                // Layers can be left out, versions cannot.
                let layers = match self.delivery {
                    Delivery::Layers => self.most_shown.min(*have),
                    Delivery::Versions => *have,
                };
                let bytes = &self.content.segments()[self.started].layered_bytes;
                if layers < *have {
                    self.wasted += bytes[*have - 1] - bytes[layers - 1];
                }
                self.shown.push(Shown {
                    at_secs: self.now,
                    layers,
                });
                self.started += 1;
            }
            None => self.is_playing = false,
        }
    }

    /// Goes on if what was waited for is there.
    fn resume(&mut self) {
        let is_there = self
            .have
            .get(self.started)
            .is_some_and(|layers| *layers > 0);
        if !self.is_playing && is_there {
            self.is_playing = true;
            self.startup.get_or_insert(self.now);
            self.start_segment();
        }
    }

    fn finish(self) -> Playback {
        let is_complete = self.shown.len() == self.have.len() && !self.is_playing;
        let (mean_error_px, p95_error_px) = self.errors.mean_and_quantile(0.95);
        let differ = |pair: &&[Shown]| pair[0].layers != pair[1].layers;
        Playback {
            startup_secs: self.startup.unwrap_or(f64::INFINITY),
            stalls: self.stalls,
            stall_secs: self.stall_secs,
            switches: self.shown.windows(2).filter(differ).count(),
            bytes: self.bytes,
            wasted_bytes: self.wasted,
            mean_error_px,
            p95_error_px,
            shown: self.shown,
            is_complete,
        }
    }
}
