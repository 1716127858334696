//! Held keys with which a child cancels the error of its ancestors.
//!
//! Source: `docs/methods/motion-lod.md` 4.4. Joints are processed parents first, by the model-space
//! error of each joint under its *shown* parent; a renewed joint takes the local rotation that
//! gives it its true model-space rotation.

use articula_core::{JointSet, Rig, angle_between};
use glam::Quat;

/// Local rotations shown at each frame, and the joints renewed there.
#[derive(Debug, Clone, Default)]
pub(crate) struct ClosedLoop {
    /// `shown[frame][joint]`.
    pub shown: Vec<Vec<Quat>>,
    /// Joints renewed at each frame; none at the first.
    pub renewed: Vec<JointSet>,
}

/// Plays true local rotations (`truth[frame][joint]`) holding each of `moving` while its
/// model-space error stays within its `radians`.
pub(crate) fn closed_loop(
    rig: &Rig,
    truth: &[&[Quat]],
    moving: &JointSet,
    radians: &[f32],
) -> ClosedLoop {
    let mut out = ClosedLoop::default();
    let mut held: Vec<Quat> = truth.first().map_or_else(Vec::new, |first| first.to_vec());
    let mut true_model = held.clone();
    let mut shown_model = held.clone();
    for (frame, locals) in truth.iter().enumerate() {
        let mut renewed = JointSet::EMPTY;
        for joint in 0..rig.len() {
            let above = |models: &[Quat]| rig.parent(joint).map_or(Quat::IDENTITY, |p| models[p]);
            true_model[joint] = above(&true_model) * locals[joint];
            let parent = above(&shown_model);
            let error = angle_between(parent * held[joint], true_model[joint]);
            if frame == 0 || !moving.contains(joint) {
                held[joint] = locals[joint];
            } else if error > radians[joint] {
                held[joint] = (parent.conjugate() * true_model[joint]).normalize();
                renewed.insert(joint);
            }
            shown_model[joint] = parent * held[joint];
        }
        out.shown.push(held.clone());
        out.renewed.push(renewed);
    }
    out
}
