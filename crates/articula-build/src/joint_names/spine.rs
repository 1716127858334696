//! Assignment of vertebrae to the spine joints of a rig.
//!
//! Source: `docs/methods/hanim.md` part 7, rule 3. `n` spine joints take the first `n` vertebrae of
//! a preference list in the order of the body, so a rig with one has `vl5`, one with three has
//! `vl5`, `vt10`, `vt6`; in a rig with more joints than the list, those nearest to the vertebrae by
//! arc length between hips and neck are mapped.

use super::gap::UnmappedReason;
use super::rest;
use articula_core::hanim_table::{self, JOINTS};
use articula_core::joint_names::{JointTarget, StandardJoint};
use articula_core::source::Skeleton;

/// Vertebrae in order of preference.
const PREFERENCE: [&str; 9] = [
    "vl5", "vt10", "vt6", "vl1", "vt1", "vl3", "vt3", "vt8", "vt12",
];

/// Names that end the spine of a rig, lowest first.
const NECK: [&str; 4] = ["vc7", "vc4", "vc2", "skullbase"];

/// Replaces [`JointTarget::Spine`] by vertebrae along the chain from the root to the neck; spine
/// joints beside that chain become duplicates.
pub(super) fn name_by_arc_length(
    skeleton: &Skeleton,
    meanings: &mut [Result<JointTarget, UnmappedReason>],
) {
    let chain = chain(skeleton, meanings);
    let spine: Vec<usize> = chain
        .iter()
        .copied()
        .filter(|&j| meanings[j] == Ok(JointTarget::Spine))
        .collect();
    let vertebrae = vertebrae(spine.len());
    let picked = pick(
        &fractions(skeleton, &chain, &spine),
        &standard_fractions(&vertebrae),
    );
    for (slot, vertebra) in picked.into_iter().zip(vertebrae) {
        meanings[spine[slot]] = Ok(JointTarget::Joint(StandardJoint::from(&JOINTS[vertebra])));
    }
    for meaning in meanings
        .iter_mut()
        .filter(|m| **m == Ok(JointTarget::Spine))
    {
        *meaning = Err(UnmappedReason::Duplicate);
    }
}

/// The vertebrae of `count` spine joints, at most as many as the preference list has, lowest first.
pub(super) fn vertebrae(count: usize) -> Vec<usize> {
    let preferred = PREFERENCE.iter().take(count);
    let mut vertebrae: Vec<usize> = preferred.filter_map(|n| hanim_table::find(n)).collect();
    vertebrae.sort_unstable();
    vertebrae
}

/// Joints from the root joint (or the tree's root) to the neck, both included.
fn chain(skeleton: &Skeleton, meanings: &[Result<JointTarget, UnmappedReason>]) -> Vec<usize> {
    let named = |wanted: &str| {
        meanings
            .iter()
            .position(|m| matches!(m, Ok(JointTarget::Joint(j)) if j.name == wanted))
    };
    let last_spine = || meanings.iter().rposition(|m| *m == Ok(JointTarget::Spine));
    let Some(top) = NECK.iter().find_map(|n| named(n)).or_else(last_spine) else {
        return Vec::new();
    };
    let bottom = named("humanoid_root");
    let mut chain = vec![top];
    let mut at = top;
    while let Some(parent) = skeleton.joints[at].parent.filter(|_| Some(at) != bottom) {
        chain.push(parent);
        at = parent;
    }
    chain.reverse();
    chain
}

/// Share of the chain's rest length below each spine joint, 0 to 1.
fn fractions(skeleton: &Skeleton, chain: &[usize], spine: &[usize]) -> Vec<f32> {
    let positions = rest::positions(skeleton);
    let mut length = 0.0;
    let mut below = Vec::new();
    for (index, &joint) in chain.iter().enumerate() {
        if index > 0 {
            length += positions[joint].distance(positions[chain[index - 1]]);
        }
        if spine.contains(&joint) {
            below.push(length);
        }
    }
    below.iter().map(|b| b / f32::max(length, 1e-9)).collect()
}

/// Likewise for the vertebrae of H-Anim, between root and vc4.
fn standard_fractions(vertebrae: &[usize]) -> Vec<f32> {
    let mut length = 0.0;
    let mut below = Vec::new();
    let mut last = JOINTS[0].center;
    for joint in JOINTS.iter().filter(|j| j.name.starts_with('v')) {
        length += joint.center.distance(last);
        last = joint.center;
        below.push((joint.name, length));
        if joint.name == "vc4" {
            break;
        }
    }
    let of = |name: &str| {
        below
            .iter()
            .find(|(n, _)| *n == name)
            .map_or(0.0, |(_, b)| b / length)
    };
    vertebrae.iter().map(|&v| of(JOINTS[v].name)).collect()
}

/// For each target the nearest joint, in order, each joint once; there are at least as many joints
/// as targets.
fn pick(joints: &[f32], targets: &[f32]) -> Vec<usize> {
    let mut picked: Vec<usize> = Vec::with_capacity(targets.len());
    for (index, target) in targets.iter().enumerate() {
        let first = picked.last().map_or(0, |last| last + 1);
        let last = joints.len() - (targets.len() - index);
        let distance = |j: &usize| (joints[*j] - target).abs();
        let nearest = (first..=last).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        picked.extend(nearest);
    }
    picked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_joints_as_targets_are_taken_in_order() {
        assert_eq!(pick(&[0.0, 0.1, 0.2], &[0.3, 0.6, 0.9]), [0, 1, 2]);
    }

    #[test]
    fn with_more_joints_the_nearest_are_taken() {
        assert_eq!(pick(&[0.0, 0.25, 0.5, 0.75, 1.0], &[0.3, 0.9]), [1, 4]);
        assert_eq!(pick(&[0.0, 0.8, 0.9], &[0.85, 0.86]), [1, 2]);
    }

    #[test]
    fn standard_fractions_rise_to_one() {
        let all: Vec<usize> = PREFERENCE
            .iter()
            .filter_map(|n| hanim_table::find(n))
            .collect();
        assert_eq!(all.len(), PREFERENCE.len());
        let mut sorted = all.clone();
        sorted.sort_unstable();
        let shares = standard_fractions(&sorted);
        assert!(shares.windows(2).all(|w| w[0] < w[1]));
        assert!(shares[0] > 0.0 && shares[8] < 1.0);
    }
}
