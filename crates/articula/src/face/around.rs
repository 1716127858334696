//! The skin that goes on from a head, such as the neck: it follows what is beside it.

use super::surface::HeadSurface;
use crate::figure::Figure;
use articula_core::PosedMesh;
use glam::{Quat, Vec3};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Distance along the skin over which it follows the end of the head, by the height of the face.
const REACH: f32 = 0.4;
/// Offsets that are shorter, in metres, are none.
const LEAST: f32 = 1e-5;

/// A head with the skin around it.
pub(super) struct Around {
    /// The vertices of the head, then those around it.
    pub(super) head: HeadSurface,
    /// For each vertex around the head, the one of the head that it follows, and how much.
    followed: Vec<(u32, f32)>,
}

impl Around {
    /// The skin around a head, with the height of its face in metres.
    pub(super) fn of(figure: &Figure, head: &HeadSurface, height: f32) -> Self {
        let mesh = &figure.asset.mesh;
        let positions = at_rest(figure, head.model_from_head);
        let place = places(&positions);
        let mut open: BinaryHeap<Reverse<(u32, u32)>> = BinaryHeap::new();
        // Distance, and the vertex of the head that is followed, of each place.
        let mut found: BTreeMap<u32, (f32, u32)> = BTreeMap::new();
        for (index, vertex) in head.vertices.iter().enumerate() {
            let place = place[*vertex as usize];
            found.entry(place).or_insert((0.0, index as u32));
            open.push(Reverse((0, place)));
        }
        let mut beside: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| place[v as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                beside.entry(from).or_default().push(to);
                beside.entry(to).or_default().push(from);
            }
        }
        let reach = REACH * height;
        while let Some(Reverse((bits, from))) = open.pop() {
            let (here, head) = found[&from];
            if f32::from_bits(bits) > here {
                continue;
            }
            for to in beside.get(&from).into_iter().flatten() {
                let way = positions[from as usize].distance(positions[*to as usize]);
                let there = here + way;
                if there < reach && found.get(to).is_none_or(|known| there < known.0) {
                    found.insert(*to, (there, head));
                    open.push(Reverse((there.to_bits(), *to)));
                }
            }
        }
        let mut around = Self {
            head: head.clone(),
            followed: Vec::new(),
        };
        let mut index_of = vec![u32::MAX; mesh.len()];
        for (index, vertex) in head.vertices.iter().enumerate() {
            index_of[*vertex as usize] = index as u32;
        }
        for vertex in 0..mesh.len() {
            let Some((away, head)) = found.get(&place[vertex]).copied() else {
                continue;
            };
            if index_of[vertex] == u32::MAX {
                index_of[vertex] = around.head.vertices.len() as u32;
                around.head.vertices.push(vertex as u32);
                around.head.surface.positions.push(positions[vertex]);
                let t = 1.0 - away / reach;
                around.followed.push((head, t * t * (3.0 - 2.0 * t)));
            }
        }
        let triangles = mesh.triangles.iter();
        let triangles = triangles.map(|t| t.map(|v| index_of[v as usize]));
        let known = triangles.filter(|t| !t.contains(&u32::MAX));
        around.head.surface.triangles = known.collect();
        around.head.surface.shapes.clear();
        around
    }

    /// Displacements of all vertices by those of the head.
    pub(super) fn displacements(&self, mut of_head: Vec<Vec3>) -> Vec<Vec3> {
        let follow = |(head, share): &(u32, f32)| {
            let offset = *share * of_head[*head as usize];
            if offset.length() < LEAST {
                Vec3::ZERO
            } else {
                offset
            }
        };
        let around: Vec<Vec3> = self.followed.iter().map(follow).collect();
        of_head.extend(around);
        of_head
    }
}

/// The places of all vertices of a figure at rest, in the frame of its head.
fn at_rest(figure: &Figure, model_from_head: Quat) -> Vec<Vec3> {
    let asset = &figure.asset;
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    posed.pose(asset.rig.rest_pose());
    let weights = vec![0.0; asset.mesh.morph_weights.len()];
    let to_head = model_from_head.inverse();
    let all = posed.skinned(&weights).positions;
    all.iter().map(|p| to_head * *p).collect()
}

/// The first vertex at the place of each.
fn places(positions: &[Vec3]) -> Vec<u32> {
    let mut first: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let of = positions.iter().enumerate().map(|(v, p)| {
        // One bit pattern for both zeros.
        let key = p.to_array().map(|x| (x + 0.0).to_bits());
        *first.entry(key).or_insert(v as u32)
    });
    of.collect()
}
