//! Some vertices of a mesh, as a mesh that is posed alike.

use articula_core::{Mesh, Morph};
use glam::Vec3;

/// The mesh of some vertices, which ascend, without triangles.
///
/// # Panics
/// If there is no such vertex.
pub(crate) fn part_mesh(mesh: &Mesh, vertices: &[u32]) -> Mesh {
    let influences = |v: &u32| *v as usize * mesh.influences..(*v as usize + 1) * mesh.influences;
    let pick = |of: &[Vec3]| vertices.iter().map(|v| of[*v as usize]).collect();
    let morph = |morph: &Morph| {
        let moved = morph.vertices.iter().enumerate();
        let moved: Vec<(usize, u32)> = moved
            .filter_map(|(i, v)| Some((i, vertices.binary_search(v).ok()? as u32)))
            .collect();
        Morph {
            slot: morph.slot,
            vertices: moved.iter().map(|(_, v)| *v).collect(),
            positions: moved.iter().map(|(i, _)| morph.positions[*i]).collect(),
            normals: moved.iter().map(|(i, _)| morph.normals[*i]).collect(),
        }
    };
    Mesh {
        positions: pick(&mesh.positions),
        normals: pick(&mesh.normals),
        influences: mesh.influences,
        binding_indices: vertices
            .iter()
            .flat_map(|v| mesh.binding_indices[influences(v)].iter().copied())
            .collect(),
        weights: vertices
            .iter()
            .flat_map(|v| mesh.weights[influences(v)].iter().copied())
            .collect(),
        bindings: mesh.bindings.clone(),
        morphs: mesh.morphs.iter().map(morph).collect(),
        morph_weights: mesh.morph_weights.clone(),
        morph_slots: mesh.morph_slots.clone(),
        ..Mesh::default()
    }
}
