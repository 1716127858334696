//! Policies as players of video have them: access unit by access unit a level of quality, chosen by the
//! estimate of the bandwidth or by the fill of the buffer. What was fetched is not fetched again, and not
//! refined before it plays again.
//!
//! Sources: hls.js (rate), BOLA (Spiteri, Urgaonkar, Sitaraman 2016, the basic form), dash.js (a request that
//! takes long is given up).

use super::view::{Action, HORIZON_SECS, Policy, View};
use articula_stream::decide::{
    LayerSwitch, SwitchRule, ThroughputEstimator, ThroughputOptions, Transfer,
};

/// Seconds to which access units are fetched ahead.
const BUFFER_SECS: f64 = 10.0;
/// Weight of playing on against quality, in access units.
const GAMMA: f64 = 5.0;

/// What chooses the level.
#[derive(Debug, Clone)]
enum By {
    Rate(LayerSwitch),
    Buffer,
}

/// Access units of time after which a request above the least level is given up, as by dash.js.
const PATIENCE_UNITS: f64 = 1.8;

/// Levels of quality, one access unit after the other.
#[derive(Debug, Clone)]
pub(super) struct ByLevel {
    throughput: ThroughputEstimator,
    by: By,
    /// The first play that was not yet asked for.
    next: usize,
}

impl ByLevel {
    /// By the estimate of the bandwidth, with the thresholds of hls.js.
    pub(super) fn rate() -> Self {
        let rule = SwitchRule {
            hold_secs: 0.0,
            rise_gap_secs: 0.0,
            ..SwitchRule::default()
        };
        Self::new(By::Rate(LayerSwitch::new(rule)))
    }

    /// By the fill of the buffer, as BOLA does.
    pub(super) fn buffer() -> Self {
        Self::new(By::Buffer)
    }

    fn new(by: By) -> Self {
        Self {
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
            by,
            next: 0,
        }
    }

    /// The level for a play; `None` to wait.
    fn level(&mut self, view: &View<'_>, play: usize) -> Option<usize> {
        let secs = view.content.timeline.plays[play].secs();
        match &mut self.by {
            By::Rate(switch) => {
                let estimate = self.throughput.bits_per_second();
                let level = switch.update(view.now_secs, &view.rates(), estimate) - 1;
                let is_low = view.until_start(play) < secs;
                Some(if is_low { 0 } else { level })
            }
            By::Buffer => bola(&sizes(view, play), secs, view.until_start(play)),
        }
    }
}

/// Bytes of a play at each level, with the share of the shape that its time has in what is fetched ahead.
fn sizes(view: &View<'_>, play: usize) -> Vec<f64> {
    let content = view.content;
    let nothing = vec![false; content.delivery.catalogue.pieces.len()];
    let play = &content.timeline.plays[play];
    let (part, _) = content.motion_part(play.motion);
    let share = play.secs() / HORIZON_SECS;
    let levels = content.delivery.ladder.levels.iter();
    let size = levels.map(|level| {
        let shape = content.delivery.missing_of_shape(&nothing, level);
        let unit = content.missing_of_unit(&nothing, play, &level[part]);
        let bytes = |pieces: &[usize]| content.delivery.catalogue.bytes(pieces) as f64;
        (share * bytes(&shape) + bytes(&unit)).max(1.0)
    });
    size.collect()
}

/// The level of the greatest score by BOLA; `None` if the buffer is full enough for all.
fn bola(sizes: &[f64], secs: f64, buffer_secs: f64) -> Option<usize> {
    let utility = |level: usize| (sizes[level] / sizes[0]).ln();
    let most = (BUFFER_SECS / secs - 1.0).max(1.0);
    let v = most / (utility(sizes.len() - 1) + GAMMA);
    let score = |level: usize| {
        let gain = v * (utility(level) + GAMMA) - buffer_secs / secs;
        gain / sizes[level]
    };
    let best = (0..sizes.len()).max_by(|a, b| score(*a).total_cmp(&score(*b)));
    best.filter(|best| score(*best) >= 0.0)
}

impl Policy for ByLevel {
    fn next(&mut self, view: &View<'_>) -> Action {
        let plays = view.content.timeline.plays.len();
        // What was given up is asked for again.
        self.next = self.next.min(view.first_unready()).max(view.next_play);
        while self.next < plays && view.until_start(self.next) < BUFFER_SECS {
            let play = self.next;
            let Some(level) = self.level(view, play) else {
                break;
            };
            self.next += 1;
            let pieces = view.missing(play, &view.content.delivery.ladder.levels[level]);
            let patience_secs = match level {
                0 => f64::INFINITY,
                _ => PATIENCE_UNITS * view.content.timeline.plays[play].secs(),
            };
            if !pieces.is_empty() {
                return Action::Fetch(pieces, view.now_secs + patience_secs);
            }
        }
        Action::Wait
    }

    fn transferred(&mut self, transfer: &Transfer) {
        self.throughput.add(*transfer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fuller_buffer_gets_a_finer_level_and_a_full_one_waits() {
        let sizes = [1000.0, 3000.0, 9000.0];
        let at = |buffer| bola(&sizes, 1.0, buffer);
        assert_eq!(at(0.0), Some(0));
        let levels: Vec<Option<usize>> = [3.0, 6.5, 8.0].map(at).to_vec();
        assert!(levels.is_sorted() && levels[2] == Some(2), "{levels:?}");
        // 9 = v (ln 9 + 5): beyond, no level has a score.
        assert_eq!(at(9.1), None);
    }
}
