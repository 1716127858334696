//! Matching of a rig's joints to H-Anim with one joint map.
//!
//! Source: `docs/methods/hanim.md` part 7, rule 1: hips, both upper legs and both upper arms must
//! be found or the joint map does not fit. A joint whose name contradicts the side of the limb it
//! hangs from is mapped with the limb (rigs with crossed thumbs exist).

use super::evidence::MappingEvidence;
use super::gap::UnmappedReason;
use super::{complete, hand, inserted, spine};
use articula_core::Region;
use articula_core::joint_names::{JointMap, JointTarget, RigScope, Side, StandardJoint};
use articula_core::source::Skeleton;
use std::collections::{BTreeMap, BTreeSet};

const BODY: [&str; 5] = [
    "humanoid_root",
    "l_hip",
    "r_hip",
    "l_shoulder",
    "r_shoulder",
];

/// Number of joints that a rig of hands alone must exceed.
const HAND_FINGER_JOINTS: usize = 5;

/// Result of one joint map for every joint of a skeleton.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Candidate {
    pub(super) profile: String,
    /// One entry per joint: its target, or the reason why it has none.
    pub(super) meanings: Vec<Result<JointTarget, UnmappedReason>>,
    /// What told the meaning of each joint; of those without a meaning it says nothing.
    pub(super) evidence: Vec<MappingEvidence>,
    /// Joints whose name contradicts their side.
    pub(super) crossed: Vec<usize>,
}

/// Whether joints whose names tell nothing are found by their place in the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Completion {
    /// The map was given for this rig: what it leaves out is left out.
    AsGiven,
    /// Limbs, neck and head are completed.
    FromTree,
}

impl Candidate {
    /// Matches a skeleton's names, as a rig of the given scope; `None` if the joint map does not fit.
    pub(super) fn by_name(
        skeleton: &Skeleton,
        profile: &JointMap,
        scope: RigScope,
        completion: Completion,
    ) -> Option<Self> {
        let lone_hand = hand::side(skeleton);
        let eligible = eligible(skeleton);
        let found = skeleton
            .joints
            .iter()
            .zip(eligible)
            .map(|(joint, eligible)| {
                let target = profile.target(&joint.name).filter(|_| eligible)?;
                Some(match target {
                    JointTarget::HandJoint(left) => JointTarget::Joint(match lone_hand {
                        Side::Left => left.clone(),
                        Side::Right => left.mirrored(),
                    }),
                    other => other.clone(),
                })
            });
        let found = found.map(|target| Some((target?, MappingEvidence::JointMap)));
        Self::new(skeleton, &profile.name, found.collect(), scope, completion)
    }

    /// Removes contradictions from the targets found for each joint; `None` if required joints are
    /// missing.
    pub(super) fn new(
        skeleton: &Skeleton,
        profile: &str,
        found: Vec<Option<(JointTarget, MappingEvidence)>>,
        scope: RigScope,
        completion: Completion,
    ) -> Option<Self> {
        let mut evidence: Vec<MappingEvidence> = Vec::with_capacity(found.len());
        evidence.extend(
            found
                .iter()
                .map(|f| f.as_ref().map_or(MappingEvidence::Tree, |f| f.1)),
        );
        let mut found: Vec<Option<JointTarget>> = found.into_iter().map(|f| Some(f?.0)).collect();
        let crossed = uncross(skeleton, &mut found);
        let mut meanings = without_duplicates(skeleton, found);
        let eligible = eligible(skeleton);
        if completion == Completion::FromTree {
            complete::complete(skeleton, &eligible, &mut meanings, &mut evidence);
        }
        inserted::tell(skeleton, &eligible, &mut meanings, &mut evidence);
        spine::name_by_arc_length(skeleton, &mut meanings);
        let candidate = Self {
            profile: profile.to_owned(),
            meanings,
            evidence,
            crossed,
        };
        candidate.fits(scope).then_some(candidate)
    }

    /// Number of joints mapped to H-Anim, then of all joints that the joint map knows.
    pub(super) fn score(&self) -> (usize, usize) {
        let known = self.meanings.iter().filter(|m| m.is_ok()).count();
        (self.names().count(), known)
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.joints().map(|joint| joint.name.as_str())
    }

    fn joints(&self) -> impl Iterator<Item = &StandardJoint> {
        self.meanings.iter().filter_map(|m| match m {
            Ok(JointTarget::Joint(joint)) => Some(joint),
            _ => None,
        })
    }

    fn fits(&self, scope: RigScope) -> bool {
        let names: BTreeSet<&str> = self.names().collect();
        match scope {
            RigScope::Body => BODY.iter().all(|b| names.contains(b)),
            RigScope::Hand => {
                let wrist = names.iter().any(|n| n.ends_with("_wrist"));
                let is_of_arm = |region| matches!(region, Region::Arms | Region::Hands);
                let arms = self.joints().all(|j| is_of_arm(j.region));
                wrist && arms && names.len() > HAND_FINGER_JOINTS
            }
        }
    }
}

/// Whether a name counts: mesh nodes outside the skeleton are often called `Head` or `Hand.L` as
/// well, so in a file with a skin only nodes of its trees count.
pub(super) fn eligible(skeleton: &Skeleton) -> Vec<bool> {
    let joints = &skeleton.joints;
    let any_skin = joints.iter().any(|j| j.in_skin);
    let mut eligible: Vec<bool> = joints.iter().map(|j| j.in_skin || !any_skin).collect();
    for (index, joint) in joints.iter().enumerate() {
        eligible[index] |= joint.parent.is_some_and(|p| eligible[p]);
    }
    for (index, joint) in joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            eligible[parent] |= eligible[index];
        }
    }
    eligible
}

/// Gives each sided joint the side of the nearest sided joint above it.
fn uncross(skeleton: &Skeleton, found: &mut [Option<JointTarget>]) -> Vec<usize> {
    let mut limb: Vec<Option<Side>> = Vec::with_capacity(found.len());
    let mut crossed = Vec::new();
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let above = joint.parent.and_then(|p| limb[p]);
        let own = match &found[index] {
            Some(JointTarget::Joint(joint)) => Side::of(&joint.name),
            _ => None,
        };
        if let (Some(above), Some(own), Some(JointTarget::Joint(j))) = (above, own, &found[index])
            && above != own
        {
            found[index] = Some(JointTarget::Joint(j.mirrored()));
            crossed.push(index);
        }
        limb.push(above.or(own));
    }
    crossed
}

/// Keeps the first joint of each H-Anim name; joints of a skin precede other nodes.
fn without_duplicates(
    skeleton: &Skeleton,
    found: Vec<Option<JointTarget>>,
) -> Vec<Result<JointTarget, UnmappedReason>> {
    let mut first: BTreeMap<&str, usize> = BTreeMap::new();
    for in_skin in [true, false] {
        for (index, target) in found.iter().enumerate() {
            if let Some(JointTarget::Joint(joint)) = target
                && skeleton.joints[index].in_skin == in_skin
            {
                first.entry(&joint.name).or_insert(index);
            }
        }
    }
    let kept: BTreeSet<usize> = first.into_values().collect();
    let keep = |(index, target): (usize, Option<JointTarget>)| match target {
        None => Err(UnmappedReason::NoEntry),
        Some(JointTarget::Joint(_)) if !kept.contains(&index) => Err(UnmappedReason::Duplicate),
        Some(target) => Ok(target),
    };
    found.into_iter().enumerate().map(keep).collect()
}
