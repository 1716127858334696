//! The observed points of the body: every joint, and all skin that it moves.
//!
//! A vertex is a weighted mean of the positions to which its joints take it, so its error is
//! nowhere larger than that of the joint matrices applied to the vertex in their own spaces. All
//! vertices of a joint lie in a box in its space, and a box moves most at a corner: nine points per
//! joint bound the whole skin.

use super::super::subject::{EditSubject, Posed};
use crate::motion_error::joint_lever::JointLever;
use articula_core::source::{Property, RawClip};
use glam::{Affine3A, Vec3, Vec3A};

/// A box in the space of its joint.
#[derive(Debug, Clone, Copy)]
struct Hull {
    low: Vec3A,
    high: Vec3A,
}

impl Hull {
    fn add(hull: &mut Option<Self>, low: Vec3, high: Vec3) {
        let (low, high) = (low.into(), high.into());
        let grown = hull.map_or(Self { low, high }, |h| Self {
            low: h.low.min(low),
            high: h.high.max(high),
        });
        *hull = Some(grown);
    }

    fn corners(self) -> impl Iterator<Item = Vec3A> {
        (0..8).map(move |c| {
            let pick = |bit: usize, axis: usize| {
                if c & bit == 0 {
                    self.low[axis]
                } else {
                    self.high[axis]
                }
            };
            Vec3A::new(pick(1, 0), pick(2, 1), pick(4, 2))
        })
    }
}

/// The observed points of all joints.
#[derive(Debug)]
pub(super) struct Watch {
    hulls: Vec<Option<Hull>>,
}

impl Watch {
    /// The skin of each joint with the morph targets that the clip may show. End joints without
    /// skin get a small lever, so that their rotations count.
    pub(super) fn new(subject: &EditSubject<'_>, clip: &RawClip) -> Self {
        let rig = &subject.rig;
        let mut hulls: Vec<Option<Hull>> = vec![None; rig.len()];
        let morphed = morphed(subject, clip);
        let mesh = &subject.mesh;
        for (v, (low, high)) in morphed.into_iter().enumerate() {
            let (low, high) = (mesh.positions[v] + low, mesh.positions[v] + high);
            let at = v * mesh.influences..(v + 1) * mesh.influences;
            for (b, w) in mesh.binding_indices[at.clone()]
                .iter()
                .zip(&mesh.weights[at])
            {
                if *w > 0.0 {
                    let binding = &mesh.bindings[usize::from(*b)];
                    let (low, high) = boxed(&binding.inverse_bind, low, high);
                    Hull::add(&mut hulls[usize::from(binding.joint)], low, high);
                }
            }
        }
        for (joint, point) in &subject.ends {
            Hull::add(&mut hulls[*joint], *point, *point);
        }
        let mut is_last = vec![true; rig.len()];
        (0..rig.len())
            .filter_map(|j| rig.parent(j))
            .for_each(|p| is_last[p] = false);
        let rest = subject.rest();
        for (j, hull) in hulls.iter_mut().enumerate() {
            if !is_last[j] || hull.is_some() {
                continue;
            }
            let half = least_lever(subject, &rest, j) / 3.0f32.sqrt();
            *hull = Some(Hull {
                low: Vec3A::splat(-half),
                high: Vec3A::splat(half),
            });
        }
        Self { hulls }
    }

    /// Maximum distance of the joint's points from their wanted positions, and the farthest point
    /// in the joint's space. Points that are certainly closer than `enough` are skipped.
    pub(super) fn error(
        &self,
        joint: usize,
        wanted: &Posed,
        shown: &Posed,
        enough: f32,
    ) -> (f32, Vec3A) {
        let (a, b) = (&wanted.model.matrices[joint], &shown.model.matrices[joint]);
        let linear = b.matrix3 - a.matrix3;
        let offset = b.translation - a.translation;
        let mut worst = (offset.length(), Vec3A::ZERO);
        let Some(hull) = self.hulls[joint] else {
            return worst;
        };
        let (centre, half) = (0.5 * (hull.low + hull.high), 0.5 * (hull.high - hull.low));
        let spread = half.x * linear.x_axis.length()
            + half.y * linear.y_axis.length()
            + half.z * linear.z_axis.length();
        let at_most = (linear * centre + offset).length() + spread;
        if at_most <= enough {
            worst.0 = worst.0.max(at_most);
            return worst;
        }
        for corner in hull.corners() {
            let far = (linear * corner + offset).length();
            if far > worst.0 {
                worst = (far, corner);
            }
        }
        worst
    }

    /// Distance from a joint to the farthest observed point at or below it, at rest.
    pub(super) fn levers(&self, subject: &EditSubject<'_>) -> Vec<f32> {
        let rest = subject.rest();
        let rig = &subject.rig;
        let mut levers = vec![JointLever::FLOOR_METRES; rig.len()];
        for joint in 0..rig.len() {
            let model = &rest.model.matrices[joint];
            let corners = self.hulls[joint].into_iter().flat_map(Hull::corners);
            let points: Vec<Vec3A> = corners
                .map(|c| model.transform_point3a(c))
                .chain([model.translation])
                .collect();
            let mut at = Some(joint);
            while let Some(j) = at {
                let from = rest.model.matrices[j].translation;
                let far = points.iter().map(|p| p.distance(from)).fold(0.0, f32::max);
                levers[j] = levers[j].max(far);
                at = rig.parent(j);
            }
        }
        levers
    }
}

/// Lever of an end joint that moves no skin, in its own space: half of the bone that leads to it
/// where there is no mesh at all, otherwise the minimum lever that counts.
fn least_lever(subject: &EditSubject<'_>, rest: &Posed, joint: usize) -> f32 {
    let matrix = &rest.model.matrices[joint];
    let scale = matrix.matrix3.x_axis.length().max(1e-6);
    let bone = subject.rig.parent(joint).map_or(0.0, |p| {
        rest.model.position(joint).distance(rest.model.position(p))
    });
    let metres = if subject.mesh.is_empty() {
        0.5 * bone
    } else {
        0.0
    };
    metres.max(JointLever::FLOOR_METRES) / scale
}

/// Range of the displacement of each vertex by morph targets along each axis, lower and upper end.
fn morphed(subject: &EditSubject<'_>, clip: &RawClip) -> Vec<(Vec3, Vec3)> {
    let mesh = &subject.mesh;
    let mut greatest = mesh.morph_weights.clone();
    let mut least = mesh.morph_weights.clone();
    for channel in clip
        .channels
        .iter()
        .filter(|c| c.property == Property::Weights)
    {
        let (slot, count) = (
            mesh.morph_slots[channel.target],
            subject.morph_counts[channel.target],
        );
        for (i, value) in channel.values.iter().enumerate() {
            let slot = slot + i % count;
            greatest[slot] = greatest[slot].max(*value);
            least[slot] = least[slot].min(*value);
        }
    }
    let mut ways = vec![(Vec3::ZERO, Vec3::ZERO); mesh.len()];
    for morph in &mesh.morphs {
        let slot = usize::from(morph.slot);
        for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
            let (a, b) = (*offset * least[slot], *offset * greatest[slot]);
            let way = &mut ways[*v as usize];
            way.0 += a.min(b).min(Vec3::ZERO);
            way.1 += a.max(b).max(Vec3::ZERO);
        }
    }
    ways
}

/// The axis-aligned box around a box transformed by a matrix.
fn boxed(matrix: &Affine3A, low: Vec3, high: Vec3) -> (Vec3, Vec3) {
    let centre = matrix.transform_point3(0.5 * (low + high));
    let half = 0.5 * (high - low);
    let turned = Vec3::from(matrix.matrix3.x_axis).abs() * half.x
        + Vec3::from(matrix.matrix3.y_axis).abs() * half.y
        + Vec3::from(matrix.matrix3.z_axis).abs() * half.z;
    (centre - turned, centre + turned)
}
