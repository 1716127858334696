//! Error of blended and of stepped palettes, measured on the skin against evaluated ones.
//!
//! The error at a time is measured per vertex, as `docs/metrics.md` defines it for levels. Between
//! two times of the grid the true trajectory of a vertex is curved; its curvature is estimated from
//! the time half-way and added, so that the stated error holds at any time. The percentile is that
//! of a sample, the maximum that of every vertex.
//!
//! Of palettes that are shown as they are the nearest is shown. They are at ticks of their grid, so what
//! is shown changes at ticks and at half ticks only; there both the one before and the one after count.

use super::farthest::{BEND_SHARE, Farthest, Palettes};
use super::keys::{Ticks, evaluated};
use super::skins::Skins;
use articula_core::percentile;
use articula_core::{
    Backend, BlendRecord, ClipSet, Mesh, Mismatch, PaletteMap, PaletteRows, PoseCache,
    f32_from_half, lod_error_metres,
};
use glam::{Affine3A, Vec3};

/// Entry of a palette that is shown from the middle of a tick on.
const CHANGED: usize = 3;

/// Number of half ticks that are evaluated at once.
const BLOCK_HALVES: usize = 512;

/// Error of one clip at one level, as the maximum over time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ShownError {
    /// 95th percentile over vertices.
    pub(super) percentile_metres: f32,
    /// Maximum over all vertices.
    pub(super) worst_metres: f32,
}

impl ShownError {
    /// The larger of the percentile and half of the maximum.
    pub(super) fn judged_metres(&self) -> f32 {
        lod_error_metres(self.percentile_metres, self.worst_metres)
    }
}

/// State of the last three half ticks at one level: palettes, true positions of the watched vertices
/// and their errors. A fourth entry of what is shown is for a palette that changes half-way.
struct Recent {
    true_palettes: [Vec<Affine3A>; 3],
    shown_palettes: [Vec<Affine3A>; 4],
    truth: [Vec<Vec3>; 3],
    off: [Vec<f32>; 4],
    /// Whether the palette changes half-way.
    is_changing: bool,
    shown: Vec<Vec3>,
    lengths: Vec<f32>,
    percentile_metres: f32,
    farthest: Farthest,
}

/// Errors of the blended palettes of one clip at every level; 0 where none are cached.
pub(super) fn measure(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    skins: &mut Skins,
) -> Result<Vec<ShownError>, Mismatch> {
    let all = 0..skins.levels();
    let mut recent: Vec<Recent> = all.map(|level| Recent::new(skins.mesh(level))).collect();
    for_truth(clips, (clip, ticks), map, |half, truth| {
        for (level, recent) in recent.iter_mut().enumerate() {
            if let Some(record) = cache.locate(clip, level, ticks.secs(half)) {
                let shown = rows_of(cache, level, record);
                recent.take(half, (skins, level), truth, [&shown, &shown]);
            }
        }
    })?;
    Ok(recent.iter().map(Recent::error).collect())
}

/// Error of the palettes of one clip at one level that are shown as they are, on the grid that they
/// are at ticks of.
pub(super) fn measure_steps(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, level, ticks): (usize, usize, &Ticks),
    map: &PaletteMap,
    skins: &mut Skins,
) -> Result<ShownError, Mismatch> {
    let mut recent = Recent::new(skins.mesh(level));
    for_truth(clips, (clip, ticks), map, |half, truth| {
        let shown = ticks.beside(half).map(|secs| {
            let first = cache.nearest(clip, level, secs).unwrap_or_default();
            rows_of(cache, level, BlendRecord::of_key(first))
        });
        recent.take(half, (skins, level), truth, [&shown[0], &shown[1]]);
    })?;
    Ok(recent.error())
}

/// Calls `see` with the true palette of each half tick.
fn for_truth(
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    mut see: impl FnMut(usize, &[[f32; 4]]),
) -> Result<(), Mismatch> {
    let stride = map.len(0) * 3;
    for first in (0..ticks.halves()).step_by(BLOCK_HALVES) {
        let block = first..ticks.halves().min(first + BLOCK_HALVES);
        let rows = evaluated(clips, (clip, ticks), map, block.clone())?;
        for (i, half) in block.enumerate() {
            see(half, &rows[i * stride..][..stride]);
        }
    }
    Ok(())
}

/// Palette given by the cache.
fn rows_of(cache: &PoseCache, level: usize, record: BlendRecord) -> Vec<[f32; 4]> {
    let records = [record];
    let len = cache.matrices(level) * 3;
    if cache.form().is_half() {
        let mut rows = vec![[0; 4]; len];
        cache.blend(
            level,
            &records,
            Backend::best(),
            PaletteRows::Half(&mut rows),
        );
        return rows.iter().map(|row| row.map(f32_from_half)).collect();
    }
    let mut rows = vec![[0.0; 4]; len];
    cache.blend(
        level,
        &records,
        Backend::best(),
        PaletteRows::Float(&mut rows),
    );
    rows
}

impl Recent {
    fn new(mesh: &Mesh) -> Self {
        Self {
            true_palettes: Default::default(),
            shown_palettes: Default::default(),
            is_changing: false,
            truth: Default::default(),
            off: Default::default(),
            shown: Vec::new(),
            lengths: Vec::new(),
            percentile_metres: 0.0,
            farthest: Farthest::new(mesh),
        }
    }

    fn error(&self) -> ShownError {
        ShownError {
            percentile_metres: self.percentile_metres,
            worst_metres: self.farthest.metres(),
        }
    }

    /// Adds a half tick with its true palette, and those shown just before and just after it.
    fn take(
        &mut self,
        half: usize,
        (skins, level): (&Skins, usize),
        truth: &[[f32; 4]],
        [before, after]: [&[[f32; 4]]; 2],
    ) {
        // A tick, the half tick after it, the next tick.
        let slot = if half == 0 { 0 } else { 2 - half % 2 };
        skins.matrices(level, truth, &mut self.true_palettes[slot]);
        skins.posed(level, &self.true_palettes[slot], &mut self.truth[slot]);
        self.show((skins, level), (slot, slot), before);
        match slot {
            0 => {
                self.lengths.clone_from(&self.off[0]);
                self.count((skins, level), 1);
            }
            1 => {
                self.is_changing = before != after;
                if self.is_changing {
                    self.show((skins, level), (slot, CHANGED), after);
                }
            }
            _ => {
                self.count_tick((skins, level));
                self.truth.swap(0, 2);
                self.off.swap(0, 2);
                self.true_palettes.swap(0, 2);
                self.shown_palettes.swap(0, 2);
                if before != after {
                    self.show((skins, level), (0, 0), after);
                }
            }
        }
    }

    /// Keeps a shown palette and the errors of the watched vertices at a half tick.
    fn show(
        &mut self,
        (skins, level): (&Skins, usize),
        (half, slot): (usize, usize),
        rows: &[[f32; 4]],
    ) {
        skins.matrices(level, rows, &mut self.shown_palettes[slot]);
        skins.posed(level, &self.shown_palettes[slot], &mut self.shown);
        let pairs = self.truth[half].iter().zip(&self.shown);
        let apart = pairs.map(|(t, s)| t.distance(*s));
        self.off[slot].clear();
        self.off[slot].extend(apart.map(|d| if d.is_finite() { d } else { 0.0 }));
    }

    /// Counts the errors within a tick.
    fn count_tick(&mut self, (skins, level): (&Skins, usize)) {
        self.span();
        self.count((skins, level), 3);
        if self.is_changing {
            self.off.swap(1, CHANGED);
            self.shown_palettes.swap(1, CHANGED);
            self.span();
            self.count((skins, level), 3);
        }
    }

    /// Error of each vertex within the last tick.
    fn span(&mut self) {
        let [before, middle, after] = &self.truth;
        let [a, b, c, _] = &self.off;
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
        let palettes = Palettes {
            truth: &self.true_palettes[..halves],
            shown: &self.shown_palettes[..halves],
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
            let shown = rows(4.0 * t);
            recent.take(half, (&skins, 0), &rows(t * t), [&shown, &shown]);
        }
        // Each tick bends by 1 in its middle, half of which counts.
        let found = recent.error();
        assert!((found.worst_metres - 4.5).abs() < 1e-5);
        assert!((found.percentile_metres - 4.5).abs() < 1e-5);
        let mut single = Recent::new(skins.mesh(0));
        single.take(0, (&skins, 0), &rows(1.0), [&rows(0.0), &rows(0.0)]);
        assert!((single.error().worst_metres - 1.0).abs() < 1e-5);
    }

    #[test]
    fn steps_by_hand() {
        let mut asset = arm(1);
        asset.clips = vec![moving(1, 0, &[Quat::IDENTITY])];
        let levels = merged_levels(&asset, &JointLodOptions::default()).unwrap();
        let skins = Skins::new(&asset, &levels, &CacheOptions::default());
        // All skin moves by 1 in each half tick and is shown where it is at the nearest key.
        let found = |halves: &[f32], keys: &[[f32; 2]]| {
            let mut recent = Recent::new(skins.mesh(0));
            for (half, (t, [before, after])) in halves.iter().zip(keys).enumerate() {
                let shown = [rows(*before), rows(*after)];
                recent.take(half, (&skins, 0), &rows(*t), [&shown[0], &shown[1]]);
            }
            recent.error().worst_metres
        };
        // Keys at 0 and 2: the change is half-way in a tick.
        let way = [0.0, 1.0, 2.0];
        let error = found(&way, &[[0.0, 0.0], [0.0, 2.0], [2.0, 2.0]]);
        assert!((error - 1.0).abs() < 1e-5);
        // Keys at 0 and 4: the change is at a tick.
        let way = [0.0, 1.0, 2.0, 3.0, 4.0];
        let keys = [[0.0, 0.0], [0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 4.0]];
        assert!((found(&way, &keys) - 2.0).abs() < 1e-5);
        // The second key is off where it begins, or where the first one ends half-way.
        let keys = [[0.0, 0.0], [0.0, 0.0], [0.0, 9.0], [3.0, 3.0], [4.0, 4.0]];
        assert!((found(&way, &keys) - 7.0).abs() < 1e-5);
        let keys = [[0.0, 0.0], [0.0, 9.0], [2.0, 2.0]];
        assert!((found(&way[..3], &keys) - 8.0).abs() < 1e-5);
        let keys = [[0.0, 0.0], [9.0, 1.0], [2.0, 2.0]];
        assert!((found(&way[..3], &keys) - 8.0).abs() < 1e-5);
    }
}
