//! Forearm and hand: palm, knuckles and nails.

use super::{SKIN, between, mix, spot};
use crate::skeleton::{FINGER_POINTS, hand_axes, hand_point};
use glam::{Mat3, Vec3};

/// Half the length and half the width of a nail, in metres.
const NAIL: [f32; 2] = [0.0062, 0.0048];

/// A fingernail.
struct Nail {
    middle: Vec3,
    /// Away from the finger, towards its tip, across.
    axes: Mat3,
}

/// Where the features of the left hand are.
pub(super) struct Hand {
    back: Vec3,
    knuckles: Vec<Vec3>,
    nails: Vec<Nail>,
}

impl Hand {
    pub(super) fn new() -> Self {
        let back = hand_axes().x_axis;
        let joints = FINGER_POINTS.iter().flat_map(|points| &points[1..4]);
        let nail = |points: &[[f32; 3]; 5]| {
            let (end, tip) = (hand_point(points[3]), hand_point(points[4]));
            let along = (tip - end).normalize();
            // The nail of the thumb faces forwards.
            let away = if points[4][2] > 0.04 {
                back + Vec3::Z
            } else {
                back
            };
            let out = (away - along * away.dot(along)).normalize();
            Nail {
                middle: end.lerp(tip, 0.8) + out * 0.006,
                axes: Mat3::from_cols(out, along, out.cross(along)),
            }
        };
        Self {
            back,
            knuckles: joints.map(|p| hand_point(*p)).collect(),
            nails: FINGER_POINTS.iter().map(nail).collect(),
        }
    }

    /// The colour of a point of the forearm or the hand.
    pub(super) fn skin(&self, p: Vec3, normal: Vec3) -> Vec3 {
        let outwards = normal.dot(self.back);
        let hand = between(p.y, 0.0, 0.87, 0.02);
        let palm = 0.5 * hand * (-outwards - 0.1).clamp(0.0, 1.0);
        let pale = mix(SKIN, Vec3::new(0.78, 0.47, 0.36), palm);
        let near = self.knuckles.iter().map(|k| spot(p, k.to_array(), 0.016));
        let knuckle = near.fold(0.0, f32::max) * outwards.max(0.0);
        let elbow = spot(p, [0.222, 1.142, -0.075], 0.04);
        let red = mix(pale, Vec3::new(0.6, 0.27, 0.2), 0.6 * knuckle.max(elbow));
        self.nails
            .iter()
            .fold(red, |color, nail| nail.over(color, p, normal))
    }
}

impl Nail {
    /// `color`, or that of the nail, if the point is on it.
    fn over(&self, color: Vec3, p: Vec3, normal: Vec3) -> Vec3 {
        let at = self.axes.transpose() * (p - self.middle);
        if normal.dot(self.axes.x_axis) < 0.2 || at.x.abs() > 0.008 {
            return color;
        }
        let (along, across) = (at.y / NAIL[0], at.z / NAIL[1]);
        // Round towards the finger, straight at its end.
        let round = if along < 0.0 { along } else { along.powi(3) };
        let inside = 1.0 - round.hypot(across * across);
        let pink = Vec3::new(0.8, 0.5, 0.43);
        let white = Vec3::new(0.86, 0.74, 0.66);
        let nail = mix(pink, white, (along - 0.62) / 0.1);
        let rim = mix(
            color,
            Vec3::new(0.5, 0.22, 0.17),
            0.6 * (inside + 0.25) / 0.2,
        );
        mix(rim, nail, inside / 0.15)
    }
}
