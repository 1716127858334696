//! A shared motion as a list of transforms.

use super::path::fixed;
use crate::planar::keyed_clip::KeyedTrack;
use crate::planar::keyed_motion::{ANGLE, KeyedMotion, SCALE, TRANSLATION};

/// Numbers in units of a power of ten, as a list.
pub(super) fn fixed_numbers(values: &[i32], unit: f64) -> String {
    let texts: Vec<String> = values.iter().map(|v| fixed(*v, unit)).collect();
    let mut out = texts[0].clone();
    for text in &texts[1..] {
        out.push_str(if text.starts_with('-') { "" } else { " " });
        out.push_str(text);
    }
    out
}

/// Parts of a motion in the sequence of a list of transforms: name, numbers, units of 1. Rotation, skew and
/// scale are left out where they change nothing.
pub(super) fn transforms(motion: &KeyedMotion) -> Vec<(&'static str, &KeyedTrack, f64)> {
    let [translation, rotation, skew, scale] = motion.tracks();
    let parts = [
        ("rotate", rotation, ANGLE, 0),
        ("skewX", skew, ANGLE, 0),
        ("scale", scale, SCALE, SCALE as i32),
    ];
    let changes = |track: &KeyedTrack, usual: i32| track.values.iter().any(|v| *v != usual);
    let parts = parts
        .into_iter()
        .filter(|(_, track, _, usual)| changes(track, *usual));
    std::iter::once(("translate", translation, TRANSLATION))
        .chain(parts.map(|(kind, track, unit, _)| (kind, track, unit)))
        .collect()
}
