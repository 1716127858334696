//! Mean pose of a rig, in which merged joints are shown.
//!
//! Source: `docs/methods/motion-lod.md` part 8. Rotations are averaged as in Markley, Cheng,
//! Crassidis and Oshman (Averaging Quaternions, 2007): the principal eigenvector of the summed
//! outer products, for which `q` and `-q` are the same rotation.

use super::moments::{pose_of, share_frames, spread_frames};
use crate::character::Asset;
use articula_core::{LocalPose, Transform, same_hemisphere};
use glam::{DMat4, DVec3, DVec4, Quat, Vec3};

/// A clip is weighted by its duration up to this value, so that a long one does not dominate.
const WHOLE_WEIGHT_SECS: f32 = 1.0;

/// Minimum weight, so that a clip of a single pose still counts.
const MIN_WEIGHT_SECS: f32 = 1.0 / 30.0;

/// Maximum number of poses that are averaged, over all clips.
const MAX_POSES: usize = 2048;

/// Returns the mean pose of a character over all its clips, or the rest pose without clips.
///
/// A clip is weighted by its duration, up to one second. A joint that no clip moves keeps its
/// transform bit for bit. O(joints).
///
/// # Panics
/// If a clip belongs to another rig.
pub fn mean_pose(asset: &Asset) -> LocalPose {
    let rest = asset.rig.rest_pose();
    let mut means: Vec<Mean> = (0..rest.rotations.len())
        .map(|j| Mean::new(rest.get(j)))
        .collect();
    let counts = share_frames(&asset.clips, MAX_POSES);
    for (clip, count) in asset.clips.iter().zip(counts) {
        let secs = clip.duration_secs();
        let weight = secs.clamp(MIN_WEIGHT_SECS, WHOLE_WEIGHT_SECS);
        let frames = spread_frames(clip.frames(), count);
        let share = f64::from(weight) / frames.len() as f64;
        for frame in frames {
            let pose = pose_of(asset, clip, frame);
            for (joint, mean) in means.iter_mut().enumerate() {
                mean.add(pose.get(joint), share);
            }
        }
    }
    means.iter().map(Mean::get).collect()
}

/// Running sums for one joint.
struct Mean {
    rest: Transform,
    first: Option<Transform>,
    moves: bool,
    weight: f64,
    translation: DVec3,
    scale: DVec3,
    outer: DMat4,
}

impl Mean {
    fn new(rest: Transform) -> Self {
        Self {
            rest,
            first: None,
            moves: false,
            weight: 0.0,
            translation: DVec3::ZERO,
            scale: DVec3::ZERO,
            outer: DMat4::ZERO,
        }
    }

    fn add(&mut self, t: Transform, weight: f64) {
        if !t.is_finite() {
            return;
        }
        self.moves |= self.first.is_some_and(|first| first != t);
        self.first.get_or_insert(t);
        self.weight += weight;
        self.translation += t.translation.as_dvec3() * weight;
        self.scale += t.scale.as_dvec3() * weight;
        let q = DVec4::from_array(t.rotation.to_array().map(f64::from));
        self.outer += DMat4::from_cols(q * q.x, q * q.y, q * q.z, q * q.w) * weight;
    }

    fn get(&self) -> Transform {
        let Some(first) = self.first else {
            return self.rest;
        };
        if !self.moves {
            return first;
        }
        let mean = |sum: DVec3| -> Vec3 { (sum / self.weight).as_vec3() };
        Transform {
            translation: mean(self.translation),
            rotation: same_hemisphere(first.rotation, principal(self.outer, first.rotation)),
            scale: mean(self.scale),
        }
    }
}

/// Greatest change of an element by a further squaring, relative to the greatest element, at which only rounding is left.
const CONVERGED: f64 = 1e-14;

/// Returns the eigenvector of the largest eigenvalue, by repeated squaring of the matrix.
pub(crate) fn principal(outer: DMat4, fallback: Quat) -> Quat {
    let mut m = outer;
    let mut last = DMat4::ZERO;
    for _ in 0..48 {
        let size = m
            .to_cols_array()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        if size.is_nan() || size <= 0.0 {
            return fallback;
        }
        m *= 1.0 / size;
        if m.abs_diff_eq(last, CONVERGED) {
            break;
        }
        last = m;
        m *= m;
    }
    let columns = [m.x_axis, m.y_axis, m.z_axis, m.w_axis];
    let longest =
        columns.into_iter().fold(
            DVec4::ZERO,
            |a, b| if b.length() > a.length() { b } else { a },
        );
    match longest.try_normalize() {
        Some(q) => Quat::from_array(q.to_array().map(|x| x as f32)).normalize(),
        None => fallback,
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_figures::{arm, moving};
    use super::*;
    use articula_core::angle_between;

    #[test]
    fn half_way_between_two_turns_whatever_their_signs() {
        let mut asset = arm(3);
        let (a, b) = (Quat::from_rotation_z(0.2), Quat::from_rotation_z(0.8));
        asset.clips = vec![moving(3, 1, &[a, -b])];
        let mean = mean_pose(&asset);
        assert!(angle_between(mean.rotations[1], Quat::from_rotation_z(0.5)) < 1e-5);
        assert_eq!(mean.get(2), asset.rig.rest_pose().get(2));
        assert_eq!(mean.get(0), asset.rig.rest_pose().get(0));
    }

    #[test]
    fn a_long_clip_counts_as_one_of_a_second() {
        let mut asset = arm(2);
        // One second at 0 and a hundred at 1: 0.5 on average.
        asset.clips = vec![
            moving(2, 1, &[Quat::IDENTITY; 31]),
            moving(2, 1, &[Quat::from_rotation_x(1.0); 3001]),
        ];
        let mean = mean_pose(&asset);
        let half = Quat::from_rotation_x(0.5);
        assert!(angle_between(mean.rotations[1], half) < 1e-4);
    }

    #[test]
    fn no_clips_give_rest_and_opposite_turns_a_rotation() {
        let mut asset = arm(2);
        assert_eq!(mean_pose(&asset), *asset.rig.rest_pose());
        // Half a turn apart there is no mean; any unit quaternion is valid.
        let turned = Quat::from_rotation_x(std::f32::consts::PI);
        asset.clips = vec![moving(2, 1, &[Quat::IDENTITY, turned])];
        assert!(mean_pose(&asset).rotations[1].is_normalized());
        let bad = Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0);
        asset.clips = vec![moving(2, 1, &[bad, bad])];
        assert_eq!(mean_pose(&asset), *asset.rig.rest_pose());
    }
}
