//! Facing direction of a character.

use articula_core::Libm;
use articula_core::{Articulation, ModelPose, Rig};
use glam::Vec3;

/// Returns the direction that a character faces at rest, in radians from +Z towards its left:
/// perpendicular to the line from its right to its left side. VRM 0 files face -Z, some others
/// sideways. Returns 0 (+Z) if the sides are unknown.
pub fn facing(rig: &Rig, rest: &ModelPose) -> f32 {
    facing_of(rig.articulation(), |joint| rest.position(joint))
}

/// As [`facing`], from the places of the joints at rest.
pub(crate) fn facing_of(articulation: &Articulation, place: impl Fn(usize) -> Vec3) -> f32 {
    let place = |name: &str| articulation.find(name).map(&place);
    let across = [("l_hip", "r_hip"), ("l_shoulder", "r_shoulder")]
        .into_iter()
        .filter_map(|(left, right)| Some(place(left)? - place(right)?))
        .fold(Vec3::ZERO, |sum, across| sum + across);
    let forward = across.cross(Vec3::Y);
    if forward.length() < 1e-4 {
        return 0.0;
    }
    forward.x.libm_atan2(forward.z)
}
