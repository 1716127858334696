//! The decision of the thesis: each part by itself gets the finest level whose share of its bytes is
//! within the ratio of bandwidth to content.
//!
//! Source: thesis 3.2.1 and annex B (one level of articulation for each bandwidth). It is told the true
//! bandwidth, as by the network simulator of the thesis, and decides anew for each access unit.

use super::content::Content;
use super::view::{Action, Policy, View};
use crate::item::delivery::{Kept, is_motion, side};
use crate::item::part::{ItemPart, PartKind};
use articula_stream::decide::{NetworkShare, finest_level};

/// Seconds ahead to which access units are sent.
const PUSHED_SECS: f64 = 2.0;

/// The ratio of the thesis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ThesisRatio {
    /// Time in which the item is transferred (`T_W`), seconds.
    wait_secs: f64,
    /// The first play that was not yet sent.
    next: usize,
}

impl ThesisRatio {
    pub(super) fn new(wait_secs: f64) -> Self {
        Self { wait_secs, next: 0 }
    }

    /// What is no motion, at the level for the bandwidth of the moment.
    fn shape(&self, view: &View<'_>) -> Kept {
        let content = view.content;
        let bits = 8.0 * full_bytes(content) as f64;
        let ratio = ratio(view.capacity_bps, self.wait_secs, bits);
        let of_part = |(index, part): (usize, &ItemPart)| match is_motion(part) {
            true => vec![false; part.layers.len()],
            false => level(content, index, ratio, |kept| part.bytes_of(kept)),
        };
        content.parts().map(of_part).collect()
    }

    /// An access unit, at its own level.
    fn unit(&self, view: &View<'_>, play: usize) -> Vec<usize> {
        let content = view.content;
        let play = &content.timeline.plays[play];
        let (part, of) = content.motion_part(play.motion);
        let nothing = vec![false; content.delivery.catalogue.pieces.len()];
        let bytes = |kept: &[bool]| {
            let pieces = content.missing_of_unit(&nothing, play, kept);
            content.delivery.catalogue.bytes(&pieces)
        };
        let full = bytes(&vec![true; of.layers.len()]);
        let ratio = ratio(view.capacity_bps, play.secs(), 8.0 * full as f64);
        let kept = level(content, part, ratio, bytes);
        content.missing_of_unit(view.has, play, &kept)
    }
}

fn ratio(bits_per_second: f64, window_secs: f64, content_bits: f64) -> f64 {
    let share = NetworkShare {
        bits_per_second,
        window_secs,
        content_bits,
    };
    share.ratio()
}

/// Bytes of the item at full quality, with one motion, since one plays at a time.
fn full_bytes(content: &Content) -> u64 {
    let manifest = &content.item.manifest;
    let shape = content.parts().filter(|(_, part)| !is_motion(part));
    let shape: u64 = shape
        .map(|(_, part)| match part.kind {
            PartKind::Texture => part.layers.iter().map(|l| l.bytes).max().unwrap_or(0),
            _ => part.bytes,
        })
        .sum();
    let motions = content.parts().filter(|(_, part)| is_motion(part));
    let motion = motions.map(|(_, part)| part.bytes).max().unwrap_or(0);
    manifest.sent_bytes(&manifest.figure.file) + shape + motion
}

/// The layers of the finest level of a part within a ratio; of the coarsest one if none is.
fn level(content: &Content, part: usize, ratio: f64, bytes: impl Fn(&[bool]) -> u64) -> Vec<bool> {
    let of = &content.item.manifest.parts[part];
    let top = &content.delivery.ladder.top()[part];
    let levels = levels(of, top);
    let sizes: Vec<f64> = levels.iter().map(|kept| bytes(kept) as f64).collect();
    let full = sizes.first().copied().unwrap_or(0.0).max(1.0);
    let shares: Vec<f64> = sizes.iter().map(|size| size / full).collect();
    let level = finest_level(ratio, &shares).unwrap_or(levels.len().saturating_sub(1));
    let none = || vec![false; of.layers.len()];
    levels.into_iter().nth(level).unwrap_or_else(none)
}

/// The levels of a part from the finest that the context asks for to the coarsest: levels of the mesh,
/// sizes of a texture, levels of articulation at their finest tier.
fn levels(part: &ItemPart, top: &[bool]) -> Vec<Vec<bool>> {
    let scheme = match part.kind {
        PartKind::Mesh => "level",
        PartKind::BodyMotion => "loa",
        PartKind::FaceMotion => "face_loa",
        PartKind::Texture => {
            let most = crate::item::delivery::largest(part, top);
            let fitting = |layer: &usize| side(&part.layers[*layer]) <= most;
            let mut sizes: Vec<usize> = (0..part.layers.len()).filter(fitting).collect();
            sizes.sort_by_key(|layer| std::cmp::Reverse(side(&part.layers[*layer])));
            return sizes.iter().map(|layer| part.closure(&[*layer])).collect();
        }
    };
    let of = |layer: usize| part.layers[layer].keep.get(scheme).copied().unwrap_or(0);
    let kept = |layer: &usize| top[*layer];
    let mut values: Vec<u32> = (0..top.len()).filter(kept).map(of).collect();
    values.sort_unstable();
    values.dedup();
    // Levels of a mesh count from the finest, those of articulation from the coarsest.
    if part.kind != PartKind::Mesh {
        values.reverse();
    }
    let is_within = |value: u32, of: u32| match part.kind {
        PartKind::Mesh => of >= value,
        _ => of <= value,
    };
    let level = |value: &u32| {
        let layers: Vec<usize> = (0..top.len())
            .filter(|layer| top[*layer] && is_within(*value, of(*layer)))
            .collect();
        part.closure(&layers)
    };
    values.iter().map(level).collect()
}

impl Policy for ThesisRatio {
    fn next(&mut self, view: &View<'_>) -> Action {
        let plays = view.content.timeline.plays.len();
        // A play that waits for its bytes has not begun.
        self.next = self.next.max(view.next_play);
        while self.next < plays && view.until_start(self.next) < PUSHED_SECS {
            let play = self.next;
            self.next += 1;
            let mut pieces = view
                .content
                .delivery
                .missing_of_shape(view.has, &self.shape(view));
            pieces.extend(self.unit(view, play));
            if !pieces.is_empty() {
                return Action::fetch(pieces);
            }
        }
        Action::Wait
    }
}
