//! Joint transforms at rest.

use articula_core::source::Skeleton;
use glam::Vec3;

/// Position of every joint at rest, in model space.
pub(super) fn positions(skeleton: &Skeleton) -> Vec<Vec3> {
    skeleton
        .model_rest()
        .iter()
        .map(|m| m.translation.into())
        .collect()
}
