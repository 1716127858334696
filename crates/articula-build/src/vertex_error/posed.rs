//! A character whose vertices are posed as its file is read.

use crate::moment::Moment;
use articula_core::source::evaluate::{self, Sampler};
use articula_core::source::{Character, Property, RawClip};
use articula_core::{
    Articulation, LocalPose, Mesh, Mismatch, ModelPose, Morph, Rig, local_to_model, palette,
};
use glam::{Affine3A, Vec3, Vec3A};
use std::sync::Arc;

/// A character whose vertices can be posed at any time of a clip.
/// Copies share its rig and mesh.
#[derive(Debug, Clone)]
pub struct PosedVertices<'a> {
    character: &'a Character,
    rig: Arc<Rig>,
    pub(super) mesh: Arc<Mesh>,
    local: LocalPose,
    model: ModelPose,
    pub(super) palette: Vec<Affine3A>,
    weights: Vec<f32>,
    points: Vec<Vec3>,
}

impl<'a> PosedVertices<'a> {
    /// Prepares a character.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the inconsistent part of the character.
    pub fn new(character: &'a Character) -> Result<Self, Mismatch> {
        let joints = character.skeleton.joints.len();
        let rig = Rig::new(&character.skeleton, Articulation::unmapped(joints))?;
        let mesh = Mesh::new(&character.meshes, rig.len())?;
        Ok(Self {
            character,
            local: rig.rest_pose().clone(),
            model: ModelPose::new(rig.len()),
            palette: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            weights: mesh.morph_weights.clone(),
            points: Vec::new(),
            rig: Arc::new(rig),
            mesh: Arc::new(mesh),
        })
    }

    /// Number of vertices; of joints where there is no mesh.
    pub fn count(&self) -> usize {
        match self.mesh.is_empty() {
            true => self.rig.len(),
            false => self.mesh.len(),
        }
    }

    /// All vertices at a time of a clip in seconds, or at rest without a clip, in model space; joints
    /// where there is no mesh.
    pub fn at(&mut self, clip: Option<&RawClip>, secs: f32) -> &[Vec3] {
        self.pose(clip, secs);
        self.weights.copy_from_slice(&self.mesh.morph_weights);
        if let Some(clip) = clip {
            let morphs = |c: &&articula_core::source::Channel| c.property == Property::Weights;
            for channel in clip.channels.iter().filter(morphs) {
                let first = self.mesh.morph_slots[channel.target];
                let count = self.character.meshes[channel.target].morph_weights.len();
                evaluate::channel(channel, secs, &mut self.weights[first..first + count]);
            }
        }
        self.points.clear();
        if self.mesh.is_empty() {
            let joints = self.model.matrices.iter();
            self.points
                .extend(joints.map(|m| Vec3::from(m.translation)));
        } else {
            self.skin();
        }
        &self.points
    }

    /// A sampler of a clip, for [`Self::palette_at`].
    pub(super) fn sampler<'b>(&self, clip: &'b RawClip) -> Sampler<'b>
    where
        'a: 'b,
    {
        Sampler::new(clip, &self.character.skeleton)
    }

    /// The matrices of all bindings at a time of a clip in seconds.
    pub(super) fn palette_at(&mut self, clip: &mut Sampler<'_>, secs: f32) -> &[Affine3A] {
        clip.pose(secs, &mut self.local);
        local_to_model(&self.rig, &self.local, &mut self.model);
        palette(&self.mesh, &self.model, &mut self.palette);
        &self.palette
    }

    /// The matrices of all bindings where the joints that a clip moves are posed as those of another character are.
    pub(super) fn palette_as(&mut self, other: &PosedVertices<'_>, clip: &RawClip) -> &[Affine3A] {
        self.local.copy_from(self.rig.rest_pose());
        let (own, moved) = (&mut self.local, &other.local);
        for channel in &clip.channels {
            let joint = channel.target;
            match channel.property {
                Property::Translation => own.translations[joint] = moved.translations[joint],
                Property::Rotation => own.rotations[joint] = moved.rotations[joint],
                Property::Scale => own.scales[joint] = moved.scales[joint],
                Property::Weights | Property::Expression => {}
            }
        }
        local_to_model(&self.rig, &self.local, &mut self.model);
        palette(&self.mesh, &self.model, &mut self.palette);
        &self.palette
    }

    /// Joints at a time of a clip in seconds, or at rest.
    fn pose(&mut self, clip: Option<&RawClip>, secs: f32) {
        match clip {
            Some(clip) => evaluate::pose(clip, &self.character.skeleton, secs, &mut self.local),
            None => self.local.copy_from(self.rig.rest_pose()),
        }
        local_to_model(&self.rig, &self.local, &mut self.model);
    }

    /// Whether another character has the same joints at rest, and vertices that move as its own do.
    pub fn moves_as(&self, other: &Self) -> bool {
        self.rig.rest_pose() == other.rig.rest_pose()
            && (Arc::ptr_eq(&self.mesh, &other.mesh) || has_equal_vertices(&self.mesh, &other.mesh))
    }

    /// The clips of the character.
    pub fn clips(&self) -> &'a [RawClip] {
        &self.character.clips
    }

    /// The mesh whose vertices are posed.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// All vertices in a moment, in model space.
    ///
    /// # Panics
    /// If there is no such morph target.
    pub(crate) fn in_moment(&mut self, moment: Moment) -> &[Vec3] {
        match moment {
            Moment::Rest => self.at(None, 0.0),
            Moment::Clip { index, secs } => self.at(self.clips().get(index), secs),
            Moment::Morph { slot, weight } => {
                self.local.copy_from(self.rig.rest_pose());
                self.weights.copy_from_slice(&self.mesh.morph_weights);
                self.weights[slot] = weight;
                local_to_model(&self.rig, &self.local, &mut self.model);
                self.points.clear();
                self.skin();
                &self.points
            }
        }
    }

    /// The greatest weight of each morph target that moves a vertex, in clips or 1, those that move one
    /// farthest first.
    pub(crate) fn greatest_morph_weights(&self) -> Vec<(usize, f32)> {
        let mut weights: Vec<f32> = self.mesh.morph_weights.iter().map(|w| w.max(1.0)).collect();
        let channels = self.clips().iter().flat_map(|clip| &clip.channels);
        for channel in channels.filter(|c| c.property == Property::Weights) {
            let first = self.mesh.morph_slots[channel.target];
            let count = self.character.meshes[channel.target].morph_weights.len();
            let mut at = vec![0.0; count];
            for secs in &channel.times_secs {
                evaluate::channel(channel, *secs, &mut at);
                let greatest = weights[first..first + count].iter_mut().zip(&at);
                greatest.for_each(|(greatest, at)| *greatest = greatest.max(*at));
            }
        }
        let mut farthest = vec![0.0f32; weights.len()];
        for morph in &self.mesh.morphs {
            let lengths = morph.positions.iter().map(|p| p.length());
            let most = &mut farthest[usize::from(morph.slot)];
            *most = lengths.fold(*most, f32::max);
        }
        let mut order: Vec<usize> = (0..weights.len()).filter(|s| farthest[*s] > 0.0).collect();
        order.sort_by(|a, b| farthest[*b].total_cmp(&farthest[*a]));
        order
            .into_iter()
            .map(|slot| (slot, weights[slot]))
            .collect()
    }

    /// All vertices with the weights of morph targets at rest, before they are skinned.
    pub(super) fn blended(&mut self) -> Vec<Vec3> {
        self.weights.copy_from_slice(&self.mesh.morph_weights);
        self.points.clear();
        self.blend();
        self.points.clone()
    }

    fn blend(&mut self) {
        self.points.extend_from_slice(&self.mesh.positions);
        for morph in &self.mesh.morphs {
            let weight = self.weights[usize::from(morph.slot)];
            if weight != 0.0 {
                for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
                    self.points[*v as usize] += weight * *offset;
                }
            }
        }
    }

    fn skin(&mut self) {
        palette(&self.mesh, &self.model, &mut self.palette);
        self.blend();
        for (v, point) in self.points.iter_mut().enumerate() {
            *point = skinned(&self.mesh, &self.palette, v, *point);
        }
    }
}

/// A vertex by the matrices of its joints.
fn skinned(mesh: &Mesh, palette: &[Affine3A], vertex: usize, point: Vec3) -> Vec3 {
    let of_vertex = vertex * mesh.influences..(vertex + 1) * mesh.influences;
    let bindings = &mesh.binding_indices[of_vertex.clone()];
    let mut sum = Vec3A::ZERO;
    for (b, w) in bindings.iter().zip(&mesh.weights[of_vertex]) {
        if *w > 0.0 {
            sum += *w * palette[usize::from(*b)].transform_point3a(point.into());
        }
    }
    sum.into()
}

/// Whether positions, influences and morph targets are equal, all that a vertex moves by.
fn has_equal_vertices(a: &Mesh, b: &Mesh) -> bool {
    let has_equal_offsets = |(a, b): (&Morph, &Morph)| {
        a.slot == b.slot && a.vertices == b.vertices && a.positions == b.positions
    };
    a.positions == b.positions
        && a.influences == b.influences
        && a.binding_indices == b.binding_indices
        && a.weights == b.weights
        && a.bindings == b.bindings
        && a.morph_weights == b.morph_weights
        && a.morphs.len() == b.morphs.len()
        && a.morphs.iter().zip(&b.morphs).all(has_equal_offsets)
}
