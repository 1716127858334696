//! A pose of the target in model space: rotations from rest, and the resulting positions.

use super::plan::Plan;
use super::side::Side;
use glam::{Quat, Vec3, Vec3A};

/// One frame of the target.
#[derive(Debug, Clone)]
pub(super) struct Pose {
    /// Rotation of each joint from its rest orientation, in model space.
    pub(super) deltas: Vec<Quat>,
    /// Position of each joint in model space, metres.
    pub(super) positions: Vec<Vec3>,
}

impl Pose {
    /// The rest pose.
    pub(super) fn new(target: &Side) -> Self {
        Self {
            deltas: vec![Quat::IDENTITY; target.rest.len()],
            positions: target.rest.positions.clone(),
        }
    }

    /// Computes the position of every joint from the rotations, with the root joint at `root`.
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

    /// Local translation of a joint that is not attached to its parent.
    pub(super) fn local_translation(&self, target: &Side, j: usize) -> Vec3 {
        let rest = &target.rest;
        let Some(p) = rest.parents[j] else {
            return self.positions[j];
        };
        // The parent's matrix is its rest matrix, rotated and translated.
        let way = self.deltas[p].inverse() * (self.positions[j] - self.positions[p]);
        let local = Vec3::from(rest.matrices[p].matrix3.inverse() * Vec3A::from(way));
        if local.is_finite() {
            local
        } else {
            rest.locals[j].1
        }
    }
}
