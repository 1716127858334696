//! The jaw: which points it carries, and how far.

use crate::mouth::{CORNER, Side, line, parting};
use crate::person_pieces::Sheet;
use crate::weights::smooth_step;
use glam::{Quat, Vec3};

/// Middle of the axis about which the jaw turns, before the ears.
const HINGE: Vec3 = Vec3::new(0.0, 1.606, 0.012);

/// Angle of the open jaw in radians.
const OPEN: f32 = 0.3;

/// Share of the jaw's motion that the corners of the mouth take.
const AT_CORNER: f32 = 0.42;

/// The motion of the lower jaw.
pub(crate) struct Jaw {
    /// Left corner of the mouth.
    corner: Vec3,
}

impl Jaw {
    pub(crate) fn new(corner: Vec3) -> Self {
        Self { corner }
    }

    /// Share of the jaw's motion at a point; x may have either sign.
    pub(crate) fn weight(&self, p: Vec3, sheet: Sheet) -> f32 {
        let along = along(p, sheet);
        match sheet {
            Sheet::Teeth(Side::Lower) | Sheet::Tongue => 1.0,
            Sheet::Lip(side) => at_lip(side, along),
            Sheet::Skin => self.skin(p, along),
            _ => 0.0,
        }
    }

    fn skin(&self, p: Vec3, along: f32) -> f32 {
        let (below, reach) = self.below(p);
        let fade = 1.0 - smooth_step(0.0, reach, below.abs());
        let share = if below <= 0.0 {
            at_lip(Side::Upper, along) * fade
        } else {
            1.0 - (1.0 - at_lip(Side::Lower, along)) * fade
        };
        // The throat and what is behind the jaw stay.
        let throat = smooth_step(1.517, 1.552, p.y + 0.45 * p.z);
        share * throat * smooth_step(-0.05, -0.01, p.z)
    }

    /// Height below the line from the middle of the mouth over its corner to the hinge, and how far
    /// from it skin takes part of the motion.
    fn below(&self, p: Vec3) -> (f32, f32) {
        if p.x.abs() < CORNER {
            return (line(p.x) - p.y, 0.02);
        }
        let back = ((self.corner.z - p.z) / (self.corner.z - HINGE.z)).clamp(0.0, 1.0);
        let height = self.corner.y + back * (HINGE.y - self.corner.y);
        (height - p.y, 0.02 + 0.03 * back)
    }

    /// The displacement of a point by the open jaw.
    pub(crate) fn opened(&self, p: Vec3, sheet: Sheet) -> Vec3 {
        let share = self.weight(p, sheet);
        let pinch = match sheet {
            Sheet::Skin | Sheet::Lip(_) => {
                let near = (1.0 - (p - self.corner).length_squared() / 0.03_f32.powi(2)).max(0.0);
                let inward = (p.x / CORNER).min(1.0);
                Vec3::new(-0.0028 * inward, 0.0, -0.0012) * near * near
            }
            _ => Vec3::ZERO,
        };
        turned(p, share) + pinch
    }

    /// The displacement by which lips stay closed while the jaw opens: the lower lip then moves as the
    /// upper one.
    pub(crate) fn closed_lips(&self, p: Vec3, sheet: Sheet) -> Vec3 {
        let along = along(p, sheet);
        let (below, _) = self.below(p);
        let is_lower = sheet == Sheet::Lip(Side::Lower) || sheet == Sheet::Skin && below > 0.0;
        if !is_lower || p.x.abs() >= CORNER && sheet == Sheet::Skin {
            return Vec3::ZERO;
        }
        let near = match sheet {
            Sheet::Skin => 1.0 - smooth_step(0.008, 0.032, below),
            _ => 1.0,
        };
        let share = self.weight(p, sheet);
        let held = share + near * (at_lip(Side::Upper, along) - share).min(0.0);
        turned(p, held) - turned(p, share)
    }
}

/// 0 where the lips part in the middle, 1 where the skin is whole: at the corners, and at the back of
/// the mouth.
fn along(p: Vec3, sheet: Sheet) -> f32 {
    let front = match sheet {
        Sheet::Skin => smooth_step(0.038, 0.055, p.z),
        _ => 1.0,
    };
    1.0 - parting(p.x) * front
}

/// Share of the jaw's motion on a lip; `along` is 0 in the middle and 1 at the corner.
fn at_lip(side: Side, along: f32) -> f32 {
    match side {
        Side::Upper => AT_CORNER * along,
        Side::Lower => 1.0 - (1.0 - AT_CORNER) * along,
    }
}

fn turned(p: Vec3, share: f32) -> Vec3 {
    let arm = Vec3::new(0.0, p.y - HINGE.y, p.z - HINGE.z);
    Quat::from_rotation_x(OPEN * share) * arm - arm
}
