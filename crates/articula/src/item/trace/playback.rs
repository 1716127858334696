//! What playing an item over a trace gave.

use serde::Serialize;

/// How a client decides what it asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TracePolicy {
    /// The joint choice: a base ahead, and refinements in place, the greatest drop of error for its bytes
    /// first.
    Joint,
    /// The ratio of the thesis: each part by itself, told the true bandwidth.
    Thesis,
    /// Levels by the estimate of the bandwidth, as hls.js.
    Rate,
    /// Levels by the fill of the buffer, as BOLA.
    Buffer,
}

impl TracePolicy {
    /// All policies, ours first.
    pub const ALL: [Self; 4] = [Self::Joint, Self::Thesis, Self::Rate, Self::Buffer];

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint choice",
            Self::Thesis => "ratio of the thesis",
            Self::Rate => "levels by rate",
            Self::Buffer => "levels by buffer",
        }
    }
}

/// A moment of a playback.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct TraceSample {
    /// Time since the first request, seconds.
    pub secs: f64,
    /// Bandwidth of the trace, bits per second.
    pub bandwidth_bps: f64,
    /// Bytes that have come.
    pub bytes: u64,
    /// Whether playback runs; before it began and while it waits it does not.
    pub is_playing: bool,
    /// Time in the presentation, seconds.
    pub position_secs: f64,
    /// Seconds that play on without another request.
    pub buffer_secs: f64,
    /// Level of quality that is shown, of [`TracePlayback::levels`]; 0 for nothing.
    pub level: usize,
    /// Finest level of the mesh of which everything is there.
    pub mesh_level: Option<u32>,
    /// Longer side of the coarsest texture, pixels.
    pub texture_px: Option<u32>,
    /// Finest level of articulation of the access unit that is shown.
    pub loa: Option<u32>,
    /// Finest tier of that level.
    pub tier: Option<u32>,
    /// Greatest distance of the skin that is shown from where it should be, pixels; `None` before
    /// anything is shown.
    pub skin_px: Option<f64>,
    /// Error of the textures that are there, as measured when they were packaged, pixels.
    pub texture_error_px: Option<f64>,
    /// Both together.
    pub error_px: Option<f64>,
}

/// A playback of an item by a policy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracePlayback {
    /// The policy.
    pub policy: TracePolicy,
    /// Seconds until the character is shown; `None` if it never is.
    pub startup_secs: Option<f64>,
    /// Number of times at which playback waits after that.
    pub stalls: usize,
    /// Their length, seconds.
    pub stall_secs: f64,
    /// Bytes that came.
    pub bytes: u64,
    /// Bytes of access units that were not shown, and of what was given up.
    pub unused_bytes: u64,
    /// Number of levels of quality of the item.
    pub levels: usize,
    /// Samples in order of time.
    pub samples: Vec<TraceSample>,
}

impl TracePlayback {
    /// Mean error from a time on, and the error that is not exceeded in 95 % of it, pixels; `None` if
    /// nothing is shown.
    ///
    /// Who shows something earlier has a larger error at first. Playbacks are compared over the same time:
    /// from [`Self::all_shown_secs`] on.
    pub fn errors_from(&self, secs: f64) -> Option<[f64; 2]> {
        let samples = self.samples.iter().filter(|sample| sample.secs >= secs);
        let mut errors: Vec<f64> = samples.filter_map(|s| s.error_px).collect();
        errors.sort_by(f64::total_cmp);
        let at = (0.95 * errors.len() as f64).ceil() as usize;
        let p95 = *errors.get(at.max(1) - 1)?;
        Some([errors.iter().sum::<f64>() / errors.len() as f64, p95])
    }

    /// The time from which on all of these playbacks show something that ever do, seconds.
    pub fn all_shown_secs(playbacks: &[Self]) -> f64 {
        let starts = playbacks.iter().filter_map(|p| p.startup_secs);
        starts.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn playback(startup_secs: Option<f64>, errors: &[Option<f64>]) -> TracePlayback {
        let sample = |(secs, error_px): (usize, &Option<f64>)| TraceSample {
            secs: secs as f64,
            error_px: *error_px,
            ..TraceSample::default()
        };
        TracePlayback {
            policy: TracePolicy::Joint,
            startup_secs,
            stalls: 0,
            stall_secs: 0.0,
            bytes: 0,
            unused_bytes: 0,
            levels: 1,
            samples: errors.iter().enumerate().map(sample).collect(),
        }
    }

    #[test]
    fn errors_are_those_from_a_time_on() {
        let early = playback(Some(0.4), &[None, Some(9.0), Some(2.0), Some(1.0)]);
        let late = playback(Some(1.7), &[None, None, Some(2.0), Some(2.0)]);
        let never = playback(None, &[None; 4]);
        let all = [early, late, never];
        let from = TracePlayback::all_shown_secs(&all);
        assert_eq!(from, 1.7);
        assert_eq!(all[0].errors_from(from), Some([1.5, 2.0]));
        assert_eq!(all[0].errors_from(0.0), Some([4.0, 9.0]));
        assert_eq!(all[1].errors_from(from), Some([2.0, 2.0]));
        assert_eq!(all[2].errors_from(0.0), None);
    }
}
