//! Which tracks of a motion move, which are constant, and around which values they are coded.

use super::levers::{FLOOR_METRES, Mover, Rest, greatest, levers};
use super::skin_points::SkinPoints;
use super::truth::Truth;
use crate::abp2::pose_unit::{Kind, REFERENCE};
use crate::abp2::rotation::log;
use crate::abp2::tracks::unit;
use articula_core::Rig;
use glam::{DQuat, DVec3};

/// Motion of the skin below which a track is constant or at rest, in metres.
const STILL_METRES: f64 = 1e-5;

/// A track that is not at rest.
#[derive(Debug, Clone)]
pub(super) struct PlannedTrack {
    pub(super) kind: Kind,
    pub(super) target: u16,
    pub(super) moves: bool,
    /// Value around which it is coded, relative to rest.
    pub(super) reference: [f64; 3],
    /// Greatest distance that it moves a point, per unit.
    pub(super) lever: f64,
    /// A translation is coded in 2^-exponent of the joint's unit, about a metre.
    pub(super) exponent: i32,
}

impl PlannedTrack {
    pub(super) fn mover(&self) -> Mover {
        let target = usize::from(self.target);
        match self.kind {
            Kind::Rotation => Mover::Rotation(target),
            Kind::Translation => Mover::Translation(target),
            Kind::Scale => Mover::Scale(target),
            Kind::Morph => Mover::Morph(target),
        }
    }

    /// The reference of a moving track in whole numbers.
    pub(super) fn numbers(&self) -> [i32; 3] {
        let size = f64::from(unit(self.exponent)) / REFERENCE;
        self.reference.map(|x| (x / size).round() as i32)
    }
}

/// The values of a track relative to rest at every frame.
fn values(kind: Kind, target: usize, truth: &Truth, rig: &Rig) -> Vec<DVec3> {
    let rest = rig.rest_pose().clone();
    let at = |frame: usize| frame * truth.joints + target;
    let mut before = DVec3::ZERO;
    let value = |frame: usize| match kind {
        Kind::Rotation => {
            let rest = rest.rotations[target].as_dquat().normalize();
            before = log(rest.conjugate() * truth.rotation(frame, target), before);
            before
        }
        Kind::Translation => (truth.translations[at(frame)] - rest.translations[target]).as_dvec3(),
        Kind::Scale => (truth.scales[at(frame)] - rest.scales[target]).as_dvec3(),
        Kind::Morph => DVec3::X * f64::from(truth.weights(frame)[target]),
    };
    (0..truth.frames).map(value).collect()
}

/// Mean rotation relative to rest, as a rotation vector.
fn mean_rotation(target: usize, truth: &Truth, rig: &Rig) -> DVec3 {
    let rest = rig.rest_pose().rotations[target].as_dquat().normalize();
    let mut sum = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    for frame in 0..truth.frames {
        let q = rest.conjugate() * truth.rotation(frame, target);
        sum = if sum.dot(q) < 0.0 { sum - q } else { sum + q };
    }
    let length = sum.length();
    if length < 1e-3 * truth.frames as f64 {
        return DVec3::ZERO;
    }
    log(sum / length, DVec3::ZERO)
}

/// Returns the tracks that are not at rest, in the order joints, properties, morph targets.
pub(super) fn plan(
    rig: &Rig,
    points: &SkinPoints,
    rest: &Rest,
    truth: &Truth,
) -> Vec<PlannedTrack> {
    let mut wanted: Vec<(Kind, usize)> = Vec::new();
    for joint in 0..rig.len() {
        wanted.extend([Kind::Rotation, Kind::Translation, Kind::Scale].map(|kind| (kind, joint)));
    }
    wanted.extend((0..truth.targets).map(|slot| (Kind::Morph, slot)));
    let movers: Vec<Mover> = wanted
        .iter()
        .map(|(kind, target)| match kind {
            Kind::Rotation => Mover::AloneRotation(*target),
            Kind::Translation => Mover::Translation(*target),
            Kind::Scale => Mover::Scale(*target),
            Kind::Morph => Mover::Morph(*target),
        })
        .collect();
    let levers = levers(rig, points, rest, &movers, &vec![false; rig.len()]);
    let mut planned = Vec::new();
    for ((kind, target), lever) in wanted.into_iter().zip(greatest(&levers)) {
        let values = values(kind, target, truth, rig);
        let first = values[0];
        let change = values.iter().map(|v| v.distance(first)).fold(0.0, f64::max);
        let moves = truth.frames > 1 && change * lever > STILL_METRES;
        let reference = match kind {
            _ if !moves => first,
            Kind::Rotation => mean_rotation(target, truth, rig),
            _ => {
                let (low, high) = values
                    .iter()
                    .fold((first, first), |(low, high), v| (low.min(*v), high.max(*v)));
                (low + high) / 2.0
            }
        };
        if moves || reference.length() * lever > STILL_METRES {
            planned.push(PlannedTrack {
                kind,
                target: target as u16,
                moves,
                reference: reference.to_array(),
                lever: lever.max(FLOOR_METRES),
                exponent: match kind {
                    Kind::Translation => rest.metres_exponent(target),
                    _ => 0,
                },
            });
        }
    }
    planned
}
