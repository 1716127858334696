//! Vertices that the simplifier treats as one: position classes, and wedges within them.
//!
//! A position class holds vertices that stay together: equal in rest position and near each other in
//! every pose, over all parts. Skins and morph deltas may differ, as where a head and a torso with
//! weights of their own meet; both sides are then simplified together and no gap opens. A wedge
//! holds vertices that agree in all attributes, in the part that draws them and in the classes given
//! by the caller. Source: `docs/methods/clustered-mesh.md`
//! part 5.

use articula_core::{Mesh, Morph};
use foldhash::{HashMap, HashMapExt};
use glam::Vec3;

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

#[cfg(test)]
mod tests {
    use super::super::shapes::mesh;
    use super::*;
    use articula_core::Part;

    /// Two vertices at one place, and a third one 10 m away.
    fn doubled() -> Mesh {
        mesh(
            vec![Vec3::ONE, Vec3::ONE, Vec3::ONE + Vec3::X * 10.0],
            vec![],
        )
    }

    fn of(mesh: &Mesh) -> Classes {
        Classes::new(mesh, std::slice::from_ref(&mesh.positions), &[])
    }

    #[test]
    fn the_extent_is_the_longest_side_of_finite_points() {
        let points = [
            [1.0, 2.0, 3.0],
            [4.0, -3.0, 3.0],
            [f32::NAN, 90.0, 0.0],
            [2.0, 0.0, 5.0],
        ];
        assert_eq!(extent(&points.map(Vec3::from_array)), 5.0);
        assert_eq!(extent(&[Vec3::NAN]), 0.0);
    }

    #[test]
    fn vertices_of_a_class_stay_near_each_other_in_all_poses() {
        let mesh = doubled();
        // The tolerance is 1e-5 of 10 m.
        for (apart, classes) in [(0.0, [0, 0, 1]), (0.5e-4, [0, 0, 1]), (2e-4, [0, 1, 2])] {
            let mut pose = mesh.positions.clone();
            pose[1].z += apart;
            let poses = [mesh.positions.clone(), pose];
            let found = Classes::new(&mesh, &poses, &[]);
            assert_eq!(found.of_vertex, classes);
            assert_eq!(found.len(), classes[2] as usize + 1);
            assert_eq!(found.first.last(), Some(&2));
        }
        // Equal positions that are not finite are one place.
        let nowhere = [mesh.positions.clone(), vec![Vec3::INFINITY; 3]];
        assert_eq!(Classes::new(&mesh, &nowhere, &[]).of_vertex, [0, 0, 1]);
    }

    #[test]
    fn both_zeros_are_one_place() {
        let mut mesh = doubled();
        (mesh.positions[0], mesh.positions[1]) = (Vec3::ZERO, -Vec3::ZERO);
        let classes = of(&mesh);
        assert_eq!(classes.of_vertex, [0, 0, 1]);
        assert_eq!(classes.wedge, [0, 0, 2]);
    }

    #[test]
    fn charts_differ_in_skin_but_not_in_the_order_of_influences() {
        let mut mesh = doubled();
        mesh.influences = 2;
        mesh.bindings.push(mesh.bindings[0]);
        mesh.bindings[1].joint = 1;
        mesh.binding_indices = vec![0, 1, 1, 0, 0, 1];
        mesh.weights = vec![0.75, 0.25, 0.25, 0.75, 1.0, 0.0];
        assert_eq!(of(&mesh).chart, [0, 0, 2]);
        mesh.weights[2..4].copy_from_slice(&[0.75, 0.25]);
        let classes = of(&mesh);
        assert_eq!(classes.of_vertex, [0, 0, 1]);
        assert_eq!(
            (classes.chart, classes.wedge),
            (vec![0, 1, 2], vec![0, 1, 2])
        );
    }

    #[test]
    fn charts_differ_in_the_deltas_of_any_morph() {
        let morph = |slot, vertices: &[u32], deltas: &[f32]| Morph {
            slot,
            vertices: vertices.to_vec(),
            positions: deltas.iter().map(|d| Vec3::X * *d).collect(),
            normals: vec![Vec3::ZERO; deltas.len()],
        };
        let charts = |morphs: Vec<Morph>| {
            of(&Mesh {
                morphs,
                ..doubled()
            })
            .chart
        };
        assert_eq!(charts(vec![morph(0, &[0, 1], &[1.0, 1.0])]), [0, 0, 2]);
        assert_eq!(charts(vec![morph(0, &[0, 1], &[1.0, 2.0])]), [0, 1, 2]);
        assert_eq!(charts(vec![morph(0, &[1], &[1.0])]), [0, 1, 2]);
        assert_eq!(charts(vec![morph(0, &[1], &[0.0])]), [0, 0, 2]);
        let (first, second) = (morph(0, &[0], &[1.0]), morph(1, &[1], &[1.0]));
        assert_eq!(charts(vec![first.clone(), second]), [0, 1, 2]);
        // The first is equal, the second is not.
        let both = morph(0, &[0, 1], &[1.0, 1.0]);
        assert_eq!(
            charts(vec![both, morph(1, &[0, 1], &[1.0, 3.0])]),
            [0, 1, 2]
        );
    }

    #[test]
    fn wedges_of_a_chart_differ_in_normals_at_rest_or_morphed() {
        let mut mesh = doubled();
        mesh.normals[1] = Vec3::X;
        let classes = of(&mesh);
        assert_eq!(
            (classes.chart, classes.wedge),
            (vec![0, 0, 2], vec![0, 1, 2])
        );
        mesh.normals[1] = mesh.normals[0];
        mesh.morphs = vec![Morph {
            slot: 0,
            vertices: vec![1],
            positions: vec![Vec3::ZERO],
            normals: vec![Vec3::X],
        }];
        let classes = of(&mesh);
        assert_eq!(
            (classes.chart, classes.wedge),
            (vec![0, 0, 2], vec![0, 1, 2])
        );
    }

    #[test]
    fn charts_differ_in_texcoords_colour_part_and_given_classes() {
        let charts = |change: &dyn Fn(&mut Mesh)| {
            let mut mesh = doubled();
            change(&mut mesh);
            of(&mesh).chart
        };
        assert_eq!(charts(&|_| {}), [0, 0, 2]);
        assert_eq!(charts(&|m| m.texcoords[1].y = 0.5), [0, 1, 2]);
        assert_eq!(charts(&|m| m.colors[1].w = 0.5), [0, 1, 2]);
        let in_two = |m: &mut Mesh| {
            let part = m.parts[0].clone();
            m.parts = [0..1, 1..3]
                .map(|vertices| Part {
                    vertices,
                    ..part.clone()
                })
                .to_vec();
        };
        assert_eq!(charts(&in_two), [0, 1, 2]);
        let mesh = doubled();
        let given = Classes::new(&mesh, std::slice::from_ref(&mesh.positions), &[4, 5, 5]);
        assert_eq!(
            (given.of_vertex, given.chart),
            (vec![0, 0, 1], vec![0, 1, 2])
        );
        assert_eq!(given.part, [0; 3]);
    }
}
