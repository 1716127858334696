//! Layers: further motions on top of the base motion, on some joints.

use crate::Mismatch;
use crate::crowd::CharacterState;
use crate::joint_set::JointSet;
use crate::math::{Transform, nlerp, normalised};
use crate::pose::LocalPose;
use glam::{Quat, Vec3};

/// How a layer joins the motion below it.
#[derive(Debug, Clone, PartialEq)]
pub enum LayerMode {
    /// The pose of the layer replaces the one below, by its weight.
    Override,
    /// The difference of the layer's pose to this reference pose is added, by its weight.
    Additive(LocalPose),
}

/// A motion on top of others, with a weight for each joint.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionLayer {
    /// Clips and cross-fade of the layer.
    pub state: CharacterState,
    /// Weight of the whole layer, 0 to 1; may change in any frame. NaN counts as 0.
    pub weight: f32,
    mask: Vec<f32>,
    masked: JointSet,
    mode: LayerMode,
}

impl MotionLayer {
    /// Creates a layer from the weight of each joint.
    ///
    /// # Errors
    /// A [`Mismatch`] if a weight lies outside 0 to 1, or the reference pose has another number of
    /// joints.
    pub fn new(state: CharacterState, mask: Vec<f32>, mode: LayerMode) -> Result<Self, Mismatch> {
        for (joint, weight) in mask.iter().enumerate() {
            if !(0.0..=1.0).contains(weight) {
                let what = format!("{weight} is not from 0 to 1");
                return Err(Mismatch::new(format!("mask[{joint}]"), what));
            }
        }
        if let LayerMode::Additive(reference) = &mode
            && reference.rotations.len() != mask.len()
        {
            let what = format!(
                "{} joints, the mask has {}",
                reference.rotations.len(),
                mask.len()
            );
            return Err(Mismatch::new("mode", what));
        }
        let masked = (0..mask.len()).filter(|j| mask[*j] > 0.0).collect();
        Ok(Self {
            state,
            weight: 1.0,
            mask,
            masked,
            mode,
        })
    }

    /// Number of joints of the mask.
    pub(super) fn joints(&self) -> usize {
        self.mask.len()
    }

    /// Joints that the layer moves now.
    pub(super) fn moved(&self) -> JointSet {
        if self.weight > 0.0 {
            self.masked
        } else {
            JointSet::EMPTY
        }
    }

    /// Adds the layer's pose to the one below on some joints.
    pub(super) fn apply(&self, joints: &JointSet, layer: &LocalPose, pose: &mut LocalPose) {
        for joint in joints.iter() {
            let weight = self.weight.min(1.0) * self.mask[joint];
            let (below, over) = (pose.get(joint), layer.get(joint));
            let mixed = match &self.mode {
                LayerMode::Override => mix(below, over, weight),
                LayerMode::Additive(reference) => add(below, over, reference.get(joint), weight),
            };
            pose.set(joint, mixed);
        }
    }

    /// A morph weight with that of the layer's clip joined.
    pub(super) fn morph(&self, below: f32, over: f32) -> f32 {
        let weight = self.weight.clamp(0.0, 1.0);
        match self.mode {
            LayerMode::Override => below + (over - below) * weight,
            LayerMode::Additive(_) => below + over * weight,
        }
    }
}

fn mix(below: Transform, over: Transform, weight: f32) -> Transform {
    Transform {
        translation: below.translation.lerp(over.translation, weight),
        rotation: nlerp(below.rotation, over.rotation, weight),
        scale: below.scale.lerp(over.scale, weight),
    }
}

fn add(below: Transform, over: Transform, reference: Transform, weight: f32) -> Transform {
    let turn = reference.rotation.conjugate() * over.rotation;
    Transform {
        translation: below.translation + (over.translation - reference.translation) * weight,
        rotation: normalised(below.rotation * nlerp(Quat::IDENTITY, turn, weight)),
        scale: below.scale * (Vec3::ONE + (over.scale - reference.scale) * weight),
    }
}
