//! Error of blended and of stepped palettes, measured on the skin against evaluated ones.
//!
//! The error at a time is measured per vertex, as `docs/metrics.md` defines it for levels. Between
//! two times of the grid the true trajectory of a vertex is curved; its curvature is estimated from
//! the time half-way and added, so that the stated error holds at any time. The percentile is that
//! of a sample, the maximum that of every vertex.
//!
//! Of palettes that are shown as they are the nearest is shown. They are at ticks of their grid, so what
//! is shown changes at ticks and at half ticks only; there both the one before and the one after count.
//!
//! Levels that share palettes are measured together, since the matrices of a coarser one are the first of a
//! finer one's.

use super::keys::{Ticks, evaluated};
use super::level_error::LevelError;
use super::looks::{Looks, ShownError};
use super::skins::{Skins, matrix};
use articula_core::{
    Backend, BlendRecord, ClipSet, Mismatch, PaletteMap, PaletteRows, PoseCache, f32_from_half,
};
use glam::Affine3A;
use std::ops::Range;

/// Number of half ticks that are looked at together; even, so that it ends at a tick.
const BLOCK_HALVES: usize = 256;

/// A blend of cached poses that shows a level of a clip at a time in seconds.
pub(super) type BlendAt =
    fn(&PoseCache, clip: usize, level: usize, secs: f32) -> Option<BlendRecord>;

/// Errors of blended palettes of one clip at levels that share them.
pub(super) fn measure_blends(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    (skins, levels): (&Skins, Range<usize>),
    blend_at: BlendAt,
) -> Result<Vec<ShownError>, Mismatch> {
    let level = levels.start;
    let record = |half: usize| {
        let record = blend_at(cache, clip, level, ticks.secs(half));
        [record.unwrap_or_default(); 2]
    };
    shown_errors(cache, clips, (clip, ticks), map, (skins, levels), record)
}

/// Errors of the palettes of one clip at levels that share them and show them as they are, on the grid that
/// they are at ticks of.
pub(super) fn measure_steps(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    (skins, levels): (&Skins, Range<usize>),
) -> Result<Vec<ShownError>, Mismatch> {
    let level = levels.start;
    let record = |half: usize| {
        let first = ticks
            .beside(half)
            .map(|secs| cache.nearest(clip, level, secs));
        first.map(|first| BlendRecord::of_key(first.unwrap_or_default()))
    };
    shown_errors(cache, clips, (clip, ticks), map, (skins, levels), record)
}

/// Errors of what is shown just before and just after each half tick.
fn shown_errors(
    cache: &PoseCache,
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    (skins, levels): (&Skins, Range<usize>),
    record: impl Fn(usize) -> [BlendRecord; 2],
) -> Result<Vec<ShownError>, Mismatch> {
    let (level, last) = (levels.start, ticks.halves() - 1);
    let bindings = skins.mesh(level).bindings.len();
    let mut errors: Vec<LevelError<'_>> = levels.map(|level| skins.error(level)).collect();
    let (mut looks, stride) = (Looks::new(bindings), map.len(0));
    for first in (0..last.max(1)).step_by(BLOCK_HALVES) {
        let end = last.min(first + BLOCK_HALVES);
        let shown = looks_at(first..end, &record);
        let records: Vec<BlendRecord> = shown.iter().flat_map(|(_, records)| *records).collect();
        let palettes = matrices_of(cache, level, &records);
        let truth = matrices(&evaluated(clips, (clip, ticks), map, first..end + 1)?);
        looks.clear();
        for (at, (begin, _)) in shown.iter().enumerate() {
            looks.add(
                [0, 1, 2].map(|h| &truth[((begin + h).min(end) - first) * stride..][..bindings]),
                [0, 1, 2].map(|h| &palettes[(3 * at + h) * bindings..][..bindings]),
            );
        }
        errors.iter_mut().for_each(|error| error.take(&looks));
    }
    Ok(errors.iter().map(LevelError::error).collect())
}

/// The ticks between two half ticks, each by its first half tick and with what is shown at its begin, its
/// middle and its end: twice where that changes half-way. A time alone is a tick.
fn looks_at(
    halves: Range<usize>,
    record: &impl Fn(usize) -> [BlendRecord; 2],
) -> Vec<(usize, [BlendRecord; 3])> {
    let last = halves.end;
    let mut looks = Vec::new();
    for begin in (halves.start..last.max(halves.start + 1)).step_by(2) {
        let [[_, first], middle, [end, _]] = [0, 1, 2].map(|half| record((begin + half).min(last)));
        looks.push((begin, [first, middle[0], end]));
        if middle[0] != middle[1] {
            looks.push((begin, [first, middle[1], end]));
        }
    }
    looks
}

/// Palettes given by the cache.
fn matrices_of(cache: &PoseCache, level: usize, records: &[BlendRecord]) -> Vec<Affine3A> {
    let (backend, len) = (Backend::best(), records.len() * cache.matrices(level) * 3);
    if cache.form().is_half() {
        let mut rows = vec![[0; 4]; len];
        cache.blend(level, records, backend, PaletteRows::Half(&mut rows));
        let rows: Vec<[f32; 4]> = rows.iter().map(|row| row.map(f32_from_half)).collect();
        return matrices(&rows);
    }
    let mut rows = vec![[0.0; 4]; len];
    cache.blend(level, records, backend, PaletteRows::Float(&mut rows));
    matrices(&rows)
}

fn matrices(rows: &[[f32; 4]]) -> Vec<Affine3A> {
    rows.chunks_exact(3).map(matrix).collect()
}

#[cfg(test)]
mod tests {
    use super::super::CacheOptions;
    use super::*;
    use crate::joint_lods::test_figures::{arm, moving};
    use crate::joint_lods::{JointLodOptions, merged_levels};
    use glam::{Quat, Vec3};

    /// Greatest error of skin that is at `way` in each half tick, shown at `keys` just before and after it.
    fn worst(way: &[f32], keys: &[[f32; 2]]) -> f32 {
        let mut asset = arm(1);
        asset.clips = vec![moving(1, 0, &[Quat::IDENTITY])];
        let levels = merged_levels(&asset, &JointLodOptions::default()).unwrap();
        let skins = Skins::new(&asset, &levels, &CacheOptions::default());
        // A record names the height at which it shows the skin.
        let record = |half: usize| {
            keys[half].map(|y| BlendRecord {
                blend: y,
                ..BlendRecord::default()
            })
        };
        let at = |y: f32| [Affine3A::from_translation(Vec3::Y * y)];
        let last = way.len() - 1;
        let mut looks = Looks::new(1);
        for (begin, shown) in looks_at(0..last, &record) {
            let truth = [0, 1, 2].map(|half| at(way[(begin + half).min(last)]));
            let shown = shown.map(|record| at(record.blend));
            looks.add(
                truth.each_ref().map(|p| &p[..]),
                shown.each_ref().map(|p| &p[..]),
            );
        }
        let mut error = skins.error(0);
        error.take(&looks);
        let ShownError {
            percentile_metres,
            worst_metres,
        } = error.error();
        assert!((worst_metres - percentile_metres).abs() < 1e-5);
        worst_metres
    }

    #[test]
    fn by_hand() {
        // On a parabola through (0, 0), (1, 1), (2, 4) in half ticks; shown on the chord over two ticks (four
        // half ticks): at 4 t it misses by 0, 3, 4, 3, 0. Each tick bends by 1 in its middle, half of which
        // counts.
        let way = [0.0, 1.0, 4.0, 9.0, 16.0];
        let keys = [0.0, 4.0, 8.0, 12.0, 16.0].map(|y| [y, y]);
        assert!((worst(&way, &keys) - 4.5).abs() < 1e-5);
        assert!((worst(&[1.0], &[[0.0, 0.0]]) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn steps_by_hand() {
        // All skin moves by 1 in each half tick and is shown where it is at the nearest key.
        // Keys at 0 and 2: the change is half-way in a tick.
        let way = [0.0, 1.0, 2.0];
        let error = worst(&way, &[[0.0, 0.0], [0.0, 2.0], [2.0, 2.0]]);
        assert!((error - 1.0).abs() < 1e-5);
        // Keys at 0 and 4: the change is at a tick.
        let way = [0.0, 1.0, 2.0, 3.0, 4.0];
        let keys = [[0.0, 0.0], [0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 4.0]];
        assert!((worst(&way, &keys) - 2.0).abs() < 1e-5);
        // The second key is off where it begins, or where the first one ends half-way.
        let keys = [[0.0, 0.0], [0.0, 0.0], [0.0, 9.0], [3.0, 3.0], [4.0, 4.0]];
        assert!((worst(&way, &keys) - 7.0).abs() < 1e-5);
        let keys = [[0.0, 0.0], [0.0, 9.0], [2.0, 2.0]];
        assert!((worst(&way[..3], &keys) - 8.0).abs() < 1e-5);
        let keys = [[0.0, 0.0], [9.0, 1.0], [2.0, 2.0]];
        assert!((worst(&way[..3], &keys) - 8.0).abs() < 1e-5);
    }
}
