//! Vertices that the simplifier treats as one: position classes, and wedges within them.
//!
//! A position class holds vertices that stay together: equal in rest position and near each other in
//! every pose, over all parts. Skins and morph deltas may differ, as where a head and a torso with
//! weights of their own meet; both sides are then simplified together and no gap opens. A wedge
//! holds vertices that agree in all attributes, in the part that draws them and in the classes given
//! by the caller. Source: `docs/methods/clustered-mesh.md`
//! part 5.

use articula_core::{Mesh, Morph};
use glam::Vec3;
use std::collections::HashMap;

/// Maximum distance between members of a class in any pose, relative to the extent.
const TOGETHER: f32 = 1e-5;

/// Maximum number of existing classes with the same position that a vertex is compared with.
const MAX_ALIKE: usize = 8;

/// Classes and wedges of a mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct Classes {
    /// Position class of each vertex.
    pub(super) of_vertex: Vec<u32>,
    /// First vertex of each class, ascending.
    pub(super) first: Vec<u32>,
    /// First vertex that equals each vertex in all attributes.
    pub(super) wedge: Vec<u32>,
    /// First vertex of the class that equals it in part, skin influences, morph deltas, texture
    /// coordinates and colour: all but the normal.
    pub(super) chart: Vec<u32>,
    /// Part of each vertex.
    pub(super) part: Vec<u32>,
}

impl Classes {
    /// Number of position classes.
    pub(super) fn len(&self) -> usize {
        self.first.len()
    }

    /// Groups the vertices. `finer` is a class per vertex that wedges must not mix, or empty.
    pub(super) fn new(mesh: &Mesh, poses: &[Vec<Vec3>], finer: &[u32]) -> Self {
        let skins = skin_ids(mesh);
        let morphs = morph_ids(mesh, |m, i| m.positions[i]);
        let bends = morph_ids(mesh, |m, i| m.normals[i]);
        let parts = part_ids(mesh);
        let tolerance = TOGETHER * extent(&poses[0]);
        let mut classes = Self::default();
        let mut at_place = HashMap::<[u32; 3], Vec<u32>>::new();
        for v in 0..mesh.len() {
            let known = at_place.entry(bits(poses[0][v])).or_default();
            let together = |class: &&u32| {
                let first = classes.first[**class as usize] as usize;
                poses.iter().all(|p| near(p[v], p[first], tolerance))
            };
            let class = known.iter().rev().take(MAX_ALIKE).find(together).copied();
            let class = class.unwrap_or_else(|| {
                let new = classes.first.len() as u32;
                classes.first.push(v as u32);
                known.push(new);
                new
            });
            classes.of_vertex.push(class);
        }
        let chart = |v: usize| {
            let (uv, color) = (mesh.texcoords[v], mesh.colors[v].to_array());
            let finer = finer.get(v).copied().unwrap_or(0);
            (
                classes.of_vertex[v],
                (parts[v], skins[v], morphs[v]),
                uv.to_array().map(flat_bits),
                color.map(flat_bits),
                finer,
            )
        };
        classes.chart = firsts(mesh.len(), chart);
        let wedge = |v: usize| (classes.chart[v], bits(mesh.normals[v]), bends[v]);
        classes.wedge = firsts(mesh.len(), wedge);
        classes.part = parts;
        classes
    }
}

/// For each vertex, the first vertex with the same key.
fn firsts<K: std::hash::Hash + Eq>(count: usize, key: impl Fn(usize) -> K) -> Vec<u32> {
    let mut first = HashMap::with_capacity(count);
    (0..count)
        .map(|v| *first.entry(key(v)).or_insert(v as u32))
        .collect()
}

fn near(a: Vec3, b: Vec3, tolerance: f32) -> bool {
    bits(a) == bits(b) || a.distance(b) <= tolerance
}

/// Largest extent of the finite points along an axis.
pub(crate) fn extent(points: &[Vec3]) -> f32 {
    let mut finite = points.iter().filter(|p| p.is_finite());
    let Some(first) = finite.next() else {
        return 0.0;
    };
    let (lo, hi) = finite.fold((*first, *first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    (hi - lo).max_element()
}

/// Bits of a number, the same for both zeros.
fn flat_bits(x: f32) -> u32 {
    (x + 0.0).to_bits()
}

fn bits(p: Vec3) -> [u32; 3] {
    p.to_array().map(flat_bits)
}

/// Ids of influences: equal for vertices with the same influences in any order.
fn skin_ids(mesh: &Mesh) -> Vec<u32> {
    let mut known = HashMap::<Vec<(usize, u32)>, u32>::new();
    let mut influences = Vec::new();
    (0..mesh.len())
        .map(|v| {
            influences.clear();
            influences.extend(mesh.influences_of(v).map(|(j, w)| (j, w.to_bits())));
            influences.sort_unstable();
            if let Some(id) = known.get(&influences) {
                return *id;
            }
            let id = known.len() as u32;
            known.insert(influences.clone(), id);
            id
        })
        .collect()
}

/// Ids of morph deltas: equal for vertices that every morph target changes equally.
fn morph_ids(mesh: &Mesh, delta: impl Fn(&Morph, usize) -> Vec3) -> Vec<u32> {
    let mut ids = vec![0u32; mesh.len()];
    let mut known = HashMap::<(u32, u16, [u32; 3]), u32>::new();
    for morph in &mesh.morphs {
        for (i, v) in morph.vertices.iter().enumerate() {
            let delta = delta(morph, i);
            if delta == Vec3::ZERO {
                continue;
            }
            let next = known.len() as u32 + 1;
            let id = &mut ids[*v as usize];
            *id = *known.entry((*id, morph.slot, bits(delta))).or_insert(next);
        }
    }
    ids
}

/// Part of each vertex.
fn part_ids(mesh: &Mesh) -> Vec<u32> {
    let mut ids = vec![u32::MAX; mesh.len()];
    for (p, part) in mesh.parts.iter().enumerate() {
        ids[part.vertices.clone()].fill(p as u32);
    }
    ids
}
