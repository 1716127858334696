//! Figures of a size that no human has.

use super::CharacterFile;
use articula_core::{Articulation, Region};
use articula_formats::{Assumption, Warning};
use glam::Vec3A;
use std::ops::RangeInclusive;

/// Heights of human figures at rest, from a small child to a giant of a game, in metres.
const HUMAN_METRES: RangeInclusive<f32> = 0.4..=3.2;
/// Number of joints of legs that a map must know for a figure to count as a whole human.
const MIN_LEG_JOINTS: usize = 3;
/// Least height of a standing rest figure, as a fraction of its bones from top to bottom.
const STANDING: f32 = 0.7;

/// Returns a warning if a human figure is of a size that no human has.
pub(super) fn unusual(opened: &CharacterFile) -> Option<Warning> {
    let articulation = opened.articulation();
    let known = articulation.joints.iter().filter(|j| j.hanim.is_some());
    if known.filter(|j| j.region == Region::Legs).count() < MIN_LEG_JOINTS {
        return None;
    }
    let model = opened.character.skeleton.model_rest();
    let places: Vec<Vec3A> = model.iter().map(|joint| joint.translation).collect();
    let bones = bone_metres(opened, &articulation, &places);
    let (height, measured) = match height_metres(&articulation, &places) {
        height if height < STANDING * bones => (bones, "by its bones"),
        height => (height, "at rest"),
    };
    // Bones without length tell nothing.
    if HUMAN_METRES.contains(&height) || height <= 0.0 || !height.is_finite() {
        return None;
    }
    let shown = match height {
        0.001..1e6 => format!("{height:.3}"),
        _ => format!("{height:e}"),
    };
    let what = format!("the figure is {shown} m tall {measured}, the size of no human");
    Some(Warning {
        at: "file".to_owned(),
        what,
        guess: Some(Assumption::Unit),
    })
}

/// Height of the joints that a map knows, at rest.
fn height_metres(articulation: &Articulation, places: &[Vec3A]) -> f32 {
    let known = places.iter().zip(&articulation.joints);
    let known = known.filter(|(_, joint)| joint.hanim.is_some());
    let (low, high) = known.fold((f32::MAX, f32::MIN), |(low, high), (place, _)| {
        (low.min(place.y), high.max(place.y))
    });
    high - low
}

/// Length of the bones from the tops of the legs to their farthest joint, and of those of trunk and
/// head. The way from the joint above a part to its first joint does not count, since limbs may hang
/// from a joint at the origin.
fn bone_metres(opened: &CharacterFile, articulation: &Articulation, places: &[Vec3A]) -> f32 {
    let is_leg = |region: Region| matches!(region, Region::Legs | Region::Feet);
    let is_trunk = |region: Region| matches!(region, Region::Torso | Region::Face);
    let mut lengths = vec![0.0_f32; places.len()];
    let (mut down, mut up) = (0.0_f32, 0.0_f32);
    let joints = opened.character.skeleton.joints.iter();
    for (at, (joint, known)) in joints.zip(&articulation.joints).enumerate() {
        let of_part = |region: Region| match known.region {
            own if is_leg(own) => is_leg(region),
            own => is_trunk(own) && is_trunk(region),
        };
        let above = joint
            .parent
            .filter(|p| of_part(articulation.joints[*p].region));
        lengths[at] = above.map_or(0.0, |p| lengths[p] + places[at].distance(places[p]));
        match known.region {
            _ if known.hanim.is_none() => {}
            region if is_leg(region) => down = down.max(lengths[at]),
            region if is_trunk(region) => up = up.max(lengths[at]),
            _ => {}
        }
    }
    down + up
}
