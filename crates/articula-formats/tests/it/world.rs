//! Joint transforms, computed directly from a character and its first clip.

use articula_core::LocalPose;
use articula_core::source::{Character, evaluate};
use glam::{Affine3A, Vec3};

/// Returns the world matrices of all joints at a time of the first clip; at rest without one.
pub(crate) fn matrices(character: &Character, time_secs: f32) -> Vec<Affine3A> {
    let skeleton = &character.skeleton;
    let rests = || skeleton.joints.iter().map(|j| j.rest);
    let mut pose = LocalPose {
        translations: rests().map(|r| r.translation).collect(),
        rotations: rests().map(|r| r.rotation).collect(),
        scales: rests().map(|r| r.scale).collect(),
    };
    if let Some(clip) = character.clips.first() {
        evaluate::pose(clip, skeleton, time_secs, &mut pose);
    }
    let mut matrices: Vec<Affine3A> = Vec::new();
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let local = pose.get(index).to_affine();
        matrices.push(joint.parent.map_or(local, |p| matrices[p] * local));
    }
    matrices
}

/// Returns the positions of all joints, in metres.
pub(crate) fn places(character: &Character, time_secs: f32) -> Vec<Vec3> {
    let matrices = matrices(character, time_secs);
    matrices.iter().map(|m| m.translation.into()).collect()
}
