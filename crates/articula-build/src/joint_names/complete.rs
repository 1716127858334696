//! Joints that must be there, found in the tree where their names tell nothing.
//!
//! Between a hip and an ankle there is a knee, and above a head's neck a head. A joint is taken only
//! if it has no meaning of its own; of several, the one that divides the limb most evenly at rest.

use super::evidence::MappingEvidence;
use super::gap::UnmappedReason;
use super::rest;
use articula_core::joint_names::JointTarget;
use articula_core::source::Skeleton;
use glam::Vec3;

/// Limits of the length of a limb's lower segment, as a share of its upper one.
const SHARES: [f32; 2] = [0.5, 1.6];

const LIMBS: [[&str; 3]; 2] = [["hip", "knee", "ankle"], ["shoulder", "elbow", "wrist"]];

/// Completes limbs, neck and head.
pub(super) fn complete(
    skeleton: &Skeleton,
    eligible: &[bool],
    meanings: &mut [Result<JointTarget, UnmappedReason>],
    evidence: &mut [MappingEvidence],
) {
    let mut tree = Tree {
        skeleton,
        eligible,
        places: rest::positions(skeleton),
        meanings,
        evidence,
    };
    for limb in LIMBS {
        for sides in [["l", "r"], ["r", "l"]] {
            tree.limb(limb.map(|part| sides.map(|side| format!("{side}_{part}"))));
        }
    }
    tree.head();
}

struct Tree<'a> {
    skeleton: &'a Skeleton,
    eligible: &'a [bool],
    places: Vec<Vec3>,
    meanings: &'a mut [Result<JointTarget, UnmappedReason>],
    evidence: &'a mut [MappingEvidence],
}

impl Tree<'_> {
    /// Completes a limb; each joint is given by its name and that of its counterpart.
    fn limb(&mut self, [upper, middle, end]: [[String; 2]; 3]) {
        let [own_upper, own_middle, own_end] = [&upper, &middle, &end].map(|n| self.named(&n[0]));
        let (name, joint) = match (own_upper, own_middle, own_end) {
            (Some(u), None, Some(e)) => (&middle[0], self.evenly(u, e)),
            (None, Some(m), Some(e)) => {
                let others = [self.named(&upper[1]), self.named(&middle[1])];
                (&upper[0], self.above_limb(m, e, others))
            }
            (Some(u), Some(m), None) => (&end[0], self.below_limb(u, m)),
            _ => return,
        };
        if let Some(joint) = joint {
            self.set(joint, name);
        }
    }

    fn set(&mut self, joint: usize, name: &str) {
        if let Some(target) = JointTarget::standard(name) {
            self.meanings[joint] = Ok(target);
            self.evidence[joint] = MappingEvidence::Tree;
        }
    }

    fn named(&self, name: &str) -> Option<usize> {
        let is_it = |m: &Result<JointTarget, UnmappedReason>| matches!(m, Ok(JointTarget::Joint(joint)) if joint.name == name);
        self.meanings.iter().position(is_it)
    }

    fn is_free(&self, joint: usize) -> bool {
        self.eligible[joint] && self.meanings[joint] == Err(UnmappedReason::NoEntry)
    }

    fn above(&self, joint: usize) -> impl Iterator<Item = usize> {
        let parent = |j: &usize| self.skeleton.joints[*j].parent;
        std::iter::successors(parent(&joint), parent)
    }

    fn holds(&self, above: usize, joint: usize) -> bool {
        joint == above || self.above(joint).any(|j| j == above)
    }

    fn apart(&self, a: usize, b: usize) -> f32 {
        self.places[a].distance(self.places[b])
    }

    /// The free joint between two that divides their distance most evenly.
    fn evenly(&self, upper: usize, end: usize) -> Option<usize> {
        if !self.holds(upper, end) {
            return None;
        }
        let between = self.above(end).take_while(|j| *j != upper);
        let uneven = |j: usize| (self.apart(upper, j) - self.apart(j, end)).abs();
        between
            .filter(|j| self.is_free(*j))
            .min_by(|a, b| uneven(*a).total_cmp(&uneven(*b)))
    }

    /// The free joint above a middle joint, on its own branch, that makes the upper segment as long
    /// as the lower one.
    fn above_limb(&self, middle: usize, end: usize, others: [Option<usize>; 2]) -> Option<usize> {
        let lower = self.apart(middle, end);
        let other = others.into_iter().flatten().next()?;
        let own = self.above(middle).take_while(|j| !self.holds(*j, other));
        let uneven = |j: usize| (self.apart(j, middle) - lower).abs();
        own.filter(|j| self.is_free(*j))
            .min_by(|a, b| uneven(*a).total_cmp(&uneven(*b)))
    }

    /// The only free child of a middle joint at the distance of a limb's end.
    fn below_limb(&self, upper: usize, middle: usize) -> Option<usize> {
        let length = self.apart(upper, middle);
        self.only_child(middle, |j| {
            let share = self.apart(middle, j) / length;
            self.is_free(j) && (SHARES[0]..=SHARES[1]).contains(&share)
        })
    }

    fn children(&self, of: usize) -> Vec<usize> {
        let joints = self.skeleton.joints.iter().enumerate();
        let children = joints.filter(|(_, joint)| joint.parent == Some(of));
        children.map(|(j, _)| j).collect()
    }

    /// The only child that fits.
    fn only_child(&self, of: usize, fits: impl Fn(usize) -> bool) -> Option<usize> {
        let mut fitting = self.children(of).into_iter().filter(|j| fits(*j));
        fitting.next().filter(|_| fitting.next().is_none())
    }

    /// The joint where the arms part. In a rig whose arms do not hang from the spine it is the highest
    /// joint of the spine that is not above them.
    fn chest(&self, left: usize, right: usize) -> Option<usize> {
        let parting = self.above(left).find(|j| self.holds(*j, right))?;
        let hips = self.named("humanoid_root");
        let Some(hips) = hips.filter(|hips| *hips != parting && self.holds(parting, *hips)) else {
            return Some(parting);
        };
        let shoulders = 0.5 * (self.places[left].y + self.places[right].y);
        let mut chest = hips;
        let is_next = |tree: &Self, j: usize| {
            tree.meanings[j] == Ok(JointTarget::Spine) && tree.places[j].y <= shoulders
        };
        while let Some(next) = self.only_child(chest, |j| is_next(self, j)) {
            chest = next;
        }
        Some(chest)
    }

    /// Completes neck and head above the joint where the arms part.
    fn head(&mut self) {
        if self.named("skullbase").is_some() {
            return;
        }
        let [Some(left), Some(right)] = ["l_shoulder", "r_shoulder"].map(|n| self.named(n)) else {
            return;
        };
        let Some(chest) = self.chest(left, right) else {
            return;
        };
        let is_arm = |tree: &Self, j: usize| tree.holds(j, left) || tree.holds(j, right);
        let is_spine = |tree: &Self, j: usize| tree.meanings[j] == Ok(JointTarget::Spine);
        if let Some(neck) = self.named("vc4") {
            if let Some(head) = self.only_child(neck, |j| self.is_free(j)) {
                self.set(head, "skullbase");
            }
            return;
        }
        let mut branches = self.children(chest);
        branches.retain(|j| self.eligible[*j] && !is_arm(self, *j));
        let spine = branches.iter().copied().find(|j| is_spine(self, *j));
        let only = match branches[..] {
            [only] => Some(only),
            _ => None,
        };
        let continues = |tree: &Self, j: usize| match spine {
            Some(_) => is_spine(tree, j),
            None => tree.is_free(j) && tree.places[j].y > tree.places[chest].y,
        };
        let Some(first) = spine.or(only).filter(|j| continues(self, *j)) else {
            return;
        };
        let mut chain = vec![first];
        while let Some(next) = self.only_child(chain[chain.len() - 1], |j| continues(self, j)) {
            chain.push(next);
        }
        // Above a free neck and head there is nothing but hair and ends.
        if spine.is_none() {
            chain.truncate(2);
        }
        for joint in &chain {
            self.meanings[*joint] = Err(UnmappedReason::Duplicate);
        }
        if chain.len() > 1 {
            self.set(chain[0], "vc4");
        }
        self.set(chain[chain.len() - 1], "skullbase");
    }
}

#[cfg(test)]
mod tests {
    use crate::joint_names::test_rigs::{check_map, rig};
    use crate::joint_names::{DoubtReason, MappingConfidence, map};
    use articula_formats::joint_map::builtin;

    /// Rigify's deform bones, as in characters made with Blender for Godot: no joint is called a
    /// neck or a head, and limbs have segments.
    const RIGIFY: &str = "
DEF-spine 0 1 0 = humanoid_root
 DEF-pelvis.L 0 1 0 = -
 DEF-thigh.L 0.1 0.95 0 = l_hip
  DEF-thigh.L.001 0.1 0.7 0 = -
   DEF-shin.L 0.1 0.5 0 = l_knee
    DEF-shin.L.001 0.1 0.3 0 = -
     DEF-foot.L 0.1 0.1 0 = l_ankle
      DEF-toe.L 0.1 0 0.1 = l_metatarsal
 DEF-thigh.R -0.1 0.95 0 = r_hip
  DEF-thigh.R.001 -0.1 0.7 0 = -
   DEF-shin.R -0.1 0.5 0 = r_knee
    DEF-foot.R -0.1 0.1 0 = r_ankle
     DEF-toe.R -0.1 0 0.1 = r_metatarsal
 DEF-spine.001 0 1.1 0 = vl5
  DEF-spine.002 0 1.2 0 = vt10
   DEF-spine.003 0 1.3 0 = vt6
    DEF-spine.004 0 1.5 0 = vc4
     DEF-spine.005 0 1.55 0 = -
      DEF-spine.006 0 1.6 0 = skullbase
    DEF-shoulder.L 0.05 1.45 0 = l_sternoclavicular
     DEF-upper_arm.L 0.2 1.45 0 = l_shoulder
      DEF-upper_arm.L.001 0.35 1.45 0 = -
       DEF-forearm.L 0.5 1.45 0 = l_elbow
        DEF-hand.L 0.8 1.45 0 = l_wrist
         DEF-palm.01.L 0.82 1.45 0 = -
          DEF-f_index.01.L 0.9 1.45 0 = l_index1
           DEF-f_index.02.L 0.93 1.45 0 = l_index2
    DEF-shoulder.R -0.05 1.45 0 = r_sternoclavicular
     DEF-upper_arm.R -0.2 1.45 0 = r_shoulder
      DEF-forearm.R -0.5 1.45 0 = r_elbow
       DEF-hand.R -0.8 1.45 0 = r_wrist
        DEF-thumb.01.R -0.9 1.45 0 = r_thumb1
";

    #[test]
    fn deform_bones_of_rigify_have_a_neck_and_a_head() {
        let mapping = check_map(RIGIFY);
        assert_eq!(mapping.articulation.profile, "words");
        let head = rig(RIGIFY).0.find("DEF-spine.006").unwrap();
        assert_eq!(mapping.confidence(head), Some(MappingConfidence::Low));
        let doubts = mapping.doubts.iter();
        assert_eq!(doubts.clone().count(), 2, "neck and head: {doubts:?}");
    }

    /// The same deform bones without what connects them: limbs and collar bones at the root.
    const LOOSE: &str = "
rig 0 0 0 = -
 DEF-spine 0 1 0 = humanoid_root
  DEF-spine.001 0 1.1 0 = vl5
   DEF-spine.002 0 1.2 0 = vt10
    DEF-spine.003 0 1.3 0 = vt6
     DEF-spine.004 0 1.5 0 = vc4
      DEF-spine.005 0 1.55 0 = -
       DEF-spine.006 0 1.6 0 = skullbase
 DEF-shoulder.L 0.05 1.45 0 = l_sternoclavicular
 DEF-upper_arm.L 0.2 1.45 0 = l_shoulder
  DEF-forearm.L 0.5 1.45 0 = l_elbow
   DEF-hand.L 0.8 1.45 0 = l_wrist
 DEF-shoulder.R -0.05 1.45 0 = r_sternoclavicular
 DEF-upper_arm.R -0.2 1.45 0 = r_shoulder
  DEF-forearm.R -0.5 1.45 0 = r_elbow
   DEF-hand.R -0.8 1.45 0 = r_wrist
 DEF-thigh.L 0.1 0.95 0 = l_hip
  DEF-shin.L 0.1 0.5 0 = l_knee
   DEF-foot.L 0.1 0.1 0 = l_ankle
    DEF-toe.L 0.1 0 0.1 = l_metatarsal
 DEF-thigh.R -0.1 0.95 0 = r_hip
  DEF-shin.R -0.1 0.5 0 = r_knee
   DEF-foot.R -0.1 0.1 0 = r_ankle
    DEF-toe.R -0.1 0 0.1 = r_metatarsal
";

    #[test]
    fn deform_bones_with_limbs_at_the_root_are_the_same_human() {
        let mapping = check_map(LOOSE);
        assert_eq!(
            mapping.doubts.len(),
            2,
            "neck and head: {:?}",
            mapping.doubts
        );
        // Fewer joints of the spine, and hips and neck with names of their own.
        check_map(&LOOSE.replace("DEF-spine 0", "DEF-pelvis 0"));
        let names = [("DEF-spine.004", "DEF-neck"), ("DEF-spine.006", "DEF-head")];
        let named = names
            .iter()
            .fold(LOOSE.to_owned(), |t, (a, b)| t.replace(a, b));
        check_map(&named);
    }

    #[test]
    fn the_player_of_the_shooter_demo_of_godot_maps() {
        check_map(
            "
root 0 0 0 = -
 hips 0 1 0 = humanoid_root
  thigh.L 0.1 0.95 0 = l_hip
   shin.L 0.1 0.5 0 = l_knee
    foot.L 0.1 0.1 0 = l_ankle
  thigh.R -0.1 0.95 0 = r_hip
   shin.R -0.1 0.5 0 = r_knee
    foot.R -0.1 0.1 0 = r_ankle
  spine 0 1.1 0 = vl5
   spine1 0 1.3 0 = vt10
    neck.001 0 1.5 0 = vc4
     head 0 1.6 0 = skullbase
      eyelid.d.L 0 1.65 0 = -
      eyes 0 1.65 0 = -
    upper_arm.L 0.2 1.45 0 = l_shoulder
     forearm.L 0.5 1.45 0 = l_elbow
      hand.L 0.8 1.45 0 = l_wrist
    upper_arm.R -0.2 1.45 0 = r_shoulder
     forearm.R -0.5 1.45 0 = r_elbow
      hand.R -0.8 1.45 0 = r_wrist
",
        );
    }

    #[test]
    fn the_humanoid_profile_of_godot_maps() {
        let mapping = check_map(
            "
Root 0 0 0 = -
 Hips 0 1 0 = humanoid_root
  Spine 0 1.1 0 = vl5
   Chest 0 1.2 0 = vt10
    UpperChest 0 1.3 0 = vt6
     Neck 0 1.5 0 = vc4
      Head 0 1.6 0 = skullbase
       LeftEye 0.03 1.65 0.1 = l_eyeball_joint
       RightEye -0.03 1.65 0.1 = r_eyeball_joint
       Jaw 0 1.6 0.1 = temporomandibular
     LeftShoulder 0.05 1.45 0 = l_sternoclavicular
      LeftUpperArm 0.2 1.45 0 = l_shoulder
       LeftLowerArm 0.5 1.45 0 = l_elbow
        LeftHand 0.8 1.45 0 = l_wrist
         LeftThumbMetacarpal 0.85 1.45 0.05 = l_thumb1
          LeftThumbProximal 0.87 1.45 0.07 = l_thumb2
           LeftThumbDistal 0.9 1.45 0.09 = l_thumb3
         LeftIndexProximal 0.9 1.45 0 = l_index1
          LeftIndexIntermediate 0.93 1.45 0 = l_index2
           LeftIndexDistal 0.95 1.45 0 = l_index3
         LeftLittleProximal 0.9 1.45 -0.05 = l_pinky1
     RightShoulder -0.05 1.45 0 = r_sternoclavicular
      RightUpperArm -0.2 1.45 0 = r_shoulder
       RightLowerArm -0.5 1.45 0 = r_elbow
        RightHand -0.8 1.45 0 = r_wrist
  LeftUpperLeg 0.1 0.95 0 = l_hip
   LeftLowerLeg 0.1 0.5 0 = l_knee
    LeftFoot 0.1 0.1 0 = l_ankle
     LeftToes 0.1 0 0.1 = l_metatarsal
  RightUpperLeg -0.1 0.95 0 = r_hip
   RightLowerLeg -0.1 0.5 0 = r_knee
    RightFoot -0.1 0.1 0 = r_ankle
     RightToes -0.1 0 0.1 = r_metatarsal
",
        );
        assert!(mapping.doubts.is_empty(), "{:?}", mapping.doubts);
    }

    /// A rig of Mixamo's names, in which one joint of each limb has a name of its own.
    const GAPS: &str = "
Hips 0 1 0 = humanoid_root
 Spine 0 1.2 0 = vl5
  Neck 0 1.5 0 = vc4
   Kopf 0 1.6 0 = skullbase
  LeftArm 0.2 1.45 0 = l_shoulder
   LeftRuffle 0.25 1.45 0 = -
    Bork 0.5 1.45 0 = l_elbow
     LeftHand 0.8 1.45 0 = l_wrist
  Schulter 0 1.45 0 = -
   Oberarm -0.2 1.45 0 = r_shoulder
    RightForeArm -0.5 1.45 0 = r_elbow
     RightHand -0.8 1.45 0 = r_wrist
 LeftUpLeg 0.1 0.95 0 = l_hip
  Bein 0.1 0.5 0 = l_knee
   LeftFoot 0.1 0.1 0 = l_ankle
 RightUpLeg -0.1 0.95 0 = r_hip
  RightLeg -0.1 0.5 0 = r_knee
   Fuss -0.1 0.1 0 = r_ankle
    Zeh -0.1 0 0.1 = -
";

    #[test]
    fn a_joint_with_an_unknown_name_is_found_in_its_limb() {
        let mapping = check_map(GAPS);
        let (skeleton, _) = rig(GAPS);
        let named = |joint: usize| skeleton.joints[joint].name.as_str();
        let doubts = mapping.doubts.iter().map(|d| (named(d.joint), d.reason));
        let unknown = ["Kopf", "Bork", "Oberarm", "Bein", "Fuss"];
        let wanted = unknown.map(|name| (name, DoubtReason::UnknownName));
        assert_eq!(doubts.collect::<Vec<_>>(), wanted);
        for (joint, own) in skeleton.joints.iter().enumerate() {
            let low = mapping.confidence(joint) == Some(MappingConfidence::Low);
            assert_eq!(low, unknown.contains(&own.name.as_str()), "{}", own.name);
        }
    }

    #[test]
    fn names_do_not_tell_a_limb_with_two_unknown_joints() {
        let (skeleton, _) = rig(&GAPS.replace("LeftUpLeg", "Ober"));
        let mapping = map(&skeleton, builtin(), None);
        assert_eq!(mapping.articulation.profile, "shape");
    }
}
