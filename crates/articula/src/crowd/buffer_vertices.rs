//! Vertices of a mesh as bytes, for buffers of a GPU.
//!
//! Form: `docs/formats/crowd-buffers.md`.

use articula_core::Mesh;

/// Number of influences that a stored vertex has room for: those of its mesh, filled up to fours.
pub(super) fn stored_influences(mesh: &Mesh) -> usize {
    mesh.influences.next_multiple_of(4)
}

/// Bytes of a stored vertex: position, normal, texture coordinates, entries, weights.
pub(super) fn vertex_bytes(mesh: &Mesh) -> usize {
    32 + 6 * stored_influences(mesh)
}

/// Appends the vertices of a mesh.
pub(super) fn push_vertices(mesh: &Mesh, out: &mut Vec<u8>) {
    let room = stored_influences(mesh);
    out.reserve(mesh.len() * vertex_bytes(mesh));
    for v in 0..mesh.len() {
        out.extend(floats(&mesh.positions[v].to_array()));
        out.extend(floats(&mesh.normals[v].to_array()));
        out.extend(floats(&mesh.texcoords[v].to_array()));
        let of = v * mesh.influences..(v + 1) * mesh.influences;
        let (entries, weights) = (&mesh.binding_indices[of.clone()], &mesh.weights[of]);
        let entries = entries.iter().copied().chain(std::iter::repeat(0));
        out.extend(entries.take(room).flat_map(u16::to_le_bytes));
        let weights = weights.iter().copied().chain(std::iter::repeat(0.0));
        out.extend(weights.take(room).flat_map(f32::to_le_bytes));
    }
}

/// Numbers as little-endian bytes.
pub(super) fn floats(numbers: &[f32]) -> impl Iterator<Item = u8> + '_ {
    numbers.iter().flat_map(|n| n.to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn a_vertex_by_hand() {
        let mesh = Mesh {
            positions: vec![Vec3::new(1.0, 2.0, 3.0)],
            normals: vec![Vec3::Y],
            texcoords: vec![Vec2::new(0.5, 0.25)],
            influences: 2,
            binding_indices: vec![7, 258],
            weights: vec![0.75, 0.25],
            ..Mesh::default()
        };
        let mut bytes = Vec::new();
        push_vertices(&mesh, &mut bytes);
        assert_eq!(bytes.len(), 56);
        assert_eq!(bytes.len(), vertex_bytes(&mesh));
        assert_eq!(bytes[..4], [0, 0, 0x80, 0x3f]);
        assert_eq!(bytes[16..20], [0, 0, 0x80, 0x3f], "y of the normal");
        assert_eq!(bytes[32..40], [7, 0, 2, 1, 0, 0, 0, 0]);
        assert_eq!(bytes[40..48], [0, 0, 0x40, 0x3f, 0, 0, 0x80, 0x3e]);
        assert_eq!(bytes[48..], [0; 8]);
    }
}
