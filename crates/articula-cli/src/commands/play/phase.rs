//! What was shown while the slider of the bandwidth stood still, and how fast it was followed: the thesis' table 6.4.

use super::monitor::Sample;
use crate::table::Table;
use serde::Serialize;

/// The time between two movements of the slider.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Phase {
    /// When it begins, seconds since the first picture.
    pub(super) secs: f64,
    /// The bandwidth, bits per second; null without a bound.
    pub(super) slider_bps: Option<f64>,
    /// Bytes a second.
    bytes_per_second: f64,
    /// Pictures a second.
    fps: f64,
    /// Mean processor time of a picture, milliseconds.
    frame_ms: f64,
    /// Mean number of joints that were sampled.
    joints: f64,
    /// Bound of the error at its end, pixels.
    error_px: Option<f64>,
    /// Memory of the program at its end, bytes.
    memory_bytes: Option<u64>,
    /// Times at which playback waited.
    stalls: u64,
    /// Time until another level of quality was decided, seconds; null if it stays.
    decided_secs: Option<f64>,
    /// Time until what plays has another error, seconds; null if it has not.
    shown_secs: Option<f64>,
    /// Whether something was shown before, with the slider elsewhere.
    #[serde(skip)]
    is_moved: bool,
    #[serde(skip)]
    from: Option<Start>,
    #[serde(skip)]
    pictures: usize,
}

/// What was shown before the slider was moved.
#[derive(Debug, Clone)]
struct Start {
    target: usize,
    error_px: Option<f64>,
    bytes: u64,
    stalls: u64,
}

impl Phase {
    pub(super) fn new(secs: f64, slider_bps: Option<f64>, before: Option<&Sample>) -> Self {
        Self {
            secs,
            slider_bps,
            bytes_per_second: 0.0,
            fps: 0.0,
            frame_ms: 0.0,
            joints: 0.0,
            error_px: None,
            memory_bytes: None,
            stalls: 0,
            decided_secs: None,
            shown_secs: None,
            is_moved: before.is_some(),
            from: before.map(|before| Start {
                target: before.shown.target,
                error_px: before.shown.error_px,
                bytes: before.shown.bytes,
                stalls: before.shown.stalls,
            }),
            pictures: 0,
        }
    }

    /// Takes a picture into account that took a time of the processor.
    pub(super) fn add(&mut self, sample: &Sample, frame_ms: f64) {
        let secs = sample.secs - self.secs;
        let is_moved = self.is_moved;
        let from = self.from.get_or_insert(Start {
            target: sample.shown.target,
            error_px: sample.shown.error_px,
            bytes: 0,
            stalls: 0,
        });
        if is_moved && self.decided_secs.is_none() && sample.shown.target != from.target {
            self.decided_secs = Some(secs);
        }
        if is_moved && self.shown_secs.is_none() && sample.shown.error_px != from.error_px {
            self.shown_secs = Some(secs);
        }
        self.pictures += 1;
        let count = self.pictures as f64;
        self.frame_ms += (frame_ms - self.frame_ms) / count;
        self.joints += (sample.joints_sampled as f64 - self.joints) / count;
        self.fps = count / secs.max(1e-3);
        self.bytes_per_second =
            sample.shown.bytes.saturating_sub(from.bytes) as f64 / secs.max(1e-3);
        self.stalls = sample.shown.stalls.saturating_sub(from.stalls);
        self.error_px = sample.shown.error_px;
        self.memory_bytes = sample.memory_bytes;
    }
}

/// The phases as a table.
pub(super) fn table(phases: &[Phase]) -> Table {
    let mut table = Table::new(&[
        "from, s",
        "kbit/s",
        "kB/s",
        "joints",
        "pictures/s",
        "ms each",
        "error, px",
        "memory, MB",
        "stalls",
        "decided after, s",
        "shown after, s",
    ]);
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
    };
    for phase in phases {
        table.row([
            format!("{:.1}", phase.secs),
            phase
                .slider_bps
                .map_or("full".to_owned(), |bps| format!("{:.0}", bps / 1e3)),
            format!("{:.1}", phase.bytes_per_second / 1e3),
            format!("{:.1}", phase.joints),
            format!("{:.0}", phase.fps),
            format!("{:.1}", phase.frame_ms),
            number(phase.error_px, 2),
            number(phase.memory_bytes.map(|bytes| bytes as f64 / 1e6), 0),
            phase.stalls.to_string(),
            number(phase.decided_secs, 2),
            number(phase.shown_secs, 2),
        ]);
    }
    table
}
