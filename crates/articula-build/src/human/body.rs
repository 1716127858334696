//! The shape of the reference human: trunk, limbs, and how all parts join.
//!
//! All numbers are metres of the left half in the rest pose, drawn after common proportions of
//! an adult of 1.75 m (eight-part limbs, eyes at half the head); the field mirrors them.

use super::field::{Group, Join, Section, Shape, gradient, smooth_min};
use super::{foot, hand, head};
use glam::{Mat3, Vec3};

/// Hips to collar.
const TRUNK: [Section; 15] = [
    [0.84, -0.138, 0.138, 0.072, -0.084],
    [0.90, -0.157, 0.157, 0.086, -0.100],
    [0.95, -0.161, 0.161, 0.094, -0.104],
    [1.00, -0.154, 0.154, 0.097, -0.099],
    [1.05, -0.141, 0.141, 0.096, -0.091],
    [1.10, -0.132, 0.132, 0.093, -0.087],
    [1.15, -0.130, 0.130, 0.093, -0.090],
    [1.20, -0.134, 0.134, 0.097, -0.098],
    [1.25, -0.141, 0.141, 0.103, -0.109],
    [1.30, -0.147, 0.147, 0.107, -0.117],
    [1.35, -0.151, 0.151, 0.101, -0.121],
    [1.40, -0.148, 0.148, 0.085, -0.118],
    [1.44, -0.130, 0.130, 0.061, -0.105],
    [1.48, -0.085, 0.085, 0.030, -0.088],
    [1.51, -0.055, 0.055, 0.012, -0.075],
];

const LEG: [Section; 17] = [
    [0.08, 0.070, 0.140, 0.003, -0.079],
    [0.11, 0.073, 0.138, 0.001, -0.074],
    [0.15, 0.073, 0.136, 0.003, -0.069],
    [0.20, 0.068, 0.140, 0.010, -0.071],
    [0.25, 0.062, 0.145, 0.017, -0.078],
    [0.30, 0.055, 0.151, 0.024, -0.084],
    [0.35, 0.051, 0.154, 0.031, -0.084],
    [0.40, 0.050, 0.152, 0.040, -0.075],
    [0.445, 0.051, 0.147, 0.050, -0.061],
    [0.49, 0.049, 0.147, 0.058, -0.053],
    [0.53, 0.045, 0.149, 0.062, -0.057],
    [0.60, 0.034, 0.156, 0.070, -0.070],
    [0.70, 0.020, 0.164, 0.079, -0.084],
    [0.78, 0.012, 0.167, 0.083, -0.093],
    [0.84, 0.013, 0.1645, 0.079, -0.094],
    [0.90, 0.026, 0.155, 0.068, -0.085],
    [0.96, 0.050, 0.132, 0.040, -0.060],
];

const ARM: [Section; 14] = [
    [0.876, 0.2290, 0.2650, 0.0045, -0.0435],
    [0.90, 0.2220, 0.2665, 0.0065, -0.0485],
    [0.94, 0.2135, 0.2675, 0.008, -0.056],
    [1.00, 0.2020, 0.2665, 0.006, -0.067],
    [1.055, 0.1930, 0.2655, 0.003, -0.077],
    [1.10, 0.1895, 0.2625, -0.001, -0.082],
    [1.14, 0.1865, 0.2580, -0.004, -0.083],
    [1.18, 0.1810, 0.2525, -0.001, -0.081],
    [1.24, 0.1730, 0.2465, 0.006, -0.082],
    [1.30, 0.1650, 0.2405, 0.0105, -0.082],
    [1.36, 0.1545, 0.2360, 0.012, -0.079],
    [1.40, 0.1455, 0.2310, 0.012, -0.076],
    [1.43, 0.1410, 0.2240, 0.009, -0.070],
    [1.45, 0.1450, 0.2150, 0.004, -0.064],
];

/// The whole body as one signed distance field, symmetric about x = 0.
#[derive(Debug, Clone)]
pub(super) struct Body {
    pub(super) trunk: Group,
    pub(super) head: Group,
    pub(super) arm: Group,
    pub(super) palm: Group,
    pub(super) fingers: [Group; 5],
    pub(super) leg: Group,
    pub(super) foot: Group,
}

impl Body {
    /// The mannequin.
    pub(super) fn new() -> Self {
        Self {
            trunk: trunk(),
            head: head::head(),
            arm: arm(),
            palm: hand::palm(),
            fingers: hand::fingers(),
            leg: leg(),
            foot: foot::foot(),
        }
    }

    /// Signed distance to the skin.
    pub(super) fn distance(&self, p: Vec3) -> f32 {
        let p = Vec3::new(p.x.abs(), p.y, p.z);
        let torso = smooth_min(self.trunk.distance(p), self.head.distance(p), 0.03);
        let lower = smooth_min(self.leg.distance(p), self.foot.distance(p), 0.03);
        let core = smooth_min(torso, lower, 0.06);
        smooth_min(core, self.upper_limb(p), armpit_blend(p))
    }

    /// Distance to arm and hand; fingers blend with the palm and never with each other.
    pub(super) fn upper_limb(&self, p: Vec3) -> f32 {
        let palm = self.palm.distance(p);
        let hand = self
            .fingers
            .iter()
            .map(|finger| smooth_min(palm, finger.distance(p), 0.007))
            .fold(palm, f32::min);
        smooth_min(self.arm.distance(p), hand, 0.03)
    }

    /// Unit vector away from the surface.
    pub(super) fn normal(&self, p: Vec3) -> Vec3 {
        gradient(|q| self.distance(q), p)
            .try_normalize()
            .unwrap_or(Vec3::Y)
    }
}

/// Wide at the shoulder, narrow down the inner side of the arm, so that the gap stays open.
fn armpit_blend(p: Vec3) -> f32 {
    let t = ((p.y - 1.29) / 0.11).clamp(0.0, 1.0);
    0.003 + 0.057 * t * t * (3.0 - 2.0 * t)
}

fn turned(x: f32, y: f32, z: f32) -> Mat3 {
    Mat3::from_rotation_z(z) * Mat3::from_rotation_y(y) * Mat3::from_rotation_x(x)
}

fn trunk() -> Group {
    let add = Join::Add;
    let plain = Mat3::IDENTITY;
    Group::default()
        .with(Shape::loft(&TRUNK), add(0.0))
        // Chest, blades, flanks.
        .with(
            Shape::ellipsoid(
                [0.068, 1.345, 0.06],
                [0.076, 0.06, 0.036],
                turned(0.2, 0.25, 0.0),
            ),
            add(0.055),
        )
        .with(
            Shape::ellipsoid(
                [0.08, 1.37, -0.088],
                [0.052, 0.075, 0.03],
                turned(0.0, -0.3, 0.0),
            ),
            add(0.05),
        )
        .with(
            Shape::cone([0.113, 1.35, -0.05], [0.075, 1.13, -0.04], [0.034, 0.03]),
            add(0.05),
        )
        // Collar bones and the slope of the neck.
        .with(
            Shape::cone([0.02, 1.456, 0.011], [0.165, 1.463, -0.022], [0.012, 0.017]),
            add(0.04),
        )
        .with(
            Shape::cone([0.018, 1.55, -0.05], [0.16, 1.455, -0.045], [0.024, 0.026]),
            add(0.06),
        )
        // Seat.
        .with(
            Shape::ellipsoid([0.074, 0.895, -0.056], [0.076, 0.09, 0.066], plain),
            add(0.045),
        )
        // Spine, the line of the breast bone, a hint of a navel.
        .with(
            Shape::cone([0.0, 1.08, -0.112], [0.0, 1.4, -0.143], [0.012, 0.012]),
            Join::Carve(0.045),
        )
        .with(
            Shape::cone([0.0, 1.28, 0.127], [0.0, 1.4, 0.108], [0.008, 0.008]),
            Join::Carve(0.035),
        )
        .with(
            Shape::ellipsoid([0.0, 1.045, 0.101], [0.005, 0.007, 0.006], plain),
            Join::Carve(0.008),
        )
}

fn leg() -> Group {
    let add = Join::Add;
    let plain = Mat3::IDENTITY;
    Group::default()
        .with(Shape::loft(&LEG), add(0.0))
        // Knee cap, the two bellies of the calf, ankle bones.
        .with(
            Shape::ellipsoid([0.098, 0.495, 0.036], [0.027, 0.036, 0.024], plain),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.079, 0.35, -0.05],
                [0.027, 0.08, 0.03],
                turned(0.0, 0.0, -0.06),
            ),
            add(0.04),
        )
        .with(
            Shape::ellipsoid(
                [0.126, 0.365, -0.047],
                [0.025, 0.075, 0.028],
                turned(0.0, 0.0, 0.06),
            ),
            add(0.04),
        )
        .with(
            Shape::ellipsoid([0.077, 0.096, -0.035], [0.011, 0.016, 0.016], plain),
            add(0.02),
        )
        .with(
            Shape::ellipsoid([0.133, 0.085, -0.043], [0.011, 0.017, 0.016], plain),
            add(0.02),
        )
        // Muscle above the knee, inner and outer.
        .with(
            Shape::ellipsoid([0.072, 0.56, 0.028], [0.025, 0.055, 0.03], plain),
            add(0.04),
        )
        .with(
            Shape::ellipsoid([0.124, 0.585, 0.032], [0.025, 0.065, 0.03], plain),
            add(0.04),
        )
}

fn arm() -> Group {
    let add = Join::Add;
    let turn = turned(0.0, 0.0, 0.12);
    Group::default()
        .with(Shape::loft(&ARM), add(0.0))
        // Deltoid, biceps, triceps, elbow, forearm.
        .with(
            Shape::ellipsoid([0.186, 1.405, -0.031], [0.045, 0.08, 0.049], turn),
            add(0.035),
        )
        .with(
            Shape::ellipsoid([0.206, 1.28, -0.01], [0.027, 0.075, 0.023], turn),
            add(0.04),
        )
        .with(
            Shape::ellipsoid([0.203, 1.29, -0.062], [0.028, 0.08, 0.022], turn),
            add(0.04),
        )
        .with(
            Shape::ellipsoid([0.2225, 1.145, -0.07], [0.02, 0.028, 0.014], Mat3::IDENTITY),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.237, 1.07, -0.03],
                [0.027, 0.07, 0.031],
                turned(0.0, 0.0, 0.09),
            ),
            add(0.04),
        )
}
