//! Detection in a motion of the side to which elbows and knees bend.
//!
//! Straight limbs at rest do not determine it, and T-poses of captures differ: elbows of the CMU
//! figures bend 30 degrees above forward. Where the rest pose is ambiguous, the bends of a clip
//! decide.

use super::frames::Fronts;
use super::motion::Motion;
use super::side::Side;
use glam::Vec3;

/// Minimum root mean square of the sine of the bends of a clip: 12 degrees.
const ENOUGH: f32 = 0.2;
/// Minimum length of the mean bend over the mean length of the bends: 1 is a perfect hinge.
const STEADY: f32 = 0.9;
/// Minimum cosine between the detected front and that of the rest pose: 75 degrees.
const PLAUSIBLE: f32 = 0.26;

/// Fronts of the limbs that a motion determines.
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
        // Slight bends are noise; the square gives weight to the strong ones.
        sum += bend * bend.length();
        total += bend.length_squared();
    }
    let steady = sum.length() > STEADY * total;
    let enough = total > ENOUGH * ENOUGH * motion.frames() as f32;
    let front = sign * sum.try_normalize()?;
    let expected = source.frames.own[upper]? * Vec3::Y;
    (steady && enough && front.dot(expected) > PLAUSIBLE).then_some(front)
}
