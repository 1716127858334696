//! What a policy sees and what it asks for.

use super::content::Content;
use crate::decide::throughput::Transfer;

/// Whether better quality is added to what is there, or replaces it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delivery {
    /// Layers: a request brings the layers that are missing.
    Layers,
    /// Versions: a request brings a whole version, and what was there is wasted.
    Versions,
}

/// State of the player.
#[derive(Debug, Clone, Copy)]
pub struct PlayerView<'a> {
    /// Virtual clock, seconds.
    pub now_secs: f64,
    /// Time in the content, seconds.
    pub position_secs: f64,
    /// The first segment that has not started; what comes for those before is too late.
    pub next_segment: usize,
    /// Whether playback runs.
    pub is_playing: bool,
    /// Layers, or version, that is there of each segment; 0 for nothing.
    pub have: &'a [usize],
    /// What is played.
    pub content: &'a Content,
    /// Time of the last frame, nanoseconds; 0 before the first.
    pub frame_ns: f64,
    /// The true bandwidth of the moment, for policies that are told.
    pub capacity_bits_per_second: f64,
}

impl PlayerView<'_> {
    /// Seconds from now until a segment starts, if nothing stalls.
    pub fn until_start(&self, segment: usize) -> f64 {
        segment as f64 * self.content.segment_secs() - self.position_secs
    }

    /// The first segment of which nothing is there, not counting those that have started.
    pub fn first_missing(&self) -> Option<usize> {
        (self.next_segment..self.have.len()).find(|s| self.have[*s] == 0)
    }

    /// Seconds that can be played without another request.
    pub fn buffer_secs(&self) -> f64 {
        let until = self.first_missing().unwrap_or(self.have.len());
        self.until_start(until).max(0.0)
    }
}

/// A request of layers or of a version.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// The segment.
    pub segment: usize,
    /// Number of layers, or version, that is there afterwards.
    pub layers: usize,
    /// Virtual time at which the request is given up, seconds; infinite for never.
    pub give_up_secs: f64,
}

/// What a player does next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Requests something.
    Fetch(Request),
    /// Asks again after these seconds, at most a quarter of one.
    Wait(f64),
}

impl Action {
    /// Waits for the longest time.
    pub const WAIT: Self = Self::Wait(0.25);

    /// A request that is never given up.
    pub fn fetch(segment: usize, layers: usize) -> Self {
        Self::Fetch(Request {
            segment,
            layers,
            give_up_secs: f64::INFINITY,
        })
    }
}

/// Decides what is requested next; the simulator calls it whenever nothing is in flight.
pub trait Policy {
    /// Name for reports.
    fn name(&self) -> String;

    /// How quality is delivered to this policy.
    fn delivery(&self) -> Delivery;

    /// Returns the next action. Requests of what is there or has started count as waiting.
    fn next(&mut self, view: &PlayerView<'_>) -> Action;

    /// Maximum number of layers to show, of those that are there; asked when a segment starts.
    fn most_shown(&self) -> usize {
        usize::MAX
    }

    /// Tells of a transfer that ended, finished or given up.
    fn transferred(&mut self, transfer: &Transfer) {
        let _ = transfer;
    }
}
