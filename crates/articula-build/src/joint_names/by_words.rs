//! Recognition of a human, or of hands alone, by the words in the joint names, where no joint map
//! fits.
//!
//! A word tells the part of the body and its side; where it may mean two joints (`shoulder` is a
//! collar bone or an upper arm, `leg` a thigh or a shin), the place in the tree decides. Names with
//! unknown words are left out, unless most joints have these words.

use super::evidence::MappingEvidence;
use super::inserted::is_thumb_base;
use super::part::{FINGERS, Part, is_known, meaning};
use super::{hand, rest, words};
use articula_core::joint_names::{JointTarget, Side};
use articula_core::source::Skeleton;

/// Name of the joint map of joints that are found by their words.
pub(super) const NAME: &str = "words";

/// Distance of the hips of a loose rig from the tops of its legs, over that of the joint that holds
/// all limbs; greatest.
const NEAR: f32 = 0.5;

/// The target of each joint with what told it.
pub(super) type Found = Vec<Option<(JointTarget, MappingEvidence)>>;

/// The target of each joint, if the words of the names are those of a human. One joint of a limb may
/// lack a known name.
pub(super) fn human(skeleton: &Skeleton, eligible: &[bool]) -> Option<Found> {
    let mut body = Body::new(skeleton, eligible);
    let limbs = Side::BOTH.map(|side| body.limbs(side));
    let [Some(left), Some(right)] = limbs else {
        return None;
    };
    body.middle([left.0, right.0], [left.1, right.1])?;
    (!body.stands_on_four()).then_some(body.found)
}

/// The target of each joint, if the words of the names are those of hands or arms, and none is of
/// another part of the body.
pub(super) fn hands(skeleton: &Skeleton, eligible: &[bool]) -> Option<Found> {
    let mut body = Body::new(skeleton, eligible);
    let is_of_body = |part: Part| {
        use Part::{Foot, Head, Hips, Jaw, Leg, Neck, Shin, Spine, Thigh, Toes};
        matches!(
            part,
            Hips | Spine | Neck | Head | Jaw | Thigh | Leg | Shin | Foot | Toes
        )
    };
    let mut parts = body.meanings.iter().flatten();
    if parts.any(|(part, _)| is_of_body(*part)) {
        return None;
    }
    body.name_the_side_of_a_lone_hand();
    for side in Side::BOTH {
        let named = |part: &str| format!("{}_{part}", side.letter());
        if body.arm(side, &named).is_none() {
            body.hand(side, &named, None);
        }
    }
    Some(body.found)
}

struct Body<'a> {
    skeleton: &'a Skeleton,
    meanings: Vec<Option<(Part, Option<Side>)>>,
    found: Found,
}

impl<'a> Body<'a> {
    fn new(skeleton: &'a Skeleton, eligible: &[bool]) -> Self {
        let mut names: Vec<Vec<String>> = Vec::with_capacity(skeleton.joints.len());
        names.extend(skeleton.joints.iter().map(|j| words::split(&j.name)));
        words::without_common(&mut names, is_known);
        let meanings = names.iter().zip(eligible).zip(&skeleton.joints);
        Self {
            skeleton,
            meanings: meanings
                .map(|((words, eligible), joint)| {
                    meaning(words).filter(|_| *eligible && !is_thumb_base(joint))
                })
                .collect(),
            found: vec![None; skeleton.joints.len()],
        }
    }

    /// Joints of these parts on a side, parents first.
    fn of(&self, side: Option<Side>, is: impl Fn(Part) -> bool) -> Vec<usize> {
        let all = self.meanings.iter().enumerate();
        let matching = all.filter(|(_, m)| m.is_some_and(|(part, own)| own == side && is(part)));
        matching.map(|(joint, _)| joint).collect()
    }

    fn is_part(&self, joint: usize, side: Option<Side>, is: impl Fn(Part) -> bool) -> bool {
        self.meanings[joint].is_some_and(|(part, own)| own == side && is(part))
    }

    /// The nearest joint above another one that is one of these parts on the same side. Of a bone
    /// that is stored in segments, such as `thigh` and `thigh.001`, the first one counts.
    fn nearest_above(
        &self,
        joint: usize,
        side: Option<Side>,
        is: impl Fn(Part) -> bool,
    ) -> Option<usize> {
        let mut found = self.above(joint).find(|j| self.is_part(*j, side, &is))?;
        let whole = self.meanings[found].map(|(part, _)| part);
        if let Some(part @ (Part::UpperArm | Part::Thigh)) = whole {
            let mut above = self.above(found);
            while let Some(next) = above
                .next()
                .filter(|j| self.is_part(*j, side, |p| p == part))
            {
                found = next;
            }
        }
        Some(found)
    }

    /// The joints above one, from its parent to the root.
    fn above(&self, joint: usize) -> impl Iterator<Item = usize> + use<'a> {
        let skeleton = self.skeleton;
        let parent = move |j: &usize| skeleton.joints[*j].parent;
        std::iter::successors(parent(&joint), parent)
    }

    fn is_below(&self, joint: usize, above: usize) -> bool {
        self.above(joint).any(|j| j == above)
    }

    /// Whether the rest pose is that of an animal: feet below the hips, hands below the knees.
    fn stands_on_four(&self) -> bool {
        let places = rest::positions(self.skeleton);
        let height = |name: &str| {
            let is_named = |found: &Option<(JointTarget, MappingEvidence)>| match found {
                Some((JointTarget::Joint(joint), _)) => joint.name == name,
                _ => false,
            };
            Some(places[self.found.iter().position(is_named)?].y)
        };
        let is_above = |a: &str, b: &str| {
            let [a, b] = [a, b].map(height);
            a.zip(b).is_some_and(|(a, b)| a > b)
        };
        ["l", "r"].iter().all(|side| {
            let [knee, ankle, wrist] = ["knee", "ankle", "wrist"].map(|j| format!("{side}_{j}"));
            is_above("humanoid_root", &ankle) && is_above(&knee, &wrist)
        })
    }

    fn set(&mut self, joint: usize, name: &str) {
        let is_ambiguous = self.meanings[joint].is_some_and(|(part, _)| part.is_ambiguous());
        let told = if is_ambiguous {
            MappingEvidence::WordsAndTree
        } else if self.meanings[joint].is_some() {
            MappingEvidence::Words
        } else {
            MappingEvidence::Tree
        };
        self.found[joint] = JointTarget::standard(name).map(|target| (target, told));
    }

    /// Names leg, arm, fingers and eye of a side; returns the highest joint of leg and arm, if at
    /// least two of the three joints of both are found.
    fn limbs(&mut self, side: Side) -> Option<(usize, usize)> {
        let named = |part: &str| format!("{}_{part}", side.letter());
        let leg = self.leg(side, &named)?;
        let arm = self.arm(side, &named)?;
        let eye = self.of(Some(side), |p| p == Part::Eye);
        if let Some(eye) = eye.first() {
            self.set(*eye, &named("eyeball_joint"));
        }
        Some((leg, arm))
    }

    fn leg(&mut self, side: Side, named: &dyn Fn(&str) -> String) -> Option<usize> {
        let own = Some(side);
        let is_thigh = |p| matches!(p, Part::Thigh | Part::Leg);
        let shins = self.of(own, |p| p == Part::Shin).into_iter();
        let shins = shins.chain(self.of(own, |p| p == Part::Leg));
        // A leg is a shin if it is below another one.
        let both = |shin| Some((Some(self.nearest_above(shin, own, is_thigh)?), Some(shin)));
        let (thigh, shin) = shins.clone().find_map(both).or_else(|| {
            let ends = self.of(own, |p| p == Part::Foot);
            self.alone(shins.collect(), &ends, own, Part::Shin, is_thigh)
        })?;
        let upper = thigh.or(shin)?;
        for (joint, name) in [(thigh, "hip"), (shin, "knee")] {
            if let Some(joint) = joint {
                self.set(joint, &named(name));
            }
        }
        let lower = shin.unwrap_or(upper);
        let feet = self.of(own, |p| matches!(p, Part::Foot | Part::Toes));
        let mut feet = feet.into_iter().filter(|j| self.is_below(*j, lower));
        let (ankle, ball) = (feet.next(), feet.next());
        if let Some(ankle) = ankle {
            self.set(ankle, &named("ankle"));
        }
        if let Some(ball) = ball {
            self.set(ball, &named("metatarsal"));
        }
        Some(upper)
    }

    /// Of a limb with one known joint above its end: that joint as the upper or the lower one. A
    /// name with two meanings is the lower joint if the end is its child.
    fn alone(
        &self,
        lowers: Vec<usize>,
        ends: &[usize],
        side: Option<Side>,
        lower: Part,
        is_upper: impl Fn(Part) -> bool,
    ) -> Option<(Option<usize>, Option<usize>)> {
        ends.iter().find_map(|end| {
            let holds = |j: &usize| self.is_below(*end, *j);
            if let Some(own) = lowers.iter().copied().find(holds) {
                let is_lower = self.is_part(own, side, |p| p == lower);
                let is_parent = self.skeleton.joints[*end].parent == Some(own);
                let is_lower = is_lower || is_parent;
                return Some(if is_lower {
                    (None, Some(own))
                } else {
                    (Some(own), None)
                });
            }
            let upper = self.nearest_above(*end, side, &is_upper)?;
            Some((Some(upper), None))
        })
    }

    fn arm(&mut self, side: Side, named: &dyn Fn(&str) -> String) -> Option<usize> {
        let own = Some(side);
        let is_upper = |p| matches!(p, Part::UpperArm | Part::Arm | Part::Shoulder);
        let is_collar = |p| matches!(p, Part::Collar | Part::Shoulder);
        let lowers = self.of(own, |p| p == Part::Forearm).into_iter();
        let lowers = lowers.chain(self.of(own, |p| p == Part::Arm));
        let both = |lower| Some((Some(self.nearest_above(lower, own, is_upper)?), Some(lower)));
        let (upper, lower) = lowers.clone().find_map(both).or_else(|| {
            let ends = self.of(own, |p| p == Part::Hand);
            let is_upper = |p| matches!(p, Part::UpperArm | Part::Arm);
            self.alone(lowers.collect(), &ends, own, Part::Forearm, is_upper)
        })?;
        let highest = upper.or(lower)?;
        let collar = self.nearest_above(highest, own, is_collar);
        if let Some(collar) = collar.or_else(|| self.loose_collar(highest, own)) {
            self.set(collar, &named("sternoclavicular"));
        }
        for (joint, name) in [(upper, "shoulder"), (lower, "elbow")] {
            if let Some(joint) = joint {
                self.set(joint, &named(name));
            }
        }
        self.hand(side, named, lower.or(upper));
        Some(highest)
    }

    /// The collar bone beside an arm that hangs from no part of the body.
    fn loose_collar(&self, arm: usize, side: Option<Side>) -> Option<usize> {
        if self.above(arm).any(|j| self.meanings[j].is_some()) {
            return None;
        }
        let collars = self.of(side, |p| matches!(p, Part::Collar | Part::Shoulder));
        let mut collars = collars
            .into_iter()
            .filter(|j| *j != arm && !self.is_below(*j, arm));
        collars.next().filter(|_| collars.next().is_none())
    }

    /// Names the hand of a side, below a joint if one is given, and its fingers.
    fn hand(&mut self, side: Side, named: &dyn Fn(&str) -> String, below: Option<usize>) {
        let own = Some(side);
        let is_there = |hand: &usize| below.is_none_or(|arm| self.is_below(*hand, arm));
        let mut hands = self.of(own, |p| p == Part::Hand).into_iter();
        if let Some(hand) = hands.find(is_there) {
            self.set(hand, &named("wrist"));
        }
        for (finger, name) in FINGERS.iter().enumerate() {
            let joints = self.of(own, |p| matches!(p, Part::Finger(f, _) if f == finger));
            let mut next = 1;
            for joint in joints {
                let palm = matches!(self.meanings[joint], Some((Part::Finger(_, true), _)));
                if palm && finger > 0 {
                    self.set(joint, &named(&format!("{name}0")));
                } else if next <= 3 {
                    self.set(joint, &named(&format!("{name}{next}")));
                    next += 1;
                }
            }
        }
    }

    /// In a rig without a side in any name of hands and fingers: gives all the side of the other
    /// names, or that of the rest pose.
    fn name_the_side_of_a_lone_hand(&mut self) {
        if self
            .meanings
            .iter()
            .flatten()
            .any(|(_, side)| side.is_some())
        {
            return;
        }
        let said = |joint: &articula_core::source::Joint| {
            words::split(&joint.name)
                .iter()
                .find_map(|w| words::side(w))
        };
        let mut said = self.skeleton.joints.iter().filter_map(said);
        let wrist = self.of(None, |p| p == Part::Hand).first().copied();
        let thumb = self.of(None, |p| matches!(p, Part::Finger(0, _)));
        let side = said.next().unwrap_or_else(|| {
            let thumb = thumb.get(1).or(thumb.first()).copied();
            hand::side_of(self.skeleton, wrist, thumb)
        });
        for (_, own) in self.meanings.iter_mut().flatten() {
            *own = Some(side);
        }
    }

    /// The hips of a rig whose limbs do not hang from them, as deform bones alone do whose controls
    /// were left out: hips, or the lowest joint of the spine, much nearer to the tops of the legs than
    /// the nameless joint that holds all limbs.
    fn loose_hips(&self, holder: usize, legs: [usize; 2]) -> Option<usize> {
        let places = rest::positions(self.skeleton);
        let tops = 0.5 * (places[legs[0]] + places[legs[1]]);
        let apart = |joint: usize| places[joint].distance(tops);
        let named = self.of(None, |p| p == Part::Hips).into_iter();
        let mut named = named.chain(self.of(None, |p| p == Part::Spine));
        let found = named.find(|j| self.is_below(*j, holder))?;
        let is_loose = self.meanings[holder].is_none() && apart(found) < NEAR * apart(holder);
        is_loose.then_some(found)
    }

    /// Names hips, spine, neck and head; `legs` and `arms` are the highest joints of the limbs.
    fn middle(&mut self, legs: [usize; 2], arms: [usize; 2]) -> Option<()> {
        let holds = |joint: usize, all: &[usize]| all.iter().all(|j| self.is_below(*j, joint));
        let limbs = [legs[0], legs[1], arms[0], arms[1]];
        let named = self.of(None, |p| p == Part::Hips);
        let by_name = named.iter().copied().rfind(|j| holds(*j, &limbs));
        // The joint where legs and arms part, whatever its name is.
        let by_tree = (0..self.skeleton.joints.len()).rfind(|j| holds(*j, &limbs));
        let loose = || self.loose_hips(by_tree?, legs);
        let hips = by_name.or_else(loose).or(by_tree)?;
        let pelvis = named
            .iter()
            .copied()
            .find(|j| *j != hips && holds(*j, &legs));
        let spine = self.of(None, |p| p == Part::Spine);
        let spine: Vec<usize> = spine.into_iter().filter(|j| *j != hips).collect();
        let head = self.of(None, |p| p == Part::Head).into_iter().next();
        let neck = self.of(None, |p| p == Part::Neck).into_iter().next();
        let jaw = self.of(None, |p| p == Part::Jaw).into_iter().next();
        self.set(hips, "humanoid_root");
        if by_name.is_none()
            && let Some((_, told)) = &mut self.found[hips]
        {
            *told = (*told).max(MappingEvidence::WordsAndTree);
        }
        for joint in spine {
            self.found[joint] = Some((JointTarget::Spine, MappingEvidence::Words));
        }
        let singles = [
            (pelvis, "sacroiliac"),
            (neck, "vc4"),
            (head, "skullbase"),
            (jaw, "temporomandibular"),
        ];
        for (joint, name) in singles {
            if let Some(joint) = joint {
                self.set(joint, name);
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_names::map;
    use crate::joint_names::test_rigs::{check_map, rig};
    use articula_formats::joint_map::builtin;

    fn check(text: &str) {
        let (skeleton, wanted) = rig(text);
        let eligible = vec![true; wanted.len()];
        let found = human(&skeleton, &eligible).expect("a human");
        for ((joint, target), wanted) in skeleton.joints.iter().zip(&found).zip(wanted) {
            let found = match target {
                Some((JointTarget::Joint(joint), _)) => joint.name.as_str(),
                Some((JointTarget::Spine, _)) => "spine",
                _ => "-",
            };
            assert_eq!(found, wanted, "{}", joint.name);
        }
    }

    #[test]
    fn names_of_daz_and_poser() {
        check(
            "
hip = humanoid_root
 abdomen = spine
  chest = spine
   neck = vc4
    head = skullbase
     leftEye = l_eyeball_joint
   lCollar = l_sternoclavicular
    lShldr = l_shoulder
     lForeArm = l_elbow
      lHand = l_wrist
       lThumb1 = l_thumb1
        lThumb2 = l_thumb2
       lMid1 = l_middle1
   rCollar = r_sternoclavicular
    rShldr = r_shoulder
     rForeArm = r_elbow
      rHand = r_wrist
 lThigh = l_hip
  lShin = l_knee
   lFoot = l_ankle
    lToe = l_metatarsal
 rThigh = r_hip
  rShin = r_knee
   rFoot = r_ankle
",
        );
    }

    #[test]
    fn words_in_any_order_with_numbers_of_the_exporter() {
        check(
            "
C_root0000_bind_JNT = humanoid_root
 C_spine0001_bind_JNT = spine
  C_head0002_bind_JNT = skullbase
  L_clavicle0001_bind_JNT = l_sternoclavicular
   L_armUpper0001_bind_JNT = l_shoulder
    L_armLower0001_bind_JNT = l_elbow
     L_hand0001_bind_JNT = l_wrist
  R_clavicle0001_bind_JNT = r_sternoclavicular
   R_armUpper0001_bind_JNT = r_shoulder
    R_armUpperTwist0001_bind_JNT = -
    R_armLower0001_bind_JNT = r_elbow
 L_legUpper0001_bind_JNT = l_hip
  L_legLower0001_bind_JNT = l_knee
   L_foot0001_bind_JNT = l_ankle
 R_legUpper0001_bind_JNT = r_hip
  R_legLower0001_bind_JNT = r_knee
   R_foot0001_bind_JNT = r_ankle
",
        );
    }

    #[test]
    fn conventions_in_one_rig_are_told_apart_by_the_tree() {
        check(
            "
mixamorig:Hips_01 = humanoid_root
 mixamorig:Spine_02 = spine
  mixamorig:Chest3_03 = spine
   mixamorig:LeftCollar_04 = l_sternoclavicular
    mixamorig:LeftShoulder_05 = l_shoulder
     mixamorig:LeftElbow_06 = l_elbow
      mixamorig:LeftWrist_07 = l_wrist
   mixamorig:RightShoulder_08 = r_sternoclavicular
    mixamorig:RightArm_09 = r_shoulder
     mixamorig:RightForeArm_010 = r_elbow
      mixamorig:RightHand_011 = r_wrist
       mixamorig:RightHandIndex1_012 = r_index1
        mixamorig:RightHandIndex2_013 = r_index2
         mixamorig:RightHandIndex3_014 = r_index3
          mixamorig:RightHandIndex4_015 = -
 mixamorig:LeftHip_016 = l_hip
  mixamorig:LeftKnee_017 = l_knee
   mixamorig:LeftAnkle_018 = l_ankle
    mixamorig:LeftToes_019 = l_metatarsal
 mixamorig:RightUpLeg_020 = r_hip
  mixamorig:RightLeg_021 = r_knee
   mixamorig:RightFoot_022 = r_ankle
",
        );
    }

    #[test]
    fn limbs_without_lower_joints_are_no_human() {
        let (skeleton, wanted) = rig("
hips = -
 leftarm = -
 rightarm = -
 leftleg = -
 rightleg = -
");
        assert!(human(&skeleton, &vec![true; wanted.len()]).is_none());
    }

    /// Finger joints of a hand by a convention, below its wrist: `{s}` is the side.
    fn hand(wrist: &str, finger: impl Fn(&str, usize) -> String, side: &str) -> String {
        let mut text = format!("{wrist} = {side}_wrist\n");
        for name in ["thumb", "index", "middle", "ring", "pinky"] {
            for part in 1..=3 {
                let indent = " ".repeat(part);
                text += &format!("{indent}{} = {side}_{name}{part}\n", finger(name, part));
            }
        }
        text
    }

    #[test]
    fn hands_alone_are_mapped_as_hands() {
        let capital = |name: &str| format!("{}{}", name[..1].to_uppercase(), &name[1..]);
        let mixamo = |side: &str, letter: &str| {
            let finger = |name: &str, part| format!("mixamorig:{side}Hand{}{part}", capital(name));
            hand(&format!("mixamorig:{side}Hand"), finger, letter)
        };
        let vrm = |name: &str, part: usize| {
            let parts = match name {
                "thumb" => ["Metacarpal", "Proximal", "Distal"],
                _ => ["Proximal", "Intermediate", "Distal"],
            };
            let name = if name == "pinky" { "little" } else { name };
            format!("right{}{}", capital(name), parts[part - 1])
        };
        let glove = |name: &str, part| format!("glove_{name}_{part:02}_jnt");
        for text in [
            mixamo("Left", "l"),
            mixamo("Left", "l") + &mixamo("Right", "r"),
            hand("rightHand", vrm, "r"),
            hand("glove_hand_jnt", glove, "l"),
            // The side is that of a name above the hand.
            format!(
                "right_glove = -\n{}",
                hand("glove_hand_jnt", glove, "r")
                    .replace('\n', "\n ")
                    .trim_end()
                    .replacen("glove_hand", " glove_hand", 1)
            ),
        ] {
            let mapping = check_map(&text);
            assert!(mapping.is_hands_alone() && !mapping.humanoid, "{text}");
            assert!(mapping.missing.is_empty() && mapping.doubts.is_empty());
        }
    }

    #[test]
    fn arms_in_the_first_person_are_hands_with_arms() {
        let mapping = check_map(
            "
arms_root = -
 upper_arm_l = l_shoulder
  lower_arm_l = l_elbow
   hand_l = l_wrist
    thumb_01_l = l_thumb1
    index_01_l = l_index1
 upper_arm_r = r_shoulder
  lower_arm_r = r_elbow
   hand_r = r_wrist
    thumb_01_r = r_thumb1
    index_01_r = r_index1
",
        );
        assert!(mapping.is_hands_alone());
    }

    #[test]
    fn a_body_without_a_leg_is_no_rig_of_hands() {
        let text = format!(
            "Hips = -\n {}",
            hand("LeftHand", |n, p| format!("Left_{n}_{p}"), "l")
        );
        let (skeleton, _) = rig(&text);
        let mapping = map(&skeleton, builtin(), None);
        assert!(!mapping.is_hands_alone() && mapping.articulation.mapped() == 0);
    }
}
