//! Figures of a size that no human has.

use super::CharacterFile;
use articula_core::{Articulation, Region};
use articula_formats::{Assumption, Warning};
use glam::Affine3A;
use std::ops::RangeInclusive;

/// Heights of human figures at rest, from a small child to a giant of a game, in metres.
const HUMAN_METRES: RangeInclusive<f32> = 0.4..=3.2;
/// Number of joints of legs that a map must know for a figure to count as a whole human.
const MIN_LEG_JOINTS: usize = 3;

/// Returns a warning if a human figure is of a size that no human has.
pub(super) fn unusual(opened: &CharacterFile) -> Option<Warning> {
    let articulation = opened.articulation();
    let known = articulation.joints.iter().filter(|j| j.hanim.is_some());
    if known.filter(|j| j.region == Region::Legs).count() < MIN_LEG_JOINTS {
        return None;
    }
    let height = height_metres(opened, &articulation);
    // A figure that lies, or bones without length, tell nothing.
    if HUMAN_METRES.contains(&height) || height <= 0.0 || !height.is_finite() {
        return None;
    }
    let shown = match height {
        0.001..1e6 => format!("{height:.3}"),
        _ => format!("{height:e}"),
    };
    let what = format!("the figure is {shown} m tall at rest, the size of no human");
    Some(Warning {
        at: "file".to_owned(),
        what,
        guess: Some(Assumption::Unit),
    })
}

/// Height of the joints that a map knows, at rest.
fn height_metres(opened: &CharacterFile, articulation: &Articulation) -> f32 {
    let joints = &opened.character.skeleton.joints;
    let mut model: Vec<Affine3A> = Vec::with_capacity(joints.len());
    for joint in joints {
        let above = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
        model.push(above * joint.rest.to_affine());
    }
    let places = model.iter().zip(&articulation.joints);
    let places = places.filter(|(_, joint)| joint.hanim.is_some());
    let (low, high) = places.fold((f32::MAX, f32::MIN), |(low, high), (place, _)| {
        (low.min(place.translation.y), high.max(place.translation.y))
    });
    high - low
}
