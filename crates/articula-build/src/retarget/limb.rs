//! A limb of two segments, and two-bone inverse kinematics that brings its end to a position.
//!
//! Source: the law of cosines, as in common two-bone solvers. The side to which the middle joint
//! bends is kept.

use super::pose::Pose;
use super::side::Side;
use articula_core::Libm;
use glam::{Quat, Vec3};

/// Maximum distance of a limb's end from its start, as a share of its length: slightly less than
/// straight, so that the bend keeps its side.
const REACH: f32 = 0.9995;
/// Minimum angle between the segments of a limb, radians; soft tissue prevents a smaller one.
const FOLDED: f32 = 0.45;
/// Maximum sine of a bend to the wrong side that is attributed to capture noise: 25 degrees.
const OVERSTRETCH: f32 = 0.42;

/// A leg or an arm: upper, middle and end joint, and the joints that turn with each segment.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Limb {
    pub(super) upper: usize,
    pub(super) middle: usize,
    pub(super) end: usize,
    /// Joints that turn with the upper segment, including `upper`.
    with_upper: Vec<usize>,
    /// Joints that turn with the lower segment.
    with_middle: Vec<usize>,
    /// Joints that turn with the end.
    with_end: Vec<usize>,
    /// Lengths of both segments, metres.
    lengths: [f32; 2],
    /// Direction in which the middle joint points when the limb is bent, at rest in model space: to
    /// the front for a knee, to the back for an elbow.
    point: Vec3,
}

impl Limb {
    /// The leg of a figure on one side.
    pub(super) fn leg(side: &Side, index: usize) -> Option<Self> {
        let leg = side.body.legs[index];
        Self::new(side, [leg.hip, leg.knee?, leg.ankle?], 1.0)
    }

    /// The arm of a figure on one side.
    pub(super) fn arm(side: &Side, index: usize) -> Option<Self> {
        let letter = ['l', 'r'][index];
        let find = |name: &str| side.rest.sided(letter, name);
        let joints = [find("shoulder")?, find("elbow")?, find("wrist")?];
        Self::new(side, joints, -1.0)
    }

    /// The limb of these three joints; `None` if a segment has no length.
    fn new(side: &Side, [upper, middle, end]: [usize; 3], sign: f32) -> Option<Self> {
        let rest = &side.rest;
        let lengths = [
            rest.way(upper, middle).length(),
            rest.way(middle, end).length(),
        ];
        let least = 1e-3 * side.body.leg_metres;
        if lengths.iter().any(|l| *l < least) {
            return None;
        }
        // Each joint belongs to the nearest of the three at or above it.
        let mut with: Vec<Option<usize>> = Vec::with_capacity(rest.len());
        for j in 0..rest.len() {
            let own = [upper, middle, end].into_iter().find(|l| *l == j);
            with.push(own.or_else(|| rest.parents[j].and_then(|p| with[p])));
        }
        let of = |l: usize| (0..rest.len()).filter(|j| with[*j] == Some(l)).collect();
        let frame = side.frames.own[upper].unwrap_or(side.frames.part[upper]);
        Some(Self {
            upper,
            middle,
            end,
            with_upper: of(upper),
            with_middle: of(middle),
            with_end: of(end),
            lengths,
            point: sign * (frame * Vec3::Y),
        })
    }

    /// Minimum and maximum distance of the end from the start.
    pub(super) fn span(&self) -> [f32; 2] {
        let [a, b] = self.lengths;
        let folded = a * a + b * b - 2.0 * a * b * FOLDED.libm_cos();
        [folded.max(0.0).sqrt(), a + b]
    }

    /// Turns both segments so that the end comes to `place`, or as near as it reaches; the end
    /// joint keeps its rotation. Positions are not updated.
    pub(super) fn reach(&self, pose: &mut Pose, place: Vec3) {
        let [start, bend, end] = [self.upper, self.middle, self.end].map(|j| pose.positions[j]);
        let first = bend - start;
        let wanted = place - start;
        let Some(toward) = wanted.try_normalize() else {
            return;
        };
        let straight = first.length() + (end - bend).length();
        let far = (REACH * straight).max((end - start).length());
        let from = (end - start).normalize_or(toward);
        let point = pose.deltas[self.upper] * self.point;
        // A straight limb bends to the side where its middle joint points.
        let bent = first - from * from.dot(first);
        let weight = (bent.length() / (0.05 * first.length())).min(1.0);
        let aside = bent.normalize_or_zero() * weight + point * (1.0 - weight);
        // That side stays fixed in the world; a small part of it turns with the limb, in case the
        // limb turns towards it.
        let along = Quat::from_rotation_arc(from, toward) * aside;
        let sideways = |v: Vec3| v - toward * toward.dot(v);
        let side = sideways(aside + 0.3 * along).normalize_or(toward.any_orthonormal_vector());
        self.bend(pose, toward * wanted.length().min(far), side);
    }

    /// Bends a limb that is hyperextended by the same amount to the right side; returns whether it
    /// was. Positions are not updated.
    pub(super) fn unstretch(&self, pose: &mut Pose) -> bool {
        let [start, bend, end] = [self.upper, self.middle, self.end].map(|j| pose.positions[j]);
        let Some(along) = (end - start).try_normalize() else {
            return false;
        };
        let sideways = |v: Vec3| v - along * along.dot(v);
        let bent = sideways(bend - start);
        let point = sideways(pose.deltas[self.upper] * self.point).normalize_or_zero();
        let wrong = -bent.dot(point);
        let (first, second) = (bend - start, end - bend);
        let size = (first.length() * second.length()).max(1e-12);
        let nearly_straight =
            first.dot(second) > 0.0 && first.cross(second).length() < OVERSTRETCH * size;
        if wrong <= 0.0 || !nearly_straight {
            return false;
        }
        let side = (bent + 2.0 * wrong * point).normalize_or(point);
        self.bend(pose, end - start, side);
        true
    }

    /// Turns the end and the joints that hang from it.
    pub(super) fn turn_end(&self, pose: &mut Pose, turn: Quat) {
        turn_all(pose, &self.with_end, turn);
    }

    /// Turns both segments so that the end lies at `way` from the start and the middle joint on
    /// `side` of the line between.
    fn bend(&self, pose: &mut Pose, way: Vec3, side: Vec3) {
        let [start, bend, end] = [self.upper, self.middle, self.end].map(|j| pose.positions[j]);
        let (first, second) = (bend - start, end - bend);
        let [a, b] = [first.length(), second.length()];
        let near = (a - b).abs().max(1e-3 * (a + b));
        let distance = way.length().clamp(near, (a + b).max(near));
        let toward = way.normalize_or_zero();
        let along = (a * a - b * b + distance * distance) / (2.0 * distance);
        let aside = (a * a - along * along).max(0.0).sqrt();
        let new_first = toward * along + side * aside;
        let new_second = toward * distance - new_first;
        let turn = |from: Vec3, to: Vec3| {
            let (from, to) = (from.normalize_or_zero(), to.normalize_or_zero());
            if from == Vec3::ZERO || to == Vec3::ZERO {
                return Quat::IDENTITY;
            }
            Quat::from_rotation_arc(from, to)
        };
        turn_all(pose, &self.with_upper, turn(first, new_first));
        turn_all(pose, &self.with_middle, turn(second, new_second));
    }
}

fn turn_all(pose: &mut Pose, joints: &[usize], turn: Quat) {
    for j in joints {
        pose.deltas[*j] = (turn * pose.deltas[*j]).normalize();
    }
}
