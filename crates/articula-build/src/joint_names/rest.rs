//! Joint transforms at rest.

use articula_core::source::Skeleton;
use glam::{Affine3A, Vec3};

/// Model-from-joint matrix of every joint at rest.
pub(super) fn matrices(skeleton: &Skeleton) -> Vec<Affine3A> {
    let mut world: Vec<Affine3A> = Vec::with_capacity(skeleton.joints.len());
    for joint in &skeleton.joints {
        let local = joint.rest.to_affine();
        world.push(joint.parent.map_or(local, |p| world[p] * local));
    }
    world
}

/// Position of every joint at rest, in model space.
pub(super) fn positions(skeleton: &Skeleton) -> Vec<Vec3> {
    matrices(skeleton)
        .iter()
        .map(|m| m.translation.into())
        .collect()
}
