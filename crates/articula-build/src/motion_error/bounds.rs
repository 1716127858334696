//! What the drift controller judges each joint by while a clip plays.

use super::levers::chain_counts;
use crate::character::Asset;
use articula_core::{Clip, JointErrorBounds, JointSet, angle_between};

/// How a tolerance is shared along a chain of joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChainTolerance {
    /// Every joint has the whole tolerance; errors of a chain may add up.
    #[default]
    Whole,
    /// The tolerance over the square root of the joints of the chain: errors that are
    /// independent of each other stay within it on average.
    Root,
    /// The tolerance over the number of joints of the chain: errors stay within it always.
    Split,
}

/// Joints that move in a clip by the rule of the published numbers: all but the root whose
/// rotation ranges over more than `1e-4` in any quaternion component.
pub fn moving_joints(asset: &Asset, clip: &Clip) -> JointSet {
    let mut moving: JointSet = clip
        .tracks()
        .rotations
        .iter()
        .filter(|t| {
            let range = |pick: fn(&glam::Quat) -> f32| {
                let values = t.values.iter().map(pick);
                let (lo, hi) =
                    values.fold((f32::MAX, f32::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
                hi - lo > 1e-4
            };
            range(|q| q.x) || range(|q| q.y) || range(|q| q.z) || range(|q| q.w)
        })
        .map(|t| usize::from(t.target))
        .collect();
    moving.remove(asset.rig.root());
    moving
}

/// Bounds of all joints for one clip, within one pass of it: where an open clip loops, everyone
/// is to be woken.
///
/// `levers_metres` turns the radians of each joint into metres: with the levers at rest
/// ([`rest_metres`](crate::JointLever::rest_metres)) a good estimate, with the reach in any
/// pose ([`reach_metres`](crate::JointLever::reach_metres)) a bound.
pub fn joint_bounds(
    asset: &Asset,
    clip: &Clip,
    levers_metres: &[f32],
    share: ChainTolerance,
) -> Vec<JointErrorBounds> {
    let counts = match share {
        ChainTolerance::Whole => vec![1; asset.rig.len()],
        _ => {
            // Whatever turns adds to the chain's error, the root too.
            let turning = clip
                .tracks()
                .rotations
                .iter()
                .filter(|t| t.values.len() > 1);
            let turning = turning.map(|t| usize::from(t.target)).collect();
            chain_counts(&asset.rig, &asset.mesh, &turning)
        }
    };
    let mut bounds: Vec<JointErrorBounds> = levers_metres
        .iter()
        .zip(&counts)
        .map(|(lever, count)| JointErrorBounds {
            lever_metres: *lever,
            speed_metres_per_sec: 0.0,
            share: match share {
                ChainTolerance::Whole => 1.0,
                ChainTolerance::Root => 1.0 / (*count as f32).sqrt(),
                ChainTolerance::Split => 1.0 / *count as f32,
            },
        })
        .collect();
    for track in &clip.tracks().rotations {
        // A normalised linear blend turns fastest in the middle of its interval: an interval
        // of angle a passes there at 4 tan(a / 4) a frame, a little more than its mean.
        let fastest = track
            .values
            .windows(2)
            .map(|w| 4.0 * (0.25 * angle_between(w[0], w[1])).tan())
            .fold(0.0, f32::max);
        let fastest = jumps(track.step, fastest);
        let joint = &mut bounds[usize::from(track.target)];
        joint.speed_metres_per_sec += joint.lever_metres * fastest * clip.rate_hz();
    }
    for track in &clip.tracks().translations {
        let steps = track.values.windows(2).map(|w| w[0].distance(w[1]));
        let fastest = jumps(track.step, steps.fold(0.0, f32::max));
        bounds[usize::from(track.target)].speed_metres_per_sec += fastest * clip.rate_hz();
    }
    bounds
}

/// The speed a frame of a track whose frames differ by at most `fastest`: no bound where values
/// jump.
fn jumps(step: bool, fastest: f32) -> f32 {
    if step && fastest > 0.0 {
        f32::INFINITY
    } else {
        fastest
    }
}
