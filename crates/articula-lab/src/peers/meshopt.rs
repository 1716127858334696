//! meshoptimizer: its simplifier and its codecs, for comparison.

use crate::wire_mesh::{PRECISION, WireMesh};
use anyhow::{Result, ensure};
use articula_core::Mesh;
use glam::{Vec2, Vec3};
use meshopt::{SimplifyOptions, VertexDataAdapter};
use std::collections::HashMap;

/// Weight of normals against positions.
const NORMAL_WEIGHT: f32 = 0.5;

/// Coded size of the vertices and triangles of a mesh, as users of meshoptimizer code them: equal
/// vertices are joined, triangles are in vertex-cache order, vertices in the order of their first
/// use; a vertex is one interleaved record of whole numbers (24 bytes for a skinned vertex with
/// texture coordinates), current version of the stream.
pub(crate) fn coded_bytes(mesh: &WireMesh) -> Result<usize> {
    if mesh.triangles.is_empty() {
        return Ok(0);
    }
    let bytes = record(mesh, 0).len();
    match bytes {
        8 => coded::<8>(mesh),
        12 => coded::<12>(mesh),
        16 => coded::<16>(mesh),
        20 => coded::<20>(mesh),
        24 => coded::<24>(mesh),
        28 => coded::<28>(mesh),
        _ => anyhow::bail!("a vertex of {bytes} bytes"),
    }
}

/// A vertex of `N` bytes.
#[derive(Clone, Copy, PartialEq)]
#[repr(transparent)]
struct Record<const N: usize>([u8; N]);

impl<const N: usize> Default for Record<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn coded<const N: usize>(mesh: &WireMesh) -> Result<usize> {
    let mut vertices = vec![Record([0; N]); mesh.vertices()];
    for (v, vertex) in vertices.iter_mut().enumerate() {
        vertex.0.copy_from_slice(&record(mesh, v));
    }
    let indices = mesh.triangles.as_flattened();
    let (count, remap) = meshopt::generate_vertex_remap(&vertices, Some(indices));
    let vertices = meshopt::remap_vertex_buffer(&vertices, count, &remap);
    let indices = meshopt::remap_index_buffer(Some(indices), vertices.len(), &remap);
    let mut indices = meshopt::optimize_vertex_cache(&indices, count);
    let vertices = meshopt::optimize_vertex_fetch(&mut indices, &vertices);
    let coded_vertices = meshopt::encode_vertex_buffer(&vertices)?;
    let coded_indices = meshopt::encode_index_buffer(&indices, vertices.len())?;
    let back: Vec<Record<N>> = meshopt::decode_vertex_buffer(&coded_vertices, vertices.len())?;
    ensure!(back == vertices, "meshopt does not decode its own vertices");
    Ok(coded_vertices.len() + coded_indices.len())
}

/// A vertex: position (with two unused bytes), normal, texture coordinates, colour, joints,
/// weights.
pub(crate) fn record(mesh: &WireMesh, v: usize) -> Vec<u8> {
    let [x, y, z] = mesh.positions[v];
    let mut bytes: Vec<u8> = [x, y, z, 0].iter().flat_map(|c| c.to_le_bytes()).collect();
    if let Some(normal) = mesh.normals.get(v) {
        bytes.extend(octahedral(*normal).iter().flat_map(|c| c.to_le_bytes()));
    }
    if let Some(texcoord) = mesh.texcoords.get(v) {
        bytes.extend(texcoord.iter().flat_map(|c| c.to_le_bytes()));
    }
    bytes.extend(mesh.colors.get(v).into_iter().flatten());
    if let Some(joints) = mesh.joints.get(v) {
        // Joints of a part with more than 256 of them would take two bytes each.
        bytes.extend(joints.map(|j| j as u8));
    }
    bytes.extend(mesh.weights.get(v).into_iter().flatten());
    bytes
}

/// A whole character as input of meshoptimizer's simplifier: vertices that are equal in all
/// attributes are joined first, as its users do. It detects seams by bitwise equal positions and
/// keeps them, as it keeps borders between materials.
pub(crate) struct Simplifier {
    triangles: Vec<[u32; 3]>,
    positions: Vec<f32>,
    normals: Vec<f32>,
}

/// Whether a collapse may cross a seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Seams {
    /// Not allowed.
    Kept,
    /// Allowed: for meshes in which every triangle has its own normals.
    Crossed,
}

impl Simplifier {
    /// The simplifier of a mesh with vertices at `positions`.
    pub(crate) fn new(mesh: &Mesh, triangles: &[[u32; 3]], positions: &[Vec3]) -> Self {
        let first = first_equals(mesh, positions);
        Self {
            triangles: triangles
                .iter()
                .map(|t| t.map(|v| first[v as usize]))
                .collect(),
            positions: positions.iter().flat_map(|p| p.to_array()).collect(),
            normals: mesh.normals.iter().flat_map(|n| n.to_array()).collect(),
        }
    }

    /// Simplifies to a number of triangles, without a bound on the error; more may remain. With
    /// `by_normals`, normals have weight one half, as in `gltfpack`.
    pub(crate) fn run(
        &self,
        target: usize,
        by_normals: bool,
        seams: Seams,
    ) -> Result<Vec<[u32; 3]>> {
        let bytes = meshopt::typed_to_bytes(&self.positions);
        let vertices = VertexDataAdapter::new(bytes, 12, 0)?;
        let indices = self.triangles.as_flattened();
        let options = match seams {
            Seams::Kept => SimplifyOptions::None,
            Seams::Crossed => SimplifyOptions::Permissive,
        };
        let found = if by_normals {
            meshopt::simplify_with_attributes_and_locks(
                indices,
                &vertices,
                &self.normals,
                &[NORMAL_WEIGHT; 3],
                12,
                &vec![false; self.positions.len() / 3],
                3 * target,
                f32::MAX,
                options,
                None,
            )
        } else {
            meshopt::simplify(indices, &vertices, 3 * target, f32::MAX, options, None)
        };
        Ok(found.as_chunks().0.to_vec())
    }
}

/// For each vertex, the first vertex of the same part with equal attributes.
fn first_equals(mesh: &Mesh, positions: &[Vec3]) -> Vec<u32> {
    let mut known = HashMap::new();
    let mut first = vec![0; mesh.len()];
    for (p, part) in mesh.parts.iter().enumerate() {
        for v in part.vertices.clone() {
            let at = v * mesh.influences..(v + 1) * mesh.influences;
            let mut key = vec![p as u32];
            key.extend(positions[v].to_array().map(f32::to_bits));
            key.extend(mesh.normals[v].to_array().map(f32::to_bits));
            key.extend(mesh.texcoords[v].to_array().map(f32::to_bits));
            key.extend(mesh.colors[v].to_array().map(f32::to_bits));
            key.extend(
                mesh.binding_indices[at.clone()]
                    .iter()
                    .map(|b| u32::from(*b)),
            );
            key.extend(mesh.weights[at].iter().map(|w| w.to_bits()));
            first[v] = *known.entry(key).or_insert(v as u32);
        }
    }
    first
}

/// A direction on the unfolded octahedron.
fn octahedral(normal: Vec3) -> [i16; 2] {
    let n = normal / normal.abs().element_sum().max(f32::MIN_POSITIVE);
    let flat = Vec2::new(n.x, n.y);
    let folded = if n.z >= 0.0 {
        flat
    } else {
        (Vec2::ONE - Vec2::new(n.y, n.x).abs()) * Vec2::new(1f32.copysign(n.x), 1f32.copysign(n.y))
    };
    let most = ((1u32 << (PRECISION.normal_bits - 1)) - 1) as f32;
    (folded * most).round().to_array().map(|c| c as i16)
}
