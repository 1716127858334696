//! The greatest distance of any vertex between two characters in motion, as their files are read.

use crate::moment::Moment;
use crate::part_mesh::part_mesh;
use crate::split_mix::SplitMix;
use articula_core::source::{Character, Property, RawClip, evaluate};
use articula_core::{
    Articulation, LocalPose, Mesh, Mismatch, ModelPose, Rig, local_to_model, palette,
};
use glam::{Affine3A, Vec3, Vec3A};
use std::sync::Arc;

/// Maximum number of times of a clip that are posed, of its keys and the middles between them.
const MAX_TIMES: usize = 1500;
/// Number of random times besides.
const RANDOM_TIMES: usize = 32;

/// A character whose vertices can be posed at any time of a clip.
/// Copies share its rig and mesh.
#[derive(Debug, Clone)]
pub struct PosedVertices<'a> {
    character: &'a Character,
    rig: Arc<Rig>,
    mesh: Arc<Mesh>,
    local: LocalPose,
    model: ModelPose,
    palette: Vec<Affine3A>,
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
        self.local.copy_from(self.rig.rest_pose());
        self.weights.copy_from_slice(&self.mesh.morph_weights);
        if let Some(clip) = clip {
            evaluate::pose(clip, &self.character.skeleton, secs, &mut self.local);
            let morphs = |c: &&articula_core::source::Channel| c.property == Property::Weights;
            for channel in clip.channels.iter().filter(morphs) {
                let first = self.mesh.morph_slots[channel.target];
                let count = self.character.meshes[channel.target].morph_weights.len();
                evaluate::channel(channel, secs, &mut self.weights[first..first + count]);
            }
        }
        local_to_model(&self.rig, &self.local, &mut self.model);
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

    /// Vertices at which errors in motion are expected to be the greatest, ascending: those farthest out in 14
    /// directions of all that follow a joint most, and that which each morph target moves farthest.
    pub fn outermost(&self) -> Vec<u32> {
        outermost(&self.mesh)
    }

    /// The same with these vertices alone, which ascend.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn of_vertices(&self, vertices: &[u32]) -> Self {
        Self {
            mesh: Arc::new(part_mesh(&self.mesh, vertices)),
            ..self.clone()
        }
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

    fn skin(&mut self) {
        palette(&self.mesh, &self.model, &mut self.palette);
        self.points.extend_from_slice(&self.mesh.positions);
        for morph in &self.mesh.morphs {
            let weight = self.weights[usize::from(morph.slot)];
            if weight != 0.0 {
                for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
                    self.points[*v as usize] += weight * *offset;
                }
            }
        }
        let influences = self.mesh.influences;
        for (v, point) in self.points.iter_mut().enumerate() {
            let of_vertex = v * influences..(v + 1) * influences;
            let bindings = &self.mesh.binding_indices[of_vertex.clone()];
            let mut sum = Vec3A::ZERO;
            for (b, w) in bindings.iter().zip(&self.mesh.weights[of_vertex]) {
                if *w > 0.0 {
                    let matrix = &self.palette[usize::from(*b)];
                    sum += *w * matrix.transform_point3a((*point).into());
                }
            }
            *point = sum.into();
        }
    }
}

/// Directions in which vertices are farthest: the axes and the diagonals, both ways.
fn directions() -> impl Iterator<Item = Vec3> {
    let diagonals = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let diagonals = diagonals.map(|(y, z)| Vec3::new(1.0, y, z));
    let half = Vec3::AXES.into_iter().chain(diagonals);
    half.flat_map(|way| [way, -way])
}

/// The vertices of [`PosedVertices::outermost`].
fn outermost(mesh: &Mesh) -> Vec<u32> {
    let heaviest = |v: usize| {
        let all = v * mesh.influences..(v + 1) * mesh.influences;
        let pairs = mesh.binding_indices[all.clone()]
            .iter()
            .zip(&mesh.weights[all]);
        let most = pairs.reduce(|a, b| if b.1 > a.1 { b } else { a });
        most.map(|(binding, _)| usize::from(*binding))
    };
    let mut of_binding = vec![Vec::new(); mesh.bindings.len()];
    for v in 0..mesh.len() {
        if let Some(binding) = heaviest(v) {
            of_binding[binding].push(v as u32);
        }
    }
    let farthest = |of: &[u32], far: &dyn Fn(u32) -> f32| {
        let pairs = of.iter().map(|v| (*v, far(*v)));
        pairs.reduce(|a, b| if b.1 > a.1 { b } else { a })
    };
    let mut found = Vec::new();
    for of in &of_binding {
        for way in directions() {
            let far = |v: u32| mesh.positions[v as usize].dot(way);
            found.extend(farthest(of, &far).map(|(v, _)| v));
        }
    }
    for morph in &mesh.morphs {
        let moved = morph.vertices.iter().zip(&morph.positions);
        let moved = moved.map(|(v, offset)| (*v, offset.length_squared()));
        found.extend(
            moved
                .reduce(|a, b| if b.1 > a.1 { b } else { a })
                .map(|(v, _)| v),
        );
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Greatest distance of any vertex between two characters of one order of vertices, each over a clip of
/// its own or at rest, in metres.
///
/// Posed are all key times of the first clip and the middles between them, at most 1500 that are drawn
/// by the seed if there are more, and 32 random times.
pub fn greatest_vertex_error(
    wanted: (&mut PosedVertices<'_>, Option<&RawClip>),
    shown: (&mut PosedVertices<'_>, Option<&RawClip>),
    seed: u64,
) -> f32 {
    let (from, clip) = wanted;
    let (to, other) = shown;
    let times = clip.map_or_else(|| vec![0.0], |clip| times(clip, seed));
    let mut worst = 0.0f32;
    for secs in times {
        let pairs = from.at(clip, secs).iter().zip(to.at(other, secs));
        let farthest = pairs.map(|(a, b)| a.distance_squared(*b));
        worst = farthest.fold(worst, f32::max);
    }
    worst.sqrt()
}

fn times(clip: &RawClip, seed: u64) -> Vec<f32> {
    let keys = clip.channels.iter().flat_map(|c| &c.times_secs);
    let mut times: Vec<f32> = keys.copied().collect();
    times.sort_by(f32::total_cmp);
    times.dedup();
    let middles: Vec<f32> = times.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    times.extend(middles);
    let mut random = SplitMix(seed);
    for i in 0..times.len().min(MAX_TIMES) {
        let other = i + random.below(times.len() - i);
        times.swap(i, other);
    }
    times.truncate(MAX_TIMES);
    times.extend((0..RANDOM_TIMES).map(|_| clip.duration_secs * random.unit()));
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{
        Channel, Interpolation, Joint, Primitive, RawMesh, Skeleton, Skin,
    };
    use glam::Quat;

    /// A vertex 2 m from a joint that turns by an angle in a second.
    fn arm(radians: f32, length: f32) -> (Character, RawClip) {
        let primitive = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X * length, Vec3::Y * 0.1],
            normals: vec![Vec3::Z; 3],
            influences: 1,
            joints: vec![0; 3],
            weights: vec![1.0; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "arm".into(),
                    parent: None,
                    rest: Transform::IDENTITY,
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                name: "arm".into(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![primitive],
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        let turns = [0.0, radians].map(|a| Quat::from_rotation_z(a).to_array());
        let clip = RawClip {
            name: "turn".into(),
            duration_secs: 1.0,
            channels: vec![Channel {
                target: 0,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times_secs: vec![0.0, 1.0],
                values: turns.as_flattened().to_vec(),
            }],
        };
        (character, clip)
    }

    #[test]
    fn some_vertices_are_posed_as_all_are() {
        let (character, clip) = arm(1.0, 2.0);
        let mut all = PosedVertices::new(&character).unwrap();
        let outermost = all.outermost();
        assert!(outermost.contains(&1), "{outermost:?}");
        let mut some = all.of_vertices(&[1, 2]);
        assert_eq!(some.count(), 2);
        for secs in [0.0, 0.4, 1.0] {
            let expected = all.at(Some(&clip), secs)[1..].to_vec();
            assert_eq!(some.at(Some(&clip), secs), expected);
        }
    }

    #[test]
    fn the_end_of_an_arm_is_a_chord_away() {
        let (character, clip) = arm(1.0, 2.0);
        let (_, other) = arm(0.9, 2.0);
        let mut from = PosedVertices::new(&character).unwrap();
        let mut to = PosedVertices::new(&character).unwrap();
        assert_eq!(from.count(), 3);
        let same = greatest_vertex_error((&mut from, Some(&clip)), (&mut to, Some(&clip)), 1);
        assert_eq!(same, 0.0);
        let error = greatest_vertex_error((&mut from, Some(&clip)), (&mut to, Some(&other)), 1);
        assert!((error - 4.0 * 0.05f32.sin()).abs() < 1e-5, "{error}");
        let (longer, _) = arm(0.0, 2.5);
        let mut to = PosedVertices::new(&longer).unwrap();
        let at_rest = greatest_vertex_error((&mut from, None), (&mut to, None), 1);
        assert!((at_rest - 0.5).abs() < 1e-6);
    }
}
