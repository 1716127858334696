//! The side to which elbows and knees bend, seen in a motion.
//!
//! Straight limbs at rest do not tell it, and not every capture means the same by a T-pose:
//! elbows of the CMU figures bend 30 degrees above forward. Where the rest pose leaves it open,
//! the bends of a clip decide.

use super::frames::Fronts;
use super::motion::Motion;
use super::side::Side;
use glam::Vec3;

/// Mean sine of the bend that a clip must show at least: 12 degrees.
const ENOUGH: f32 = 0.2;
/// Length of the mean bend over the mean length of the bends: 1 is a perfect hinge.
const STEADY: f32 = 0.9;
/// Cosine between what is seen and what the rest pose suggests, at least: 75 degrees.
const PLAUSIBLE: f32 = 0.26;

/// What a motion shows of the hinges of its figure.
pub(super) fn seen(source: &Side, motion: &Motion) -> Fronts {
    let mut fronts = Fronts::new();
    for side in ['l', 'r'] {
        for (names, sign) in [
            (["shoulder", "elbow", "wrist"], 1.0),
            (["hip", "knee", "ankle"], -1.0),
        ] {
            let joints = names.map(|n| source.rest.sided(side, n));
            if let [Some(upper), Some(middle), Some(end)] = joints
                && let Some(front) = front(source, motion, [upper, middle, end], sign)
            {
                fronts.insert(upper, front);
            }
        }
    }
    fronts
}

fn front(source: &Side, motion: &Motion, joints: [usize; 3], sign: f32) -> Option<Vec3> {
    let [upper, middle, end] = joints;
    let along = source.rest.way(upper, middle).try_normalize()?;
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for f in 0..motion.frames() {
        let places = motion.positions(f);
        let lower = (places[end] - places[middle]).normalize_or_zero();
        let lower = motion.deltas(f)[upper].inverse() * lower;
        let bend = lower - along * along.dot(lower);
        // Slight bends are noise; the square makes the strong ones decide.
        sum += bend * bend.length();
        total += bend.length_squared();
    }
    let steady = sum.length() > STEADY * total;
    let enough = total > ENOUGH * ENOUGH * motion.frames() as f32;
    let front = sign * sum.try_normalize()?;
    let expected = source.frames.own[upper]? * Vec3::Y;
    (steady && enough && front.dot(expected) > PLAUSIBLE).then_some(front)
}
