//! Two-bone leg IK: hip and knee angles that put an ankle at a target position.

use crate::motion::{Pose, Side};
use crate::skeleton::centers;
use articula_core::hanim_table::JOINTS;
use glam::{Mat3, Quat, Vec3};

/// Target of one foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Foothold {
    /// Position of the ankle joint in model space, in metres.
    pub(crate) ankle: Vec3,
    /// Pitch of the foot in radians; positive lifts the heel.
    pub(crate) pitch: f32,
    /// Part of the pitch that the toes compensate, in radians.
    pub(crate) toes: f32,
}

/// Rotates hip, knee, ankle and toes so that the foot reaches its target; the knee points forward.
///
/// A target out of reach is approached along the line from the hip.
pub(crate) fn stand(pose: &mut Pose, side: Side, foot: Foothold) {
    let [hip, knee, ankle] = ["hip", "knee", "ankle"].map(|n| side.joint(n));
    let rest = centers();
    let (thigh, shin) = (rest[knee] - rest[hip], rest[ankle] - rest[knee]);
    let (at, _) = pose.model(hip);
    let pelvis = pose.model(JOINTS[hip].parent.unwrap_or(0)).1;
    let line = foot.ankle - at;
    let reach = (thigh.length() + shin.length()) * 0.9995;
    let length = line.length().min(reach);
    let direction = line.normalize();
    // Law of cosines: distance of the knee along the line from hip to ankle, and off it.
    let along = (length * length + thigh.length_squared() - shin.length_squared()) / (2.0 * length);
    let off = (thigh.length_squared() - along * along).max(0.0).sqrt();
    let ahead = Vec3::new(0.06 * side.sign(), 0.0, 1.0);
    let forward = (ahead - direction * ahead.dot(direction)).normalize();
    let bend = direction * along + forward * off;
    let hinge = forward.cross(direction);
    let thigh_turn = aim(thigh, bend, hinge);
    let shin_turn = aim(shin, direction * length - bend, hinge);
    let foot_turn = Quat::from_rotation_x(foot.pitch);
    pose.rotations[hip] = pelvis.inverse() * thigh_turn;
    pose.rotations[knee] = thigh_turn.inverse() * shin_turn;
    pose.rotations[ankle] = shin_turn.inverse() * foot_turn;
    pose.rotations[side.joint("metatarsal")] = Quat::from_rotation_x(-foot.toes);
}

/// Rotation that takes a bone at rest, with its hinge along -x, to a direction and hinge axis.
fn aim(bone: Vec3, to: Vec3, hinge: Vec3) -> Quat {
    let frame = |along: Vec3, hinge: Vec3| {
        let y = along.normalize();
        let x = (hinge - y * hinge.dot(y)).normalize();
        Mat3::from_cols(x, y, x.cross(y))
    };
    Quat::from_mat3(&(frame(to, hinge) * frame(bone, Vec3::Z.cross(Vec3::NEG_Y)).transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ankle_arrives_and_the_knee_points_forward() {
        for (side, z, y) in [
            (Side::Left, 0.3, 0.12),
            (Side::Right, -0.25, 0.2),
            (Side::Left, 0.0, 0.3),
        ] {
            let mut pose = Pose::rest();
            pose.turn(0, [4.0, 6.0, -3.0]);
            pose.root.y -= 0.05;
            let ankle = Vec3::new(0.1 * side.sign(), y, z);
            stand(
                &mut pose,
                side,
                Foothold {
                    ankle,
                    pitch: 0.3,
                    toes: 0.2,
                },
            );
            let [hip, knee, foot] = ["hip", "knee", "ankle"].map(|n| pose.model(side.joint(n)));
            assert!(foot.0.distance(ankle) < 1e-5);
            assert!(foot.1.dot(Quat::from_rotation_x(0.3)).abs() > 1.0 - 1e-6);
            let straight = hip.0.lerp(foot.0, 0.5);
            assert!(
                knee.0.z > straight.z,
                "the knee lies before the line from hip to ankle"
            );
        }
    }

    #[test]
    fn a_foothold_out_of_reach_is_approached_without_a_break() {
        let mut pose = Pose::rest();
        let far = Foothold {
            ankle: Vec3::new(0.1, -1.0, 0.0),
            pitch: 0.0,
            toes: 0.0,
        };
        stand(&mut pose, Side::Left, far);
        let hip = pose.model(Side::Left.joint("hip")).0;
        let ankle = pose.model(Side::Left.joint("ankle")).0;
        let line = (far.ankle - hip).normalize();
        assert!((ankle - hip).normalize().dot(line) > 0.999_99);
        assert!(pose.rotations.iter().all(|q| q.is_finite()));
    }
}
