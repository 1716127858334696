//! What a client measures of the network: how many bytes it carries in a second.

use articula_stream::decide::{ThroughputEstimator, ThroughputOptions, Transfer};

/// Least time of a transfer, seconds: what was under way on the machine came at once.
const LEAST_SECS: f64 = 1e-3;

/// The transfers of a client.
#[derive(Debug)]
pub(super) struct Transfers {
    throughput: ThroughputEstimator,
    /// Shortest time from a request to its first byte, seconds: that of an idle network.
    wait_secs: f64,
    /// When the last one ended.
    end_secs: f64,
}

impl Default for Transfers {
    fn default() -> Self {
        Self {
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
            wait_secs: f64::INFINITY,
            end_secs: f64::NEG_INFINITY,
        }
    }
}

impl Transfers {
    /// Takes the answer to a request that was made at a time.
    ///
    /// Short bodies on a slow network come in one piece, whose first byte says nothing of how long it was under way. It was
    /// since the network was done with the answer before, or, if that was before the request, since the shortest wait.
    pub(super) fn answered(&mut self, transfer: Transfer, asked_secs: f64) {
        let wait = (transfer.first_byte_secs - asked_secs).max(0.0);
        self.wait_secs = self.wait_secs.min(wait);
        let begun_secs = match self.end_secs > asked_secs {
            true => self.end_secs,
            false => asked_secs + self.wait_secs,
        };
        self.add(Transfer {
            first_byte_secs: transfer.first_byte_secs.min(begun_secs),
            ..transfer
        });
    }

    /// Takes a transfer whose beginning is known.
    pub(super) fn add(&mut self, transfer: Transfer) {
        let latest = transfer.last_byte_secs - LEAST_SECS;
        self.end_secs = self.end_secs.max(transfer.last_byte_secs);
        self.throughput.add(Transfer {
            first_byte_secs: transfer.first_byte_secs.min(latest),
            ..transfer
        });
    }

    /// The bandwidth, bits per second.
    pub(super) fn bits_per_second(&self) -> f64 {
        self.throughput.bits_per_second()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    /// A network that carries answers one after the other and delivers each in one piece; `most` requests are under way
    /// at once.
    fn measured(bps: f64, latency_secs: f64, bytes: u64, most: usize) -> f64 {
        let mut transfers = Transfers::default();
        let (mut busy_until, mut now) = (0.0_f64, 0.0);
        let mut under_way = VecDeque::new();
        for _ in 0..200 {
            while under_way.len() < most {
                let begun = busy_until.max(now + latency_secs);
                busy_until = begun + 8.0 * bytes as f64 / bps;
                under_way.push_back((now, busy_until));
            }
            let (asked, arrived) = under_way.pop_front().unwrap();
            now = arrived;
            let transfer = Transfer {
                bytes,
                first_byte_secs: arrived,
                last_byte_secs: arrived,
            };
            transfers.answered(transfer, asked);
        }
        transfers.bits_per_second()
    }

    #[test]
    fn bodies_that_come_in_one_piece_show_no_more_than_the_rate() {
        for (bps, bytes) in [(100e3, 1200), (100e3, 6000), (2e6, 3000)] {
            for most in [2, 4] {
                let found = measured(bps, 0.02, bytes, most) / bps;
                // Two short answers at once leave the fast network idle for a time.
                let is_idle = 8.0 * (most as f64) * (bytes as f64) / bps < 0.03;
                let least = if is_idle { 0.6 } else { 0.85 };
                assert!(
                    (least..1.1).contains(&found),
                    "{found} of {bps}, {bytes} bytes, {most} at once"
                );
            }
        }
    }

    #[test]
    fn a_request_alone_is_under_way_since_the_shortest_wait() {
        let mut transfers = Transfers::default();
        let of = |bytes, first_byte_secs, last_byte_secs| Transfer {
            bytes,
            first_byte_secs,
            last_byte_secs,
        };
        // 50 ms to an idle server and back.
        transfers.answered(of(1, 0.05, 0.05), 0.0);
        for second in 1..60 {
            let asked = f64::from(second);
            transfers.answered(of(10_000, asked + 0.85, asked + 0.85), asked);
        }
        let found = transfers.bits_per_second();
        assert!((0.95..1.05).contains(&(found / 100e3)), "{found}");
    }
}
