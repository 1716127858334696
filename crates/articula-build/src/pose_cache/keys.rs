//! Selection of the key times of a clip: long spans in which linear blends stay close to the skin.

use super::skins::Skins;
use crate::beyond::points_beyond;
use crate::motion_error::runs::long_runs;
use articula_core::batch::{BatchEvaluator, BatchPose};
use articula_core::{Backend, ClipSet, Mismatch, PaletteForm, PaletteMap, PaletteRows, SMALL_PART};
use glam::Vec3;
use std::ops::Range;

/// Minimum rate of the times that may become keys.
const MIN_TICK_HZ: f32 = 120.0;

/// Ticks in a block: limits the number of poses in memory; the end of a block is a key.
const BLOCK_TICKS: usize = 2048;

/// Minimum mean distance of keys for which blending pays: two display frames at 60 Hz.
const MIN_SPAN_SECS: f64 = 2.0 / 60.0;

/// Time grid of a clip: its frames are ticks, and there are at least 120 ticks a second. Keys are
/// at ticks; straightness is tested half-way between ticks too.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ticks {
    hz: f64,
    /// Index of the last tick, at the end of the clip.
    last: usize,
    end_secs: f32,
}

impl Ticks {
    pub(super) fn new(rate_hz: f32, frames: usize, end_secs: f32) -> Self {
        let per_frame = (MIN_TICK_HZ / rate_hz).ceil().max(1.0);
        Self {
            hz: f64::from(rate_hz) * f64::from(per_frame),
            last: (frames - 1) * per_frame as usize,
            end_secs,
        }
    }

    /// The grid of a clip of one pose.
    pub(super) fn single() -> Self {
        Self::new(MIN_TICK_HZ, 1, 0.0)
    }

    /// The grid on which so many palettes, the first at 0 and the last at the end, are measured: each
    /// is at a tick.
    pub(super) fn of_steps(count: usize, end_secs: f32) -> Self {
        let spans = count.saturating_sub(1).max(1);
        let per_span = (f64::from(MIN_TICK_HZ) * f64::from(end_secs) / spans as f64).ceil();
        let per_span = (per_span as usize).max(1);
        let last = match count {
            0 | 1 => 0,
            _ => spans * per_span,
        };
        Self {
            hz: (spans * per_span) as f64 / f64::from(end_secs).max(f64::MIN_POSITIVE),
            last,
            end_secs,
        }
    }

    /// Times of so many palettes, of a grid that was made for them.
    pub(super) fn steps_secs(&self, count: usize) -> Vec<f32> {
        let half_ticks = 2 * self.last / count.saturating_sub(1).max(1);
        (0..count).map(|k| self.secs(k * half_ticks)).collect()
    }

    /// Number of half ticks, including both ends.
    pub(super) fn halves(&self) -> usize {
        2 * self.last + 1
    }

    /// Time of a half tick in seconds; every second one is a tick.
    pub(super) fn secs(&self, half: usize) -> f32 {
        if half == 2 * self.last {
            return self.end_secs;
        }
        (half as f64 / (2.0 * self.hz)) as f32
    }

    /// Times a quarter tick before and after a half tick, within the clip.
    pub(super) fn beside(&self, half: usize) -> [f32; 2] {
        let last = self.halves() - 1;
        let between = |other: usize| 0.5 * (self.secs(half) + self.secs(other.min(last)));
        [half.saturating_sub(1), half + 1].map(between)
    }

    fn pays(&self, spans: usize) -> bool {
        spans == 0 || self.last as f64 > MIN_SPAN_SECS * self.hz * spans as f64
    }
}

/// Keys of one clip at one level.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Chosen {
    pub(super) times_secs: Vec<f32>,
    /// Whether their blends follow the motion and are far enough apart.
    pub(super) follows: bool,
}

/// Full palettes at the half ticks, one after another.
pub(super) fn evaluated(
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    halves: Range<usize>,
) -> Result<Vec<[f32; 4]>, Mismatch> {
    let evaluator = BatchEvaluator::new(clips, map, PaletteForm::Matrix, Backend::best())?;
    let mut scratch = evaluator.scratch();
    let (lanes, stride) = (evaluator.lanes(), evaluator.rows(0));
    let mut rows = vec![[0.0; 4]; halves.len() * stride];
    let shown: Vec<BatchPose> = halves
        .map(|half| clips.cursor(clip, ticks.secs(half)).into())
        .collect();
    for (shown, rows) in shown
        .chunks(lanes)
        .zip(rows.chunks_mut((lanes * stride).max(1)))
    {
        evaluator.evaluate(0, shown, PaletteRows::Float(rows), &mut scratch);
    }
    Ok(rows)
}

/// Returns the keys of a clip for several levels, from one on: one list for each tolerance of each level.
pub(super) fn choose(
    clips: &ClipSet,
    (clip, ticks): (usize, &Ticks),
    map: &PaletteMap,
    skins: &mut Skins,
    (from, tolerances): (usize, &[Vec<f32>]),
) -> Result<Vec<Vec<Chosen>>, Mismatch> {
    let begun = |of: &Vec<f32>| vec![(vec![0usize], false); of.len()];
    let mut found: Vec<Vec<(Vec<usize>, bool)>> = tolerances.iter().map(begun).collect();
    let stride = map.len(0) * 3;
    for first in (0..ticks.last).step_by(BLOCK_TICKS) {
        let last = ticks.last.min(first + BLOCK_TICKS);
        let rows = evaluated(clips, (clip, ticks), map, 2 * first..2 * last + 1)?;
        for (level, found) in found.iter_mut().enumerate() {
            let skin = |half: usize| {
                let mut points = Vec::new();
                skins.points(from + level, &rows[half * stride..][..stride], &mut points);
                points
            };
            let poses: Vec<Vec<Vec3>> = (0..=2 * (last - first)).map(skin).collect();
            let drawn = skins.drawn();
            for ((keys, jumps), tolerance) in found.iter_mut().zip(&tolerances[level]) {
                let fits = |from: usize, to: usize| {
                    is_straight(&poses, drawn, 2 * from..2 * to, *tolerance)
                };
                let mut at = 0;
                for end in long_runs(last - first, fits) {
                    *jumps |= end == at + 1 && !fits(at, end);
                    keys.push(first + end);
                    at = end;
                }
            }
        }
    }
    let chosen = |(keys, jumps): (Vec<usize>, bool)| Chosen {
        follows: !jumps && ticks.pays(keys.len() - 1),
        times_secs: keys.iter().map(|tick| ticks.secs(2 * tick)).collect(),
    };
    let each = |of: Vec<(Vec<usize>, bool)>| of.into_iter().map(chosen).collect();
    Ok(found.into_iter().map(each).collect())
}

/// Whether the error of a blend between the first pose and the one at the end stays within the
/// tolerance at each pose between them: the 95th percentile over the drawn points, and half of the
/// maximum over all.
fn is_straight(poses: &[Vec<Vec3>], drawn: &[bool], span: Range<usize>, tolerance: f32) -> bool {
    let Range { start, end } = span;
    let limit = tolerance * tolerance;
    let most = limit * (SMALL_PART * SMALL_PART);
    let (a, b) = (&poses[start], &poses[end]);
    let beyond = points_beyond(drawn.iter().filter(|d| **d).count());
    (start + 1..end).all(|at| {
        let u = (at - start) as f32 / (end - start) as f32;
        let mut left = beyond;
        let ends = a.iter().zip(b).zip(&poses[at]).zip(drawn);
        ends.into_iter().all(|(((a, b), p), drawn)| {
            let squared = a.lerp(*b, u).distance_squared(*p);
            if squared > limit && *drawn {
                if left == 0 {
                    return false;
                }
                left -= 1;
            }
            squared <= most || squared.is_nan()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_a_frame_or_between_two() {
        let ticks = Ticks::new(30.0, 4, 0.1);
        assert_eq!((ticks.last, ticks.halves()), (12, 25));
        assert_eq!([0, 8, 24].map(|h| ticks.secs(h)), [0.0, 1.0 / 30.0, 0.1]);
        // A little over a twelfth of a second: one span pays, three do not.
        assert!(ticks.pays(1) && ticks.pays(2) && !ticks.pays(3));
        let single = Ticks::single();
        assert_eq!((single.halves(), single.secs(0)), (1, 0.0));
        assert!(single.pays(0));
    }

    #[test]
    fn a_twentieth_of_the_sample_may_be_off_and_no_point_by_more_than_twice() {
        // Forty points on a line, of which some leave it half-way: one alone is below the
        // percentile.
        let poses = |off: &[f32]| -> Vec<Vec<Vec3>> {
            let at = |t: usize| (0..40).map(move |p| (t, p));
            let y = |t: usize, p: usize| match t {
                1 => off.get(p).copied().unwrap_or(0.0),
                _ => 0.0,
            };
            let point = |(t, p)| Vec3::new(t as f32, y(t, p), 0.0);
            (0..=2).map(|t| at(t).map(point).collect()).collect()
        };
        let fits = |off: &[f32]| is_straight(&poses(off), &[true; 40], 0..2, 1.0);
        assert_eq!(points_beyond(40), 1);
        assert!(fits(&[1.9]) && !fits(&[2.1]) && !fits(&[1.1, 1.1]));
    }

    #[test]
    fn a_corner_bends_the_way() {
        // One point: along x for four half ticks, then along y.
        let at = |t: usize| match t {
            0..=4 => vec![Vec3::X * t as f32],
            _ => vec![Vec3::new(4.0, (t - 4) as f32, 0.0)],
        };
        let poses: Vec<_> = (0..=8).map(at).collect();
        let drawn = |span, tolerance| is_straight(&poses, &[true], span, tolerance);
        assert!(drawn(0..4, 1e-3) && drawn(4..8, 1e-3));
        assert!(!drawn(2..6, 1e-3));
        // The corner is half the diagonal of a square of side 2 off the line from (2, 0) to (4, 2).
        assert!(drawn(2..6, 1.415) && !drawn(2..6, 1.414));
        // A point outside of the sample may be off by twice the tolerance.
        let other = |span, tolerance| is_straight(&poses, &[false], span, tolerance);
        assert!(other(2..6, 0.708) && !other(2..6, 0.707));
    }
}
