//! Error bounds of each joint for the drift controller while a clip plays.

use super::levers::chain_counts;
use crate::character::Asset;
use articula_core::Libm;
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
            .map(|w| 4.0 * (0.25 * angle_between(w[0], w[1])).libm_tan())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::arm;
    use articula_core::{Track, Tracks};
    use glam::{Quat, Vec3};
    use std::f32::consts::PI;

    fn clip(joints: usize, tracks: Tracks) -> Clip {
        let rotations = tracks.rotations.iter().map(|t| t.values.len());
        let translations = tracks.translations.iter().map(|t| t.values.len());
        let frames = rotations.chain(translations).max().unwrap();
        Clip::new("c", 30.0, frames, joints, tracks).unwrap()
    }

    fn track<T>(joint: usize, values: Vec<T>) -> Track<T> {
        Track {
            target: joint as u16,
            step: false,
            values,
        }
    }

    #[test]
    fn a_joint_moves_if_any_component_does() {
        let asset = arm(7);
        let turned = |joint, from: Quat, to: Quat| track(joint, vec![from, to]);
        let still = Quat::IDENTITY;
        let tracks = Tracks {
            rotations: vec![
                turned(0, still, Quat::from_rotation_x(1.0)),
                // A component is half of a small angle, the real part near half a turn.
                turned(1, still, Quat::from_rotation_x(4e-4)),
                turned(2, still, Quat::from_rotation_y(4e-4)),
                turned(3, still, Quat::from_rotation_z(4e-4)),
                turned(
                    4,
                    Quat::from_rotation_x(PI - 3e-4),
                    Quat::from_rotation_x(PI),
                ),
                turned(5, still, Quat::from_rotation_x(1e-4)),
                track(6, vec![Quat::from_rotation_x(1.0)]),
            ],
            ..Tracks::default()
        };
        let moving = moving_joints(&asset, &clip(7, tracks));
        assert_eq!(moving.iter().collect::<Vec<_>>(), [1, 2, 3, 4]);
    }

    #[test]
    fn speeds_are_those_of_the_fastest_frame() {
        let asset = arm(4);
        let z = Quat::from_rotation_z;
        let step = |joint, values| Track {
            step: true,
            ..track(joint, values)
        };
        let tracks = Tracks {
            rotations: vec![
                track(1, vec![z(0.0), z(0.2), z(0.5)]),
                step(2, vec![z(0.0), z(0.0), z(0.1)]),
                step(3, vec![z(0.3); 3]),
            ],
            translations: vec![
                track(0, vec![Vec3::ZERO, Vec3::X * 0.1, Vec3::X * 0.3]),
                track(1, vec![Vec3::ZERO, Vec3::Y * 0.02, Vec3::Y * 0.03]),
            ],
            ..Tracks::default()
        };
        let levers = [3.5, 2.5, 1.5, 0.5];
        let found = joint_bounds(&asset, &clip(4, tracks), &levers, ChainTolerance::Whole);
        // 0.3 rad in a frame of 1/30 s are 9 rad/s at the ends; a blend is faster in its middle.
        let speeds = found.iter().map(|b| b.speed_metres_per_sec);
        let speeds: Vec<f32> = speeds.collect();
        assert!((speeds[0] - 6.0).abs() < 1e-4);
        let turning = speeds[1] - 0.6;
        assert!(
            turning > 2.5 * 9.0 && turning < 2.5 * 9.0 * 1.002,
            "{turning}"
        );
        assert_eq!(speeds[2], f32::INFINITY);
        assert_eq!(speeds[3], 0.0);
        for (bounds, lever) in found.iter().zip(levers) {
            assert_eq!((bounds.lever_metres, bounds.share), (lever, 1.0));
        }
    }

    #[test]
    fn a_chain_divides_its_tolerance() {
        let asset = arm(4);
        let turning = |joint| track(joint, vec![Quat::IDENTITY, Quat::from_rotation_z(0.1)]);
        let tracks = Tracks {
            rotations: vec![
                turning(0),
                turning(1),
                track(2, vec![Quat::from_rotation_z(0.1)]),
                turning(3),
            ],
            ..Tracks::default()
        };
        let clip = clip(4, tracks);
        let shares = |share| -> Vec<f32> {
            let found = joint_bounds(&asset, &clip, &[1.0; 4], share);
            found.iter().map(|b| b.share).collect()
        };
        // Three of the four turn.
        assert_eq!(shares(ChainTolerance::Whole), [1.0; 4]);
        let third = 1.0 / 3.0;
        assert_eq!(shares(ChainTolerance::Split), [third, third, 1.0, third]);
        let root = 1.0 / 3.0_f32.sqrt();
        assert_eq!(shares(ChainTolerance::Root), [root, root, 1.0, root]);
    }
}
