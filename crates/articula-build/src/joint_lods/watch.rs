//! The vertices that errors are measured on, and their substitute for a character without a mesh.

use super::moments::model_of;
use crate::character::Asset;
use crate::points::draw_vertices;
use articula_core::{Binding, Mesh};
use glam::{Affine3A, Vec3};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Minimum number of watched vertices of each joint with skin, so that a small body part is not
/// missed by chance.
const MIN_FOR_A_JOINT: usize = 4;

/// Directions in which the outermost vertices of each joint are watched: both ways along the axes
/// and the diagonals of a cube. Where a joint alone moves its skin, the error of holding it is an
/// affine function of the position, whose length is greatest at an outermost vertex.
const OUTWARD: [Vec3; 7] = [
    Vec3::X,
    Vec3::Y,
    Vec3::Z,
    Vec3::new(1.0, 1.0, 1.0),
    Vec3::new(1.0, 1.0, -1.0),
    Vec3::new(1.0, -1.0, 1.0),
    Vec3::new(-1.0, 1.0, 1.0),
];

/// Minimum weight with which a vertex counts as skin of a joint.
const MIN_WEIGHT: f32 = 0.5;

/// Minimum length of a bone that is used as skin, in metres.
const MIN_BONE_METRES: f32 = 0.01;

/// Watched vertices of a mesh, ascending.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Watched {
    /// All watched vertices.
    pub(crate) vertices: Vec<u32>,
    /// Whether each belongs to the uniform random sample, over which percentiles are computed.
    pub(crate) drawn: Vec<bool>,
}

impl Watched {
    /// Draws `count` random vertices and adds all others.
    pub(crate) fn every(mesh: &Mesh, count: usize, seed: u64) -> Self {
        let mut is_drawn = vec![false; mesh.len()];
        for v in draw_vertices(mesh.len(), count, seed) {
            is_drawn[v as usize] = true;
        }
        let all = mesh.positions.iter().zip(is_drawn).zip(0..);
        let finite = all.filter(|((position, _), _)| position.is_finite());
        let (vertices, drawn) = finite.map(|((_, drawn), v)| (v, drawn)).unzip();
        Self { vertices, drawn }
    }

    /// Draws `count` random vertices and adds the farthest one of each joint's skin from the joint.
    pub(crate) fn tips(mesh: &Mesh, count: usize, seed: u64) -> Self {
        let mut farthest = vec![(0.0f32, None); mesh.bindings.len()];
        for v in 0..mesh.len() {
            let of = v * mesh.influences..(v + 1) * mesh.influences;
            let indices = mesh.binding_indices[of.clone()].iter();
            for (binding, weight) in indices.zip(&mesh.weights[of]) {
                let binding = usize::from(*binding);
                let from_joint = mesh.bindings[binding].inverse_bind;
                let squared = from_joint
                    .transform_point3(mesh.positions[v])
                    .length_squared();
                // No comparison holds for a position that is not a number.
                if *weight >= MIN_WEIGHT && squared >= farthest[binding].0 && squared.is_finite() {
                    farthest[binding] = (squared, Some(v as u32));
                }
            }
        }
        let mut is_tip = vec![false; mesh.len()];
        for v in farthest.iter().filter_map(|(_, v)| *v) {
            is_tip[v as usize] = true;
        }
        Self::every(mesh, count, seed).only_drawn_or(|v| is_tip[v as usize])
    }

    /// Those that some triangle uses.
    pub(crate) fn of_triangles(&self, triangles: &[[u32; 3]]) -> Self {
        let used: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
        let all = self.vertices.iter().zip(&self.drawn);
        let (vertices, drawn) = all.filter(|(v, _)| used.contains(v)).unzip();
        Self { vertices, drawn }
    }

    /// The drawn vertices and some of the others.
    pub(crate) fn only_drawn_or(&self, is_kept: impl Fn(u32) -> bool) -> Self {
        let all = self.vertices.iter().zip(&self.drawn);
        let kept = all.filter(|(v, drawn)| **drawn || is_kept(**v));
        let (vertices, drawn) = kept.unzip();
        Self { vertices, drawn }
    }

    /// Draws `count` random vertices and adds, for each joint, those of the largest weight and the
    /// outermost ones of its skin.
    pub(crate) fn draw(mesh: &Mesh, joints: usize, count: usize, seed: u64) -> Self {
        let finite = |v: &u32| mesh.positions[*v as usize].is_finite();
        let mut drawn = draw_vertices(mesh.len(), count, seed);
        drawn.retain(finite);
        let mut heaviest = vec![Vec::<(f32, u32)>::new(); joints];
        let nothing = [(f32::MIN, None); 2 * OUTWARD.len()];
        let mut outermost: Vec<[(f32, Option<u32>); 2 * OUTWARD.len()]> = vec![nothing; joints];
        for v in (0..mesh.len() as u32).filter(finite) {
            for (joint, weight) in mesh.influences_of(v as usize) {
                let top = &mut heaviest[joint];
                let at = top.partition_point(|(w, _)| *w >= weight);
                if at < MIN_FOR_A_JOINT {
                    top.insert(at, (weight, v));
                    top.truncate(MIN_FOR_A_JOINT);
                }
                if weight >= MIN_WEIGHT {
                    let position = mesh.positions[v as usize];
                    let along = OUTWARD
                        .iter()
                        .flat_map(|d| [d.dot(position), -d.dot(position)]);
                    for (farthest, along) in outermost[joint].iter_mut().zip(along) {
                        if along > farthest.0 {
                            *farthest = (along, Some(v));
                        }
                    }
                }
            }
        }
        let mut vertices = drawn.clone();
        vertices.extend(heaviest.iter().flatten().map(|(_, v)| *v));
        vertices.extend(outermost.iter().flatten().filter_map(|(_, v)| *v));
        vertices.sort_unstable();
        vertices.dedup();
        let is_drawn = |v: &u32| drawn.binary_search(v).is_ok();
        Self {
            drawn: vertices.iter().map(is_drawn).collect(),
            vertices,
        }
    }
}

/// Returns the mesh of a character, or points on its bones if it has none. Errors of levels are
/// measured on it.
pub fn skin_of(asset: &Asset) -> Cow<'_, Mesh> {
    if asset.mesh.is_empty() {
        Cow::Owned(bones(asset))
    } else {
        Cow::Borrowed(&asset.mesh)
    }
}

/// Points at each joint, half-way to its children, and half a bone beyond each end joint.
fn bones(asset: &Asset) -> Mesh {
    let rig = &asset.rig;
    let model = model_of(asset, rig.rest_pose());
    let mut mesh = Mesh {
        influences: 1,
        ..Mesh::default()
    };
    let mut hang = |joint: usize, point: Vec3| {
        mesh.positions.push(point);
        mesh.normals.push(Vec3::Y);
        mesh.binding_indices.push(joint as u16);
        mesh.weights.push(1.0);
    };
    let mut ends = vec![true; rig.len()];
    for joint in 0..rig.len() {
        let at = model.position(joint);
        hang(joint, at);
        if let Some(parent) = rig.parent(joint) {
            ends[parent] = false;
            hang(parent, 0.5 * (at + model.position(parent)));
        }
    }
    for joint in (0..rig.len()).filter(|j| ends[*j]) {
        let at = model.position(joint);
        let bone = rig.parent(joint).map(|p| at - model.position(p));
        let bone = bone.filter(|b| b.length() >= MIN_BONE_METRES);
        hang(joint, at + 0.5 * bone.unwrap_or(Vec3::Y * MIN_BONE_METRES));
    }
    let binding = |joint: usize| {
        let inverse = model.matrices[joint].inverse();
        Binding {
            joint: joint as u16,
            inverse_bind: if inverse.is_finite() {
                inverse
            } else {
                Affine3A::IDENTITY
            },
        }
    };
    mesh.bindings = (0..rig.len()).map(binding).collect();
    mesh
}

#[cfg(test)]
mod tests {
    use super::super::test_figures::arm;
    use super::*;
    use std::sync::Arc;

    #[test]
    fn bones_stand_for_the_skin() {
        // Joints at 0, 1 and 2 along y: three joints, two midpoints, one end.
        let mut asset = arm(3);
        asset.mesh = Mesh::default().into();
        let mesh = skin_of(&asset);
        let mut heights: Vec<f32> = mesh.positions.iter().map(|p| p.y).collect();
        heights.sort_by(f32::total_cmp);
        assert_eq!(heights, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
    }

    #[test]
    fn every_joint_with_skin_is_watched() {
        let asset = arm(5);
        let watched = Watched::draw(&asset.mesh, 5, 0, 1);
        for joint in 0..5 {
            let of = |v: &&u32| asset.mesh.influences_of(**v as usize).any(|i| i.0 == joint);
            assert!(watched.vertices.iter().filter(of).count() >= 4);
        }
        assert!(watched.drawn.iter().all(|d| !d));
        let all = Watched::draw(&asset.mesh, 5, usize::MAX, 1);
        assert_eq!(all.vertices.len(), asset.mesh.len());
        assert!(all.drawn.iter().all(|d| *d));
    }

    #[test]
    fn every_vertex_with_a_position_is_watched_with_the_same_sample() {
        let mut mesh = Mesh::clone(&arm(5).mesh);
        mesh.positions[7].z = f32::NAN;
        let (every, some) = (Watched::every(&mesh, 9, 3), Watched::draw(&mesh, 5, 9, 3));
        let expected: Vec<u32> = (0..mesh.len() as u32).filter(|v| *v != 7).collect();
        assert_eq!(every.vertices, expected);
        let drawn = |watched: &Watched| -> Vec<u32> {
            let all = watched.vertices.iter().zip(&watched.drawn);
            all.filter(|(_, d)| **d).map(|(v, _)| *v).collect()
        };
        assert_eq!(drawn(&every), drawn(&some));
        assert!(every.drawn.iter().any(|d| *d));
    }

    #[test]
    fn the_farthest_vertex_of_each_joint_is_a_tip() {
        let mut asset = arm(3);
        // The last vertex is pulled out, on the joint at a height of 2 m; one is lost.
        let last = asset.mesh.len() - 1;
        let positions = &mut Arc::make_mut(&mut asset.mesh).positions;
        positions[last] = Vec3::Y * 3.5;
        positions[last - 1] = Vec3::NAN;
        let tips = Watched::tips(&asset.mesh, 0, 1);
        assert!(tips.drawn.iter().all(|d| !d));
        assert_eq!(tips.vertices.len(), 3, "{:?}", tips.vertices);
        assert_eq!(tips.vertices[2], last as u32);
        for (joint, v) in tips.vertices.iter().enumerate() {
            let from = |v: usize| asset.mesh.positions[v].distance(Vec3::Y * joint as f32);
            let of = |v: &usize| {
                asset
                    .mesh
                    .influences_of(*v)
                    .any(|i| i.0 == joint && i.1 >= 0.5)
            };
            let most = (0..asset.mesh.len())
                .filter(of)
                .map(from)
                .fold(0.0, f32::max);
            assert!((from(*v as usize) - most).abs() < 1e-6);
        }
    }

    #[test]
    fn the_heaviest_and_the_outermost_vertices_of_each_joint_are_watched() {
        let count = 400usize;
        let part = |v: usize, k: usize| ((v * 7919 + k * 104_729) % 1009) as f32 / 1009.0;
        let weight = |v: usize| part(v, 4);
        let mut mesh = Mesh::clone(&arm(2).mesh);
        mesh.positions = (0..count)
            .map(|v| Vec3::new(part(v, 1), part(v, 2), part(v, 3)) - Vec3::new(0.3, 0.6, 0.5))
            .collect();
        mesh.binding_indices = [0, 1].repeat(count);
        mesh.weights = (0..count)
            .flat_map(|v| [1.0 - weight(v), weight(v)])
            .collect();
        mesh.positions[17].y = f32::NAN;
        mesh.positions[18].x = f32::INFINITY;
        let mut expected: Vec<u32> = Vec::new();
        for joint in 0..2 {
            let of = |v: u32| [1.0 - weight(v as usize), weight(v as usize)][joint];
            let mut all: Vec<u32> = (0..count as u32)
                .filter(|v| ![17, 18].contains(v))
                .collect();
            all.sort_by(|a, b| of(*b).total_cmp(&of(*a)));
            expected.extend(&all[..4]);
            all.retain(|v| of(*v) >= 0.5);
            // Both ways along the axes and the diagonals of a cube.
            for x in [-1.0, 0.0, 1.0] {
                for y in [-1.0, 0.0, 1.0] {
                    for z in [-1.0, 0.0, 1.0] {
                        let direction = Vec3::new(x, y, z);
                        if [1.0, 3.0].contains(&direction.length_squared()) {
                            let along = |v: &u32| direction.dot(mesh.positions[*v as usize]);
                            let farthest = all.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
                            expected.extend(farthest);
                        }
                    }
                }
            }
        }
        expected.sort_unstable();
        expected.dedup();
        assert!(expected.len() > 12, "{} vertices", expected.len());
        assert_eq!(Watched::draw(&mesh, 2, 0, 1).vertices, expected);
        let drawn = Watched::draw(&mesh, 2, usize::MAX, 1);
        assert_eq!(drawn.vertices.len(), count - 2);
    }
}
