//! A pose of the target in model space: rotations from rest, and the places that follow.

use super::motion::Motion;
use super::plan::{Drive, Plan, Side, Source, swing};
use articula_core::math::same_hemisphere;
use glam::{Quat, Vec3};

/// One frame of the target.
#[derive(Debug, Clone)]
pub(super) struct Pose {
    /// Rotation of each joint from its rest orientation, in model space.
    pub(super) deltas: Vec<Quat>,
    /// Position of each joint in model space, metres.
    pub(super) positions: Vec<Vec3>,
}

impl Pose {
    pub(super) fn new(target: &Side) -> Self {
        Self {
            deltas: vec![Quat::IDENTITY; target.rest.len()],
            positions: target.rest.positions.clone(),
        }
    }

    /// Turns every joint as the plan says.
    pub(super) fn turn(
        &mut self,
        plan: &Plan,
        source: &Side,
        target: &Side,
        motion: (&Motion, usize),
    ) {
        let (motion, frame) = motion;
        let read = |s: &Source| {
            let mut delta = motion.deltas(frame)[s.joint];
            if let Some((from, to)) = s.along {
                let places = motion.positions(frame);
                let now = places[to] - places[from];
                delta = swing(delta, source.rest.way(from, to), now);
            }
            plan.world * delta * s.frame
        };
        for j in 0..self.deltas.len() {
            self.deltas[j] = match &plan.drives[j] {
                Drive::Held => target.rest.parents[j].map_or(Quat::IDENTITY, |p| self.deltas[p]),
                Drive::Twin(s) => read(s),
                Drive::Between(a, b, share) => {
                    let (a, b) = (read(a), read(b));
                    a.slerp(same_hemisphere(a, b), *share)
                }
            };
        }
    }

    /// Puts every joint where the rotations bring it, the root joint at `root`.
    pub(super) fn place(&mut self, plan: &Plan, target: &Side, root: Vec3) {
        let rest = &target.rest;
        for &j in &plan.order {
            self.positions[j] = match plan.floats[j].or(rest.parents[j]) {
                _ if j == target.body.root => root,
                Some(base) => self.positions[base] + self.deltas[base] * rest.way(base, j),
                None => rest.positions[j],
            };
        }
    }

    /// Local rotation of a joint.
    pub(super) fn local_rotation(&self, target: &Side, j: usize) -> Quat {
        let rest = &target.rest;
        let around = rest.parent_rotation(j);
        let above = rest.parents[j].map_or(Quat::IDENTITY, |p| self.deltas[p]);
        let turn = around.inverse() * above.inverse() * self.deltas[j] * around;
        (turn * rest.locals[j].0).normalize()
    }

    /// Local translation of a joint that does not stay fixed to its parent.
    pub(super) fn local_translation(&self, target: &Side, j: usize) -> Vec3 {
        let rest = &target.rest;
        let Some(p) = rest.parents[j] else {
            return self.positions[j];
        };
        // The parent's matrix is its rest matrix, turned and moved.
        let way = self.deltas[p].inverse() * (self.positions[j] - self.positions[p]);
        let local = rest.matrices[p].matrix3.inverse() * glam::Vec3A::from(way);
        let local = Vec3::from(local);
        if local.is_finite() {
            local
        } else {
            rest.locals[j].1
        }
    }
}
