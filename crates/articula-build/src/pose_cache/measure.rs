//! Error of blended palettes, measured on the skin against evaluated ones.
//!
//! The error at a time is measured per vertex, as `docs/metrics.md` defines it for levels. Between
//! two times of the grid the true trajectory of a vertex is curved; its curvature is estimated from
//! the time half-way and added, so that the stated error holds at any time. The percentile is that
//! of a sample, the maximum that of every vertex.

use super::farthest::{BEND_SHARE, Farthest, Palettes};
use super::keys::{Ticks, evaluated};
use super::skins::Skins;
use articula_core::percentile;
use articula_core::{
    Backend, ClipSet, Mesh, Mismatch, PaletteMap, PaletteRows, PoseCache, f32_from_half,
};
use glam::{Affine3A, Vec3};

/// Number of half ticks that are evaluated at once.
const BLOCK_HALVES: usize = 512;

/// Error of one clip at one level, as the maximum over time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct BlendError {
    /// 95th percentile over vertices.
    pub(super) percentile_metres: f32,
    /// Maximum over all vertices.
    pub(super) worst_metres: f32,
}

/// State of the last three half ticks at one level: palettes, true positions of the watched vertices
/// and their errors.
struct Recent {
    palettes: [[Vec<Affine3A>; 3]; 2],
    truth: [Vec<Vec3>; 3],
    off: [Vec<f32>; 3],
    shown: Vec<Vec3>,
    lengths: Vec<f32>,
    percentile_metres: f32,
    farthest: Farthest,
}

/// Errors of one clip at every level; 0 where nothing is cached.
pub(super) fn measure(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    skins: &mut Skins,
) -> Result<Vec<BlendError>, Mismatch> {
    let all = 0..skins.levels();
    let mut recent: Vec<Recent> = all.map(|level| Recent::new(skins.mesh(level))).collect();
    let stride = map.len(0) * 3;
    for first in (0..ticks.halves()).step_by(BLOCK_HALVES) {
        let block = first..ticks.halves().min(first + BLOCK_HALVES);
        let rows = evaluated(clips, (clip, ticks), map, block.clone())?;
        for (i, half) in block.enumerate() {
            let truth = &rows[i * stride..][..stride];
            let secs = ticks.secs(half);
            for (level, recent) in recent.iter_mut().enumerate() {
                if let Some(shown) = blended(cache, clip, level, secs) {
                    recent.take(half, (skins, level), [truth, &shown]);
                }
            }
        }
    }
    Ok(recent.iter().map(Recent::error).collect())
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
    fn new(mesh: &Mesh) -> Self {
        Self {
            palettes: Default::default(),
            truth: Default::default(),
            off: Default::default(),
            shown: Vec::new(),
            lengths: Vec::new(),
            percentile_metres: 0.0,
            farthest: Farthest::new(mesh),
        }
    }

    fn error(&self) -> BlendError {
        BlendError {
            percentile_metres: self.percentile_metres,
            worst_metres: self.farthest.metres(),
        }
    }

    /// Adds a half tick with its true and its shown palette.
    fn take(&mut self, half: usize, (skins, level): (&Skins, usize), rows: [&[[f32; 4]]; 2]) {
        // A tick, the half tick after it, the next tick.
        let slot = if half == 0 { 0 } else { 2 - half % 2 };
        for (palettes, rows) in self.palettes.iter_mut().zip(rows) {
            skins.matrices(level, rows, &mut palettes[slot]);
        }
        let [true_palette, shown_palette] = &self.palettes;
        let truth = &mut self.truth[slot];
        skins.posed(level, &true_palette[slot], truth);
        skins.posed(level, &shown_palette[slot], &mut self.shown);
        let apart = truth.iter().zip(&self.shown).map(|(t, s)| t.distance(*s));
        self.off[slot].clear();
        self.off[slot].extend(apart.map(|d| if d.is_finite() { d } else { 0.0 }));
        if slot == 0 {
            self.lengths.clone_from(&self.off[0]);
            self.count((skins, level), 1);
        } else if slot == 2 {
            self.span();
            self.count((skins, level), 3);
            self.truth.swap(0, 2);
            self.off.swap(0, 2);
            self.palettes.iter_mut().for_each(|p| p.swap(0, 2));
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

    /// Counts the errors of the first half ticks of the last tick.
    fn count(&mut self, (skins, level): (&Skins, usize), halves: usize) {
        let worst = self.lengths.iter().copied().fold(0.0, f32::max);
        let [truth, shown] = &self.palettes;
        let palettes = Palettes {
            truth: &truth[..halves],
            shown: &shown[..halves],
        };
        self.farthest.add(skins.mesh(level), palettes, worst);
        let mut drawn = skins.drawn().iter();
        self.lengths.retain(|_| drawn.next().is_some_and(|d| *d));
        let percentile = percentile(&mut self.lengths, 0.95);
        self.percentile_metres = self.percentile_metres.max(percentile);
    }
}

#[cfg(test)]
mod tests {
    use super::super::CacheOptions;
    use super::*;
    use crate::joint_lods::test_figures::{arm, moving};
    use crate::joint_lods::{JointLodOptions, merged_levels};
    use glam::Quat;

    /// A palette of one translation.
    fn rows(y: f32) -> [[f32; 4]; 3] {
        [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, y],
            [0.0, 0.0, 1.0, 0.0],
        ]
    }

    #[test]
    fn by_hand() {
        let mut asset = arm(1);
        asset.clips = vec![moving(1, 0, &[Quat::IDENTITY])];
        let levels = merged_levels(&asset, &JointLodOptions::default()).unwrap();
        let skins = Skins::new(&asset, &levels, &CacheOptions::default());
        // All skin on a parabola through (0, 0), (1, 1), (2, 4) in half ticks; shown on the chord
        // over two ticks (four half ticks): at 4 t it misses by 0, 3, 4, 3, 0.
        let mut recent = Recent::new(skins.mesh(0));
        for half in 0..=4usize {
            let t = half as f32;
            recent.take(half, (&skins, 0), [&rows(t * t), &rows(4.0 * t)]);
        }
        // Each tick bends by 1 in its middle, half of which counts.
        let found = recent.error();
        assert!((found.worst_metres - 4.5).abs() < 1e-5);
        assert!((found.percentile_metres - 4.5).abs() < 1e-5);
        let mut single = Recent::new(skins.mesh(0));
        single.take(0, (&skins, 0), [&rows(1.0), &rows(0.0)]);
        assert!((single.error().worst_metres - 1.0).abs() < 1e-5);
    }
}
