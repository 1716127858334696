//! Joints that a joint scheme has inserted, told by their names in every rig.
//!
//! A converted file may have other names for all other joints, and its own map or the joint map of
//! its kind does not know the inserted ones. Source: `docs/methods/hanim.md` part 4.

use super::evidence::MappingEvidence;
use super::gap::UnmappedReason;
use articula_core::joint_names::{JointTarget, Side, folded};
use articula_core::source::{Joint, Skeleton};

/// The joints that schemes insert, with the joint that they are below.
const INSERTED: [(&str, &str); 2] = [("thumb0", "wrist"), ("subtalar", "ankle")];

/// Offset in metres below which a joint is where its parent is.
const SAME_PLACE: f32 = 1e-6;

/// Gives the joints with the names of inserted ones their meaning, below the joint that they belong
/// to.
pub(super) fn tell(
    skeleton: &Skeleton,
    eligible: &[bool],
    meanings: &mut [Result<JointTarget, UnmappedReason>],
    evidence: &mut [MappingEvidence],
) {
    for side in Side::BOTH {
        for (part, above) in INSERTED {
            let [name, above] = [part, above].map(|part| format!("{}_{part}", side.letter()));
            let is = |meaning: &Result<JointTarget, UnmappedReason>, wanted: &str| match meaning {
                Ok(JointTarget::Joint(joint)) => joint.name == wanted,
                _ => false,
            };
            if meanings.iter().any(|meaning| is(meaning, &name)) {
                continue;
            }
            let is_below = |joint: usize, meanings: &[Result<JointTarget, UnmappedReason>]| {
                let parent = |j: &usize| skeleton.joints[*j].parent;
                let mut path = std::iter::successors(parent(&joint), parent);
                let nearest = path.find(|j| matches!(meanings[*j], Ok(JointTarget::Joint(_))));
                nearest.is_some_and(|j| is(&meanings[j], &above))
            };
            let plain = folded(&name);
            let found = (0..meanings.len()).find(|j| {
                let is_free = !matches!(meanings[*j], Ok(JointTarget::Joint(_)));
                let is_named = folded(&skeleton.joints[*j].name) == plain;
                is_named && is_free && eligible[*j] && is_below(*j, meanings)
            });
            if let (Some(joint), Some(target)) = (found, JointTarget::standard(&name)) {
                meanings[joint] = Ok(target);
                evidence[joint] = MappingEvidence::JointMap;
            }
        }
    }
}

/// Whether a joint is one that the scheme of the thesis inserts: it has its name, and is where its
/// parent is. Elsewhere the first joint of a thumb may have this name.
pub(super) fn is_thumb_base(joint: &Joint) -> bool {
    matches!(folded(&joint.name).as_str(), "lthumb0" | "rthumb0")
        && joint.rest.translation.length() <= SAME_PLACE
}

#[cfg(test)]
mod tests {
    use crate::joint_names::test_rigs::check_map;

    #[test]
    fn inserted_joints_are_told_in_a_rig_of_other_names() {
        let mapping = check_map(
            "
mixamorig:Hips 0 1 0 = humanoid_root
 mixamorig:Spine 0 1.1 0 = vl5
  mixamorig:Neck 0 1.5 0 = vc4
   mixamorig:Head 0 1.6 0 = skullbase
  mixamorig:LeftArm 0.2 1.45 0 = l_shoulder
   mixamorig:LeftForeArm 0.5 1.45 0 = l_elbow
    mixamorig:LeftHand 0.8 1.45 0 = l_wrist
     l_thumb0 0.8 1.45 0 = l_thumb0
      mixamorig:LeftHandThumb1 0.82 1.45 0.03 = l_thumb1
  mixamorig:RightArm -0.2 1.45 0 = r_shoulder
   mixamorig:RightForeArm -0.5 1.45 0 = r_elbow
    mixamorig:RightHand -0.8 1.45 0 = r_wrist
     l_thumb0 -0.8 1.45 0 = -
 mixamorig:LeftUpLeg 0.1 0.95 0 = l_hip
  mixamorig:LeftLeg 0.1 0.5 0 = l_knee
   mixamorig:LeftFoot 0.1 0.1 0 = l_ankle
    l_subtalar 0.1 0 0.03 = l_subtalar
     mixamorig:LeftToeBase 0.1 0 0.1 = l_metatarsal
 mixamorig:RightUpLeg -0.1 0.95 0 = r_hip
  mixamorig:RightLeg -0.1 0.5 0 = r_knee
   mixamorig:RightFoot -0.1 0.1 0 = r_ankle
",
        );
        assert_eq!(mapping.articulation.profile, "mixamo");
        let thumb = &mapping.articulation.joints[7];
        assert_eq!((thumb.level, thumb.region.to_string()), (5, "hands".into()));
    }

    /// Names of DAZ, told by their words, with an inserted joint; and thumbs that count from 0.
    #[test]
    fn words_tell_thumbs_with_and_without_an_inserted_joint() {
        let rig = |thumb: &str| {
            let human = "
hip 0 1 0 = humanoid_root
 abdomen 0 1.1 0 = vl5
  neck 0 1.5 0 = vc4
   head 0 1.6 0 = skullbase
  lShldr 0.2 1.45 0 = l_shoulder
   lForeArm 0.5 1.45 0 = l_elbow
    lHand 0.8 1.45 0 = l_wrist
THUMB
  rShldr -0.2 1.45 0 = r_shoulder
   rForeArm -0.5 1.45 0 = r_elbow
    rHand -0.8 1.45 0 = r_wrist
 lThigh 0.1 0.95 0 = l_hip
  lShin 0.1 0.5 0 = l_knee
   lFoot 0.1 0.1 0 = l_ankle
 rThigh -0.1 0.95 0 = r_hip
  rShin -0.1 0.5 0 = r_knee
   rFoot -0.1 0.1 0 = r_ankle
";
            check_map(&human.replace("THUMB", thumb));
        };
        rig("     l_thumb0 0.8 1.45 0 = l_thumb0
      lThumb1 0.82 1.45 0.03 = l_thumb1
       lThumb2 0.85 1.45 0.03 = l_thumb2");
        rig("     l_thumb0 0.82 1.45 0.03 = l_thumb1
      l_thumb1 0.85 1.45 0.03 = l_thumb2
       l_thumb2 0.87 1.45 0.03 = l_thumb3");
    }
}
