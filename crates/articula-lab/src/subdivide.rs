//! Subdivision of a character: each triangle becomes four.
//!
//! Source: Loop, *Smooth Subdivision Surfaces Based on Triangles* (1987), with the border rule of
//! Hoppe et al. (1994). Positions and morph offsets are smoothed across seams, which stay closed;
//! texture coordinates, colours and skin weights of a new vertex are the mean of its edge's ends.
//! Normals are those of the new surface, so the surface should have no creases.

use articula_core::source::{MorphTarget, Primitive, RawMesh};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Maximum number of influences of a vertex.
const INFLUENCES: usize = 4;

/// Subdivides every part of a mesh once.
pub(crate) fn subdivide(mesh: &RawMesh) -> RawMesh {
    RawMesh {
        primitives: mesh.primitives.iter().map(primitive).collect(),
        levels: Vec::new(),
        clustered: Vec::new(),
        ..mesh.clone()
    }
}

fn primitive(coarse: &Primitive) -> Primitive {
    let surface = Surface::new(coarse);
    let edges: Vec<[u32; 2]> = surface.edges.iter().copied().collect();
    let mut fine = Primitive {
        positions: surface.smoothed(coarse, &coarse.positions, &edges),
        texcoords: with_edge_values(&coarse.texcoords, &edges, |a, b| 0.5 * (a + b)),
        colors: with_edge_values(&coarse.colors, &edges, |a, b| 0.5 * (a + b)),
        morphs: coarse
            .morphs
            .iter()
            .map(|m| MorphTarget {
                positions: surface.smoothed(coarse, &m.positions, &edges),
                normals: with_edge_values(&m.normals, &edges, |a, b| 0.5 * (a + b)),
            })
            .collect(),
        material: coarse.material,
        ..Primitive::default()
    };
    add_influences(coarse, &edges, &mut fine);
    let number: BTreeMap<[u32; 2], u32> = edges
        .iter()
        .enumerate()
        .map(|(e, edge)| (*edge, (coarse.positions.len() + e) as u32))
        .collect();
    for &[a, b, c] in &coarse.triangles {
        let middle = |a: u32, b: u32| number[&[a.min(b), a.max(b)]];
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        fine.triangles
            .extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    if !coarse.normals.is_empty() {
        fine.normals = normals(&fine);
    }
    fine
}

/// Area-weighted normals of a surface without creases.
fn normals(fine: &Primitive) -> Vec<Vec3> {
    let points = points(&fine.positions);
    let mut sums = vec![Vec3::ZERO; points.len()];
    for t in &fine.triangles {
        let [a, b, c] = t.map(|v| fine.positions[v as usize]);
        for v in t {
            sums[points[*v as usize] as usize] += (b - a).cross(c - a);
        }
    }
    points
        .iter()
        .map(|p| sums[*p as usize].try_normalize().unwrap_or(Vec3::Y))
        .collect()
}

/// The first vertex at the position of each vertex.
fn points(positions: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::new();
    (0u32..)
        .zip(positions)
        .map(|(v, p)| *first.entry(p.to_array().map(f32::to_bits)).or_insert(v))
        .collect()
}

/// The old values, followed by one value for each edge.
fn with_edge_values<T: Copy>(
    values: &[T],
    edges: &[[u32; 2]],
    middle: impl Fn(T, T) -> T,
) -> Vec<T> {
    if values.is_empty() {
        return Vec::new();
    }
    let at = |v: u32| values[v as usize];
    let new = edges.iter().map(|&[a, b]| middle(at(a), at(b)));
    values.iter().copied().chain(new).collect()
}

fn add_influences(coarse: &Primitive, edges: &[[u32; 2]], fine: &mut Primitive) {
    let count = coarse.influences;
    let kept = (2 * count).min(INFLUENCES);
    let of = |v: u32| {
        let at = v as usize * count..(v as usize + 1) * count;
        coarse.joints[at.clone()].iter().zip(&coarse.weights[at])
    };
    let mut add = |ends: &[u32]| {
        let mut all = BTreeMap::new();
        for (joint, weight) in ends.iter().flat_map(|v| of(*v)) {
            *all.entry(*joint).or_insert(0.0) += *weight;
        }
        let mut all: Vec<(u16, f32)> = all.into_iter().collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        all.resize(kept, (all[0].0, 0.0));
        let sum: f32 = all.iter().map(|(_, w)| w).sum();
        fine.joints.extend(all.iter().map(|(joint, _)| *joint));
        fine.weights.extend(all.iter().map(|(_, w)| w / sum));
    };
    for v in 0..coarse.positions.len() as u32 {
        add(&[v]);
    }
    for edge in edges {
        add(edge);
    }
    fine.influences = kept;
}

/// Neighbourhood of the vertices of a surface, across seams.
struct Surface {
    /// First vertex at the position of each vertex.
    points: Vec<u32>,
    /// Edges by vertices.
    edges: BTreeSet<[u32; 2]>,
    /// For each edge by points: the point opposite in each of its triangles.
    opposite: BTreeMap<[u32; 2], Vec<u32>>,
    /// Neighbouring points of each point, each once.
    beside: Vec<Vec<u32>>,
    /// Neighbouring points of each point along a border.
    border: Vec<Vec<u32>>,
}

impl Surface {
    fn new(coarse: &Primitive) -> Self {
        let points = points(&coarse.positions);
        let mut surface = Self {
            edges: BTreeSet::new(),
            opposite: BTreeMap::new(),
            beside: vec![Vec::new(); points.len()],
            border: vec![Vec::new(); points.len()],
            points,
        };
        for &[a, b, c] in &coarse.triangles {
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                surface.edges.insert([a.min(b), a.max(b)]);
                let [p, q, r] = [a, b, c].map(|v| surface.points[v as usize]);
                let edge = [p.min(q), p.max(q)];
                surface.opposite.entry(edge).or_default().push(r);
            }
        }
        for (&[p, q], opposite) in &surface.opposite {
            for (p, q) in [(p, q), (q, p)] {
                surface.beside[p as usize].push(q);
                if opposite.len() != 2 {
                    surface.border[p as usize].push(q);
                }
            }
        }
        surface
    }

    /// Applies Loop's masks to values of the vertices, which are equal at equal positions.
    fn smoothed(&self, coarse: &Primitive, values: &[Vec3], edges: &[[u32; 2]]) -> Vec<Vec3> {
        let at = |p: u32| values[p as usize];
        let sum = |points: &[u32]| points.iter().map(|p| at(*p)).sum::<Vec3>();
        let old = (0..coarse.positions.len()).map(|v| {
            let p = self.points[v];
            let (beside, border) = (&self.beside[p as usize], &self.border[p as usize]);
            match (beside.len(), border.len()) {
                (0, _) => at(p),
                (n, 0) => {
                    let cosine = (std::f32::consts::TAU / n as f32).cos();
                    let weight = (0.625 - (0.375 + 0.25 * cosine).powi(2)) / n as f32;
                    at(p) * (1.0 - n as f32 * weight) + weight * sum(beside)
                }
                (_, 2) => 0.75 * at(p) + 0.125 * sum(border),
                _ => at(p),
            }
        });
        let new = edges.iter().map(|&[a, b]| {
            let [p, q] = [a, b].map(|v| self.points[v as usize]);
            match self.opposite[&[p.min(q), p.max(q)]].as_slice() {
                opposite @ [_, _] => 0.375 * (at(p) + at(q)) + 0.125 * sum(opposite),
                _ => 0.5 * (at(p) + at(q)),
            }
        });
        old.chain(new).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An octahedron whose vertex 0 is stored twice, the second time for two of its triangles.
    fn octahedron() -> RawMesh {
        let axes = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y];
        let positions = [Vec3::Z, Vec3::NEG_Z].into_iter().chain(axes);
        let mut triangles = Vec::new();
        for i in 0..4u32 {
            let (a, b) = (2 + i, 2 + (i + 1) % 4);
            triangles.extend([[if i < 2 { 0 } else { 6 }, a, b], [1, b, a]]);
        }
        RawMesh {
            primitives: vec![Primitive {
                positions: positions.chain([Vec3::Z]).collect(),
                influences: 1,
                joints: vec![0, 1, 0, 0, 0, 0, 0],
                weights: vec![1.0; 7],
                triangles,
                ..Primitive::default()
            }],
            ..RawMesh::default()
        }
    }

    #[test]
    fn an_octahedron_by_hand() {
        let fine = &subdivide(&octahedron()).primitives[0];
        assert_eq!(fine.triangles.len(), 32);
        // Four neighbours at 90 degrees: their weight is (5/8 - 9/64) / 4 each, and they cancel.
        let expected = 1.0 - (0.625 - 9.0 / 64.0);
        assert!((fine.positions[0].z - expected).abs() < 1e-6);
        assert_eq!(fine.positions[0], fine.positions[6], "no gap at the seam");
        // An edge from X to Y: 3/8 of both; what is opposite cancels.
        let middle = Vec3::new(0.375, 0.375, 0.0);
        assert!(fine.positions.iter().any(|p| p.distance(middle) < 1e-6));
        assert_eq!(fine.influences, 2);
        let mixed = fine.weights.chunks(2).filter(|w| *w == [0.5, 0.5]).count();
        assert_eq!(mixed, 4, "the edges at the one vertex on another joint");
    }

    #[test]
    fn a_border_stays_a_border() {
        let mesh = RawMesh {
            primitives: vec![Primitive {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                influences: 1,
                joints: vec![0; 3],
                weights: vec![1.0; 3],
                triangles: vec![[0, 1, 2]],
                ..Primitive::default()
            }],
            ..RawMesh::default()
        };
        let fine = &subdivide(&mesh).primitives[0];
        assert_eq!(fine.triangles.len(), 4);
        assert_eq!(fine.positions[3], Vec3::new(0.5, 0.0, 0.0));
        assert_eq!(fine.positions[0], Vec3::new(0.125, 0.125, 0.0));
    }
}
