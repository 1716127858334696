//! Displacement caused by fewer keys of morph weights, in metres.
//!
//! A vertex moves by at most the sum of its offsets' lengths, each times the error of its weight.
//! Vertices are grouped by the target that moves them most, and each group has the maximum length
//! of every target: a bound of some fifty sums instead of fifty for each vertex.

use super::super::channel;
use super::super::subject::EditSubject;
use articula_core::JointSet;
use articula_core::source::{Channel, Property, RawClip};

/// Vertices that the same target moves most.
#[derive(Debug, Clone)]
struct Gathering {
    /// Maximum offset by each target of the mesh, metres.
    lengths: Vec<f32>,
    /// Joints that move any of them.
    joints: JointSet,
}

/// The groups of each mesh whose weights a clip drives.
#[derive(Debug)]
pub(super) struct MorphErrors {
    /// Index of the channel and its groups.
    meshes: Vec<(usize, Vec<Gathering>)>,
}

impl MorphErrors {
    pub(super) fn new(subject: &EditSubject<'_>, clip: &RawClip) -> Self {
        let driven = clip.channels.iter().enumerate();
        let driven = driven.filter(|(_, c)| c.property == Property::Weights);
        Self {
            meshes: driven
                .map(|(i, c)| (i, gathered(subject, c.target)))
                .collect(),
        }
    }

    /// Whether the weights of a channel displace no vertex by more than `metres`.
    pub(super) fn is_within(&self, channel: usize, a: &[f32], b: &[f32], metres: f32) -> bool {
        let of_mesh = self.meshes.iter().filter(|(c, _)| *c == channel);
        of_mesh
            .flat_map(|(_, g)| g)
            .all(|g| g.error(a, b) <= metres)
    }

    /// The error of the skin of each joint at a time; `out` has one value per joint.
    pub(super) fn errors(&self, source: &RawClip, shown: &[Channel], secs: f32, out: &mut [f32]) {
        out.fill(0.0);
        for (c, gatherings) in &self.meshes {
            let a = channel::value(&source.channels[*c], secs);
            let b = channel::value(&shown[*c], secs);
            for g in gatherings {
                let error = g.error(&a, &b);
                for joint in g.joints.iter() {
                    out[joint] = out[joint].max(error);
                }
            }
        }
    }
}

impl Gathering {
    fn error(&self, a: &[f32], b: &[f32]) -> f32 {
        let errors = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        errors.zip(&self.lengths).map(|(e, l)| e * l).sum()
    }
}

fn gathered(subject: &EditSubject<'_>, source_mesh: usize) -> Vec<Gathering> {
    let mesh = &subject.mesh;
    let (slot, count) = (
        mesh.morph_slots[source_mesh],
        subject.morph_counts[source_mesh],
    );
    let rest = subject.rest();
    // Metres per unit of the mesh, for each joint that may move it.
    let scales: Vec<f32> = mesh
        .bindings
        .iter()
        .map(|b| rest.model.matrices[usize::from(b.joint)] * b.inverse_bind)
        .map(|m| {
            m.matrix3
                .x_axis
                .length()
                .max(m.matrix3.y_axis.length())
                .max(m.matrix3.z_axis.length())
        })
        .collect();
    let mut lengths: Vec<Vec<(usize, f32)>> = vec![Vec::new(); mesh.len()];
    for morph in &mesh.morphs {
        let Some(target) = usize::from(morph.slot)
            .checked_sub(slot)
            .filter(|t| *t < count)
        else {
            continue;
        };
        for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
            lengths[*v as usize].push((target, offset.length()));
        }
    }
    let mut gatherings: Vec<Option<Gathering>> = vec![None; count];
    for (v, lengths) in lengths.iter().enumerate() {
        let Some((most, _)) = lengths.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        let gathering = gatherings[*most].get_or_insert_with(|| Gathering {
            lengths: vec![0.0; count],
            joints: JointSet::EMPTY,
        });
        let mut scale = 0.0f32;
        let at = v * mesh.influences..(v + 1) * mesh.influences;
        for (b, w) in mesh.binding_indices[at.clone()]
            .iter()
            .zip(&mesh.weights[at])
        {
            if *w > 0.0 {
                scale = scale.max(scales[usize::from(*b)]);
                gathering
                    .joints
                    .insert(usize::from(mesh.bindings[usize::from(*b)].joint));
            }
        }
        for (target, length) in lengths {
            let greatest = &mut gathering.lengths[*target];
            *greatest = greatest.max(scale * length);
        }
    }
    gatherings.into_iter().flatten().collect()
}
