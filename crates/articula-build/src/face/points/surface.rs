//! The surface on which the points of a face are sought, and its connected parts.

use foldhash::{HashMap, HashMapExt};
use glam::Vec3;

/// The mesh of a head in its rest pose, in the frame of the head: +X to the subject's left, +Y up,
/// +Z out of the face. Lengths in metres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaceSurface {
    /// Places of the vertices.
    pub positions: Vec<Vec3>,
    /// Vertex indices of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Blend shapes by their names in ARKit, each with one offset for each vertex, at weight 1.
    pub shapes: Vec<(&'static str, Vec<Vec3>)>,
    /// Centres of the left and the right eyeball, if joints tell them.
    pub eyes: Option<[Vec3; 2]>,
}

/// Triangles that share vertices, or vertices of the same place and the same offsets.
#[derive(Debug, Clone, Default)]
pub(in crate::face) struct SurfacePart {
    pub(in crate::face) triangles: Vec<[u32; 3]>,
    /// Vertices of the triangles, ascending.
    pub(in crate::face) vertices: Vec<u32>,
    /// Sum of the areas, m².
    pub(super) area: f32,
}

impl FaceSurface {
    /// First vertex of the same place and the same offsets, for each vertex. Lips that touch stay
    /// apart, as their offsets differ.
    pub(in crate::face) fn joined(&self) -> Vec<u32> {
        let mut first: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut key = Vec::new();
        let mut joined = Vec::with_capacity(self.positions.len());
        for vertex in 0..self.positions.len() {
            key.clear();
            let offsets = self.shapes.iter().map(|(_, offsets)| &offsets[vertex]);
            for at in std::iter::once(&self.positions[vertex]).chain(offsets) {
                // One bit pattern for both zeros.
                key.extend(at.to_array().map(|x| (x + 0.0).to_bits()));
            }
            let known = first.get(&key).copied();
            joined.push(known.unwrap_or_else(|| {
                first.insert(key.clone(), vertex as u32);
                vertex as u32
            }));
        }
        joined
    }

    /// The connected parts, the one with the largest area first. Triangles are connected across an
    /// edge; where more than two meet at the same place, such as the shell over an eye at the rim of
    /// the lids, only those that share the vertices themselves are.
    pub(in crate::face) fn parts(&self, joined: &[u32]) -> Vec<SurfacePart> {
        let mut root: Vec<u32> = (0..self.triangles.len() as u32).collect();
        fn top(root: &mut [u32], mut at: u32) -> u32 {
            while root[at as usize] != at {
                root[at as usize] = root[root[at as usize] as usize];
                at = root[at as usize];
            }
            at
        }
        let mut edges: Vec<([u32; 2], [u32; 2], u32)> = Vec::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                let places = (joined[a as usize], joined[b as usize]);
                edges.push((ordered(places), ordered((a, b)), index as u32));
            }
        }
        edges.sort_unstable();
        for same_place in edges.chunk_by(|a, b| a.0 == b.0) {
            for pair in same_place.windows(2) {
                if same_place.len() == 2 || pair[0].1 == pair[1].1 {
                    let (one, other) = (top(&mut root, pair[0].2), top(&mut root, pair[1].2));
                    root[one.max(other) as usize] = one.min(other);
                }
            }
        }
        let mut of_root: HashMap<u32, usize> = HashMap::new();
        let mut parts: Vec<SurfacePart> = Vec::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            let part = *of_root
                .entry(top(&mut root, index as u32))
                .or_insert_with(|| {
                    parts.push(SurfacePart::default());
                    parts.len() - 1
                });
            parts[part].triangles.push(*triangle);
            parts[part].area += self.doubled_normal(triangle).length() / 2.0;
        }
        for part in &mut parts {
            part.vertices = part.triangles.iter().flatten().copied().collect();
            part.vertices.sort_unstable();
            part.vertices.dedup();
        }
        parts.sort_by(|a, b| b.area.total_cmp(&a.area));
        parts
    }

    /// The triangles all of whose corners are among some vertices.
    pub(in crate::face) fn triangles_among(&self, vertices: &[u32]) -> Vec<[u32; 3]> {
        let mut is_one = vec![false; self.positions.len()];
        vertices.iter().for_each(|v| is_one[*v as usize] = true);
        let all = self.triangles.iter().copied();
        all.filter(|t| t.iter().all(|v| is_one[*v as usize]))
            .collect()
    }

    /// Corners of a triangle.
    pub(super) fn corners(&self, triangle: &[u32; 3]) -> [Vec3; 3] {
        triangle.map(|v| self.positions[v as usize])
    }

    /// Normal of a triangle with the length of twice its area.
    pub(super) fn doubled_normal(&self, triangle: &[u32; 3]) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }
}

fn ordered((a, b): (u32, u32)) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
