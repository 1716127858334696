//! Cross-fading of two poses, joint by joint.
//!
//! Rotations use normalised linear interpolation along the shorter arc, translations and scales
//! linear interpolation, as is common in animation runtimes.

use crate::joint_set::JointSet;
use crate::math::nlerp;
use crate::pose::LocalPose;

/// Blends the `active` joints of `pose` towards `other`: weight 0 keeps them, 1 copies those of
/// `other`.
///
/// O(active joints); does not allocate.
///
/// # Panics
/// If a pose or the set belongs to another rig.
pub fn blend(pose: &mut LocalPose, other: &LocalPose, weight: f32, active: &JointSet) {
    assert_eq!(
        pose.rotations.len(),
        other.rotations.len(),
        "the poses must belong to the same rig"
    );
    for j in active.iter() {
        pose.rotations[j] = nlerp(pose.rotations[j], other.rotations[j], weight);
        pose.translations[j] = pose.translations[j].lerp(other.translations[j], weight);
        pose.scales[j] = pose.scales[j].lerp(other.scales[j], weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Transform, angle_between};
    use glam::{Quat, Vec3};

    #[test]
    fn half_way_by_hand_and_inactive_joints_stay() {
        let turned = Transform {
            translation: Vec3::X * 2.0,
            rotation: -Quat::from_rotation_y(0.4),
            scale: Vec3::splat(3.0),
        };
        let rest = LocalPose::from_iter([Transform::IDENTITY; 2]);
        let mut pose = rest.clone();
        blend(
            &mut pose,
            &LocalPose::from_iter([turned; 2]),
            0.5,
            &JointSet::first(1),
        );
        assert!(angle_between(pose.rotations[0], Quat::from_rotation_y(0.2)) < 1e-5);
        assert_eq!(pose.translations[0], Vec3::X);
        assert_eq!(pose.scales[0], Vec3::splat(2.0));
        assert_eq!(pose.get(1), rest.get(1));
    }
}
