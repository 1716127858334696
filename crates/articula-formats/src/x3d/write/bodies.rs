//! Meshes in the zero pose: those that follow one joint, and skin.
//!
//! All skin shares one list of points, as the standard requires. A point whose joints agree on its
//! position moves exactly as in the source; where skins were bound in different poses, that fails
//! for all but the first, whose points are bound again.

use super::bones::Bones;
use super::zero::{agree, influences, model_from_mesh};
use crate::error::Warning;
use articula_core::source::{Character, Primitive, RawMesh};
use glam::{DAffine3, DVec3, Vec3};

/// A mesh ready to be written.
#[derive(Debug)]
pub(super) struct Body {
    /// Index of the mesh.
    pub(super) mesh: usize,
    /// The only bone that it follows; `None` for skin.
    pub(super) bone: Option<usize>,
    /// Index of its first point in the list of skin points.
    pub(super) first_point: usize,
    /// Points of all its primitives.
    pub(super) points: Vec<Vec3>,
    /// Normals of each primitive; empty where it has none.
    pub(super) normals: Vec<Vec<Vec3>>,
    pub(super) targets: Vec<BodyTarget>,
}

/// A morph target, piece by piece: bone (the one of a rigid body), points, offsets.
#[derive(Debug)]
pub(super) struct BodyTarget {
    pub(super) pieces: Vec<(usize, Vec<(usize, Vec3)>)>,
}

/// Points that each bone moves, with their weights.
pub(super) type SkinWeights = Vec<Vec<(usize, f32)>>;

/// Transforms all meshes to the zero pose.
pub(super) fn bodies(
    character: &Character,
    bones: &Bones,
    warnings: &mut Vec<Warning>,
) -> (Vec<Body>, SkinWeights) {
    let mut weights: SkinWeights = vec![Vec::new(); bones.list.len()];
    let mut list = Vec::new();
    let mut next_point = 0;
    for (index, mesh) in character.meshes.iter().enumerate() {
        let layout = Layout::new(mesh, bones);
        let only = layout.only_bone(mesh);
        let mut body = Body {
            mesh: index,
            bone: only,
            first_point: if only.is_some() { 0 } else { next_point },
            points: Vec::new(),
            normals: Vec::new(),
            targets: Vec::new(),
        };
        let mut loose = 0;
        for primitive in &mesh.primitives {
            loose += layout.add(primitive, &mut body, &mut weights);
        }
        if loose > 0 {
            let what = format!(
                "{loose} points with several joints were bound in a different pose than the other \
                 skins; they are rebound"
            );
            warnings.push(Warning::new(format!("mesh \"{}\"", mesh.name), what));
        }
        body.targets = layout.targets(mesh, &body);
        if only.is_none() {
            next_point += body.points.len();
        }
        list.push(body);
    }
    (list, weights)
}

/// Transform from a mesh's space to model space.
struct Layout {
    /// Model-from-mesh matrix of each joint of the skin.
    matrices: Vec<DAffine3>,
    /// Bone of each joint of the skin.
    bones: Vec<usize>,
}

impl Layout {
    fn new(mesh: &RawMesh, bones: &Bones) -> Self {
        let joints = mesh.skin.joints.iter();
        Self {
            matrices: model_from_mesh(mesh, &bones.zero.matrices),
            bones: joints.map(|&j| bones.of_joint[j].unwrap_or(0)).collect(),
        }
    }

    /// Returns the only bone that moves all vertices, if there is one.
    fn only_bone(&self, mesh: &RawMesh) -> Option<usize> {
        let mut only = None;
        for primitive in &mesh.primitives {
            for vertex in 0..primitive.positions.len() {
                for (joint, _) in influences(primitive, vertex) {
                    if *only.get_or_insert(joint) != joint {
                        return None;
                    }
                }
            }
        }
        let joint = only.unwrap_or(0);
        self.bones.get(joint).copied()
    }

    /// Returns the model-from-mesh matrix of a vertex, and whether its joints agree on it.
    fn matrix(&self, primitive: &Primitive, vertex: usize) -> (DAffine3, bool) {
        let mut influences = influences(primitive, vertex);
        let Some((first, weight)) = influences.next() else {
            return (self.matrices.first().copied().unwrap_or_default(), true);
        };
        let base = self.matrices[first];
        let (mut sum, mut total, mut agrees) = (scaled(&base, weight), f64::from(weight), true);
        for (joint, weight) in influences {
            let other = self.matrices[joint];
            agrees &= agree(&base, &other);
            let part = scaled(&other, weight);
            sum.matrix3 += part.matrix3;
            sum.translation += part.translation;
            total += f64::from(weight);
        }
        let matrix = if agrees {
            base
        } else {
            scaled(&sum, (1.0 / total) as f32)
        };
        (matrix, agrees)
    }

    /// Adds one primitive; returns the number of vertices that are bound again.
    fn add(&self, primitive: &Primitive, body: &mut Body, weights: &mut SkinWeights) -> usize {
        let mut loose = 0;
        let mut normals = Vec::with_capacity(primitive.normals.len());
        for (vertex, position) in primitive.positions.iter().enumerate() {
            let (matrix, agrees) = self.matrix(primitive, vertex);
            loose += usize::from(!agrees);
            let point = body.first_point + body.points.len();
            body.points
                .push(matrix.transform_point3(position.as_dvec3()).as_vec3());
            if let Some(normal) = primitive.normals.get(vertex) {
                let turn = matrix.matrix3.inverse().transpose();
                let turned = (turn * normal.as_dvec3()).normalize_or(DVec3::Y);
                normals.push(turned.as_vec3());
            }
            if body.bone.is_none() {
                for (joint, weight) in influences(primitive, vertex) {
                    let list = &mut weights[self.bones[joint]];
                    match list.last_mut() {
                        Some((last, sum)) if *last == point => *sum += weight,
                        _ => list.push((point, weight)),
                    }
                }
            }
        }
        body.normals.push(normals);
        loose
    }

    /// Returns the morph targets: a skin point's offset is divided among the bones that move it, so
    /// that each share rotates with its bone, as in the source.
    fn targets(&self, mesh: &RawMesh, body: &Body) -> Vec<BodyTarget> {
        let target = |slot: usize| {
            let mut pieces: std::collections::BTreeMap<usize, Vec<(usize, Vec3)>> =
                std::collections::BTreeMap::new();
            let mut first = body.first_point;
            for primitive in &mesh.primitives {
                let offsets = primitive.morphs.get(slot).map_or(&[][..], |m| &m.positions);
                for (vertex, offset) in offsets.iter().enumerate() {
                    if *offset == Vec3::ZERO {
                        continue;
                    }
                    for (joint, weight) in influences(primitive, vertex) {
                        let moved = self.matrices[joint].transform_vector3(offset.as_dvec3());
                        let share = (moved * f64::from(weight)).as_vec3();
                        let of_bone = pieces.entry(self.bones[joint]).or_default();
                        match of_bone.last_mut() {
                            Some((last, sum)) if *last == first + vertex => *sum += share,
                            _ => of_bone.push((first + vertex, share)),
                        }
                    }
                }
                first += primitive.positions.len();
            }
            BodyTarget {
                pieces: pieces.into_iter().collect(),
            }
        };
        (0..mesh.morph_names.len()).map(target).collect()
    }
}

fn scaled(matrix: &DAffine3, by: f32) -> DAffine3 {
    let by = f64::from(by);
    DAffine3 {
        matrix3: matrix.matrix3 * by,
        translation: matrix.translation * by,
    }
}
