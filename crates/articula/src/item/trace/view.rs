//! What a policy sees of the player, and what it asks for.

use super::content::Content;
use crate::item::delivery::Kept;
use articula_stream::decide::Transfer;
use std::collections::BTreeSet;

/// Time ahead that counts for what is fetched next, seconds.
pub(super) const HORIZON_SECS: f64 = 10.0;

/// State of the player.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) now_secs: f64,
    /// Time in the presentation.
    pub(super) position_secs: f64,
    /// The first play that has not begun.
    pub(super) next_play: usize,
    /// For each piece whether it is there.
    pub(super) has: &'a [bool],
    pub(super) content: &'a Content,
    /// The true bandwidth of the moment, for a policy that is told.
    pub(super) capacity_bps: f64,
}

/// What is done next.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Action {
    /// These pieces are asked for in one request, and come in this order, up to a time at which the rest is
    /// given up.
    Fetch(Vec<usize>, f64),
    /// Nothing for a while.
    Wait,
}

impl Action {
    /// A request that is never given up.
    pub(super) fn fetch(pieces: Vec<usize>) -> Self {
        Self::Fetch(pieces, f64::INFINITY)
    }
}

/// Decides what is asked for; called whenever nothing is in flight.
pub(super) trait Policy {
    fn next(&mut self, view: &View<'_>) -> Action;

    /// Tells of a transfer that ended.
    fn transferred(&mut self, transfer: &Transfer) {
        let _ = transfer;
    }
}

impl View<'_> {
    /// Seconds until a play begins, if nothing stalls.
    pub(super) fn until_start(&self, play: usize) -> f64 {
        self.content.timeline.plays[play].start_secs - self.position_secs
    }

    /// The plays that have not begun and begin within some seconds.
    pub(super) fn ahead(&self, secs: f64) -> impl Iterator<Item = usize> + '_ {
        let plays = self.next_play..self.content.timeline.plays.len();
        plays.take_while(move |play| self.until_start(*play) < secs)
    }

    /// Pieces that are missing to play an access unit at a level; what is no motion is not among them.
    pub(super) fn missing_of_play(&self, play: usize, level: &Kept) -> Vec<usize> {
        let play = &self.content.timeline.plays[play];
        let (part, _) = self.content.motion_part(play.motion);
        self.content.missing_of_unit(self.has, play, &level[part])
    }

    /// Pieces that are missing for a play at a level, of everything.
    pub(super) fn missing(&self, play: usize, level: &Kept) -> Vec<usize> {
        let mut pieces = self.content.delivery.missing_of_shape(self.has, level);
        pieces.extend(self.missing_of_play(play, level));
        pieces
    }

    /// The first play that has not begun and lacks its base; the number of all without one.
    pub(super) fn first_unready(&self) -> usize {
        let (content, timeline) = (self.content, &self.content.timeline);
        let least = &content.delivery.ladder.levels[0];
        if !content
            .delivery
            .missing_of_shape(self.has, least)
            .is_empty()
        {
            return self.next_play;
        }
        // Access units play again and again.
        let count: usize = timeline.motions.iter().map(|m| m.units.len()).sum();
        let mut seen = BTreeSet::new();
        for play in self.next_play..timeline.plays.len() {
            let of = &timeline.plays[play];
            if seen.len() == count {
                break;
            }
            if seen.insert((of.motion, of.unit)) && !self.missing_of_play(play, least).is_empty() {
                return play;
            }
        }
        timeline.plays.len()
    }

    /// Seconds that play on without another request.
    pub(super) fn buffer_secs(&self) -> f64 {
        let plays = &self.content.timeline.plays;
        let end = plays.last().map_or(0.0, |last| last.end_secs);
        let missing = plays.get(self.first_unready());
        let until = missing.map_or(end, |play| play.start_secs);
        (until - self.position_secs).max(0.0)
    }

    /// For each level the bits per second that bring what is missing of it for the time ahead within that
    /// time.
    pub(super) fn rates(&self) -> Vec<f64> {
        let of_level = |level: &Kept| {
            let mut pieces = self.content.delivery.missing_of_shape(self.has, level);
            for play in self.ahead(HORIZON_SECS) {
                pieces.extend(self.missing_of_play(play, level));
            }
            pieces.sort_unstable();
            pieces.dedup();
            8.0 * self.content.delivery.catalogue.bytes(&pieces) as f64 / HORIZON_SECS
        };
        let mut rates: Vec<f64> = self
            .content
            .delivery
            .ladder
            .levels
            .iter()
            .map(of_level)
            .collect();
        // A texture may be there that is larger than one of a finer level.
        for level in 1..rates.len() {
            rates[level] = rates[level].max(rates[level - 1]);
        }
        rates
    }
}
