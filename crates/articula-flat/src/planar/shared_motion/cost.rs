//! Estimated bytes, compressed, of the outline of a triangle that follows a motion.

use super::item::Item;
use super::placed::Placed;
use crate::planar::keyed_motion::KeyedMotion;
use articula_core::{Cancelled, Progress};
use glam::DVec2;

/// Bytes of the animation of an outline, apart from its keys.
const ANIMATION: f32 = 30.0;
/// Bytes of a key of an outline.
const KEY: f32 = 10.0;
/// Bytes of a group that moves, apart from the keys of its motion.
const GROUP: f32 = 60.0;
/// Bytes of a number of a motion's key.
const NUMBER: f32 = 3.0;

/// Number of layers from report to report.
const STEP: usize = 32;

/// Bytes of layers by motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Costs {
    /// Bytes of each layer without a motion, then with each motion.
    rows: Vec<Vec<f32>>,
    /// Bytes of a group without a motion, then with each motion.
    groups: Vec<f32>,
}

impl Costs {
    /// O(motions x layers x frames).
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn new(
        items: &[Item],
        motions: &[KeyedMotion],
        progress: &mut Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let frames = items.first().map_or(0, |item| item.corners.len());
        let placed = motions.iter().map(|m| Placed::of(m, frames));
        let still = vec![Placed::STILL; frames];
        let placed: Vec<Vec<Placed>> = std::iter::once(still).chain(placed).collect();
        let mut rows = Vec::with_capacity(items.len());
        for (i, item) in items.iter().enumerate() {
            if i % STEP == 0 {
                progress.step(i as f32 / items.len() as f32)?;
            }
            rows.push(placed.iter().map(|p| bytes(item, p)).collect());
        }
        let group = |motion: &KeyedMotion| {
            let numbers = motion
                .tracks()
                .map(|t| if t.is_still() { 0 } else { t.values.len() });
            GROUP + NUMBER * numbers.iter().sum::<usize>() as f32
        };
        let groups = motions.iter().map(group);
        Ok(Self {
            rows,
            groups: std::iter::once(0.0).chain(groups).collect(),
        })
    }

    #[cfg(test)]
    pub(super) fn from_rows(rows: Vec<Vec<f32>>, groups: Vec<f32>) -> Self {
        Self { rows, groups }
    }

    /// Bytes of a layer: index 0 without a motion, then with each of them.
    pub(super) fn row(&self, layer: usize) -> &[f32] {
        &self.rows[layer]
    }

    /// Bytes of a group, in the same sequence.
    pub(super) fn groups(&self) -> &[f32] {
        &self.groups
    }

    /// Motion of each layer that leaves it the fewest bytes.
    pub(super) fn best(&self) -> Vec<Option<u32>> {
        self.rows.iter().map(|row| motion(least(row))).collect()
    }
}

/// Index of the least number, the first of equal ones.
pub(super) fn least(row: &[f32]) -> usize {
    let all = row.iter().enumerate();
    let least = all.min_by(|a, b| a.1.total_cmp(b.1));
    least.map_or(0, |(i, _)| i)
}

/// Motion of an index into a row.
pub(super) fn motion(index: usize) -> Option<u32> {
    index.checked_sub(1).map(|m| m as u32)
}

/// Half width of a window of a coordinate on the grid, below which no key is sure to be in it, grid steps.
const LEAST_REACH: f64 = 0.5;

/// Bytes of an outline by the number of keys that a greedy choice needs; infinite where the motion enlarges what
/// rounding to the grid loses beyond the tolerance.
fn bytes(item: &Item, placed: &[Placed]) -> f32 {
    let is_within = |p: &Placed| *p == Placed::STILL || p.tolerance(item.tolerance) >= LEAST_REACH;
    let mut shown = placed
        .iter()
        .zip(&item.is_shown)
        .filter(|(_, shown)| **shown);
    if !shown.all(|(p, _)| is_within(p)) {
        return f32::INFINITY;
    }
    match keys(item, placed) {
        0..=1 => 0.0,
        keys => ANIMATION + KEY * keys as f32,
    }
}

/// Window of three points: least and greatest.
type Windows = [[DVec2; 2]; 3];

fn window(item: &Item, placed: &[Placed], frame: usize) -> Windows {
    let reach = DVec2::splat(placed[frame].tolerance(item.tolerance));
    item.corners[frame].map(|corner| {
        let point = placed[frame].to_shape(corner);
        [point - reach, point + reach]
    })
}

/// Number of keys of the longest segments through the windows, each from where the last one ends.
fn keys(item: &Item, placed: &[Placed]) -> usize {
    let frames: Vec<usize> = (0..placed.len()).filter(|f| item.is_shown[*f]).collect();
    let Some(first) = frames.first() else {
        return 1;
    };
    let windows: Vec<Windows> = frames.iter().map(|f| window(item, placed, *f)).collect();
    if is_still(&windows) {
        return 1;
    }
    let middle = |windows: &Windows| windows.map(|[low, high]| (low + high) / 2.0);
    let (mut from, mut at) = (*first, middle(&windows[0]));
    let mut slopes = [[DVec2::NEG_INFINITY, DVec2::INFINITY]; 3];
    let (mut keys, mut i, mut last) = (1, 1, *first);
    while i < frames.len() {
        let length = (frames[i] - from) as f64;
        let mut narrowed = slopes;
        for ((slope, window), at) in narrowed.iter_mut().zip(&windows[i]).zip(at) {
            slope[0] = slope[0].max((window[0] - at) / length);
            slope[1] = slope[1].min((window[1] - at) / length);
        }
        if narrowed.iter().all(|[low, high]| low.cmple(*high).all()) {
            (slopes, last) = (narrowed, frames[i]);
            i += 1;
            continue;
        }
        keys += 1;
        let whole = (last - from) as f64;
        for (at, [low, high]) in at.iter_mut().zip(slopes) {
            *at += (low + high) / 2.0 * whole;
        }
        (from, slopes) = (last, [[DVec2::NEG_INFINITY, DVec2::INFINITY]; 3]);
    }
    keys + 1
}

fn is_still(windows: &[Windows]) -> bool {
    (0..3).all(|c| {
        let low = windows
            .iter()
            .map(|w| w[c][0])
            .fold(DVec2::NEG_INFINITY, DVec2::max);
        let high = windows
            .iter()
            .map(|w| w[c][1])
            .fold(DVec2::INFINITY, DVec2::min);
        low.cmple(high).all()
    })
}
