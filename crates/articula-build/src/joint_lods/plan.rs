//! Bindings that take over the skin of merged joints, and matrices of the mean pose.
//!
//! A vertex stays in the space of its mesh, so the weight of a merged joint goes to the binding
//! that this mesh has for the target joint. If there is none, one is derived from the rest pose.

use super::moments::model_of;
use super::prefixes::Prefixes;
use crate::character::Asset;
use articula_core::{Binding, Mesh, ModelPose};
use glam::{Affine3A, DAffine3};
use std::collections::BTreeMap;

/// Maximum relative difference between a stored inverse bind and a derived one that may share it.
const SAME_BINDING: f32 = 1e-3;

/// Bindings of the full mesh and those added for merged joints, with their matrices in the mean
/// pose.
pub(super) struct Plan<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) prefixes: &'a Prefixes<'a>,
    rest: ModelPose,
    /// Source mesh of each vertex.
    groups: Vec<u32>,
    by_joint: BTreeMap<(u32, u16), u16>,
    bindings: Vec<Binding>,
    mean: Vec<DAffine3>,
}

impl<'a> Plan<'a> {
    pub(super) fn new(asset: &Asset, mesh: &'a Mesh, prefixes: &'a Prefixes<'a>) -> Self {
        let mut groups = vec![0; mesh.len()];
        for part in &mesh.parts {
            groups[part.vertices.clone()].fill(part.mesh as u32);
        }
        let mut by_joint = BTreeMap::new();
        for (v, group) in groups.iter().enumerate() {
            for i in v * mesh.influences..(v + 1) * mesh.influences {
                let index = mesh.binding_indices[i];
                let joint = mesh.bindings[usize::from(index)].joint;
                if mesh.weights[i] > 0.0 {
                    // The smallest index, regardless of the order of vertices.
                    let entry = by_joint.entry((*group, joint)).or_insert(index);
                    *entry = (*entry).min(index);
                }
            }
        }
        let bindings = mesh.bindings.clone();
        let mean = bindings.iter().map(|b| placed(&prefixes.mean, b)).collect();
        Self {
            mesh,
            prefixes,
            rest: model_of(asset, asset.rig.rest_pose()),
            groups,
            by_joint,
            bindings,
            mean,
        }
    }

    /// All bindings, those of the mesh first.
    pub(super) fn bindings(&self) -> &[Binding] {
        &self.bindings
    }

    /// Influences of a vertex; if all weights are 0, the first one.
    pub(super) fn influences(&self, vertex: usize) -> Vec<(u16, f32)> {
        let at = vertex * self.mesh.influences..(vertex + 1) * self.mesh.influences;
        let indices = &self.mesh.binding_indices[at.clone()];
        let all = indices
            .iter()
            .copied()
            .zip(self.mesh.weights[at].iter().copied());
        let used: Vec<(u16, f32)> = all.clone().filter(|(_, w)| *w != 0.0).collect();
        if used.is_empty() {
            all.take(1).collect()
        } else {
            used
        }
    }

    /// Returns the binding that takes over the weight of another on a vertex at a level.
    pub(super) fn target(&mut self, level: usize, vertex: usize, binding: u16) -> u16 {
        let from = self.bindings[usize::from(binding)];
        let joint = usize::from(from.joint);
        let target = self.prefixes.target(joint, level);
        if usize::from(target) == joint {
            return binding;
        }
        let key = (self.groups[vertex], target);
        if let Some(found) = self.by_joint.get(&key) {
            return *found;
        }
        let made = self.bind(target, &from);
        self.by_joint.insert(key, made);
        made
    }

    /// Sum of the mean-pose matrices times their weights.
    pub(super) fn blend(&self, influences: &[(u16, f32)]) -> DAffine3 {
        let mut sum = DAffine3::ZERO;
        for (binding, weight) in influences {
            let matrix = self.mean_matrix(*binding);
            sum.matrix3 += matrix.matrix3 * f64::from(*weight);
            sum.translation += matrix.translation * f64::from(*weight);
        }
        sum
    }

    /// Model-from-mesh matrix of a binding in the mean pose.
    pub(super) fn mean_matrix(&self, binding: u16) -> &DAffine3 {
        &self.mean[usize::from(binding)]
    }

    /// Returns a binding of `joint` in the mesh space of `like`: a stored one that fits, or a new
    /// one.
    fn bind(&mut self, joint: u16, like: &Binding) -> u16 {
        let matrices = &self.rest.matrices;
        let wanted = matrices[usize::from(joint)].inverse()
            * matrices[usize::from(like.joint)]
            * like.inverse_bind;
        let made = Binding {
            joint,
            inverse_bind: if wanted.is_finite() {
                wanted
            } else {
                Affine3A::IDENTITY
            },
        };
        let fits = |b: &Binding| b.joint == joint && close(&b.inverse_bind, &made.inverse_bind);
        if let Some(at) = self.bindings.iter().position(fits) {
            return at as u16;
        }
        self.mean.push(placed(&self.prefixes.mean, &made));
        self.bindings.push(made);
        (self.bindings.len() - 1) as u16
    }
}

fn close(a: &Affine3A, b: &Affine3A) -> bool {
    let (a, b) = (a.to_cols_array(), b.to_cols_array());
    let size = a.iter().fold(0.0f32, |s, x| s.max(x.abs()));
    let apart = a.iter().zip(&b).map(|(x, y)| (x - y).abs());
    apart.fold(0.0, f32::max) <= SAME_BINDING * size
}

fn placed(joints: &[DAffine3], binding: &Binding) -> DAffine3 {
    let (m, t) = (
        binding.inverse_bind.matrix3,
        binding.inverse_bind.translation,
    );
    let inverse_bind = DAffine3::from_mat3_translation(
        glam::DMat3::from_cols(
            m.x_axis.as_dvec3(),
            m.y_axis.as_dvec3(),
            m.z_axis.as_dvec3(),
        ),
        t.as_dvec3(),
    );
    joints[usize::from(binding.joint)] * inverse_bind
}

#[cfg(test)]
mod tests {
    use super::super::mean_pose::mean_pose;
    use super::super::test_figures::arm;
    use super::*;
    use glam::Vec3;

    #[test]
    fn matrices_are_close_relative_to_their_largest_number() {
        let one = Affine3A::from_translation(Vec3::new(0.0, -20.0, 0.0));
        let moved = |by: f32| Affine3A::from_translation(Vec3::new(by, -20.0, 0.0));
        assert!(close(&one, &one));
        assert!(close(&one, &moved(0.0199)) && close(&one, &moved(-0.0199)));
        assert!(!close(&one, &moved(0.0201)) && !close(&one, &moved(-0.0201)));
    }

    #[test]
    fn a_binding_at_another_place_is_scaled_and_moved_with_its_joint() {
        let joint = DAffine3::from_scale_rotation_translation(
            glam::DVec3::splat(2.0),
            glam::DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            glam::DVec3::new(5.0, 0.0, 0.0),
        );
        let binding = Binding {
            joint: 1,
            inverse_bind: Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0)),
        };
        let placed = placed(&[DAffine3::IDENTITY, joint], &binding);
        // (1, 1, 1) moves to (2, 3, 4), then by a quarter turn and twice its size to (-6, 4, 8).
        let point = placed.transform_point3(glam::DVec3::ONE);
        assert!(point.distance(glam::DVec3::new(-1.0, 4.0, 8.0)) < 1e-9);
    }

    #[test]
    fn the_skin_of_a_merged_joint_keeps_its_place_at_rest() {
        let asset = arm(3);
        // One level with all joints, one with the first alone, whose binding this mesh lacks.
        let mut mesh = Mesh::clone(&asset.mesh);
        mesh.bindings[0].inverse_bind = Affine3A::from_translation(Vec3::X * 7.0);
        for index in &mut mesh.binding_indices {
            *index = (*index).max(1);
        }
        let mean = mean_pose(&asset);
        let prefixes = Prefixes::new(&asset.rig, &[0, 1, 2], &[3, 1], &mean);
        let mut plan = Plan::new(&asset, &mesh, &prefixes);
        assert_eq!(plan.target(0, 0, 2), 2);
        let made = plan.target(1, 0, 2);
        assert_eq!((made, plan.bindings().len()), (3, 4));
        // Joint 2 is 2 m above joint 0, at the origin of the mesh.
        let binding = plan.bindings()[3];
        assert_eq!(binding.joint, 0);
        assert!(binding.inverse_bind.abs_diff_eq(Affine3A::IDENTITY, 1e-6));
        assert_eq!(plan.target(1, 5, 1), made, "made once");
        // Nothing moves, so each matrix is the identity, and so is a blend of them.
        let blend = plan.blend(&[(1, 0.25), (2, 0.5), (made, 0.25)]);
        assert!(blend.abs_diff_eq(DAffine3::IDENTITY, 1e-6));
        let half = plan.blend(&[(1, 0.5)]).matrix3.x_axis.x;
        assert!((half - 0.5).abs() < 1e-6);
    }

    #[test]
    fn influences_without_weight_are_left_out_unless_there_is_no_other() {
        let asset = arm(2);
        let mut mesh = Mesh::clone(&asset.mesh);
        mesh.weights[2..4].fill(0.0);
        let mean = mean_pose(&asset);
        let prefixes = Prefixes::new(&asset.rig, &[0, 1], &[2], &mean);
        let plan = Plan::new(&asset, &mesh, &prefixes);
        assert_eq!(plan.influences(0), [(0, 0.5), (0, 0.5)]);
        assert_eq!(plan.influences(1), [(0, 0.0)]);
        assert_eq!(plan.influences(4), [(0, 1.0)]);
        // The lower vertices of the second joint are shared.
        assert_eq!(plan.influences(8), [(1, 0.5), (0, 0.5)]);
    }
}
