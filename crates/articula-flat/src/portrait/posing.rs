//! Poses the figure by head angles and expressions: skinning and projection.

use super::error::PortraitError;
use super::head::{Head, HeadPose, PortraitExpression};
use crate::projection::{Projection, Screen};
use articula_core::{
    Camera, LocalPose, Mesh, ModelPose, Morph, PosedMesh, Rig, SkinnedMesh, local_to_model_from,
};
use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};

/// Poses a mesh by the angles of its head and the weights of its expressions.
pub(crate) struct Poser<'a> {
    mesh: &'a Mesh,
    rig: &'a Rig,
    head: &'a Head,
    expressions: &'a [PortraitExpression],
}

impl<'a> Poser<'a> {
    pub(crate) fn new(
        mesh: &'a Mesh,
        rig: &'a Rig,
        head: &'a Head,
        expressions: &'a [PortraitExpression],
    ) -> Self {
        Self {
            mesh,
            rig,
            head,
            expressions,
        }
    }

    /// Skins the mesh; expressions without a weight are ignored.
    pub(crate) fn skin(&self, pose: HeadPose, weights: &[(usize, f32)]) -> SkinnedMesh {
        let mut local = self.rig.rest_pose().clone();
        let mut morphs = self.mesh.morph_weights.clone();
        for (e, weight) in weights {
            let expression = &self.expressions[*e];
            for (slot, full) in &expression.morphs {
                morphs[usize::from(*slot)] += full * weight;
            }
            for turn in &expression.joints {
                let rest = self.rig.rest_pose().rotations[turn.joint];
                let step = Quat::IDENTITY.slerp(rest.inverse() * turn.rotation, *weight);
                local.rotations[turn.joint] = (local.rotations[turn.joint] * step).normalize();
            }
        }
        let rotation = pose.rotation();
        let mut world = Affine3A::IDENTITY;
        match self.head {
            Head::Whole { pivot } => {
                world = Affine3A::from_translation(*pivot)
                    * Affine3A::from_quat(rotation)
                    * Affine3A::from_translation(-*pivot);
            }
            Head::Joints(joints) => self.turn_joints(joints, rotation, &mut local),
        }
        let mut posed = PosedMesh::new(self.rig, self.mesh);
        posed.pose_from(&local, world).skinned(&morphs)
    }

    /// Rotates each joint in model space by its part, after the rotations of its ancestors.
    fn turn_joints(&self, joints: &[usize], rotation: Quat, local: &mut LocalPose) {
        let share = Quat::IDENTITY.slerp(rotation, 1.0 / joints.len() as f32);
        for &joint in joints {
            let mut above = Quat::IDENTITY;
            let mut at = self.rig.parent(joint);
            while let Some(parent) = at {
                above = local.rotations[parent] * above;
                at = self.rig.parent(parent);
            }
            let turned = above.inverse() * share * above * local.rotations[joint];
            local.rotations[joint] = turned.normalize();
        }
    }

    /// Position of the centre of rotation at rest.
    pub(crate) fn pivot(&self) -> Vec3 {
        match self.head {
            Head::Whole { pivot } => *pivot,
            Head::Joints(joints) => {
                let mut model = ModelPose::new(self.rig.len());
                let rest = self.rig.rest_pose();
                local_to_model_from(self.rig, rest, Affine3A::IDENTITY, &mut model);
                model.position(joints[0])
            }
        }
    }

    /// Part of a head rotation that each vertex takes, 0 to 1.
    pub(crate) fn shares(&self) -> Vec<f32> {
        let Head::Joints(joints) = self.head else {
            return vec![1.0; self.mesh.len()];
        };
        let share = |joint: usize| {
            let above = joints
                .iter()
                .filter(|j| self.rig.is_at_or_below(joint, **j));
            above.count() as f32 / joints.len() as f32
        };
        let of: Vec<f32> = (0..self.rig.len()).map(share).collect();
        let blend = |v: usize| self.mesh.influences_of(v).map(|(j, w)| of[j] * w).sum();
        (0..self.mesh.len()).map(blend).collect()
    }
}

/// Screen corners of all vertices of a skinned mesh.
///
/// # Errors
/// [`PortraitError::NotInView`] for a vertex that the camera cannot see.
pub(crate) fn project(
    skinned: &SkinnedMesh,
    camera: &Camera,
    pose: HeadPose,
) -> Result<Vec<Vec4>, PortraitError> {
    let screen = Screen::new(camera, Projection::Perspective);
    let mut corners = Vec::with_capacity(skinned.positions.len());
    for (vertex, point) in skinned.positions.iter().enumerate() {
        let corner = screen.corner(*point);
        // At less than a centimetre from the camera, pixel positions are meaningless.
        let is_ahead = corner.is_finite() && corner.w > 1e-2;
        let place = Vec2::new(corner.x, corner.y) / corner.w;
        if !is_ahead || !place.is_finite() || place.abs().max_element() > 1e5 {
            return Err(PortraitError::NotInView {
                vertex,
                yaw: pose.yaw_degrees.round() as i32,
                mend: "move the camera away or hide that part of the figure",
            });
        }
        corners.push(corner);
    }
    Ok(corners)
}

/// Positions in pixels of projected corners.
pub(crate) fn places(corners: &[Vec4]) -> Vec<Vec2> {
    corners.iter().map(|c| Vec2::new(c.x, c.y) / c.w).collect()
}

/// The mesh reduced to some of its vertices (ascending), without triangles and parts.
pub(crate) fn part_of(mesh: &Mesh, vertices: &[u32]) -> Mesh {
    let mut place = vec![u32::MAX; mesh.len()];
    for (new, old) in vertices.iter().enumerate() {
        place[*old as usize] = new as u32;
    }
    let pick = |values: &[Vec3]| vertices.iter().map(|v| values[*v as usize]).collect();
    let mut out = Mesh {
        positions: pick(&mesh.positions),
        normals: pick(&mesh.normals),
        texcoords: vertices
            .iter()
            .map(|v| mesh.texcoords[*v as usize])
            .collect(),
        colors: vertices.iter().map(|v| mesh.colors[*v as usize]).collect(),
        influences: mesh.influences,
        bindings: mesh.bindings.clone(),
        morph_weights: mesh.morph_weights.clone(),
        morph_slots: mesh.morph_slots.clone(),
        ..Mesh::default()
    };
    for v in vertices {
        let at = *v as usize * mesh.influences..(*v as usize + 1) * mesh.influences;
        out.binding_indices
            .extend(&mesh.binding_indices[at.clone()]);
        out.weights.extend(&mesh.weights[at]);
    }
    for morph in &mesh.morphs {
        let mut kept = Morph {
            slot: morph.slot,
            vertices: Vec::new(),
            positions: Vec::new(),
            normals: Vec::new(),
        };
        for (i, v) in morph.vertices.iter().enumerate() {
            if place[*v as usize] != u32::MAX {
                kept.vertices.push(place[*v as usize]);
                kept.positions.push(morph.positions[i]);
                kept.normals.push(morph.normals[i]);
            }
        }
        if !kept.vertices.is_empty() {
            out.morphs.push(kept);
        }
    }
    out
}
