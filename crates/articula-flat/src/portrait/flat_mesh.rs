//! 2D mesh of a portrait: the triangles that are visible in some pose, over welded vertices.

use super::error::{PortraitError, refuse};
use super::head::HeadPose;
use super::posing::{Poser, part_of, places, project};
use super::source::{MAX_VERTICES, PortraitOptions, PortraitSource, limit};
use articula_core::Mesh;
use glam::Vec2;
use std::collections::BTreeMap;

/// Triangles smaller than this, in square pixels, are not drawn.
const MIN_AREA: f32 = 0.02;

/// Triangles of a portrait, without positions.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct FlatMesh {
    /// Vertex of the 3D mesh for each vertex; ascending.
    pub vertices: Vec<u32>,
    /// Vertex indices, counter-clockwise where visible; two-sided triangles are stored twice.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle.
    pub materials: Vec<Option<usize>>,
}

impl FlatMesh {
    /// Triangle on the other side of each edge (corner to next corner), if there is one.
    pub(crate) fn neighbours(&self) -> Vec<[Option<u32>; 3]> {
        let mut of_edge: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        let key = |a: u32, b: u32| (a.min(b), a.max(b));
        let edges = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        for (t, triangle) in self.triangles.iter().enumerate() {
            for (a, b) in edges(triangle) {
                of_edge.entry(key(a, b)).or_default().push(t as u32);
            }
        }
        let corners = |t: u32| {
            let mut corners = self.triangles[t as usize];
            corners.sort_unstable();
            corners
        };
        // The back of the same triangle is not a neighbour.
        let other = |t: usize, (a, b): (u32, u32)| {
            let own = corners(t as u32);
            let mut sharing = of_edge.get(&key(a, b))?.iter().copied();
            sharing.find(|n| corners(*n) != own)
        };
        let of = |(t, triangle)| edges(triangle).map(|edge| other(t, edge));
        self.triangles.iter().enumerate().map(of).collect()
    }

    /// Whether a triangle with these corners is drawn: its front is visible.
    pub(crate) fn shows(corners: [Vec2; 3]) -> bool {
        front_area(corners) > MIN_AREA
    }
}

/// Area in square pixels, positive if the front is visible (the picture's y axis points down).
pub(crate) fn front_area([a, b, c]: [Vec2; 3]) -> f32 {
    -0.5 * (b - a).perp_dot(c - a)
}

/// The corners of a triangle.
pub(crate) fn corners_of(places: &[Vec2], triangle: [u32; 3]) -> [Vec2; 3] {
    triangle.map(|v| places[v as usize])
}

/// Poses that cover the range of a portrait: head angles alone, and each expression at some angles.
fn probes(expressions: usize, options: &PortraitOptions) -> Vec<(HeadPose, Vec<(usize, f32)>)> {
    let (yaw, pitch) = (options.yaw_limit_degrees, options.pitch_limit_degrees);
    let mut out = Vec::new();
    for y in [0.0, -1.0, -0.5, 0.5, 1.0] {
        for p in [0.0, -1.0, 1.0] {
            let pose = HeadPose {
                yaw_degrees: y * yaw,
                pitch_degrees: p * pitch,
                roll_degrees: 0.0,
            };
            out.push((pose, Vec::new()));
            if p == 0.0 {
                out.extend((0..expressions).map(|e| (pose, vec![(e, 1.0)])));
            }
        }
    }
    out
}

/// Finds the 2D mesh of a source.
pub(crate) fn flat_mesh(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
) -> Result<FlatMesh, PortraitError> {
    let mut used: Vec<u32> = source.triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mesh = part_of(source.mesh, &used);
    let poser = Poser::new(&mesh, source.rig, &source.head, source.expressions);
    let local = |v: u32| used.partition_point(|u| *u < v) as u32;
    let (mut triangles, mut materials) = (Vec::new(), Vec::new());
    for triangle in source.triangles {
        let [a, b, c] = triangle.map(local);
        let part = part_at(source.mesh, triangle[0]);
        let material = part.and_then(|p| source.mesh.parts[p].material);
        let appearance = material.and_then(|m| source.appearance.materials.get(m));
        triangles.push([a, b, c]);
        materials.push(material);
        if appearance.is_some_and(|m| m.double_sided) {
            triangles.push([a, c, b]);
            materials.push(material);
        }
    }
    let viewport = source.camera.viewport;
    let size = Vec2::new(viewport.width_px, viewport.height_px);
    let mut tracks: Vec<Vec<u32>> = vec![Vec::new(); used.len()];
    let mut seen = vec![false; triangles.len()];
    for (pose, weights) in probes(source.expressions.len(), options) {
        let skinned = poser.skin(pose, &weights);
        for (track, p) in tracks.iter_mut().zip(&skinned.positions) {
            // In steps of 0.1 µm, so that rounding tears no seam.
            track.extend(p.to_array().map(|x| (x * 1e7).round() as i32 as u32));
        }
        let places = places(&project(&skinned, &source.camera, pose)?);
        for (t, triangle) in triangles.iter().enumerate() {
            let corners = corners_of(&places, *triangle);
            let low = corners[0].min(corners[1]).min(corners[2]);
            let high = corners[0].max(corners[1]).max(corners[2]);
            let inside = high.cmpgt(Vec2::ZERO).all() && low.cmplt(size).all();
            seen[t] |= inside && FlatMesh::shows(corners);
        }
    }
    let welded = weld(tracks);
    let mut flat = FlatMesh::default();
    for (t, triangle) in triangles.iter().enumerate() {
        let corners = triangle.map(|v| welded[v as usize]);
        let [a, b, c] = corners;
        if seen[t] && a != b && b != c && c != a {
            flat.triangles.push(corners);
            flat.materials.push(materials[t]);
        }
    }
    if flat.triangles.is_empty() {
        return Err(refuse(
            "triangles",
            "no triangle is visible from any view; turn the camera or show other meshes",
        ));
    }
    compact(flat, &used)
}

/// For each vertex, the first vertex that coincides with it in all poses.
fn weld(tracks: Vec<Vec<u32>>) -> Vec<u32> {
    let mut first: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
    let place = |(v, track)| *first.entry(track).or_insert(v as u32);
    tracks.into_iter().enumerate().map(place).collect()
}

/// Removes vertices without a triangle.
fn compact(mut flat: FlatMesh, used: &[u32]) -> Result<FlatMesh, PortraitError> {
    let mut kept: Vec<u32> = flat.triangles.iter().flatten().copied().collect();
    kept.sort_unstable();
    kept.dedup();
    limit("vertices of the 2D mesh", kept.len(), MAX_VERTICES)?;
    for corner in flat.triangles.iter_mut().flatten() {
        *corner = kept.partition_point(|k| k < corner) as u32;
    }
    flat.vertices = kept.iter().map(|k| used[*k as usize]).collect();
    Ok(flat)
}

/// Part of the mesh that a vertex belongs to.
pub(crate) fn part_at(mesh: &Mesh, vertex: u32) -> Option<usize> {
    let is_in = |p: &articula_core::Part| p.vertices.contains(&(vertex as usize));
    mesh.parts.iter().position(is_in)
}
