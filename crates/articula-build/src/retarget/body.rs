//! Orientation of a figure at rest, and the length of its legs.
//!
//! A rest pose may face any direction; the names of left and right joints determine its front.

use super::rest::Rest;
use articula_core::Mismatch;
use articula_core::{Libm, LibmQuat};
use glam::{Mat3, Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Minimum cosine between up axis and vertical of an upright rest pose.
const UPRIGHT_COSINE: f32 = 0.8;
/// A rest pose that is turned from an axis by less than this faces along the axis.
const SQUARE_RADIANS: f32 = 0.35;
/// Maximum height of the lowest joint, as a share of the leg, with which a figure counts as
/// standing on a floor at height 0.
const NEAR_FLOOR: f32 = 0.15;
/// Height of the toe joint above the floor where the rest pose does not determine it, as a share of
/// the leg: about the middle of 20 rigs, whose values range from 0 to 0.07.
const TOE_HEIGHT: f32 = 0.03;
/// Height of the ankle, likewise; it is a joint at the heel in some rigs: 0.02 to 0.39.
const ANKLE_HEIGHT: f32 = 0.1;

/// One leg: hip, knee, ankle and the joint at which the toes bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leg {
    pub(super) hip: usize,
    pub(super) knee: Option<usize>,
    pub(super) ankle: Option<usize>,
    pub(super) toe: Option<usize>,
}

/// Measurements of a figure's body in its rest pose.
#[derive(Debug, Clone)]
pub(super) struct Body {
    /// Rotation from (left, up, forward) to model space.
    pub(super) axes: Quat,
    /// Rotation about +Y that takes +Z to the direction in which the figure faces.
    pub(super) heading: Quat,
    /// Left and right leg.
    pub(super) legs: [Leg; 2],
    /// Length from hip over knee to ankle at rest, mean of both sides; at least a millimetre.
    pub(super) leg_metres: f32,
    /// Height of the ankles above the floor with a flat foot.
    pub(super) ankle_height: f32,
    /// Height of the joints of the toes above the floor with a flat foot.
    pub(super) toe_height: f32,
    /// Whether the rest pose stands on the floor at height 0.
    pub(super) stands_on_floor: bool,
    /// The joint from which the legs hang in the body: the sacroiliac or the root joint.
    pub(super) pelvis: usize,
    /// The joint mapped to the H-Anim root.
    pub(super) root: usize,
}

impl Body {
    pub(super) fn new(rest: &Rest, which: &str) -> Result<Self, Mismatch> {
        let find = |name: &str| {
            rest.find(name)
                .ok_or_else(|| Mismatch::new(which, format!("no joint is mapped to {name}")))
        };
        let root = find("humanoid_root")?;
        let hips = [find("l_hip")?, find("r_hip")?];
        let legs = ['l', 'r'].map(|side| leg(rest, side, hips));
        let sacroiliac = rest
            .find("sacroiliac")
            .filter(|s| rest.between(*s, hips[0]).is_some());
        let axes = axes(rest, &legs);
        let leg_metres = leg_metres(rest, &legs);
        let mut body = Self {
            axes,
            heading: heading(axes),
            legs,
            leg_metres,
            ankle_height: 0.0,
            toe_height: 0.0,
            stands_on_floor: false,
            pelvis: sacroiliac.unwrap_or(root),
            root,
        };
        body.stand(rest);
        Ok(body)
    }

    pub(super) fn left(&self) -> Vec3 {
        self.axes * Vec3::X
    }

    pub(super) fn up(&self) -> Vec3 {
        self.axes * Vec3::Y
    }

    pub(super) fn forward(&self) -> Vec3 {
        self.axes * Vec3::Z
    }

    /// Midpoint of the hips.
    pub(super) fn middle(&self, positions: &[Vec3]) -> Vec3 {
        0.5 * (positions[self.legs[0].hip] + positions[self.legs[1].hip])
    }

    /// Computes the heights of ankles and toes above the floor.
    fn stand(&mut self, rest: &Rest) {
        let mean = |of: &dyn Fn(&Leg) -> Option<usize>| {
            let found: Vec<f32> = self
                .legs
                .iter()
                .filter_map(of)
                .map(|j| rest.positions[j].y)
                .collect();
            (!found.is_empty()).then(|| found.iter().sum::<f32>() / found.len() as f32)
        };
        let ankle = mean(&|l| l.ankle);
        let toe = mean(&|l| l.toe);
        let lowest = ankle.into_iter().chain(toe).reduce(f32::min);
        let upright = self.up().y > UPRIGHT_COSINE;
        let near = |y: f32| (-0.02..NEAR_FLOOR).contains(&(y / self.leg_metres));
        self.stands_on_floor = upright && lowest.is_some_and(near);
        let leg = self.leg_metres;
        (self.ankle_height, self.toe_height) = match (ankle, toe) {
            (ankle, toe) if self.stands_on_floor => {
                let ankle = ankle.unwrap_or(ANKLE_HEIGHT * leg).max(0.0);
                (ankle, toe.unwrap_or(ankle).max(0.0))
            }
            (Some(ankle), Some(toe)) if upright && (0.0..0.4 * leg).contains(&(ankle - toe)) => {
                (ankle - toe + TOE_HEIGHT * leg, TOE_HEIGHT * leg)
            }
            _ => (ANKLE_HEIGHT * leg, TOE_HEIGHT * leg),
        };
    }
}

fn leg(rest: &Rest, side: char, hips: [usize; 2]) -> Leg {
    let toes = [
        "metatarsal",
        "metatarsophalangeal_1",
        "metatarsophalangeal_3",
    ];
    Leg {
        hip: hips[usize::from(side == 'r')],
        knee: rest.sided(side, "knee"),
        ankle: rest.sided(side, "ankle"),
        toe: toes.iter().find_map(|name| rest.sided(side, name)),
    }
}

fn leg_metres(rest: &Rest, legs: &[Leg; 2]) -> f32 {
    let of = |leg: &Leg| {
        let joints = [Some(leg.hip), leg.knee, leg.ankle];
        let joints: Vec<usize> = joints.into_iter().flatten().collect();
        joints
            .windows(2)
            .map(|w| rest.way(w[0], w[1]).length())
            .sum::<f32>()
    };
    let length = 0.5 * (of(&legs[0]) + of(&legs[1]));
    if length > 1e-3 {
        return length;
    }
    // Without legs: about half of the figure's extent.
    let low = rest.positions.iter().copied().reduce(Vec3::min);
    let high = rest.positions.iter().copied().reduce(Vec3::max);
    let extent = low.zip(high).map_or(0.0, |(l, h)| (h - l).max_element());
    (0.5 * extent).max(1e-3)
}

/// Left, up and forward of the trunk.
fn axes(rest: &Rest, legs: &[Leg; 2]) -> Quat {
    let unit = |from: usize, to: usize| rest.way(from, to).normalize_or_zero();
    let shoulders = ['l', 'r'].map(|s| rest.sided(s, "shoulder"));
    let mut left = unit(legs[1].hip, legs[0].hip);
    if let [Some(l), Some(r)] = shoulders {
        left += unit(r, l);
    }
    let top = ["skullbase", "vc4", "vc2", "vc7"]
        .iter()
        .find_map(|n| rest.find(n))
        .or(shoulders[0]);
    let middle = 0.5 * (rest.positions[legs[0].hip] + rest.positions[legs[1].hip]);
    let mut up = top.map_or(Vec3::ZERO, |t| {
        (rest.positions[t] - middle).normalize_or_zero()
    });
    if let [Some(l), Some(r)] = [legs[0].ankle, legs[1].ankle] {
        let feet = 0.5 * (rest.positions[l] + rest.positions[r]);
        up += (middle - feet).normalize_or_zero();
    }
    let up = squared(up, UPRIGHT_COSINE).unwrap_or(Vec3::Y);
    let left = (left - up * up.dot(left)).normalize_or_zero();
    let left = if left == Vec3::ZERO {
        up.any_orthonormal_vector()
    } else {
        left
    };
    let left = squared(left, SQUARE_RADIANS.libm_cos()).unwrap_or(left);
    let left = (left - up * up.dot(left)).normalize();
    Quat::from_mat3(&Mat3::from_cols(left, up, left.cross(up))).normalize()
}

/// The axis of model space nearest to a direction if it is close enough; else the normalised
/// direction.
fn squared(direction: Vec3, cosine: f32) -> Option<Vec3> {
    let unit = direction.try_normalize()?;
    let along = [Vec3::X, Vec3::Y, Vec3::Z]
        .map(|axis| axis * unit.dot(axis).signum())
        .into_iter()
        .find(|axis| unit.dot(*axis) > cosine);
    Some(along.unwrap_or(unit))
}

/// Rotation about +Y that takes +Z to the direction in which a body with these axes faces.
fn heading(axes: Quat) -> Quat {
    let forward = axes * Vec3::Z;
    let flat = |v: Vec3| Vec3::new(v.x, 0.0, v.z);
    // For a lying figure the side is more reliable than the front.
    let facing = if flat(forward).length() > 0.5 {
        flat(forward)
    } else {
        flat((axes * Vec3::X).cross(Vec3::Y))
    };
    if facing.length() < 1e-3 {
        return Quat::IDENTITY;
    }
    let angle = facing.x.libm_atan2(facing.z);
    let quarter = (angle / FRAC_PI_2).round() * FRAC_PI_2;
    Quat::libm_rotation_y(if (angle - quarter).abs() < 1e-4 {
        quarter
    } else {
        angle
    })
}
