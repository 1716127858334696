//! Whole-pose keys: ticks between which blended palettes follow the motion.
//!
//! Source: `spec/motion-lod.md` part 6. Skinning is linear in the palette, so blending two
//! palettes moves every vertex on a straight line between the two skinned poses. Keys are
//! chosen on a grid of at least 120 Hz and tested on all of it, between the clip's own frames
//! too; a level that even neighbouring ticks break is marked to be evaluated.

use super::tables::hashes;
use crate::character::Asset;
use crate::evaluate::Points;
use articula_core::clip::Clip;
use articula_core::key_table::{LADDER_BASE_METRES, LADDER_LEVELS, PoseKeys};
use glam::Vec3;

/// Least rate at which straightness is tested.
const LEAST_TICK_HZ: f32 = 120.0;

/// Keys for every level of the usual ladder. `points` is the sample of the skin that is
/// watched. Root motion is part of it: the palette moves on straight lines too.
pub fn pose_keys(asset: &Asset, clip: &Clip, points: &Points) -> PoseKeys {
    let per_frame = (LEAST_TICK_HZ / clip.rate_hz()).ceil().max(1.0);
    let tick_hz = clip.rate_hz() * per_frame;
    let ticks = (clip.frames() - 1) * per_frame as usize;
    let skins: Vec<Vec<Vec3>> = (0..=ticks)
        .map(|t| points.at(asset, clip, t as f64 / f64::from(tick_hz)))
        .collect();
    let levels = (0..LADDER_LEVELS)
        .map(|k| {
            straight_runs(
                &skins,
                LADDER_BASE_METRES * (1u32 << k) as f32,
                per_frame as usize,
            )
        })
        .collect();
    PoseKeys {
        hashes: hashes(&asset.rig, clip, &asset.mesh),
        tick_hz,
        ticks: ticks as u32,
        base_metres: LADDER_BASE_METRES,
        levels,
    }
}

/// The longest straight runs, greedily. `None` if most runs are no longer than two display
/// frames (at 60 Hz, two ticks of 120 Hz): evaluating is then as cheap and exact.
fn straight_runs(skins: &[Vec<Vec3>], tolerance: f32, per_frame: usize) -> Option<Vec<u32>> {
    let last = skins.len() - 1;
    let mut keys = vec![0u32];
    let mut at = 0;
    while at < last {
        let mut reached = at + 1;
        while reached < last && is_straight(skins, at, reached + 1, tolerance) {
            reached += 1;
        }
        keys.push(reached as u32);
        at = reached;
    }
    let least = per_frame.max(2) * (keys.len() - 1);
    (last == 0 || last > least).then_some(keys)
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

    #[test]
    fn a_corner_gets_a_key_and_straight_ways_get_none() {
        // One point: along x for eight ticks, then along y for eight.
        let path = (0..=16).map(|t| match t {
            0..=8 => vec![Vec3::X * t as f32],
            _ => vec![Vec3::new(8.0, (t - 8) as f32, 0.0)],
        });
        let skins: Vec<_> = path.collect();
        assert_eq!(straight_runs(&skins, 1e-3, 4), Some(vec![0, 8, 16]));
        // Nothing but corners: evaluate.
        let zigzag: Vec<_> = (0..=16).map(|t| vec![Vec3::Y * (t % 2) as f32]).collect();
        assert_eq!(straight_runs(&zigzag, 1e-3, 4), None);
    }
}
