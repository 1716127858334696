//! Attachments: the transform of one joint at full detail, at every level and for hidden
//! characters.
//!
//! An attachment needs the joints above it in every frame, whatever is visible
//! (`docs/methods/motion-lod.md` part 5), so it is computed directly from the clips: O(depth), no
//! palette is read.

use crate::batch::BatchPose;
use crate::clip_set::ClipSet;
use crate::math::{Transform, nlerp};
use glam::Affine3A;

/// Returns the model-from-joint matrix of one joint of the rig at full detail.
///
/// Does not allocate.
///
/// # Panics
/// If there is no such joint.
pub fn attachment(clips: &ClipSet, shown: &BatchPose, joint: usize) -> Affine3A {
    let joint_lods = clips.joint_lods();
    let mut at = Some(joint_lods.place(joint));
    let mut model = Affine3A::IDENTITY;
    while let Some(place) = at {
        model = local(clips, shown, place).to_affine() * model;
        at = joint_lods.parents()[place].map(usize::from);
    }
    model
}

/// Local transform of the joint at a place of the LOD order.
fn local(clips: &ClipSet, shown: &BatchPose, place: usize) -> Transform {
    let from = clips.local(&shown.from, place);
    if shown.fade == 0.0 {
        return from;
    }
    let to = clips.local(&shown.to, place);
    Transform {
        translation: from.translation.lerp(to.translation, shown.fade),
        rotation: nlerp(from.rotation, to.rotation, shown.fade),
        scale: from.scale.lerp(to.scale, shown.fade),
    }
}
