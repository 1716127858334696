//! The body of the reference human: trunk, limbs, and how all parts join.
//!
//! All numbers are metres of the left half in the rest pose, after common proportions of an adult
//! of 1.75 m (eight-part limbs, eyes at half the head); the field is mirrored.

use crate::field::{Group, Join, Section, Shape, gradient, smooth_min};
use crate::{foot, hand, head};
use glam::{Mat3, Vec3};

/// The trunk from hips to collar.
const TRUNK: [Section; 16] = [
    [0.885, -0.14, 0.14, 0.066, -0.086],
    [0.92, -0.149, 0.149, 0.074, -0.098],
    [0.96, -0.1495, 0.1495, 0.08, -0.101],
    [1.0, -0.144, 0.144, 0.084, -0.095],
    [1.05, -0.132, 0.132, 0.085, -0.084],
    [1.1, -0.122, 0.122, 0.084, -0.077],
    [1.14, -0.119, 0.119, 0.085, -0.076],
    [1.18, -0.122, 0.122, 0.088, -0.08],
    [1.23, -0.131, 0.131, 0.093, -0.089],
    [1.28, -0.14, 0.14, 0.098, -0.099],
    [1.33, -0.146, 0.146, 0.099, -0.106],
    [1.37, -0.147, 0.147, 0.094, -0.108],
    [1.41, -0.137, 0.137, 0.082, -0.105],
    [1.44, -0.113, 0.113, 0.064, -0.098],
    [1.47, -0.077, 0.077, 0.038, -0.086],
    [1.495, -0.052, 0.052, 0.017, -0.076],
];

const LEG: [Section; 17] = [
    [0.08, 0.077, 0.133, 0.002, -0.073],
    [0.12, 0.077, 0.133, 0.0, -0.067],
    [0.16, 0.0735, 0.1345, 0.002, -0.067],
    [0.21, 0.068, 0.1385, 0.009, -0.072],
    [0.27, 0.0605, 0.1455, 0.019, -0.081],
    [0.33, 0.0555, 0.1505, 0.028, -0.087],
    [0.38, 0.0535, 0.15, 0.035, -0.084],
    [0.43, 0.0535, 0.145, 0.0415, -0.072],
    [0.47, 0.053, 0.142, 0.047, -0.06],
    [0.5, 0.0515, 0.142, 0.0515, -0.056],
    [0.55, 0.0465, 0.145, 0.058, -0.057],
    [0.62, 0.0355, 0.151, 0.066, -0.067],
    [0.7, 0.0225, 0.158, 0.073, -0.081],
    [0.77, 0.014, 0.162, 0.077, -0.091],
    [0.83, 0.014, 0.16, 0.076, -0.094],
    [0.89, 0.028, 0.15, 0.065, -0.086],
    [0.95, 0.052, 0.128, 0.04, -0.06],
];

const ARM: [Section; 13] = [
    [0.876, 0.2295, 0.2645, 0.004, -0.043],
    [0.9, 0.2245, 0.2645, 0.0055, -0.0475],
    [0.94, 0.2165, 0.2655, 0.006, -0.055],
    [1.0, 0.204, 0.266, 0.005, -0.066],
    [1.05, 0.1948, 0.2658, 0.003, -0.075],
    [1.09, 0.1896, 0.2636, 0.0, -0.08],
    [1.13, 0.1867, 0.2577, -0.0045, -0.0825],
    [1.17, 0.182, 0.252, -0.004, -0.082],
    [1.22, 0.1737, 0.2467, 0.002, -0.082],
    [1.28, 0.163, 0.241, 0.009, -0.082],
    [1.34, 0.152, 0.235, 0.0135, -0.0815],
    [1.385, 0.144, 0.23, 0.016, -0.08],
    [1.415, 0.1405, 0.2235, 0.014, -0.076],
];

/// The whole body as one signed distance field, symmetric about x = 0.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) trunk: Group,
    pub(crate) head: Group,
    pub(crate) arm: Group,
    pub(crate) palm: Group,
    pub(crate) fingers: [Group; 5],
    pub(crate) leg: Group,
    pub(crate) foot: Group,
}

impl Body {
    /// Creates the mannequin.
    pub(crate) fn new() -> Self {
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

    /// Signed distance to the skin, in metres.
    pub(crate) fn distance(&self, p: Vec3) -> f32 {
        let p = Vec3::new(p.x.abs(), p.y, p.z);
        let torso = smooth_min(self.trunk.distance(p), self.head.distance(p), 0.03);
        let lower = smooth_min(self.leg.distance(p), self.foot.distance(p), 0.03);
        let core = smooth_min(torso, lower, 0.09);
        smooth_min(core, self.upper_limb(p), armpit_blend(p))
    }

    /// Distance to arm and hand; fingers blend with the palm but not with each other.
    pub(crate) fn upper_limb(&self, p: Vec3) -> f32 {
        let palm = self.palm.distance(p);
        let hand = self
            .fingers
            .iter()
            .map(|finger| smooth_min(palm, finger.distance(p), 0.007))
            .fold(palm, f32::min);
        smooth_min(self.arm.distance(p), hand, 0.03)
    }

    /// Outward unit normal of the field.
    pub(crate) fn normal(&self, p: Vec3) -> Vec3 {
        gradient(|q| self.distance(q), p)
            .try_normalize()
            .unwrap_or(Vec3::Y)
    }
}

/// Blend distance of arm and trunk: wide at the shoulder, narrow down the inner side of the arm, so
/// that the gap stays open.
fn armpit_blend(p: Vec3) -> f32 {
    let t = ((p.y - 1.29) / 0.11).clamp(0.0, 1.0);
    0.003 + 0.057 * t * t * (3.0 - 2.0 * t)
}

fn turned(x: f32, y: f32, z: f32) -> Mat3 {
    Mat3::from_rotation_z(z) * Mat3::from_rotation_y(y) * Mat3::from_rotation_x(x)
}

fn trunk() -> Group {
    let add = Join::Add;
    Group::default()
        .with(Shape::loft(&TRUNK), add(0.0))
        // Chest, shoulder blades, flanks.
        .with(
            Shape::ellipsoid(
                [0.066, 1.345, 0.058],
                [0.072, 0.06, 0.036],
                turned(0.2, 0.25, 0.0),
            ),
            add(0.06),
        )
        .with(
            Shape::ellipsoid(
                [0.075, 1.37, -0.078],
                [0.05, 0.075, 0.03],
                turned(0.0, -0.3, 0.0),
            ),
            add(0.055),
        )
        .with(
            Shape::cone([0.112, 1.36, -0.05], [0.074, 1.15, -0.035], [0.034, 0.026]),
            add(0.05),
        )
        // Collar bones and the slope of the neck.
        .with(
            Shape::cone([0.02, 1.447, 0.004], [0.155, 1.448, -0.024], [0.012, 0.016]),
            add(0.045),
        )
        .with(
            Shape::cone([0.024, 1.53, -0.06], [0.155, 1.45, -0.042], [0.022, 0.024]),
            add(0.05),
        )
        // Buttocks.
        .with(
            Shape::ellipsoid(
                [0.072, 0.895, -0.056],
                [0.074, 0.085, 0.064],
                Mat3::IDENTITY,
            ),
            add(0.045),
        )
        // Spine.
        .with(
            Shape::cone([0.0, 1.06, -0.101], [0.0, 1.4, -0.133], [0.012, 0.012]),
            Join::Carve(0.045),
        )
}

fn leg() -> Group {
    let add = Join::Add;
    let plain = Mat3::IDENTITY;
    Group::default()
        .with(Shape::loft(&LEG), add(0.0))
        // Knee cap, inner calf, ankle bones.
        .with(
            Shape::ellipsoid([0.098, 0.496, 0.029], [0.025, 0.04, 0.022], plain),
            add(0.05),
        )
        .with(
            Shape::ellipsoid(
                [0.083, 0.355, -0.047],
                [0.022, 0.11, 0.032],
                turned(0.0, 0.0, -0.06),
            ),
            add(0.05),
        )
        .with(
            Shape::ellipsoid([0.0805, 0.094, -0.034], [0.009, 0.019, 0.016], plain),
            add(0.026),
        )
        .with(
            Shape::ellipsoid([0.1295, 0.084, -0.042], [0.009, 0.02, 0.016], plain),
            add(0.026),
        )
}

fn arm() -> Group {
    let add = Join::Add;
    let turn = turned(0.0, 0.0, 0.12);
    Group::default()
        .with(Shape::loft(&ARM), add(0.0))
        // Deltoid, elbow, forearm.
        .with(
            Shape::ellipsoid([0.184, 1.39, -0.031], [0.044, 0.068, 0.049], turn),
            add(0.035),
        )
        .with(
            Shape::ellipsoid([0.2225, 1.142, -0.066], [0.02, 0.03, 0.014], Mat3::IDENTITY),
            add(0.03),
        )
}
