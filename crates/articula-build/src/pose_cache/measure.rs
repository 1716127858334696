//! Error of blended palettes, measured on the skin against evaluated ones.
//!
//! The error at a time is measured per vertex, as `docs/metrics.md` defines it for levels. Between
//! two times of the grid the true trajectory of a vertex is curved; its curvature is estimated from
//! the time half-way and added, so that the stated error holds at any time.

use super::keys::{Ticks, evaluated};
use super::skins::Skins;
use articula_core::percentile;
use articula_core::{
    Backend, ClipSet, Mismatch, PaletteMap, PaletteRows, PoseCache, f32_from_half,
};
use glam::Vec3;

/// Number of half ticks that are evaluated at once.
const BLOCK_HALVES: usize = 512;

/// Share of the bend over one tick that is added between its half ticks: a constant curvature would
/// need a quarter.
const BEND_SHARE: f32 = 0.5;

/// Error of one clip at one level, as the maximum over time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct BlendError {
    /// 95th percentile over vertices.
    pub(super) percentile_metres: f32,
    /// Maximum over vertices.
    pub(super) worst_metres: f32,
}

/// State of the last three half ticks at one level.
#[derive(Default)]
struct Recent {
    truth: [Vec<Vec3>; 3],
    off: [Vec<f32>; 3],
    shown: Vec<Vec3>,
    lengths: Vec<f32>,
    error: BlendError,
}

/// Errors of one clip at every level; 0 where nothing is cached.
pub(super) fn measure(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    skins: &mut Skins,
) -> Result<Vec<BlendError>, Mismatch> {
    let mut recent: Vec<Recent> = (0..skins.levels()).map(|_| Recent::default()).collect();
    let stride = map.len(0) * 3;
    for first in (0..ticks.halves()).step_by(BLOCK_HALVES) {
        let block = first..ticks.halves().min(first + BLOCK_HALVES);
        let rows = evaluated(clips, (clip, ticks), map, block.clone())?;
        for (i, half) in block.enumerate() {
            let truth = &rows[i * stride..][..stride];
            let secs = ticks.secs(half);
            for (level, recent) in recent.iter_mut().enumerate() {
                let Some(rows) = blended(cache, clip, level, secs) else {
                    continue;
                };
                recent.take(half, |truth_points, shown_points| {
                    skins.points(level, truth, truth_points);
                    skins.points(level, &rows, shown_points);
                });
            }
        }
    }
    Ok(recent.iter().map(|r| r.error).collect())
}

/// Palette given by the cache.
fn blended(cache: &PoseCache, clip: usize, level: usize, secs: f32) -> Option<Vec<[f32; 4]>> {
    let records = [cache.locate(clip, level, secs)?];
    let len = cache.matrices(level) * 3;
    if cache.form().is_half() {
        let mut rows = vec![[0; 4]; len];
        cache.blend(
            level,
            &records,
            Backend::best(),
            PaletteRows::Half(&mut rows),
        );
        return Some(rows.iter().map(|row| row.map(f32_from_half)).collect());
    }
    let mut rows = vec![[0.0; 4]; len];
    cache.blend(
        level,
        &records,
        Backend::best(),
        PaletteRows::Float(&mut rows),
    );
    Some(rows)
}

impl Recent {
    /// Adds a half tick, whose true and shown points `skin` writes.
    fn take(&mut self, half: usize, skin: impl FnOnce(&mut Vec<Vec3>, &mut Vec<Vec3>)) {
        // A tick, the half tick after it, the next tick.
        let slot = if half == 0 { 0 } else { 2 - half % 2 };
        let truth = &mut self.truth[slot];
        skin(truth, &mut self.shown);
        let apart = truth.iter().zip(&self.shown).map(|(t, s)| t.distance(*s));
        self.off[slot].clear();
        self.off[slot].extend(apart.map(|d| if d.is_finite() { d } else { 0.0 }));
        if slot == 0 {
            self.lengths.clone_from(&self.off[0]);
            self.count();
        } else if slot == 2 {
            self.span();
            self.count();
            self.truth.swap(0, 2);
            self.off.swap(0, 2);
        }
    }

    /// Error of each vertex within the last tick.
    fn span(&mut self) {
        let [before, middle, after] = &self.truth;
        let [a, b, c] = &self.off;
        self.lengths.clear();
        self.lengths.extend((0..before.len()).map(|v| {
            let bend = middle[v].distance(before[v].midpoint(after[v]));
            let bend = if bend.is_finite() { bend } else { 0.0 };
            a[v].max(b[v]).max(c[v]) + BEND_SHARE * bend
        }));
    }

    fn count(&mut self) {
        let worst = self.lengths.iter().copied().fold(0.0, f32::max);
        let percentile = percentile(&mut self.lengths, 0.95);
        self.error.worst_metres = self.error.worst_metres.max(worst);
        self.error.percentile_metres = self.error.percentile_metres.max(percentile);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        // One vertex on a parabola through (0, 0), (1, 1), (2, 4) in half ticks; shown on the chord
        // over two ticks (four half ticks): at 4 t it misses by 0, 3, 4, 3, 0.
        let mut recent = Recent::default();
        for half in 0..=4usize {
            let t = half as f32;
            recent.take(half, |truth, shown| {
                *truth = vec![Vec3::Y * (t * t)];
                *shown = vec![Vec3::Y * (4.0 * t)];
            });
        }
        // Each tick bends by 1 in its middle, half of which counts.
        assert_eq!(recent.error.worst_metres, 4.5);
        assert_eq!(recent.error.percentile_metres, 4.5);
        let mut single = Recent::default();
        single.take(0, |truth, shown| {
            *truth = vec![Vec3::X];
            *shown = vec![Vec3::ZERO];
        });
        assert_eq!(single.error.worst_metres, 1.0);
    }
}
