//! Counts of whole-pose keys that a clip needs under a limit in pixels.
//!
//! Source: `docs/methods/motion-lod.md` 11.2, by the protocol of 11.1: the clip's own frames, the
//! root's horizontal motion removed, weak perspective; at every frame between two keys the 95th
//! percentile over the sampled vertices stays within the limit at the worst azimuth. Spans are
//! greedy: each is the longest in which all frames are within the limit.
//!
//! These are counts for comparison. The keys that a crowd plays are those of
//! [`crate::motion_error::pose_keys`]: in metres, for the farthest vertex, and also tested between
//! the clip's own frames.

use super::stage::ClipEvaluator;
use articula_core::percentile;
use glam::Vec3;

/// Returns the frames at which the pose is evaluated, including the first and the last; all others
/// are interpolated linearly between their neighbours. `limit_metres` is the limit on the projected
/// error.
pub fn pose_key_frames(stage: &ClipEvaluator<'_>, limit_metres: f32) -> Vec<usize> {
    let seen = ViewedPoints::new(stage);
    let last = seen.places.len() - 1;
    let mut keys = vec![0];
    while let Some(from) = keys.last().copied().filter(|k| *k < last) {
        let fits = |to: &usize| seen.is_straight(from, *to, limit_metres);
        let reached = (from + 2..=last).take_while(fits).last();
        keys.push(reached.unwrap_or(from + 1));
    }
    keys
}

/// Returns key frames at every n-th frame and at the last one, for the largest n whose spans are
/// all within the limit.
pub fn uniform_key_frames(stage: &ClipEvaluator<'_>, limit_metres: f32) -> Vec<usize> {
    let seen = ViewedPoints::new(stage);
    let last = seen.places.len() - 1;
    let keys = |n: usize| -> Vec<usize> { (0..last).step_by(n).chain([last]).collect() };
    let fits = |n: &usize| {
        let keys = keys(*n);
        let mut spans = keys.windows(2);
        spans.all(|s| seen.is_straight(s[0], s[1], limit_metres))
    };
    let best = (2..=last.max(1)).rev().find(fits);
    keys(best.unwrap_or(1))
}

/// Positions of the sampled skin under a camera that follows the root over the ground.
struct ViewedPoints {
    views: Vec<Vec3>,
    places: Vec<Vec<Vec3>>,
}

impl ViewedPoints {
    fn new(stage: &ClipEvaluator<'_>) -> Self {
        Self {
            views: stage.view_directions().collect(),
            places: stage.places_around_root(),
        }
    }

    /// Whether every frame of a span is within a limit, for all cameras.
    fn is_straight(&self, from: usize, to: usize, limit_metres: f32) -> bool {
        (from + 1..to).all(|f| {
            let u = (f - from) as f32 / (to - from) as f32;
            self.views.iter().all(|view| {
                let ends = self.places[from].iter().zip(&self.places[to]);
                let shown = ends.map(|(a, b)| a.lerp(*b, u));
                let off = shown.zip(&self.places[f]).map(|(s, p)| s - *p);
                let mut seen: Vec<f32> = off.map(|d| (d - *view * d.dot(*view)).length()).collect();
                percentile(&mut seen, 0.95) <= limit_metres
            })
        })
    }
}
