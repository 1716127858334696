//! A bound on bytes per second.

/// Time that a burst may take of the bound, seconds.
const BURST_SECS: f64 = 0.25;

/// A bucket that fills at a rate: a state machine on the caller's clock.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    bits_per_second: Option<f64>,
    /// When all that was spent is paid.
    paid_secs: f64,
}

impl Pace {
    /// Without a bound.
    pub(super) fn unbounded() -> Self {
        Self {
            bits_per_second: None,
            paid_secs: f64::NEG_INFINITY,
        }
    }

    /// Changes the bound. What was spent under the old one is forgotten where the new one is higher.
    pub(super) fn set(&mut self, bits_per_second: Option<f64>, now_secs: f64) {
        if self.bits_per_second != bits_per_second {
            self.bits_per_second = bits_per_second.map(|bps| bps.max(1.0));
            self.paid_secs = self.paid_secs.min(now_secs);
        }
    }

    /// When the next bytes may go.
    pub(super) fn ready_secs(&self) -> f64 {
        self.paid_secs - BURST_SECS
    }

    /// Counts bytes that go now.
    pub(super) fn spend(&mut self, bytes: u64, now_secs: f64) {
        if let Some(bits_per_second) = self.bits_per_second {
            let start = self.paid_secs.max(now_secs);
            self.paid_secs = start + 8.0 * bytes as f64 / bits_per_second;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_go_at_the_rate_and_a_fall_counts_at_once() {
        let mut pace = Pace::unbounded();
        pace.spend(1 << 30, 0.0);
        assert!(pace.ready_secs() < 0.0);
        pace.set(Some(80e3), 1.0);
        let mut sent = Vec::new();
        let mut now: f64 = 1.0;
        while now < 11.0 {
            now = now.max(pace.ready_secs());
            pace.spend(5000, now);
            sent.push(now);
        }
        // 10 kB a second, with what a burst takes ahead.
        assert!((20..=22).contains(&sent.len()), "{}", sent.len());
        pace.set(Some(8e6), now);
        assert!(pace.ready_secs() <= now);
    }
}
