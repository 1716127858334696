//! From parameters to the motion of handles: what a parameter says of one component of one point, and
//! what goes with it.
//!
//! A parameter moves one point along one axis; skin moves in three. The rules for the other
//! components and for neighbouring points are engineering constants (`docs/methods/faces.md`).

use super::super::fap_values::FapValues;
use super::super::points::FaceUnits;
use super::handles::{Handle, HandleKind};
use articula_core::fap_table::{FapDirection, FapUnit, LOW_FAPS, TABLE};
use articula_core::feature_points::PointId;
use glam::Vec3;

/// Places that the rules refer to, and the units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RuleFrame {
    pub(super) units: FaceUnits,
    /// 2.1, the hinge of the jaw at 10.9 and 10.10, and its height.
    pub(super) chin: Vec3,
    pub(super) hinge: Vec3,
}

/// Displacements of the feature points by parameters.
struct Motion<'a> {
    frame: &'a RuleFrame,
    values: &'a FapValues,
}

impl RuleFrame {
    /// Displacement of each handle by parameters, metres.
    pub(super) fn motion(&self, values: &FapValues, handles: &[Handle]) -> Vec<Vec3> {
        let motion = Motion {
            frame: self,
            values,
        };
        handles
            .iter()
            .map(|handle| match handle.what {
                // Lids are moved as wholes, beside the handles.
                HandleKind::Resting | HandleKind::Rim(..) => Vec3::ZERO,
                HandleKind::Moving(point) if point.0 == 3 => Vec3::ZERO,
                HandleKind::Moving(point) => motion.of(point, handle.place),
            })
            .collect()
    }

    /// Value of FAP 18 by which the jaw alone moves the chin boss.
    pub(super) fn chin_boss(&self, values: &FapValues, place: Vec3) -> f32 {
        let mut jaw = FapValues::default();
        jaw.0[0] = values.get(3);
        let motion = Motion {
            frame: self,
            values: &jaw,
        };
        motion.of((2, 10), place).y / (self.units.mouth_nose / 1024.0)
    }

    /// Shift of the lower jaw, metres.
    pub(super) fn jaw_shift(&self, values: &FapValues) -> Vec3 {
        let motion = Motion {
            frame: self,
            values,
        };
        let jaw = motion.component((2, 1));
        Vec3::new(jaw.x, 0.0, jaw.z)
    }

    /// Rotation of the lower jaw about the axis through its hinge, radians; positive opens.
    pub(super) fn jaw_radians(&self, values: &FapValues) -> f32 {
        let motion = Motion {
            frame: self,
            values,
        };
        -motion.component((2, 1)).y / (self.chin.z - self.hinge.z).max(1e-4)
    }
}

impl Motion<'_> {
    fn component(&self, point: PointId) -> Vec3 {
        component(self.values, point, |unit| self.frame.units.distance(unit))
    }

    /// Motion of a corner of the lips: in as it goes out and up.
    fn corner(&self, point: PointId) -> Vec3 {
        let own = self.component(point);
        let out = outward(point) * own.x;
        Vec3::new(own.x, own.y, own.z - 0.25 * (out + 1.2 * own.y.max(0.0)))
    }

    /// Motion of a feature point outside of the lids.
    fn of(&self, point: PointId, place: Vec3) -> Vec3 {
        let own = self.component(point);
        let jaw = self.component((2, 1));
        let frame = self.frame;
        let turn = jaw.y / (frame.chin.z - frame.hinge.z).max(1e-4);
        let with_jaw = |share: f32| {
            Vec3::new(
                share * jaw.x,
                share * turn * (place.z - frame.hinge.z),
                share * jaw.z,
            )
        };
        match point {
            (2, 1) => own,
            (2, 10) => own + with_jaw(1.0),
            (2, 11 | 12) => with_jaw(1.0),
            (2, 13 | 14) => {
                let back = -0.5 * turn * (place.y - frame.hinge.y);
                Vec3::new(
                    0.6 * jaw.x,
                    0.7 * turn * (place.z - frame.hinge.z),
                    0.6 * jaw.z + back,
                )
            }
            (2, 4 | 5) | (8, 3 | 4) => self.corner(point),
            (2, 2 | 3) | (8, 1 | 2) => self.middle(point),
            (2, 6..=9) | (8, 5..=8) => {
                let (middle, corner) = quarter(point);
                let (middle, corner) = (self.middle(middle), self.corner(corner));
                let side = outward(point);
                let z = 0.75 * middle.z - 0.25 * 0.3 * side * corner.x;
                Vec3::new(0.5 * middle.x + 0.4 * corner.x, own.y, z)
            }
            (5, 1 | 2) => {
                let corner = self.component(if point.1 == 1 { (2, 4) } else { (2, 5) });
                let out = outward(point) * own.x;
                let z = 0.6 * out - 0.25 * corner.y.max(0.0);
                Vec3::new(own.x, 0.6 * corner.y, z)
            }
            (9, 1 | 2) => {
                let lip = self.component(if point.1 == 1 { (8, 5) } else { (8, 6) });
                own + Vec3::Y * 0.45 * lip.y.max(0.0)
            }
            (4, 3 | 4) => {
                let inner = self.component(if point.1 == 3 { (4, 1) } else { (4, 2) });
                own + Vec3::X * 0.5 * inner.x
            }
            _ => own,
        }
    }

    /// Motion of the middle of a lip.
    fn middle(&self, point: PointId) -> Vec3 {
        let own = self.component(point);
        let corners = match point {
            (8, _) => [(8, 3), (8, 4)],
            _ => [(2, 4), (2, 5)],
        };
        let aside: f32 = corners.iter().map(|c| 0.5 * self.component(*c).x).sum();
        let jaw = match point {
            (2, 3) | (8, 2) => self.component((2, 1)).x,
            _ => 0.0,
        };
        let inner = match point {
            (8, 1) => self.component((2, 2)).z,
            (8, 2) => self.component((2, 3)).z,
            _ => own.z,
        };
        Vec3::new(0.5 * (aside + jaw), own.y, inner)
    }
}

/// Components that parameters say of a point, with the distance of each unit in metres.
pub(super) fn component(
    values: &FapValues,
    point: PointId,
    distance: impl Fn(FapUnit) -> f32,
) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for fap in LOW_FAPS {
        let Some(action) = TABLE[fap - 1].action.filter(|a| a.point == point) else {
            continue;
        };
        let Some(axis) = axis(action.direction) else {
            continue;
        };
        sum += axis * distance(action.unit) / 1024.0 * values.get(fap);
    }
    sum
}

/// Direction of a positive value; `None` for those that are no translation.
pub(super) fn axis(direction: FapDirection) -> Option<Vec3> {
    match direction {
        FapDirection::Up => Some(Vec3::Y),
        FapDirection::Down => Some(-Vec3::Y),
        FapDirection::Left => Some(Vec3::X),
        FapDirection::Right => Some(-Vec3::X),
        FapDirection::Forward => Some(Vec3::Z),
        FapDirection::Growth | FapDirection::Curl => None,
    }
}

/// 1 for points of the left half of the face, -1 for those of the right half.
fn outward(point: PointId) -> f32 {
    match point {
        (2, 4 | 6 | 8) | (8, 3 | 5 | 7) | (5, 1 | 3) => 1.0,
        _ => -1.0,
    }
}

/// Middle of the lip and corner between which a quarter point lies.
fn quarter(point: PointId) -> (PointId, PointId) {
    match point {
        (2, 6) => ((2, 2), (2, 4)),
        (2, 7) => ((2, 2), (2, 5)),
        (2, 8) => ((2, 3), (2, 4)),
        (2, 9) => ((2, 3), (2, 5)),
        (8, 5) => ((8, 1), (8, 3)),
        (8, 6) => ((8, 1), (8, 4)),
        (8, 7) => ((8, 2), (8, 3)),
        _ => ((8, 2), (8, 4)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> RuleFrame {
        RuleFrame {
            units: FaceUnits {
                iris_diameter: 0.01,
                eye_separation: 0.06,
                eye_nose: 0.05,
                mouth_nose: 0.02,
                mouth_width: 0.05,
            },
            chin: Vec3::new(0.0, -0.08, 0.1),
            hinge: Vec3::ZERO,
        }
    }

    fn moved(faps: &[(usize, f32)], what: HandleKind, place: Vec3) -> Vec3 {
        let mut values = FapValues::default();
        for (fap, value) in faps {
            values.0[fap - 3] = *value;
        }
        let handle = Handle {
            what,
            vertex: 0,
            place,
        };
        frame().motion(&values, &[handle])[0]
    }

    fn near(a: Vec3, b: Vec3) {
        assert!((a - b).length() < 1e-6, "{a}, not {b}");
    }

    #[test]
    fn the_jaw_turns_what_is_around_it() {
        // 1024 units of MNS: the chin goes 20 mm down, 0.2 rad for 100 mm from the hinge.
        let open = [(3, 1024.0)];
        let chin = Vec3::new(0.0, -0.08, 0.1);
        near(
            moved(&open, HandleKind::Moving((2, 1)), chin),
            Vec3::new(0.0, -0.02, 0.0),
        );
        let half = Vec3::new(0.02, -0.06, 0.05);
        near(
            moved(&open, HandleKind::Moving((2, 11)), half),
            Vec3::new(0.0, -0.01, 0.0),
        );
        near(
            moved(&open, HandleKind::Moving((2, 13)), half),
            Vec3::new(0.0, -0.007, -0.006),
        );
        // The lips have parameters of their own.
        near(moved(&open, HandleKind::Moving((2, 3)), half), Vec3::ZERO);
        near(moved(&open, HandleKind::Resting, half), Vec3::ZERO);
        let mut values = FapValues::default();
        values.0[0] = 1024.0;
        assert!((frame().jaw_radians(&values) - 0.2).abs() < 1e-6);
        // The chin boss goes down by 20 mm at the depth of the chin: 1024 units against its own.
        assert!((frame().chin_boss(&values, chin) + 1024.0).abs() < 1e-3);
    }

    #[test]
    fn corners_go_in_as_they_go_out_and_take_the_lip_along() {
        // The left corner 5 mm out, and 2 mm up.
        let smile = [(6, 102.4), (12, 102.4)];
        let corner = moved(&smile, HandleKind::Moving((2, 4)), Vec3::ZERO);
        near(
            corner,
            Vec3::new(0.005, 0.002, -0.25 * (0.005 + 1.2 * 0.002)),
        );
        near(
            moved(&smile, HandleKind::Moving((2, 2)), Vec3::ZERO),
            Vec3::new(0.00125, 0.0, 0.0),
        );
        let quarter = moved(&smile, HandleKind::Moving((2, 6)), Vec3::ZERO);
        near(
            quarter,
            Vec3::new(0.5 * 0.00125 + 0.4 * 0.005, 0.0, -0.25 * 0.3 * 0.005),
        );
        let cheek = moved(&smile, HandleKind::Moving((5, 1)), Vec3::ZERO);
        near(cheek, Vec3::new(0.0, 0.6 * 0.002, -0.25 * 0.002));
        // The right corner out is towards -X, and goes in as much.
        let right = moved(&[(7, 102.4)], HandleKind::Moving((2, 5)), Vec3::ZERO);
        near(right, Vec3::new(-0.005, 0.0, -0.25 * 0.005));
    }
}
