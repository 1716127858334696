//! What is played, and how it is measured.

use crate::error::{Error, Result};
use crate::item::adapt::AdaptOptions;

/// Options of a [`TracePlayer`](super::TracePlayer).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceOptions {
    /// Time that is played from the first request on, seconds; at most an hour.
    pub secs: f64,
    /// Each motion plays in whole rounds for at least this long, then the next one, and after the last the
    /// first again.
    pub clip_secs: f64,
    /// Time between two samples of the error, seconds.
    pub sample_secs: f64,
    /// Time from a request to its first byte, seconds.
    pub latency_secs: f64,
    /// Options of the decisions; the time to wait is that of the thesis' ratio.
    pub adapt: AdaptOptions,
}

impl Default for TraceOptions {
    /// A minute, motions for 8 s each, four samples a second, 50 ms.
    fn default() -> Self {
        Self {
            secs: 60.0,
            clip_secs: 8.0,
            sample_secs: 0.25,
            latency_secs: 0.05,
            adapt: AdaptOptions::default(),
        }
    }
}

impl TraceOptions {
    pub(super) fn check(&self) -> Result<()> {
        let within = |name: &str, value: f64, least: f64, most: f64| match value {
            value if value >= least && value <= most => Ok(()),
            _ => {
                let what = format!("{name}: found {value}, expected {least} to {most}");
                Err(Error::argument(what))
            }
        };
        within("secs", self.secs, 0.1, 3600.0)?;
        within("clip_secs", self.clip_secs, 0.1, 3600.0)?;
        within("sample_secs", self.sample_secs, 0.01, 60.0)?;
        within("latency_secs", self.latency_secs, 1e-3, 60.0)
    }
}
