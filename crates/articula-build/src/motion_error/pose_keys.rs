//! Whole-pose keys: ticks between which blended palettes follow the motion.
//!
//! Source: `docs/methods/motion-lod.md` part 6. Skinning is linear in the palette, so blending two
//! palettes moves every vertex on a straight line between the two skinned poses. Keys are chosen on
//! a grid of at least 120 Hz and tested on all of it, between the clip's own frames too; a level
//! whose spans would hardly be longer than two display frames is marked to be evaluated. A span is
//! found by doubling and halving, so that the cost is proportional to the clip's length and not
//! quadratic, and none crosses the border of a block of some thousand ticks, so that only one block
//! of poses is in memory at a time.

use super::runs::long_runs;
use super::tables::{FINEST_TOLERANCE_METRES, TOLERANCE_LEVELS, table_hashes};
use crate::character::Asset;
use crate::points::Points;
use articula_core::{Clip, PoseKeys};
use glam::Vec3;

/// Minimum rate at which straightness is tested.
const MIN_TICK_HZ: f32 = 120.0;

/// Ticks of a block: half a minute.
const BLOCK_TICKS: usize = 4096;

/// Minimum average length of the spans of a level for blending to pay off: two display frames at 60
/// Hz.
const MIN_SPAN_SECS: f32 = 2.0 / 60.0;

/// Computes whole-pose keys for every tolerance level, tested on `watched` vertices of the skin
/// chosen at random with `seed`. Root motion is included: the palette moves on straight lines too.
pub fn pose_keys(asset: &Asset, clip: &Clip, watched: usize, seed: u64) -> PoseKeys {
    let points = Points::draw(asset, watched, seed);
    let per_frame = (MIN_TICK_HZ / clip.rate_hz()).ceil().max(1.0);
    let tick_hz = clip.rate_hz() * per_frame;
    let ticks = (clip.frames() - 1) * per_frame as usize;
    let mut levels = vec![vec![0u32]; TOLERANCE_LEVELS];
    for first in (0..ticks).step_by(BLOCK_TICKS) {
        let skins: Vec<Vec<Vec3>> = (first..=ticks.min(first + BLOCK_TICKS))
            .map(|t| points.at(asset, clip, t as f64 / f64::from(tick_hz)))
            .collect();
        for (k, keys) in levels.iter_mut().enumerate() {
            let ends = straight_runs(&skins, FINEST_TOLERANCE_METRES * (1u32 << k) as f32);
            keys.extend(ends.iter().map(|end| (first + end) as u32));
        }
    }
    let pays = |keys: &Vec<u32>| {
        let spans = (keys.len() - 1) as f32;
        spans == 0.0 || ticks as f32 > MIN_SPAN_SECS * tick_hz * spans
    };
    PoseKeys {
        hashes: table_hashes(&asset.rig, clip, &asset.mesh),
        tick_hz,
        ticks: ticks as u32,
        base_metres: FINEST_TOLERANCE_METRES,
        levels: levels
            .into_iter()
            .map(|keys| pays(&keys).then_some(keys))
            .collect(),
    }
}

/// The ends of consecutive long straight runs, the last one at the end of the poses.
fn straight_runs(skins: &[Vec<Vec3>], tolerance: f32) -> Vec<usize> {
    long_runs(skins.len() - 1, |from, to| {
        is_straight(skins, from, to, tolerance)
    })
}

fn is_straight(skins: &[Vec<Vec3>], from: usize, to: usize, tolerance: f32) -> bool {
    let limit = tolerance * tolerance;
    (from + 1..to).all(|t| {
        let u = (t - from) as f32 / (to - from) as f32;
        let ends = skins[from].iter().zip(&skins[to]);
        ends.zip(&skins[t])
            .all(|((a, b), p)| a.lerp(*b, u).distance_squared(*p) <= limit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::arm;
    use articula_core::{Track, Tracks};

    /// A clip whose root is that far along x at each frame.
    fn along(rate_hz: f32, metres: &[f32]) -> Clip {
        let tracks = Tracks {
            translations: vec![Track {
                target: 0,
                step: false,
                values: metres.iter().map(|x| Vec3::X * *x).collect(),
            }],
            ..Tracks::default()
        };
        Clip::new("along", rate_hz, metres.len(), 2, tracks).unwrap()
    }

    #[test]
    fn a_stop_gets_a_key_unless_the_tolerance_hides_it() {
        let asset = arm(2);
        // 4.1 mm ahead in the first four ticks, then still. A run up to tick `e` is 4.1 · (1 - 4 / e)
        // mm off at the fourth: 0.5 mm up to 4.55, 1 mm up to 5.29, 2 mm up to 7.81, and 2.73 mm at
        // 12.
        let keys = pose_keys(&asset, &along(30.0, &[0.0, 0.0041, 0.0041, 0.0041]), 4, 1);
        assert_eq!((keys.tick_hz, keys.ticks), (120.0, 12));
        assert_eq!(keys.base_metres, 0.0005);
        for (level, keys) in keys.levels.iter().enumerate() {
            let expected: &[u32] = match level {
                0 => &[0, 4, 12],
                1 => &[0, 5, 12],
                2 => &[0, 7, 12],
                _ => &[0, 12],
            };
            assert_eq!(keys.as_deref(), Some(expected), "level {level}");
        }
        // Spans of 1/30 s on average do not pay.
        let keys = pose_keys(&asset, &along(30.0, &[0.0, 1.0, 1.0]), 4, 1);
        assert!(keys.levels.iter().all(Option::is_none));
        // The least whole number of ticks to a frame that gives 120 Hz.
        for (rate_hz, tick_hz) in [(50.0, 150.0), (120.0, 120.0), (240.0, 240.0)] {
            let keys = pose_keys(&asset, &along(rate_hz, &[0.0; 19]), 4, 1);
            assert_eq!(keys.tick_hz, tick_hz);
            assert_eq!(keys.levels[0], Some(vec![0, keys.ticks]));
        }
        let one = pose_keys(&asset, &along(30.0, &[0.0]), 4, 1);
        assert_eq!((one.ticks, one.levels[0].clone()), (0, Some(vec![0])));
    }

    #[test]
    fn blocks_end_at_keys_and_motion_goes_on_in_the_next() {
        // Still for 1099 frames, then a metre ahead in one.
        let mut metres = vec![0.0; 1101];
        metres[1100] = 1.0;
        let keys = pose_keys(&arm(2), &along(30.0, &metres), 2, 1);
        assert_eq!(keys.ticks, 4400);
        assert_eq!(keys.levels[0], Some(vec![0, 4096, 4396, 4400]));
    }

    #[test]
    fn a_corner_gets_a_key_and_straight_ways_get_none() {
        // One point: along x for eight ticks, then along y for eight.
        let path = (0..=16).map(|t| match t {
            0..=8 => vec![Vec3::X * t as f32],
            _ => vec![Vec3::new(8.0, (t - 8) as f32, 0.0)],
        });
        let skins: Vec<_> = path.collect();
        assert_eq!(straight_runs(&skins, 1e-3), [8, 16]);
        // Every tick is a corner.
        let zigzag: Vec<_> = (0..=3).map(|t| vec![Vec3::Y * (t % 2) as f32]).collect();
        assert_eq!(straight_runs(&zigzag, 1e-3), [1, 2, 3]);
        assert!(straight_runs(&zigzag[..1], 1e-3).is_empty());
    }
}
