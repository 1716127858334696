//! Result of a simulation.

/// A segment that was shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Virtual time at which it started, seconds.
    pub at_secs: f64,
    /// The number of layers, or the version, that was shown.
    pub layers: usize,
}

/// What a simulation gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Playback {
    /// Seconds until the first segment started.
    pub startup_secs: f64,
    /// Number of interruptions after that.
    pub stalls: usize,
    /// Their length, seconds.
    pub stall_secs: f64,
    /// Number of segments with another number of layers than the one before.
    pub switches: usize,
    /// Bytes received.
    pub bytes: u64,
    /// Bytes received that were never shown: given up, too late, or replaced.
    pub wasted_bytes: u64,
    /// Mean error over the time of playing and stalling, pixels.
    pub mean_error_px: f64,
    /// The error that is not exceeded in 95 % of that time.
    pub p95_error_px: f64,
    /// The segments in order.
    pub shown: Vec<Shown>,
    /// Whether all was played before the time limit.
    pub is_complete: bool,
}

impl Playback {
    /// Switches per minute of content shown.
    pub fn switches_per_minute(&self, segment_secs: f64) -> f64 {
        let minutes = self.shown.len() as f64 * segment_secs / 60.0;
        if minutes > 0.0 {
            self.switches as f64 / minutes
        } else {
            0.0
        }
    }
}

/// Error over stretches of time.
#[derive(Debug, Clone, Default)]
pub(super) struct ErrorTime {
    stretches: Vec<(f64, f64)>,
}

impl ErrorTime {
    pub(super) fn add(&mut self, error_px: f64, secs: f64) {
        if secs > 0.0 {
            self.stretches.push((error_px, secs));
        }
    }

    /// Mean, and the error that is not exceeded for a share of the time.
    pub(super) fn mean_and_quantile(mut self, share: f64) -> (f64, f64) {
        let secs: f64 = self.stretches.iter().map(|s| s.1).sum();
        if secs <= 0.0 {
            return (0.0, 0.0);
        }
        let sum: f64 = self.stretches.iter().map(|s| s.0 * s.1).sum();
        self.stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut so_far = 0.0;
        let mut quantile = 0.0;
        for (error, length) in self.stretches {
            quantile = error;
            so_far += length;
            // The last stretches may add up to a little less than the whole.
            if so_far >= share * secs * (1.0 - 1e-12) {
                break;
            }
        }
        (sum / secs, quantile)
    }
}
