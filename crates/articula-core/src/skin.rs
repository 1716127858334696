//! Linear blend skinning of positions and normals, after morph targets.
//!
//! This is the plain version against which all faster ones are tested.

use crate::math::cross;
use crate::mesh::Mesh;
use crate::pose::ModelPose;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Skinned positions and normals, one for each vertex of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SkinnedMesh {
    /// Positions in model space, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals in model space.
    pub normals: Vec<Vec3>,
}

impl SkinnedMesh {
    /// Allocates space for the vertices of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            positions: vec![Vec3::ZERO; mesh.len()],
            normals: vec![Vec3::Y; mesh.len()],
        }
    }

    /// Returns the axis-aligned bounding box of the positions as (minimum, maximum) corner; `None`
    /// without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        Some(
            self.positions
                .iter()
                .fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p))),
        )
    }
}

/// Computes the skinning palette: for each binding, in the mesh's order, the matrix from mesh to
/// model space.
///
/// # Panics
/// If the length of `out` differs from the number of bindings.
pub fn palette(mesh: &Mesh, pose: &ModelPose, out: &mut [Affine3A]) {
    assert_eq!(
        out.len(),
        mesh.bindings.len(),
        "the palette must belong to this mesh"
    );
    for (matrix, binding) in out.iter_mut().zip(&mesh.bindings) {
        *matrix = pose.matrices[usize::from(binding.joint)] * binding.inverse_bind;
    }
}

/// Blends morph targets, then skins positions and normals of all vertices.
///
/// Normals are transformed by the cofactor matrix of the blended transform, which is correct under
/// non-uniform scale too. O(vertices x influences); does not allocate.
///
/// # Panics
/// If a slice belongs to another mesh.
pub fn skin(mesh: &Mesh, palette: &[Affine3A], morph_weights: &[f32], out: &mut SkinnedMesh) {
    assert_eq!(
        palette.len(),
        mesh.bindings.len(),
        "the palette must belong to this mesh"
    );
    assert_eq!(
        out.positions.len(),
        mesh.len(),
        "the output must belong to this mesh"
    );
    assert_eq!(
        morph_weights.len(),
        mesh.morph_weights.len(),
        "the morph weights must belong to this mesh"
    );
    out.positions.copy_from_slice(&mesh.positions);
    out.normals.copy_from_slice(&mesh.normals);
    apply_morphs(mesh, morph_weights, out);
    for v in 0..mesh.len() {
        let blended = blend(mesh, palette, v);
        out.positions[v] = blended.transform_point3(out.positions[v]);
        let normal = cofactor(blended.matrix3) * Vec3A::from(out.normals[v]);
        out.normals[v] = Vec3::from(normal).try_normalize().unwrap_or(out.normals[v]);
    }
}

/// Skins the positions of the given vertices without morph targets, into `out` in the order of
/// `vertices`.
///
/// # Panics
/// If a slice belongs to another mesh, or `out` and `vertices` differ in length.
pub fn skin_points(mesh: &Mesh, palette: &[Affine3A], vertices: &[u32], out: &mut [Vec3]) {
    assert_eq!(
        palette.len(),
        mesh.bindings.len(),
        "the palette must belong to this mesh"
    );
    assert_eq!(
        out.len(),
        vertices.len(),
        "expected one output for each vertex"
    );
    for (point, &v) in out.iter_mut().zip(vertices) {
        let v = v as usize;
        *point = blend(mesh, palette, v).transform_point3(mesh.positions[v]);
    }
}

fn apply_morphs(mesh: &Mesh, weights: &[f32], out: &mut SkinnedMesh) {
    for morph in &mesh.morphs {
        let weight = weights[usize::from(morph.slot)];
        if weight == 0.0 {
            continue;
        }
        for ((v, dp), dn) in morph
            .vertices
            .iter()
            .zip(&morph.positions)
            .zip(&morph.normals)
        {
            out.positions[*v as usize] += *dp * weight;
            out.normals[*v as usize] += *dn * weight;
        }
    }
}

fn blend(mesh: &Mesh, palette: &[Affine3A], vertex: usize) -> Affine3A {
    let mut sum = Affine3A::from_mat3_translation(glam::Mat3::ZERO, Vec3::ZERO);
    let first = vertex * mesh.influences;
    for i in first..first + mesh.influences {
        let weight = mesh.weights[i];
        if weight != 0.0 {
            let matrix = &palette[usize::from(mesh.binding_indices[i])];
            sum.matrix3 += matrix.matrix3 * weight;
            sum.translation += matrix.translation * weight;
        }
    }
    sum
}

/// Inverse transpose times determinant, with the sign that keeps normals pointing outwards when the
/// matrix mirrors.
fn cofactor(m: Mat3A) -> Mat3A {
    let x = cross(m.y_axis, m.z_axis);
    let y = cross(m.z_axis, m.x_axis);
    let z = cross(m.x_axis, m.y_axis);
    let sign = if m.x_axis.dot(x) < 0.0 { -1.0 } else { 1.0 };
    Mat3A::from_cols(x * sign, y * sign, z * sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::local_to_model;
    use crate::mesh::tests::triangle;
    use crate::rig::tests::rig_of;
    use glam::Quat;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn rest_pose_gives_the_mesh_back_and_a_turn_moves_it() {
        let rig = rig_of(&[(None, Vec3::ZERO, 0), (Some(0), Vec3::Y, 0)]);
        let mesh = Mesh::new(&[triangle()], 2).unwrap();
        let mut local = rig.rest_pose().clone();
        let mut model = ModelPose::new(2);
        let mut matrices = vec![Affine3A::IDENTITY; 2];
        let mut out = SkinnedMesh::new(&mesh);
        local_to_model(&rig, &local, &mut model);
        palette(&mesh, &model, &mut matrices);
        skin(&mesh, &matrices, &[0.0], &mut out);
        assert_eq!(out.positions, mesh.positions);
        assert_eq!(out.normals, mesh.normals);

        local.rotations[0] = Quat::from_rotation_x(FRAC_PI_2);
        local_to_model(&rig, &local, &mut model);
        palette(&mesh, &model, &mut matrices);
        skin(&mesh, &matrices, &[2.0], &mut out);
        // The morph moves the second corner by 2 along z; the rotation turns z to -y.
        assert!((out.positions[1] - Vec3::new(1.0, -2.0, 0.0)).length() < 1e-6);
        assert!((out.positions[2] - Vec3::Z).length() < 1e-6);
        assert!((out.normals[0] - Vec3::NEG_Y).length() < 1e-6);
        assert_eq!(out.bounds().unwrap().1.x, 1.0);
        let mut some = [Vec3::ZERO];
        skin_points(&mesh, &matrices, &[2], &mut some);
        assert_eq!(some[0], out.positions[2]);
    }

    #[test]
    fn normals_stay_right_under_non_uniform_and_mirrored_scale() {
        let flat = Mat3A::from_diagonal(Vec3::new(1.0, 0.1, 1.0));
        let slope = Vec3A::new(1.0, 1.0, 0.0).normalize();
        let turned = (cofactor(flat) * slope).normalize();
        // The surface with normal (1,1) now lies almost flat, so its normal is steep.
        assert!(turned.y > 0.99);
        let mirror = Mat3A::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
        assert!((cofactor(mirror) * Vec3A::X - Vec3A::NEG_X).length() < 1e-6);
    }
}
