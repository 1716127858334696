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
