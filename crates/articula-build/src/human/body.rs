//! The shape of the reference human: trunk, limbs, and how all parts join.
//!
//! All numbers are metres of the left half in the rest pose, drawn after common proportions of
//! an adult of 1.75 m (eight-part limbs, eyes at half the head); the field mirrors them.

use super::field::{Group, Join, Section, Shape, gradient, smooth_min};
use super::{foot, hand, head};
use glam::{Mat3, Vec3};

/// Hips to collar.
const TRUNK: [Section; 15] = [
    [0.84, -0.148, 0.148, 0.078, -0.088],
    [0.90, -0.166, 0.166, 0.09, -0.102],
    [0.95, -0.168, 0.168, 0.096, -0.104],
    [1.00, -0.157, 0.157, 0.098, -0.097],
    [1.05, -0.142, 0.142, 0.096, -0.087],
    [1.10, -0.132, 0.132, 0.092, -0.083],
    [1.15, -0.131, 0.131, 0.092, -0.087],
    [1.20, -0.137, 0.137, 0.097, -0.097],
    [1.25, -0.145, 0.145, 0.104, -0.109],
    [1.30, -0.153, 0.153, 0.108, -0.118],
    [1.35, -0.158, 0.158, 0.102, -0.122],
    [1.40, -0.153, 0.153, 0.086, -0.119],
    [1.44, -0.132, 0.132, 0.062, -0.106],
    [1.48, -0.085, 0.085, 0.03, -0.088],
    [1.51, -0.055, 0.055, 0.012, -0.075],
];

const LEG: [Section; 16] = [
    [0.08, 0.070, 0.140, 0.004, -0.080],
    [0.11, 0.073, 0.138, 0.001, -0.074],
    [0.15, 0.073, 0.136, 0.003, -0.068],
    [0.20, 0.068, 0.140, 0.011, -0.070],
    [0.25, 0.061, 0.146, 0.018, -0.079],
    [0.30, 0.053, 0.153, 0.025, -0.087],
    [0.35, 0.048, 0.157, 0.033, -0.088],
    [0.40, 0.049, 0.153, 0.041, -0.077],
    [0.445, 0.053, 0.146, 0.050, -0.060],
    [0.49, 0.051, 0.146, 0.058, -0.051],
    [0.53, 0.046, 0.149, 0.061, -0.056],
    [0.60, 0.034, 0.157, 0.069, -0.071],
    [0.70, 0.019, 0.166, 0.079, -0.085],
    [0.78, 0.011, 0.170, 0.084, -0.094],
    [0.84, 0.010, 0.170, 0.085, -0.098],
    [0.90, 0.020, 0.168, 0.085, -0.092],
];

const ARM: [Section; 14] = [
    [0.872, 0.2265, 0.2675, 0.0075, -0.0465],
    [0.90, 0.2205, 0.2675, 0.0075, -0.0495],
    [0.94, 0.213, 0.268, 0.008, -0.056],
    [1.00, 0.2015, 0.267, 0.006, -0.068],
    [1.055, 0.192, 0.266, 0.003, -0.079],
    [1.10, 0.189, 0.2625, -0.001, -0.083],
    [1.14, 0.187, 0.2575, -0.006, -0.083],
    [1.18, 0.180, 0.2525, -0.002, -0.081],
    [1.24, 0.1705, 0.2465, 0.006, -0.083],
    [1.30, 0.161, 0.241, 0.0105, -0.083],
    [1.36, 0.150, 0.237, 0.012, -0.08],
    [1.40, 0.143, 0.232, 0.012, -0.076],
    [1.43, 0.141, 0.224, 0.009, -0.07],
    [1.45, 0.145, 0.215, 0.004, -0.064],
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
        let core = smooth_min(torso, lower, 0.045);
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
        smooth_min(self.arm.distance(p), hand, 0.02)
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
    let t = ((p.y - 1.25) / 0.13).clamp(0.0, 1.0);
    0.004 + 0.041 * t * t * (3.0 - 2.0 * t)
}

fn turned(x: f32, y: f32, z: f32) -> Mat3 {
    Mat3::from_rotation_z(z) * Mat3::from_rotation_y(y) * Mat3::from_rotation_x(x)
}

fn trunk() -> Group {
    let add = Join::Add;
    Group::default()
        .with(Shape::loft(&TRUNK), add(0.0))
        // Chest, blades, flanks.
        .with(
            Shape::ellipsoid(
                [0.07, 1.345, 0.062],
                [0.078, 0.058, 0.04],
                turned(0.2, 0.25, 0.0),
            ),
            add(0.045),
        )
        .with(
            Shape::ellipsoid(
                [0.082, 1.37, -0.09],
                [0.055, 0.075, 0.034],
                turned(0.0, -0.3, 0.0),
            ),
            add(0.04),
        )
        .with(
            Shape::cone([0.13, 1.34, -0.05], [0.1, 1.14, -0.045], [0.034, 0.026]),
            add(0.05),
        )
        // Collar bones and the slope of the neck.
        .with(
            Shape::cone([0.02, 1.456, 0.012], [0.165, 1.463, -0.022], [0.014, 0.018]),
            add(0.035),
        )
        .with(
            Shape::cone([0.02, 1.55, -0.05], [0.16, 1.455, -0.045], [0.026, 0.027]),
            add(0.05),
        )
        // Seat.
        .with(
            Shape::ellipsoid([0.078, 0.9, -0.068], [0.078, 0.082, 0.07], Mat3::IDENTITY),
            add(0.03),
        )
        // Spine, navel and the line under the breast bone.
        .with(
            Shape::cone([0.0, 1.08, -0.108], [0.0, 1.4, -0.142], [0.012, 0.012]),
            Join::Carve(0.04),
        )
        .with(
            Shape::cone([0.0, 1.28, 0.125], [0.0, 1.4, 0.108], [0.008, 0.008]),
            Join::Carve(0.03),
        )
        .with(
            Shape::ellipsoid([0.0, 1.045, 0.1], [0.005, 0.007, 0.006], Mat3::IDENTITY),
            Join::Carve(0.01),
        )
}

fn leg() -> Group {
    let add = Join::Add;
    Group::default()
        .with(Shape::loft(&LEG), add(0.0))
        // Knee cap, the two bellies of the calf, shin, ankle bones.
        .with(
            Shape::ellipsoid([0.098, 0.492, 0.042], [0.025, 0.032, 0.02], Mat3::IDENTITY),
            add(0.025),
        )
        .with(
            Shape::ellipsoid(
                [0.078, 0.35, -0.055],
                [0.028, 0.075, 0.032],
                turned(0.0, 0.0, -0.06),
            ),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.126, 0.365, -0.052],
                [0.026, 0.07, 0.03],
                turned(0.0, 0.0, 0.06),
            ),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.076, 0.096, -0.035],
                [0.011, 0.016, 0.016],
                Mat3::IDENTITY,
            ),
            add(0.02),
        )
        .with(
            Shape::ellipsoid(
                [0.134, 0.085, -0.043],
                [0.011, 0.017, 0.016],
                Mat3::IDENTITY,
            ),
            add(0.02),
        )
        // Muscle above the knee, inner and outer.
        .with(
            Shape::ellipsoid([0.07, 0.555, 0.03], [0.026, 0.05, 0.03], Mat3::IDENTITY),
            add(0.03),
        )
        .with(
            Shape::ellipsoid([0.125, 0.58, 0.035], [0.026, 0.06, 0.03], Mat3::IDENTITY),
            add(0.03),
        )
}

fn arm() -> Group {
    let add = Join::Add;
    Group::default()
        .with(Shape::loft(&ARM), add(0.0))
        // Deltoid, biceps, triceps, elbow.
        .with(
            Shape::ellipsoid(
                [0.186, 1.41, -0.031],
                [0.046, 0.075, 0.05],
                turned(0.0, 0.0, 0.12),
            ),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.204, 1.28, -0.008],
                [0.028, 0.07, 0.024],
                turned(0.04, 0.0, 0.12),
            ),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.2, 1.29, -0.065],
                [0.03, 0.075, 0.023],
                turned(0.0, 0.0, 0.12),
            ),
            add(0.03),
        )
        .with(
            Shape::ellipsoid(
                [0.2225, 1.14, -0.075],
                [0.018, 0.022, 0.014],
                Mat3::IDENTITY,
            ),
            add(0.02),
        )
        .with(
            Shape::ellipsoid(
                [0.238, 1.07, -0.03],
                [0.028, 0.06, 0.032],
                turned(0.0, 0.0, 0.09),
            ),
            add(0.03),
        )
}
