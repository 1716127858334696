//! Mapping of a skeleton's joints to H-Anim, by their names, a map in the file or the shape of the
//! tree.
//!
//! - [`map`], [`map_as_told`]: apply the joint map that fits a skeleton best, or the user's
//! - [`JointMapping`]: the joints of the standard, what told each, and what is doubtful
//! - [`segments`]: the same for segments without a hierarchy
//!
//! Source: thesis 3.1.3; H-Anim 1.1 and 2 (ISO/IEC 19774); the mapping rules are described in
//! `docs/formats/joint-map.md`.

mod by_words;
mod complete;
mod doubts;
mod evidence;
mod gap;
mod hand;
mod inserted;
mod levels;
mod matching;
mod part;
mod rest;
mod shape;
mod spine;
#[cfg(test)]
mod test_rigs;
mod words;

pub use doubts::{DoubtReason, JointDoubt};
pub use evidence::{MappingConfidence, MappingEvidence};
pub use gap::{UnmappedJoint, UnmappedReason};

use articula_core::Articulation;
use articula_core::hanim_table::{self, JOINTS};
use articula_core::joint_names::{JointMap, JointTarget, RigScope, Segments};
use articula_core::source::Skeleton;
use matching::{Candidate, Completion};
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
    /// H-Anim joints up to level 2 that the rig of a human lacks.
    pub missing: Vec<&'static str>,
    /// Joints whose name contradicts the side of the limb they hang from; they are mapped with the
    /// limb.
    pub crossed: Vec<usize>,
    /// What told the joint of the standard, for every joint; `None` for joints without one.
    pub evidence: Vec<Option<MappingEvidence>>,
    /// Reasons to doubt mapped joints, in the order of the joints.
    pub doubts: Vec<JointDoubt>,
    /// Whether a joint map of the user decided, as [`map_as_told`] takes them.
    pub by_user: bool,
    /// Whether hips, both legs and both arms were found. Otherwise levels are tree depths and every
    /// joint belongs to the torso, unless the rig is one of hands alone.
    pub humanoid: bool,
}

impl JointMapping {
    /// Returns whether the rig is one or two hands, perhaps with arms, without a body.
    pub fn is_hands_alone(&self) -> bool {
        !self.humanoid && self.articulation.mapped() > 0
    }

    /// Returns the confidence in a joint; `None` if it is not mapped.
    pub fn confidence(&self, joint: usize) -> Option<MappingConfidence> {
        let told = (*self.evidence.get(joint)?)?;
        let against = self.doubts.iter();
        let against = against.filter(|d| {
            // An unknown name is the lowest confidence by itself.
            d.joint == joint && d.reason != DoubtReason::UnknownName
        });
        Some(against.fold(told.confidence(), |own, _| own.lowered()))
    }
}

/// Maps a skeleton by its joint names, with the joint map that matches the most joints among those
/// that fit. On a tie the first in the list is used.
///
/// `given` is a map from the file itself: joint index and VRM human bone. If it names hips, legs
/// and arms it is used alone. A rig of which the words in its names tell more joints than any
/// joint map, or that no joint map fits, is recognised by these words; the name of the joint map is
/// then `words`. A rig whose names tell nothing is recognised by the shape of its tree at rest, if
/// that is a plain human one: `shape`.
pub fn map(
    skeleton: &Skeleton,
    profiles: &[JointMap],
    given: Option<&[(usize, String)]>,
) -> JointMapping {
    map_as_told(skeleton, &[], profiles, given)
}

/// Maps a skeleton as [`map`] does, except that a joint map in `told`, the user's own, is used alone
/// if it fits, whatever other maps, the file's own one or the words of names tell.
pub fn map_as_told(
    skeleton: &Skeleton,
    told: &[JointMap],
    profiles: &[JointMap],
    given: Option<&[(usize, String)]>,
) -> JointMapping {
    let by_told = |scope| {
        let fitting = told.iter().filter(|p| p.scope == scope);
        best(skeleton, fitting, scope, Completion::AsGiven)
    };
    let of_user = |candidate, humanoid| JointMapping {
        by_user: true,
        ..mapping(skeleton, candidate, humanoid)
    };
    if let Some(candidate) = by_told(RigScope::Body) {
        return of_user(candidate, true);
    }
    let body = given
        .and_then(|bones| by_humanoid_map(skeleton, profiles, bones))
        .or_else(|| by_names(skeleton, profiles))
        .or_else(|| by_shape(skeleton));
    if let Some(candidate) = body {
        return mapping(skeleton, candidate, true);
    }
    if let Some(candidate) = by_told(RigScope::Hand) {
        return of_user(candidate, false);
    }
    match hands_alone(skeleton, profiles) {
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

/// The candidate of the joint map that fits best; on a tie the first.
fn best<'a>(
    skeleton: &Skeleton,
    profiles: impl Iterator<Item = &'a JointMap>,
    scope: RigScope,
    completion: Completion,
) -> Option<Candidate> {
    let mut best: Option<Candidate> = None;
    for profile in profiles {
        let Some(candidate) = Candidate::by_name(skeleton, profile, scope, completion) else {
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
    let profile = profiles.iter().find(|p| p.name == name)?;
    let mut found = vec![None; skeleton.joints.len()];
    for (joint, bone) in bones {
        if let Some(slot) = found.get_mut(*joint) {
            let target = profile.target(bone).cloned();
            *slot = target.map(|target| (target, MappingEvidence::FileMap));
        }
    }
    Candidate::new(skeleton, name, found, RigScope::Body, Completion::AsGiven)
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
    let bodies = profiles.iter().filter(|p| p.scope == RigScope::Body);
    let map = best(skeleton, bodies, RigScope::Body, Completion::FromTree);
    let eligible = matching::eligible(skeleton);
    let words = by_words::human(skeleton, &eligible);
    let words = words.and_then(|found| by_found(skeleton, found, RigScope::Body));
    or_words(map, words)
}

/// Hands by a joint map of hands, by the part of a joint map of bodies that is about hands, or by
/// the words of the names.
fn hands_alone(skeleton: &Skeleton, profiles: &[JointMap]) -> Option<Candidate> {
    let all = profiles.iter();
    let map = best(skeleton, all, RigScope::Hand, Completion::AsGiven);
    let words = by_words::hands(skeleton, &matching::eligible(skeleton));
    let words = words.and_then(|found| by_found(skeleton, found, RigScope::Hand));
    or_words(map, words)
}

/// The candidate that maps more joints; that of the map if they are equal.
fn or_words(map: Option<Candidate>, words: Option<Candidate>) -> Option<Candidate> {
    let joints = |candidate: &Candidate| candidate.score().0;
    match (map, words) {
        (Some(map), Some(words)) if joints(&words) > joints(&map) => Some(words),
        (Some(map), _) => Some(map),
        (None, words) => words,
    }
}

fn by_found(skeleton: &Skeleton, found: by_words::Found, scope: RigScope) -> Option<Candidate> {
    Candidate::new(skeleton, by_words::NAME, found, scope, Completion::FromTree)
}

fn by_shape(skeleton: &Skeleton) -> Option<Candidate> {
    let found = shape::human(skeleton)?.into_iter();
    let found = found.map(|target| Some((target?, MappingEvidence::Shape)));
    let (found, scope) = (found.collect(), RigScope::Body);
    Candidate::new(skeleton, "shape", found, scope, Completion::AsGiven)
}

fn mapping(skeleton: &Skeleton, candidate: Candidate, humanoid: bool) -> JointMapping {
    let present: BTreeSet<&str> = candidate.names().collect();
    let expected = JOINTS
        .iter()
        .filter(|j| humanoid && j.level <= EXPECTED_LEVEL);
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
    let evidence = candidate.meanings.iter().zip(&candidate.evidence);
    let evidence =
        evidence.map(|(m, told)| matches!(m, Ok(JointTarget::Joint(_))).then_some(*told));
    JointMapping {
        evidence: evidence.collect(),
        doubts: doubts::doubts(skeleton, &candidate),
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
        by_user: false,
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
        evidence: vec![None; skeleton.joints.len()],
        doubts: Vec::new(),
        by_user: false,
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
        for joint in ["r_shoulder", "r_elbow"] {
            let joint = hanim_table::find(joint).unwrap();
            skeleton.joints[joint].name = "stump".to_owned();
        }
        let mapping = map(&skeleton, builtin(), None);
        assert!(!mapping.humanoid);
        assert_eq!(mapping.articulation.mapped(), 0);
        let none = map(&Skeleton::default(), builtin(), None);
        assert!(!none.humanoid && none.gaps.is_empty());
    }

    #[test]
    fn a_map_of_the_user_wins_over_all_others() {
        let skeleton = standard();
        let at = |name: &str| hanim_table::find(name).unwrap();
        let mut targets = std::collections::BTreeMap::new();
        for (joint, name) in [
            ("humanoid_root", "humanoid_root"),
            ("l_hip", "l_hip"),
            ("r_hip", "r_hip"),
            // Not what the name says, to tell it from all other maps.
            ("l_sternoclavicular", "l_shoulder"),
            ("r_sternoclavicular", "r_shoulder"),
        ] {
            let target = JointTarget::standard(name).unwrap();
            targets.insert(articula_core::joint_names::folded(joint), target);
        }
        let own = JointMap {
            name: "own".to_owned(),
            targets,
            ..JointMap::default()
        };
        let bones = [
            ("humanoid_root", "hips"),
            ("l_hip", "leftUpperLeg"),
            ("r_hip", "rightUpperLeg"),
            ("l_shoulder", "leftUpperArm"),
            ("r_shoulder", "rightUpperArm"),
        ];
        let given = bones.map(|(j, b)| (at(j), b.to_owned()));
        for given in [None, Some(&given[..])] {
            let mapping = map_as_told(&skeleton, std::slice::from_ref(&own), builtin(), given);
            assert_eq!(mapping.articulation.profile, "own");
            assert!(mapping.by_user);
            assert_eq!(
                mapping.articulation.mapped(),
                5,
                "what it leaves out stays out"
            );
            let shoulder = &mapping.articulation.joints[at("l_sternoclavicular")];
            assert_eq!(shoulder.hanim.as_deref(), Some("l_shoulder"));
        }
        // One that does not fit changes nothing.
        let mut partial = own;
        partial.targets.remove("lhip");
        let mapping = map_as_told(&skeleton, &[partial], builtin(), None);
        assert_eq!(mapping.articulation.profile, "hanim");
        assert!(!mapping.by_user);
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
