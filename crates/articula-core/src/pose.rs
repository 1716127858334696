//! Poses: the transforms of all joints at one time, as one array per component.

use crate::math::Transform;
use glam::{Affine3A, Quat, Vec3};

/// Local transforms of all joints of a rig, in the rig's order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LocalPose {
    /// Offsets from the parents in metres.
    pub translations: Vec<Vec3>,
    /// Rotations relative to the parents, unit quaternions.
    pub rotations: Vec<Quat>,
    /// Scale along each axis.
    pub scales: Vec<Vec3>,
}

impl LocalPose {
    /// Returns the local transform of one joint.
    pub fn get(&self, joint: usize) -> Transform {
        Transform {
            translation: self.translations[joint],
            rotation: self.rotations[joint],
            scale: self.scales[joint],
        }
    }

    /// Sets the local transform of one joint.
    pub fn set(&mut self, joint: usize, transform: Transform) {
        self.translations[joint] = transform.translation;
        self.rotations[joint] = transform.rotation;
        self.scales[joint] = transform.scale;
    }

    /// Copies all transforms of another pose of the same rig, without allocating.
    ///
    /// # Panics
    /// If the poses have different numbers of joints.
    pub fn copy_from(&mut self, other: &Self) {
        self.translations.copy_from_slice(&other.translations);
        self.rotations.copy_from_slice(&other.rotations);
        self.scales.copy_from_slice(&other.scales);
    }
}

impl FromIterator<Transform> for LocalPose {
    fn from_iter<I: IntoIterator<Item = Transform>>(transforms: I) -> Self {
        let mut pose = Self::default();
        for t in transforms {
            pose.translations.push(t.translation);
            pose.rotations.push(t.rotation);
            pose.scales.push(t.scale);
        }
        pose
    }
}

/// Model-from-joint matrices of all joints of a rig, in the rig's order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModelPose {
    /// One matrix for each joint.
    pub matrices: Vec<Affine3A>,
}

impl ModelPose {
    /// Creates a pose of `joints` joints, all at the origin.
    pub fn new(joints: usize) -> Self {
        Self {
            matrices: vec![Affine3A::IDENTITY; joints],
        }
    }

    /// Returns the position of a joint in model space, in metres.
    pub fn position(&self, joint: usize) -> Vec3 {
        self.matrices[joint].translation.into()
    }
}
