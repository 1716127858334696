//! Random poses for a character without motion: every joint bent within its limits.
//!
//! Limits are round numbers below the ranges of motion that clinical tables give for adults
//! (American Academy of Orthopaedic Surgeons, Joint Motion, 1965), so that most poses are
//! plausible. Elbows and knees bend about their hinge to one side only; a character faces +Z.

use super::skin_pose::{PoseOrigin, SkinPose};
use crate::character::Asset;
use crate::split_mix::SplitMix;
use articula_core::LibmQuat;
use articula_core::{JointArticulation, ModelPose, Region, local_to_model};
use glam::{Quat, Vec3};

/// Minimum number of mapped joints for a rig to be treated as human.
const MIN_MAPPED: usize = 10;

/// Limit of a joint of an unknown kind, in degrees.
const ANY_DEGREES: f32 = 40.0;

/// Limit of a joint of a human rig that the H-Anim standard does not have, such as a twist joint or
/// a lock of hair, in degrees.
const HELPER_DEGREES: f32 = 10.0;

/// Range of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bend {
    /// About any axis, by at most this angle in radians.
    Ball(f32),
    /// About one axis in the joint's own frame, from 0 to this angle in radians.
    Hinge(Vec3, f32),
}

/// Generator of random poses.
#[derive(Debug)]
pub(super) struct Bends {
    joints: Vec<Bend>,
    random: SplitMix,
    count: usize,
}

impl Bends {
    pub(super) fn new(asset: &Asset, seed: u64) -> Self {
        let rig = &asset.rig;
        let is_human = rig.articulation().mapped() >= MIN_MAPPED;
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, rig.rest_pose(), &mut model);
        let bend = |joint: usize| {
            if rig.is_at_or_below(rig.root(), joint) {
                return Bend::Ball(0.0);
            }
            let known = &rig.articulation().joints[joint];
            let degrees = if is_human {
                limit_degrees(known)
            } else {
                ANY_DEGREES
            };
            let limit = degrees.to_radians();
            let axis = front_of_hinge(known).and_then(|front| hinge(asset, &model, joint, front));
            match axis {
                Some(axis) if is_human => Bend::Hinge(axis, limit),
                _ => Bend::Ball(limit),
            }
        };
        Self {
            joints: (0..rig.len()).map(bend).collect(),
            random: SplitMix(seed),
            count: 0,
        }
    }

    /// Returns the next pose.
    pub(super) fn next(&mut self, asset: &Asset) -> SkinPose {
        let mut pose = SkinPose::rest(asset);
        let number = self.count;
        pose.origin = PoseOrigin::Bend { number };
        self.count += 1;
        for (rotation, bend) in pose.joints.rotations.iter_mut().zip(&self.joints) {
            let turn = match bend {
                Bend::Ball(limit) => *limit * in_ball(&mut self.random),
                Bend::Hinge(axis, limit) => *axis * *limit * self.random.unit(),
            };
            if turn != Vec3::ZERO {
                *rotation = (*rotation * Quat::libm_scaled_axis(turn)).normalize();
            }
        }
        pose
    }
}

/// A random point of the unit ball, by rejection.
fn in_ball(random: &mut SplitMix) -> Vec3 {
    loop {
        let mut side = || 2.0 * random.unit() - 1.0;
        let point = Vec3::new(side(), side(), side());
        if point.length_squared() <= 1.0 {
            return point;
        }
    }
}

fn limit_degrees(joint: &JointArticulation) -> f32 {
    let Some(name) = joint.hanim.as_deref() else {
        return HELPER_DEGREES;
    };
    match name.trim_start_matches("l_").trim_start_matches("r_") {
        "shoulder" => 80.0,
        "elbow" => 120.0,
        "wrist" => 50.0,
        "hip" => 70.0,
        "knee" => 110.0,
        "ankle" => 25.0,
        "skullbase" => 25.0,
        "sternoclavicular" | "acromioclavicular" => 15.0,
        _ => match joint.region {
            Region::Hands => 45.0,
            Region::Feet => 20.0,
            Region::Face => 15.0,
            _ => 8.0,
        },
    }
}

/// Direction in which the far end of a hinge moves when it bends; `None` for other joints.
fn front_of_hinge(joint: &JointArticulation) -> Option<Vec3> {
    match joint.hanim.as_deref()? {
        "l_elbow" | "r_elbow" => Some(Vec3::Z),
        "l_knee" | "r_knee" => Some(Vec3::NEG_Z),
        _ => None,
    }
}

/// Axis, in the joint's own frame at rest, about which its first child moves towards `front`.
fn hinge(asset: &Asset, model: &ModelPose, joint: usize, front: Vec3) -> Option<Vec3> {
    let child = (0..asset.rig.len()).find(|c| asset.rig.parent(*c) == Some(joint))?;
    let along = model.position(child) - model.position(joint);
    let axis = along.try_normalize()?.cross(front);
    let (_, turned, _) = model.matrices[joint].to_scale_rotation_translation();
    let axis = turned.inverse() * axis.try_normalize()?;
    axis.is_finite().then_some(axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::small_human::small_human;
    use articula_core::angle_between;

    #[test]
    fn elbows_bend_forwards_knees_backwards_and_nobody_beyond_a_limit() {
        let asset = small_human();
        let rig = &asset.rig;
        let mut bends = Bends::new(asset, 3);
        let at = |name: &str| rig.find(name).unwrap();
        let (elbow, wrist) = (at("l_elbow"), at("l_wrist"));
        let (knee, ankle) = (at("r_knee"), at("r_ankle"));
        for _ in 0..20 {
            let pose = bends.next(asset);
            for j in 0..rig.len() {
                let turned = angle_between(pose.joints.rotations[j], rig.rest_pose().rotations[j]);
                let limit = limit_degrees(&rig.articulation().joints[j]).to_radians();
                assert!(turned <= limit + 1e-4, "{} {turned}", rig.name(j));
            }
            // Bent alone, the far end moves forwards or backwards.
            let alone = |joint: usize, end: usize| {
                let mut local = rig.rest_pose().clone();
                let mut model = ModelPose::new(rig.len());
                local_to_model(rig, &local, &mut model);
                let before = model.position(end);
                local.rotations[joint] = pose.joints.rotations[joint];
                local_to_model(rig, &local, &mut model);
                (model.position(end) - before).z
            };
            assert!(alone(elbow, wrist) >= 0.0);
            assert!(alone(knee, ankle) <= 0.0);
        }
    }
}
