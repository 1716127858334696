//! Joint names in formats that hold no joint map.
//!
//! A file with a map of its own (VRM, KHR_character) may call its joints anything, and a figure may
//! be known by its shape alone, which added joints change. BVH and ASF have nothing but names, so
//! joints that their names do not tell get those of H-Anim.

use super::left_out::{LossyPart, counted};
use crate::open::CharacterFile;
use articula_build::joint_names;
use articula_core::source::{Character, Skeleton};
use articula_core::{Articulation, JointArticulation};
use articula_formats::joint_map;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Name of the joint map of a figure that is recognised by the shape of its tree.
const BY_SHAPE: &str = "shape";

/// Returns the character for a format that holds names alone, with the number of joints that lost
/// their names. Where the joints were recognised by their names, possibly with a joint map of the
/// user, the names stay.
pub(super) fn for_names_alone(opened: &CharacterFile) -> (Cow<'_, Character>, Option<LossyPart>) {
    let character = opened.character();
    let own_map = opened.gltf().and_then(|gltf| gltf.humanoid.as_ref());
    let by_shape = opened.mapping().articulation.profile == BY_SHAPE;
    if !opened.mapping().humanoid || (own_map.is_none() && !by_shape) {
        return (Cow::Borrowed(character), None);
    }
    let wanted = opened.mapping().articulation.joints.iter();
    let wanted: Vec<Option<&str>> = wanted.map(|joint| joint.hanim.as_deref()).collect();
    let found = joint_names::map(&character.skeleton, joint_map::builtin(), None);
    let Articulation { profile, joints } = found.articulation;
    let is_told = |(wanted, found): (&Option<&str>, &JointArticulation)| {
        wanted.is_none() || *wanted == found.hanim.as_deref()
    };
    if profile != BY_SHAPE && wanted.iter().zip(&joints).all(is_told) {
        return (Cow::Borrowed(character), None);
    }
    let mut skeleton = character.skeleton.clone();
    let renamed = rename(&mut skeleton, &wanted);
    let named = Character {
        name: character.name.clone(),
        skeleton,
        clips: character.clips.clone(),
        ..Character::default()
    };
    (Cow::Owned(named), counted(renamed, LossyPart::JointNames))
}

/// Gives joints their H-Anim names; others with such a name are marked. Returns the number of
/// changed names.
fn rename(skeleton: &mut Skeleton, hanim: &[Option<&str>]) -> usize {
    let taken: BTreeSet<&str> = hanim.iter().copied().flatten().collect();
    let mut renamed = 0;
    for (joint, hanim) in skeleton.joints.iter_mut().zip(hanim) {
        let name = match hanim {
            Some(hanim) => (*hanim).to_owned(),
            None if taken.contains(joint.name.as_str()) => format!("{}_unmapped", joint.name),
            None => continue,
        };
        renamed += usize::from(name != joint.name);
        joint.name = name;
    }
    renamed
}
