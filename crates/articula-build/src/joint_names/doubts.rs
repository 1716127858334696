//! Doubts about mapped joints, from names, tree and rest pose.
//!
//! They concern single joints of a rig that is a human; whether it is one is decided before.

use super::evidence::MappingEvidence;
use super::matching::Candidate;
use super::rest;
use articula_core::joint_names::{JointTarget, Side};
use articula_core::source::Skeleton;
use glam::Vec3;
use std::collections::BTreeMap;

/// Ratio of the lengths of left and right above which both are doubtful.
const UNEQUAL: f32 = 1.5;
/// Distance beyond the middle of the body, as a share of the distance between hips and the farthest
/// mapped joint, from which a joint counts as one of the other side.
const BEYOND: f32 = 0.05;
/// Distance of the ankles below the hips, on the same scale, from which the rest pose stands.
const STANDS: f32 = 0.25;

/// Joints and the joints above them in every human.
const ABOVE: [(&str, &str); 14] = [
    ("l_knee", "l_hip"),
    ("r_knee", "r_hip"),
    ("l_ankle", "l_knee"),
    ("r_ankle", "r_knee"),
    ("l_metatarsal", "l_ankle"),
    ("r_metatarsal", "r_ankle"),
    ("l_elbow", "l_shoulder"),
    ("r_elbow", "r_shoulder"),
    ("l_wrist", "l_elbow"),
    ("r_wrist", "r_elbow"),
    ("l_index1", "l_wrist"),
    ("r_index1", "r_wrist"),
    ("skullbase", "vc4"),
    ("vc4", "humanoid_root"),
];

/// Ends of the segments that are as long on the left as on the right.
const SEGMENTS: [[&str; 2]; 4] = [
    ["hip", "knee"],
    ["knee", "ankle"],
    ["shoulder", "elbow"],
    ["elbow", "wrist"],
];

/// Reason to doubt the mapping of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DoubtReason {
    /// Its name tells nothing; it was found by its place in the tree.
    UnknownName,
    /// Its name states the side opposite to that of its limb.
    CrossedName,
    /// It rests on the other side of the body.
    OtherSide,
    /// It is not below the joint that carries it in a human.
    NotBelow,
    /// The segment above it is more than 1.5 times as long as that of the other side, or the other
    /// way round.
    UnequalLengths,
}

/// A doubt about a mapped joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JointDoubt {
    /// Index of the joint.
    pub joint: usize,
    /// Reason of the doubt.
    pub reason: DoubtReason,
}

/// The doubts about a mapping, in the order of the joints.
pub(super) fn doubts(skeleton: &Skeleton, candidate: &Candidate) -> Vec<JointDoubt> {
    let mut joints = BTreeMap::new();
    for (index, meaning) in candidate.meanings.iter().enumerate() {
        if let Ok(JointTarget::Joint(joint)) = meaning {
            joints.insert(joint.name.as_str(), index);
        }
    }
    let body = Body {
        skeleton,
        candidate,
        joints,
        places: rest::positions(skeleton),
    };
    let unknown = body
        .joints
        .values()
        .filter(|j| candidate.evidence[**j] == MappingEvidence::Tree);
    let mut all: Vec<(usize, DoubtReason)> = Vec::new();
    all.extend(unknown.map(|j| (*j, DoubtReason::UnknownName)));
    all.extend(
        candidate
            .crossed
            .iter()
            .map(|j| (*j, DoubtReason::CrossedName)),
    );
    all.extend(
        body.other_side()
            .into_iter()
            .map(|j| (j, DoubtReason::OtherSide)),
    );
    all.extend(body.not_below().map(|j| (j, DoubtReason::NotBelow)));
    all.extend(body.unequal().map(|j| (j, DoubtReason::UnequalLengths)));
    all.sort_unstable();
    all.dedup();
    let doubt = |(joint, reason)| JointDoubt { joint, reason };
    all.into_iter().map(doubt).collect()
}

struct Body<'a> {
    skeleton: &'a Skeleton,
    candidate: &'a Candidate,
    /// Mapped joints by their names in the standard.
    joints: BTreeMap<&'a str, usize>,
    places: Vec<Vec3>,
}

impl Body<'_> {
    fn place(&self, name: &str) -> Option<Vec3> {
        self.joints.get(name).map(|j| self.places[*j])
    }

    /// Sided joints on the other side of the middle, where hips and shoulders agree about the sides
    /// in a figure that stands.
    fn other_side(&self) -> Vec<usize> {
        self.across().unwrap_or_default()
    }

    fn across(&self) -> Option<Vec<usize>> {
        let root = self.place("humanoid_root")?;
        let pair = |part: &str| {
            let [left, right] = ["l", "r"].map(|side| self.place(&format!("{side}_{part}")));
            Some((left?, right?))
        };
        let (hips, shoulders) = (pair("hip")?, pair("shoulder")?);
        let ankles = pair("ankle")?;
        let mapped = self.joints.values().map(|j| self.places[*j].distance(root));
        let size = mapped.fold(0.0, f32::max);
        let stands = [ankles.0, ankles.1]
            .iter()
            .all(|a| root.y - a.y > STANDS * size);
        let across = |(left, right): (Vec3, Vec3)| (left - right).with_y(0.0);
        let axis = across(shoulders).try_normalize()?;
        if !stands || across(hips).dot(axis) <= 0.0 {
            return None;
        }
        let middle = (hips.0 + hips.1 + shoulders.0 + shoulders.1) / 4.0;
        let is_across = |(name, joint): (&&str, &usize)| {
            let left_by = (self.places[*joint] - middle).dot(axis);
            let own_by = match Side::of(name)? {
                Side::Left => left_by,
                Side::Right => -left_by,
            };
            (own_by < -BEYOND * size).then_some(*joint)
        };
        Some(self.joints.iter().filter_map(is_across).collect())
    }

    /// Joints off their chain, unless a map names them, which was made for such rigs.
    fn not_below(&self) -> impl Iterator<Item = usize> {
        let is_guessed = |joint: &usize| {
            let told = self.candidate.evidence[*joint];
            !matches!(told, MappingEvidence::FileMap | MappingEvidence::JointMap)
        };
        let off = move |(lower, upper): (&str, &str)| {
            let (lower, upper) = (*self.joints.get(lower)?, *self.joints.get(upper)?);
            let parent = |j: &usize| self.skeleton.joints[*j].parent;
            let mut above = std::iter::successors(parent(&lower), parent);
            above.all(|j| j != upper).then_some(lower)
        };
        ABOVE.into_iter().filter_map(off).filter(is_guessed)
    }

    fn unequal(&self) -> impl Iterator<Item = usize> {
        SEGMENTS.into_iter().flat_map(|[upper, lower]| {
            let segment = |side: &str| {
                let lower = *self.joints.get(format!("{side}_{lower}").as_str())?;
                let upper = self.place(&format!("{side}_{upper}"))?;
                Some((lower, upper.distance(self.places[lower])))
            };
            let unequal = |((left, a), (right, b)): ((usize, f32), (usize, f32))| {
                (a.max(b) > UNEQUAL * a.min(b)).then_some([left, right])
            };
            let found = segment("l").zip(segment("r")).and_then(unequal);
            found.into_iter().flatten()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_names::test_rigs::rig;
    use crate::joint_names::{MappingConfidence, map};
    use articula_formats::joint_map::builtin;

    const GOOD: &str = "
Hips 0 1 0 = -
 Spine 0 1.2 0 = -
  Neck 0 1.5 0 = -
   Head 0 1.6 0 = -
  LeftArm 0.2 1.45 0 = -
   LeftForeArm 0.5 1.45 0 = -
    LeftHand 0.8 1.45 0 = -
  RightArm -0.2 1.45 0 = -
   RightForeArm -0.5 1.45 0 = -
    RightHand -0.8 1.45 0 = -
 LeftUpLeg 0.1 0.95 0 = -
  LeftLeg 0.1 0.5 0 = -
   LeftFoot 0.1 0.1 0 = -
 RightUpLeg -0.1 0.95 0 = -
  RightLeg -0.1 0.5 0 = -
   RightFoot -0.1 0.1 0 = -
";

    fn check(text: &str, wanted: &[(&str, DoubtReason)]) {
        let (skeleton, _) = rig(text);
        let mapping = map(&skeleton, builtin(), None);
        assert!(mapping.humanoid);
        let named = |d: &JointDoubt| (skeleton.joints[d.joint].name.as_str(), d.reason);
        let doubts: Vec<_> = mapping.doubts.iter().map(named).collect();
        assert_eq!(doubts, wanted);
        for doubt in &mapping.doubts {
            let confidence = mapping.confidence(doubt.joint).unwrap();
            assert!(confidence < MappingConfidence::High);
        }
    }

    #[test]
    fn a_good_rig_has_no_doubt() {
        check(GOOD, &[]);
    }

    #[test]
    fn a_hand_on_the_other_side_is_doubtful() {
        use DoubtReason::OtherSide;
        let swapped = GOOD
            .replace("LeftHand 0.8", "LeftHand -0.79")
            .replace("RightHand -0.8", "RightHand 0.79");
        check(&swapped, &["LeftHand", "RightHand"].map(|j| (j, OtherSide)));
    }

    #[test]
    fn unequal_legs_are_doubtful_on_both_sides() {
        use DoubtReason::UnequalLengths;
        let text = GOOD.replace("LeftLeg 0.1 0.5", "LeftLeg 0.1 0.75");
        // 0.2 and 0.45 above, 0.65 and 0.4 below.
        let joints = ["LeftLeg", "LeftFoot", "RightLeg", "RightFoot"];
        check(&text, &joints.map(|j| (j, UnequalLengths)));
    }

    #[test]
    fn a_rest_pose_that_does_not_stand_says_nothing_about_sides() {
        // All bones along +X, as in files whose zero pose is no figure.
        let along = "
Hips 0 0 0 = -
 Spine 0.2 0 0 = -
  Neck 0.5 0 0 = -
   Head 0.6 0 0 = -
  LeftArm 0.5 0 0.1 = -
   LeftForeArm 0.8 0 0.1 = -
    LeftHand 1.1 0 0.1 = -
  RightArm 0.5 0 -0.1 = -
   RightForeArm 0.8 0 -0.1 = -
    RightHand 1.1 0 -0.1 = -
 LeftUpLeg 0.1 0 0.1 = -
  LeftLeg 0.5 0 -0.1 = -
   LeftFoot 0.9 0 -0.1 = -
 RightUpLeg 0.1 0 -0.1 = -
  RightLeg 0.5 0 0.1 = -
   RightFoot 0.9 0 0.1 = -
";
        check(along, &[]);
    }

    #[test]
    fn a_crossed_name_is_doubtful() {
        let (skeleton, _) = rig(&GOOD.replace("LeftHand", "RightHand"));
        let mapping = map(&skeleton, builtin(), None);
        let crossed = mapping
            .doubts
            .iter()
            .filter(|d| d.reason == DoubtReason::CrossedName);
        assert_eq!(crossed.map(|d| d.joint).collect::<Vec<_>>(), [6]);
    }
}
