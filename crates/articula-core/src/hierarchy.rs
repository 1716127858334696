//! Forward kinematics: from local transforms to model space.

use crate::pose::{LocalPose, ModelPose};
use crate::rig::Rig;
use glam::Affine3A;

/// Computes the model-from-joint matrix of every joint, parents first.
///
/// O(joints); does not allocate.
///
/// # Panics
/// If a pose belongs to another rig (has another number of joints).
pub fn local_to_model(rig: &Rig, local: &LocalPose, out: &mut ModelPose) {
    local_to_model_from(rig, local, Affine3A::IDENTITY, out);
}

/// Computes the matrix of every joint below a transform of the whole character, such as its
/// position in the world.
///
/// # Panics
/// If a pose belongs to another rig (has another number of joints).
pub fn local_to_model_from(
    rig: &Rig,
    local: &LocalPose,
    world_from_model: Affine3A,
    out: &mut ModelPose,
) {
    assert_eq!(
        local.rotations.len(),
        rig.len(),
        "the local pose must belong to this rig"
    );
    assert_eq!(
        out.matrices.len(),
        rig.len(),
        "the model pose must belong to this rig"
    );
    for joint in 0..rig.len() {
        let above = match rig.parent(joint) {
            Some(parent) => out.matrices[parent],
            None => world_from_model,
        };
        out.matrices[joint] = above * local.get(joint).to_affine();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::tests::rig_of;
    use glam::{Quat, Vec3};
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn a_bent_arm_by_hand() {
        // Two bones of 1 m along x; the first is rotated by 90 degrees about z, the second back.
        let rig = rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::X, 0),
            (Some(1), Vec3::X, 0),
        ]);
        let mut local = rig.rest_pose().clone();
        local.rotations[0] = Quat::from_rotation_z(FRAC_PI_2);
        local.rotations[1] = Quat::from_rotation_z(-FRAC_PI_2);
        local.scales[1] = Vec3::splat(2.0);
        let mut model = ModelPose::new(rig.len());
        local_to_model(&rig, &local, &mut model);
        assert!((model.position(1) - Vec3::Y).length() < 1e-6);
        assert!((model.position(2) - Vec3::new(2.0, 1.0, 0.0)).length() < 1e-6);
    }
}
