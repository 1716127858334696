//! Error bounds of each joint for the drift controller while a clip plays.

use super::levers::chain_counts;
use crate::character::Asset;
use articula_core::{Clip, JointErrorBounds, JointSet, angle_between};

/// Distribution of a tolerance along a chain of joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChainTolerance {
    /// Every joint has the whole tolerance; errors of a chain may add up.
    #[default]
    Whole,
    /// The tolerance is divided by the square root of the number of joints of the chain:
    /// independent errors stay within it on average.
    Root,
    /// The tolerance is divided by the number of joints of the chain: errors always stay within it.
    Split,
}

/// Returns the joints that move in a clip: all except the root whose rotation ranges over more than
/// `1e-4` in any quaternion component, as in the published numbers.
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

/// Computes the error bounds of all joints for one pass of a clip. They do not include a jump from
/// the end of a clip to its start, which needs
/// [`DriftController::invalidate`](articula_core::DriftController::invalidate).
///
/// `levers_metres` converts the rotation of each joint to metres: with the levers at rest
/// ([`rest_metres`](crate::JointLever::rest_metres)) a good estimate, with the reach in any pose
/// ([`reach_metres`](crate::JointLever::reach_metres)) an upper bound.
pub fn joint_bounds(
    asset: &Asset,
    clip: &Clip,
    levers_metres: &[f32],
    share: ChainTolerance,
) -> Vec<JointErrorBounds> {
    let counts = match share {
        ChainTolerance::Whole => vec![1; asset.rig.len()],
        _ => {
            // Every rotating joint adds to the chain's error, the root too.
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
        // A normalised linear blend rotates fastest in the middle of its interval: for an angle a
        // per frame, 4 tan(a / 4) per frame, slightly more than its mean.
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

/// Speed per frame of a track whose frames differ by at most `fastest`; infinite where values jump.
fn jumps(step: bool, fastest: f32) -> f32 {
    if step && fastest > 0.0 {
        f32::INFINITY
    } else {
        fastest
    }
}
