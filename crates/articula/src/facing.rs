//! Where a figure looks.

use articula_core::{ModelPose, Rig};
use glam::Vec3;

/// Direction in which a figure looks at rest, radians from +Z to its left: square to the line from its right to its left side. Files of VRM 0
/// look along -Z, some others sideways; without known sides +Z is the front.
pub(crate) fn facing(rig: &Rig, rest: &ModelPose) -> f32 {
    let joints = &rig.articulation().joints;
    let place = |name: &str| {
        let joint = joints
            .iter()
            .position(|j| j.hanim.as_deref() == Some(name))?;
        Some(rest.position(joint))
    };
    let across = [("l_hip", "r_hip"), ("l_shoulder", "r_shoulder")]
        .into_iter()
        .filter_map(|(left, right)| Some(place(left)? - place(right)?))
        .fold(Vec3::ZERO, |sum, across| sum + across);
    let forward = across.cross(Vec3::Y);
    if forward.length() < 1e-4 {
        return 0.0;
    }
    forward.x.atan2(forward.z)
}
