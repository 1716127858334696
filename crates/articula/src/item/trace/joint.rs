//! Our policy: the base of what comes is fetched ahead, and what is there is refined in place, the
//! greatest drop of error for its bytes first.

use super::content::Content;
use super::view::{Action, HORIZON_SECS, Policy, View};
use crate::item::delivery::{Kept, is_motion, largest};
use crate::item::part::PartKind;
use articula_stream::decide::{
    LayerSwitch, SwitchRule, ThroughputEstimator, ThroughputOptions, Transfer,
};
use std::collections::BTreeMap;

/// The base of what begins within this time comes before everything else.
const SAFE_SECS: f64 = 4.0;
/// Longest request by the estimate, seconds.
const REQUEST_SECS: f64 = 1.0;
/// Refinements of one request.
const MOST_STEPS: usize = 32;

/// Layers by bandwidth, refined in place.
#[derive(Debug, Clone)]
pub(super) struct JointChoice {
    throughput: ThroughputEstimator,
    switch: LayerSwitch,
    requested_secs: f64,
    /// Time from the last request to its first byte.
    latency_secs: f64,
}

/// A refinement that may be asked for.
struct Step {
    pieces: Vec<usize>,
    /// Drop of the stated error times the seconds for which it shows, per byte.
    value: f64,
}

impl JointChoice {
    pub(super) fn new() -> Self {
        Self {
            throughput: ThroughputEstimator::new(ThroughputOptions::default()),
            switch: LayerSwitch::new(SwitchRule::default()),
            requested_secs: 0.0,
            latency_secs: 0.0,
        }
    }

    /// The refinements of a request, one on top of the other.
    fn refinements(
        &self,
        view: &View<'_>,
        level: &Kept,
        horizon_secs: f64,
        bytes: f64,
    ) -> Vec<usize> {
        let mut has = view.has.to_vec();
        let mut pieces = Vec::new();
        let mut left = bytes;
        for _ in 0..MOST_STEPS {
            let seen = View { has: &has, ..*view };
            let best = self.best(&seen, level, horizon_secs);
            let Some(best) = best else { break };
            left -= view.content.delivery.catalogue.bytes(&best.pieces) as f64;
            // One is asked for, whatever it takes.
            if left < 0.0 && !pieces.is_empty() {
                break;
            }
            best.pieces.iter().for_each(|piece| has[*piece] = true);
            pieces.extend(best.pieces);
        }
        pieces
    }

    fn best(&self, view: &View<'_>, level: &Kept, horizon_secs: f64) -> Option<Step> {
        let shape = self.of_shape(view, level, horizon_secs);
        let motions = self.of_motions(view, level, horizon_secs);
        let all = shape.into_iter().chain(motions);
        all.max_by(|a, b| a.value.total_cmp(&b.value))
    }

    fn step(&self, content: &Content, pieces: Vec<usize>, gain_px: f64, secs: f64) -> Option<Step> {
        let bytes = content.delivery.catalogue.bytes(&pieces) as f64;
        let value = gain_px * secs / bytes.max(1.0);
        (value > 0.0 && bytes > 0.0).then_some(Step { pieces, value })
    }

    /// Refinements of meshes and textures, which show at all times.
    fn of_shape(&self, view: &View<'_>, level: &Kept, horizon_secs: f64) -> Vec<Step> {
        let content = view.content;
        let decided = &content.delivery.ladder.decision.parts;
        let mut steps = Vec::new();
        for (part, layers) in decided.parts.iter().zip(&decided.layers) {
            let is_shape =
                |(index, _): &(usize, Vec<bool>)| !is_motion(&content.item.manifest.parts[*index]);
            let options = part.options.iter().zip(layers);
            let options = options.filter(|(_, layers)| layers.iter().all(is_shape));
            let of_option = |layers: &Vec<(usize, Vec<bool>)>| {
                let mut wanted: Kept = content.delivery.ladder.levels[0].clone();
                for (index, kept) in layers {
                    wanted[*index].clone_from(kept);
                }
                content.delivery.missing_of_shape(view.has, &wanted)
            };
            let all: Vec<(f64, Vec<usize>, bool)> = options
                .map(|(option, layers)| {
                    let px = option.pixels(content.pixels_per_metre);
                    let is_within = layers
                        .iter()
                        .all(|(index, kept)| within(content, *index, kept, &level[*index]));
                    (px, of_option(layers), is_within)
                })
                .collect();
            let there = all.iter().filter(|(_, missing, _)| missing.is_empty());
            let Some(now) = there.map(|(px, ..)| *px).reduce(f64::min) else {
                continue;
            };
            let finer = all
                .into_iter()
                .filter(|(px, _, within)| *within && *px < now);
            steps.extend(finer.filter_map(|(px, missing, _)| {
                let secs = self.shown_after(view, &missing, horizon_secs);
                self.step(content, missing, now - px, secs)
            }));
        }
        steps
    }

    /// Seconds for which pieces show within the horizon, if they are asked for now and show at all times.
    fn shown_after(&self, view: &View<'_>, pieces: &[usize], horizon_secs: f64) -> f64 {
        (horizon_secs - self.arrival_secs(view.content, pieces)).max(1e-3)
    }

    /// Seconds until pieces are there that are asked for now.
    fn arrival_secs(&self, content: &Content, pieces: &[usize]) -> f64 {
        let bits = 8.0 * content.delivery.catalogue.bytes(pieces) as f64;
        self.latency_secs + bits / self.throughput.bits_per_second().max(1.0)
    }

    /// Refinements of access units that play within the horizon, and whose base is there.
    fn of_motions(&self, view: &View<'_>, level: &Kept, horizon_secs: f64) -> Vec<Step> {
        let content = view.content;
        let plays = &content.timeline.plays;
        let mut times: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        let playing = view.next_play.saturating_sub(1)..view.next_play;
        for play in playing.chain(view.ahead(horizon_secs)) {
            let of = &plays[play];
            times.entry((of.motion, of.unit)).or_default().push(play);
        }
        let mut steps = Vec::new();
        for ((motion, unit), times) in times {
            let (part, of) = content.motion_part(motion);
            let there = content.delivery.layers_there(view.has, part, Some(unit));
            if !content.is_ready(view.has, &plays[times[0]]) {
                continue;
            }
            let now = content.stated_px(part, &there);
            for layer in (0..of.layers.len()).filter(|layer| level[part][*layer] && !there[*layer])
            {
                let px = content.pixels_per_metre * of.layers[layer].error_m;
                if px >= now {
                    continue;
                }
                let kept = of.closure(&[layer]);
                let missing = content.missing_of_unit(view.has, &plays[times[0]], &kept);
                let arrival = view.position_secs + self.arrival_secs(content, &missing);
                let end = view.position_secs + horizon_secs;
                let shown = |play: &usize| {
                    let play = &plays[*play];
                    (play.end_secs.min(end) - play.start_secs.max(arrival)).max(0.0)
                };
                let secs = times.iter().map(shown).sum();
                steps.extend(self.step(content, missing, now - px, secs));
            }
        }
        steps
    }

    /// The base of the first play that has none yet, if it begins within some seconds.
    fn base(&self, view: &View<'_>, within_secs: f64) -> Option<Vec<usize>> {
        let play = view.first_unready();
        let is_near =
            play < view.content.timeline.plays.len() && view.until_start(play) < within_secs;
        is_near.then(|| view.missing(play, &view.content.delivery.ladder.levels[0]))
    }
}

/// Whether a level has layers of a part, or a texture that is no smaller.
fn within(content: &Content, part: usize, kept: &[bool], level: &[bool]) -> bool {
    let of = &content.item.manifest.parts[part];
    match of.kind {
        PartKind::Texture => largest(of, kept) <= largest(of, level),
        _ => kept.iter().zip(level).all(|(kept, level)| *level || !kept),
    }
}

impl Policy for JointChoice {
    fn next(&mut self, view: &View<'_>) -> Action {
        self.requested_secs = view.now_secs;
        if let Some(base) = self.base(view, SAFE_SECS) {
            return Action::fetch(base);
        }
        let levels = &view.content.delivery.ladder.levels;
        let fill = (view.buffer_secs() / HORIZON_SECS).min(1.0);
        let estimate = self.throughput.bits_per_second();
        let rates = view.rates();
        let target = self
            .switch
            .update_buffered(view.now_secs, &rates, estimate, fill);
        let bytes = estimate * REQUEST_SECS / 8.0;
        let rest = f64::INFINITY;
        // What the bandwidth carries, then all that there is, then what comes later.
        let mut pieces = self.refinements(view, &levels[target - 1], HORIZON_SECS, bytes);
        if pieces.is_empty() {
            pieces = self.refinements(
                view,
                view.content.delivery.ladder.top(),
                HORIZON_SECS,
                bytes,
            );
        }
        // A base is small: it comes along.
        let far = if pieces.is_empty() {
            rest
        } else {
            HORIZON_SECS
        };
        pieces.extend(self.base(view, far).unwrap_or_default());
        if pieces.is_empty() {
            let left = view.content.timeline.plays.last();
            let left = left.map_or(0.0, |last| last.end_secs - view.position_secs);
            pieces = self.refinements(view, view.content.delivery.ladder.top(), left, bytes);
        }
        match pieces.is_empty() {
            true => Action::Wait,
            false => Action::fetch(pieces),
        }
    }

    fn transferred(&mut self, transfer: &Transfer) {
        self.latency_secs = (transfer.first_byte_secs - self.requested_secs).max(0.0);
        self.throughput.add(*transfer);
    }
}
