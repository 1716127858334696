//! Skins over a part of a figure, such as its head, whose clips move the whole.

use super::motion::tops;
use articula_build::joint_names::map;
use articula_core::source::{Character, Skeleton};
use articula_formats::joint_map;

/// Declares the joints that clips move beside or above the joints of the skins, and what is between
/// and below them, where only both together are a human.
pub(super) fn mark_figure(character: &mut Character) {
    let joints = &character.skeleton.joints;
    if joints.iter().all(|j| j.in_skin) || !joints.iter().any(|j| j.in_skin) {
        return;
    }
    let mut counts: Vec<bool> = joints.iter().map(|j| j.in_skin).collect();
    let channels = character.clips.iter().flat_map(|c| &c.channels);
    for channel in channels.filter(|c| c.property.is_of_joint()) {
        counts[channel.target] = true;
    }
    let is_human = |skeleton: &Skeleton| map(skeleton, joint_map::builtin(), None).humanoid;
    if joints
        .iter()
        .zip(&counts)
        .all(|(j, counts)| j.in_skin == *counts)
        || is_human(&character.skeleton)
    {
        return;
    }
    let mut whole = character.skeleton.clone();
    let tops = tops(&whole, &counts);
    for (index, is_top) in tops.into_iter().enumerate() {
        let parent = whole.joints[index].parent;
        let is_below = parent.is_some_and(|p| whole.joints[p].in_skin);
        whole.joints[index].in_skin |= is_below || is_top;
    }
    if is_human(&whole) {
        character.skeleton = whole;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Channel, Interpolation, Property, RawClip};
    use articula_human::HumanOptions;
    use std::sync::LazyLock;

    static HUMAN: LazyLock<Character> =
        LazyLock::new(|| articula_human::human(&HumanOptions::mannequin(12_000)).unwrap());

    /// The reference human below a scene node, with a skin over some joints and a clip that moves some.
    fn human(in_skin: impl Fn(&str) -> bool, moves: impl Fn(&str) -> bool) -> Character {
        let mut character = HUMAN.clone();
        let joints = &mut character.skeleton.joints;
        joints.iter_mut().for_each(|j| j.in_skin = in_skin(&j.name));
        let moving = (0..joints.len()).filter(|j| moves(&joints[*j].name));
        let channel = |target| Channel {
            target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: vec![0.0, 0.0, 0.0, 1.0],
        };
        let channels = moving.map(channel).collect();
        character.clips = vec![RawClip {
            channels,
            ..RawClip::default()
        }];
        character
    }

    fn skinned(character: &Character) -> usize {
        character
            .skeleton
            .joints
            .iter()
            .filter(|j| j.in_skin)
            .count()
    }

    #[test]
    fn a_skin_over_any_part_takes_what_moves_beside_it() {
        for part in [
            "skullbase",
            "l_wrist",
            "r_knee",
            "l_ankle",
            "vt6",
            "r_shoulder",
        ] {
            let mut character = human(|name| name == part, |_| true);
            mark_figure(&mut character);
            assert_eq!(
                skinned(&character),
                character.skeleton.joints.len(),
                "{part}"
            );
        }
    }

    #[test]
    fn a_skin_over_a_human_or_beside_nothing_that_moves_stays() {
        let is_prop = |name: &str| name == "skullbase";
        for (in_skin, moves) in [
            (
                &(|name: &str| !is_prop(name)) as &dyn Fn(&str) -> bool,
                &is_prop as &dyn Fn(&str) -> bool,
            ),
            (&is_prop, &is_prop),
            (&is_prop, &|name: &str| name.ends_with("eyeball_joint")),
        ] {
            let mut character = human(in_skin, moves);
            let before = character.clone();
            mark_figure(&mut character);
            assert_eq!(character, before);
        }
    }
}
