//! Classification of a skeleton's rest pose.
//!
//! Source: `KHR_character_reference_pose`, values of `poseType`: arms level, at about 45 degrees,
//! or along the body. The thresholds lie half-way.

use articula_core::Libm;
use articula_core::source::Skeleton;
use glam::{Affine3A, Vec3A};

/// Returns `TPose`, `APose` or `IPose` for a skeleton with known VRM human bones, by the angle of
/// its arms at rest; `TPose` if it has no arms.
pub(super) fn pose_kind(skeleton: &Skeleton, bones: &[(usize, String)]) -> &'static str {
    let place = |bone: &str| {
        let (joint, _) = bones.iter().find(|(_, name)| name == bone)?;
        skeleton.joints.get(*joint)?;
        Some(rest_place(skeleton, *joint))
    };
    let hang = |side: &str| {
        let arm = place(&format!("{side}UpperArm"))?;
        let hand = place(&format!("{side}Hand")).or_else(|| place(&format!("{side}LowerArm")))?;
        let along = (hand - arm).try_normalize()?;
        Some((-along.y).clamp(-1.0, 1.0).libm_asin().to_degrees())
    };
    let hangs: Vec<f32> = ["left", "right"].into_iter().filter_map(hang).collect();
    let mean = hangs.iter().sum::<f32>() / hangs.len().max(1) as f32;
    match mean {
        ..22.5 => "TPose",
        22.5..67.5 => "APose",
        _ => "IPose",
    }
}

fn rest_place(skeleton: &Skeleton, joint: usize) -> Vec3A {
    let mut model = Affine3A::IDENTITY;
    let mut at = Some(joint);
    while let Some(j) = at {
        model = skeleton.joints[j].rest.to_affine() * model;
        at = skeleton.joints[j].parent;
    }
    model.translation
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::Joint;
    use glam::Vec3;

    #[test]
    fn by_how_far_the_arms_hang() {
        let joint = |parent, x, y| Joint {
            name: String::new(),
            parent,
            rest: Transform::from_translation(Vec3::new(x, y, 0.0)),
            in_skin: true,
        };
        let kind = |x, y| {
            let skeleton = Skeleton {
                joints: vec![joint(None, 5.0, 5.0), joint(Some(0), x, y)],
            };
            let bones = [(0, "leftUpperArm".to_owned()), (1, "leftHand".to_owned())];
            pose_kind(&skeleton, &bones)
        };
        assert_eq!([kind(1.0, 0.0), kind(1.0, -0.3)], ["TPose"; 2]);
        assert_eq!([kind(1.0, -1.0), kind(1.0, -0.5)], ["APose"; 2]);
        assert_eq!([kind(0.1, -1.0), kind(-0.1, -1.0)], ["IPose"; 2]);
        assert_eq!(pose_kind(&Skeleton::default(), &[]), "TPose");
    }
}
