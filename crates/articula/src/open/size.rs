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

/// Length of the bones from the farthest joint of the legs up to the first joint that a map knows, and
/// from there to the farthest joint of trunk and head.
fn bone_metres(opened: &CharacterFile, articulation: &Articulation, places: &[Vec3A]) -> f32 {
    let mut from_first: Vec<Option<f32>> = Vec::with_capacity(places.len());
    let (mut down, mut up) = (0.0_f32, 0.0_f32);
    let joints = opened.character.skeleton.joints.iter();
    for (at, (joint, known)) in joints.zip(&articulation.joints).enumerate() {
        let above = joint.parent.and_then(|p| {
            let bone = places[at].distance(places[p]);
            from_first[p].map(|length| length + bone)
        });
        from_first.push(above.or(known.hanim.is_some().then_some(0.0)));
        let length = above.filter(|_| known.hanim.is_some()).unwrap_or(0.0);
        match known.region {
            Region::Legs | Region::Feet => down = down.max(length),
            Region::Torso | Region::Face => up = up.max(length),
            Region::Arms | Region::Pelvis | Region::Hands => {}
        }
    }
    down + up
}
