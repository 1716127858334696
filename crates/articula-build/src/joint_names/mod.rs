//! Mapping of a skeleton's joints to H-Anim, by their names, a map in the file or the shape of the
//! tree.
//!
//! - [`map`]: applies the joint map that fits a skeleton best
//! - [`segments`]: the same for segments without a hierarchy
//!
//! Source: thesis 3.1.3; H-Anim 1.1 and 2 (ISO/IEC 19774); the mapping rules are described in
//! `docs/formats/joint-map.md`.

mod by_words;
mod gap;
mod hand;
mod levels;
mod matching;
mod rest;
mod shape;
mod spine;
mod words;

pub use gap::{UnmappedJoint, UnmappedReason};

use articula_core::Articulation;
use articula_core::hanim_table::{self, JOINTS};
use articula_core::joint_names::{JointMap, JointTarget, RigScope, Segments};
use articula_core::source::Skeleton;
use matching::Candidate;
use std::collections::BTreeSet;

/// Maximum level of the joints listed in [`JointMapping::missing`]: finer levels contain fingers and
/// single vertebrae, which most rigs lack intentionally.
const EXPECTED_LEVEL: u8 = 2;

/// Mapping of a skeleton's joints to H-Anim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointMapping {
    /// Level and region of every joint, and the name of the joint map; empty if none fits.
    pub articulation: Articulation,
    /// Joints without a counterpart in H-Anim, in the skeleton's order.
    pub gaps: Vec<UnmappedJoint>,
    /// H-Anim joints up to level 2 that the rig lacks.
    pub missing: Vec<&'static str>,
    /// Joints whose name contradicts the side of the limb they hang from; they are mapped with the
    /// limb.
    pub crossed: Vec<usize>,
    /// Whether hips, both legs and both arms were found. Otherwise levels are tree depths and every
    /// joint belongs to the torso, unless the rig is a single hand.
    pub humanoid: bool,
}

/// Maps a skeleton by its joint names, with the joint map that matches the most joints among those
/// that fit. On a tie the first in the list is used, so pass the user's own before built-in ones.
///
/// `given` is a map from the file itself: joint index and VRM human bone. If it names hips, legs
/// and arms it is used alone. A rig of which the words in its names tell more joints than any
/// joint map, or that no joint map fits, is recognised by these words; the name of the joint map is then `words`. A rig whose names tell nothing is recognised by
/// the shape of its tree at rest, if that is a plain human one: `shape`.
pub fn map(
    skeleton: &Skeleton,
    profiles: &[JointMap],
    given: Option<&[(usize, String)]>,
) -> JointMapping {
    let candidate = given
        .and_then(|bones| by_humanoid_map(skeleton, profiles, bones))
        .or_else(|| by_names(skeleton, profiles))
        .or_else(|| by_shape(skeleton));
    if let Some(candidate) = candidate {
        return mapping(skeleton, candidate, true);
    }
    match best(skeleton, profiles, RigScope::Hand) {
        Some(candidate) => mapping(skeleton, candidate, false),
        None => unmapped(skeleton),
    }
}

/// Maps unconnected body segments to H-Anim joints by their names; `None` if no joint map
/// recognises a human.
pub fn segments(skeleton: &Skeleton, profiles: &[JointMap]) -> Option<Segments> {
    let mapping = map(skeleton, profiles, None);
    let name = mapping.articulation.profile;
    let profile = profiles.iter().find(|p| p.name == name);
    let profile = profile.filter(|_| mapping.humanoid)?;
    let joints = mapping.articulation.joints.iter();
    let joints: Vec<Option<usize>> = joints
        .map(|j| hanim_table::find(j.hanim.as_deref()?))
        .collect();
    let is_spine = |s: &usize| {
        joints[*s].is_none()
            && profile.target(&skeleton.joints[*s].name) == Some(&JointTarget::Spine)
    };
    let spine: Vec<usize> = (0..joints.len()).filter(is_spine).collect();
    Some(Segments {
        vertebrae: spine::vertebrae(spine.len()),
        profile: name,
        joints,
        spine,
    })
}

fn best(skeleton: &Skeleton, profiles: &[JointMap], scope: RigScope) -> Option<Candidate> {
    let side = hand::side(skeleton);
    let mut best: Option<Candidate> = None;
    for profile in profiles.iter().filter(|p| p.scope == scope) {
        let Some(candidate) = Candidate::by_name(skeleton, profile, side) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| b.score() < candidate.score()) {
            best = Some(candidate);
        }
    }
    best
}

fn by_humanoid_map(
    skeleton: &Skeleton,
    profiles: &[JointMap],
    bones: &[(usize, String)],
) -> Option<Candidate> {
    let name = profile_of(bones);
    // The last of that name: the user's own precede the built-in ones.
    let profile = profiles.iter().rfind(|p| p.name == name)?;
    let mut found = vec![None; skeleton.joints.len()];
    for (joint, bone) in bones {
        if let Some(slot) = found.get_mut(*joint) {
            *slot = profile.target(bone).cloned();
        }
    }
    Candidate::new(skeleton, name, found, RigScope::Body)
}

/// Name of the joint map for the bones of a humanoid map: the two versions differ in the names of
/// the thumb's joints.
fn profile_of(bones: &[(usize, String)]) -> &'static str {
    let old = bones
        .iter()
        .any(|(_, bone)| bone.ends_with("ThumbIntermediate"));
    if old { "vrm-0" } else { "vrm-1" }
}

/// The joint map that fits best, or the words of the names if they tell more joints, as those of two
/// conventions in one rig do.
fn by_names(skeleton: &Skeleton, profiles: &[JointMap]) -> Option<Candidate> {
    let (map, words) = (best(skeleton, profiles, RigScope::Body), by_words(skeleton));
    let joints = |candidate: &Candidate| candidate.score().0;
    match (map, words) {
        (Some(map), Some(words)) if joints(&words) > joints(&map) => Some(words),
        (Some(map), _) => Some(map),
        (None, words) => words,
    }
}

fn by_words(skeleton: &Skeleton) -> Option<Candidate> {
    let found = by_words::human(skeleton, &matching::eligible(skeleton))?;
    Candidate::new(skeleton, by_words::NAME, found, RigScope::Body)
}

fn by_shape(skeleton: &Skeleton) -> Option<Candidate> {
    let found = shape::human(skeleton)?;
    Candidate::new(skeleton, "shape", found, RigScope::Body)
}

fn mapping(skeleton: &Skeleton, candidate: Candidate, humanoid: bool) -> JointMapping {
    let present: BTreeSet<&str> = candidate.names().collect();
    let expected = JOINTS.iter().filter(|j| j.level <= EXPECTED_LEVEL);
    let missing = expected.map(|j| j.name).filter(|n| !present.contains(n));
    let missing = missing.collect();
    let gap = |(joint, meaning): (usize, &Result<JointTarget, UnmappedReason>)| {
        let reason = match meaning {
            Ok(JointTarget::Joint(_)) => return None,
            Ok(JointTarget::Helper(_)) => UnmappedReason::Helper,
            Ok(_) => UnmappedReason::Ignored,
            Err(reason) => *reason,
        };
        let name = skeleton.joints[joint].name.clone();
        Some(UnmappedJoint {
            joint,
            name,
            reason,
        })
    };
    JointMapping {
        gaps: candidate
            .meanings
            .iter()
            .enumerate()
            .filter_map(gap)
            .collect(),
        missing,
        articulation: Articulation {
            joints: levels::articulated(skeleton, &candidate.meanings),
            profile: candidate.profile,
        },
        crossed: candidate.crossed,
        humanoid,
    }
}

fn unmapped(skeleton: &Skeleton) -> JointMapping {
    let gap = |joint: usize| UnmappedJoint {
        joint,
        name: skeleton.joints[joint].name.clone(),
        reason: UnmappedReason::NoEntry,
    };
    JointMapping {
        articulation: Articulation {
            profile: String::new(),
            joints: levels::by_depth(skeleton),
        },
        gaps: (0..skeleton.joints.len()).map(gap).collect(),
        missing: Vec::new(),
        crossed: Vec::new(),
        humanoid: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::Joint;
    use articula_core::{Region, Transform};
    use articula_formats::joint_map::builtin;

    fn joint(name: &str, parent: Option<usize>) -> Joint {
        Joint {
            name: name.to_owned(),
            parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        }
    }

    fn standard() -> Skeleton {
        let joints = JOINTS.iter().map(|j| joint(j.name, j.parent));
        Skeleton {
            joints: joints.collect(),
        }
    }

    #[test]
    fn the_standard_maps_to_itself() {
        let mapping = map(&standard(), builtin(), None);
        assert!(mapping.humanoid && mapping.gaps.is_empty() && mapping.missing.is_empty());
        for (own, known) in mapping.articulation.joints.iter().zip(&JOINTS) {
            assert_eq!(own.hanim.as_deref(), Some(known.name));
            assert_eq!((own.level, own.region), (known.level, known.region));
        }
    }

    #[test]
    fn unknown_joints_follow_their_parent() {
        let mut skeleton = standard();
        let elbow = hanim_table::find("l_elbow");
        skeleton.joints.push(joint("sleeve", elbow));
        skeleton.joints.push(joint("cuff", Some(94)));
        skeleton.joints.push(joint("camera", None));
        let mapping = map(&skeleton, builtin(), None);
        let of = |j: usize| {
            let own = &mapping.articulation.joints[j];
            (own.level, own.region)
        };
        assert_eq!(of(94), (2, Region::Arms), "the elbow is level 1");
        assert_eq!(of(95), (3, Region::Arms));
        assert_eq!(of(96), (5, Region::Pelvis), "beside the human");
        let gaps = mapping.gaps.iter().map(|g| (g.joint, g.reason));
        assert!(gaps.eq([94, 95, 96].map(|j| (j, UnmappedReason::NoEntry))));
    }

    #[test]
    fn a_missing_limb_is_no_human() {
        let mut skeleton = standard();
        let shoulder = hanim_table::find("r_shoulder").unwrap();
        skeleton.joints[shoulder].name = "stump".to_owned();
        let mapping = map(&skeleton, builtin(), None);
        assert!(!mapping.humanoid);
        assert_eq!(mapping.articulation.mapped(), 0);
        let none = map(&Skeleton::default(), builtin(), None);
        assert!(!none.humanoid && none.gaps.is_empty());
    }

    #[test]
    fn a_map_of_the_file_decides_if_it_is_whole() {
        let mut skeleton = standard();
        for j in &mut skeleton.joints {
            j.name = String::new();
        }
        let at = |name: &str| hanim_table::find(name).unwrap();
        let bones = [
            ("humanoid_root", "hips"),
            ("l_hip", "leftUpperLeg"),
            ("r_hip", "rightUpperLeg"),
            ("l_shoulder", "leftUpperArm"),
            ("r_shoulder", "rightUpperArm"),
        ];
        let mut given: Vec<_> = bones.map(|(j, b)| (at(j), b.to_owned())).into();
        given.push((9999, "head".to_owned()));
        let mapping = map(&skeleton, builtin(), Some(&given));
        assert_eq!(mapping.articulation.mapped(), 5);
        assert_eq!(mapping.articulation.profile, "vrm-1");
        assert!(!map(&skeleton, builtin(), Some(&given[1..])).humanoid);
    }
}
