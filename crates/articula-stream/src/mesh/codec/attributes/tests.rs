//! Properties of coded values, on random meshes and broken bytes.

use super::super::mesh::MorphLayout;
use super::*;
use crate::range_coder::{Decoder, Encoder};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Orders the faces so that each shares an edge with an earlier one if possible, and points and
/// wedges by first use.
pub(super) fn discovered(mesh: &QuantisedMesh) -> QuantisedMesh {
    let points: Vec<[u32; 3]> = mesh.point_faces().collect();
    let mut by_edge: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for (f, face) in points.iter().enumerate() {
        for k in 0..3 {
            by_edge
                .entry((face[k], face[(k + 1) % 3]))
                .or_default()
                .push(f);
        }
    }
    let mut is_done = vec![false; points.len()];
    let mut faces = Vec::new();
    for start in 0..points.len() {
        let mut stack = vec![(start, 0)];
        while let Some((f, turn)) = stack.pop() {
            if std::mem::replace(&mut is_done[f], true) {
                continue;
            }
            let mut face = mesh.faces[f];
            face.rotate_left(turn);
            faces.push(face);
            let face = points[f];
            for k in [turn, (turn + 2) % 3, (turn + 1) % 3] {
                let edge = (face[(k + 1) % 3], face[k]);
                for &g in by_edge.get(&edge).into_iter().flatten() {
                    let at = points[g].iter().position(|p| *p == edge.0).unwrap();
                    stack.push((g, at));
                }
            }
        }
    }
    renumbered(mesh, faces, (0, 0))
}

/// The mesh with the given faces, and points and wedges beyond the known ones ordered by first use.
fn renumbered(mesh: &QuantisedMesh, faces: Vec<[u32; 3]>, known: (usize, usize)) -> QuantisedMesh {
    let mut wedges: Vec<usize> = (0..known.1).collect();
    let mut points: Vec<usize> = (0..known.0).collect();
    let (mut wedge_ids, mut point_ids) = (BTreeMap::new(), BTreeMap::new());
    wedge_ids.extend((0..known.1 as u32).map(|w| (w, w)));
    point_ids.extend((0..known.0 as u32).map(|p| (p, p)));
    for &w in faces.as_flattened() {
        wedge_ids.entry(w).or_insert_with(|| {
            wedges.push(w as usize);
            wedges.len() as u32 - 1
        });
        let p = mesh.wedge_points[w as usize];
        point_ids.entry(p).or_insert_with(|| {
            points.push(p as usize);
            points.len() as u32 - 1
        });
    }
    fn pick<T: Clone>(values: &[T], kept: &[usize]) -> Vec<T> {
        let kept = kept.iter().filter(|_| !values.is_empty());
        kept.map(|i| values[*i].clone()).collect()
    }
    QuantisedMesh {
        positions: pick(&mesh.positions, &points),
        skins: pick(&mesh.skins, &points),
        morphs: mesh.morphs.iter().map(|m| pick(m, &points)).collect(),
        wedge_points: wedges
            .iter()
            .map(|w| point_ids[&mesh.wedge_points[*w]])
            .collect(),
        normals: pick(&mesh.normals, &wedges),
        texcoords: pick(&mesh.texcoords, &wedges),
        colors: pick(&mesh.colors, &wedges),
        morph_normals: mesh
            .morph_normals
            .iter()
            .map(|m| pick(m, &wedges))
            .collect(),
        faces: faces.iter().map(|f| f.map(|w| wedge_ids[&w])).collect(),
    }
}

fn surface(mesh: &QuantisedMesh, known: (usize, usize)) -> Surface<'_> {
    Surface {
        faces: &mesh.faces,
        wedge_points: &mesh.wedge_points,
        known_points: known.0,
        known_wedges: known.1,
    }
}

fn encoded(mesh: &QuantisedMesh, layout: &Layout, known: (usize, usize)) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut copy = mesh.clone();
    code_values(&mut encoder, &surface(mesh, known), layout, &mut copy);
    assert_eq!(&copy, mesh, "an encoder changes nothing");
    encoder.finish()
}

fn decoded(
    mesh: &QuantisedMesh,
    layout: &Layout,
    known: (usize, usize),
    bytes: &[u8],
) -> QuantisedMesh {
    // Everything that a decoder knows: topology, positions, and the values of the coarser level.
    let first = |n: usize, list: &Vec<[i32; 3]>| list[..n.min(list.len())].to_vec();
    let mut out = QuantisedMesh {
        skins: mesh.skins[..known.0.min(mesh.skins.len())].to_vec(),
        morphs: mesh.morphs.iter().map(|m| first(known.0, m)).collect(),
        normals: mesh.normals[..known.1.min(mesh.normals.len())].to_vec(),
        texcoords: mesh.texcoords[..known.1.min(mesh.texcoords.len())].to_vec(),
        colors: mesh.colors[..known.1.min(mesh.colors.len())].to_vec(),
        morph_normals: mesh
            .morph_normals
            .iter()
            .map(|m| first(known.1, m))
            .collect(),
        positions: mesh.positions.clone(),
        wedge_points: mesh.wedge_points.clone(),
        faces: mesh.faces.clone(),
    };
    let mut decoder = Decoder::new(bytes);
    code_values(&mut decoder, &surface(mesh, known), layout, &mut out);
    out
}

/// Random layouts.
fn layouts() -> impl Strategy<Value = Layout> {
    let bits = |low: u8, high: u8| prop_oneof![Just(0), low..=high];
    let morphs = prop::collection::vec(any::<bool>(), 0..3);
    (
        1u8..=20,
        bits(2, 16),
        bits(1, 20),
        any::<bool>(),
        0u16..9,
        morphs,
    )
        .prop_map(
            |(position_bits, normal_bits, texcoord_bits, has_colors, joints, morphs)| Layout {
                position_bits,
                normal_bits,
                texcoord_bits,
                has_colors,
                joints,
                morphs: (morphs.into_iter())
                    .map(|has_normals| MorphLayout { has_normals })
                    .collect(),
            },
        )
}

/// Bounded numbers derived from a seed.
struct Draw<'a> {
    seed: &'a [u32],
    drawn: usize,
}

impl Draw<'_> {
    fn below(&mut self, end: u32) -> u32 {
        self.drawn += 1;
        let at = self.drawn as u32;
        let mixed = self.seed[self.drawn % self.seed.len()].wrapping_mul(at | 1);
        (mixed.wrapping_add(at) >> 7) % end.max(1)
    }

    fn vector<const N: usize>(&mut self, end: u32) -> [i32; N] {
        [(); N].map(|()| self.below(end) as i32)
    }

    fn skin(&mut self, joints: u16) -> Vec<(u16, u8)> {
        let mut skin: Vec<(u16, u8)> = Vec::new();
        let mut left = 255;
        for joint in 0..joints {
            let is_last = joint + 1 == joints || skin.len() == 4;
            let weight = if is_last { left } else { self.below(left + 1) };
            skin.extend((weight > 0).then_some((joint, weight as u8)));
            left -= weight;
        }
        skin.sort_by_key(|i| (std::cmp::Reverse(i.1), i.0));
        skin
    }
}

/// Adds points at distinct positions, with skins and morph offsets.
fn add_points(out: &mut QuantisedMesh, layout: &Layout, draw: &mut Draw<'_>) {
    let mut seen = BTreeSet::new();
    for _ in 0..24 {
        let position = draw.vector(1 << layout.position_bits);
        if !seen.insert(position) {
            continue;
        }
        out.positions.push(position);
        if layout.joints > 0 {
            out.skins.push(draw.skin(layout.joints));
        }
        for offsets in &mut out.morphs {
            let is_still = draw.below(2) == 0;
            let reach = [9, 3000, 1 << 24][draw.below(3) as usize];
            let value = draw.vector(reach).map(|x| x - reach as i32 / 2);
            offsets.push(if is_still { [0; 3] } else { value });
        }
    }
}

/// Adds distinct wedges, many of which agree in some kinds.
fn add_wedges(out: &mut QuantisedMesh, layout: &Layout, draw: &mut Draw<'_>) {
    let mut seen = BTreeSet::new();
    for _ in 0..40 {
        let point = draw.below(out.positions.len() as u32);
        let half = (1i32 << (layout.normal_bits.max(2) - 1)) - 1;
        let normal = draw.vector::<2>(3).map(|n| n * half);
        let texcoord = draw.vector::<2>(1 << layout.texcoord_bits);
        let color = draw.vector::<4>(256).map(|c| c as u8);
        let turn = draw.vector::<3>(5).map(|t| t * 400 - 800);
        let own = (
            (layout.normal_bits > 0).then_some(normal),
            (layout.texcoord_bits > 0).then_some(texcoord),
            layout.has_colors.then_some(color),
            layout.morphs.iter().any(|m| m.has_normals).then_some(turn),
        );
        if !seen.insert((point, own)) {
            continue;
        }
        out.wedge_points.push(point);
        out.normals.extend(own.0);
        out.texcoords.extend(own.1);
        out.colors.extend(own.2);
        for (turns, morph) in out.morph_normals.iter_mut().zip(&layout.morphs) {
            turns.extend(morph.has_normals.then_some(turn));
        }
    }
}

/// A mesh of random faces and random values, distinct where required.
fn random_mesh(layout: &Layout, seed: &[u32], faces: &[[u32; 3]]) -> QuantisedMesh {
    let mut draw = Draw { seed, drawn: 0 };
    let mut out = QuantisedMesh {
        morphs: vec![Vec::new(); layout.morphs.len()],
        morph_normals: vec![Vec::new(); layout.morphs.len()],
        ..QuantisedMesh::default()
    };
    add_points(&mut out, layout, &mut draw);
    add_wedges(&mut out, layout, &mut draw);
    let mut seen = BTreeSet::new();
    for face in faces {
        let mut face = face.map(|w| w % out.wedge_points.len() as u32);
        let [a, b, c] = face.map(|w| out.wedge_points[w as usize]);
        let least = (0..3).min_by_key(|i| face[*i]).unwrap();
        face.rotate_left(least);
        if a != b && b != c && c != a && seen.insert(face) {
            out.faces.push(face);
        }
    }
    discovered(&out)
}

/// Number of points and wedges that the first faces use: a possible coarser level.
fn named(mesh: &QuantisedMesh, faces: usize) -> (usize, usize) {
    let wedges = mesh.faces[..faces].as_flattened();
    let wedges = wedges.iter().max().map_or(0, |w| *w as usize + 1);
    let points = mesh.wedge_points[..wedges].iter().max();
    (points.map_or(0, |p| *p as usize + 1), wedges)
}

prop_compose! {
    fn meshes()(
        layout in layouts(),
        seed in prop::collection::vec(any::<u32>(), 7..60),
        faces in prop::collection::vec(prop::array::uniform3(any::<u32>()), 0..70),
        share in 0usize..=100,
    ) -> (Layout, QuantisedMesh, (usize, usize)) {
        let mesh = random_mesh(&layout, &seed, &faces);
        let known = if share < 30 { 0 } else { mesh.faces.len() * (share - 30) / 70 };
        let known = named(&mesh, known);
        (layout, mesh, known)
    }
}

/// A curved surface of `side` * `side` quads, with all kinds of values.
fn hill(side: i32) -> (Layout, QuantisedMesh) {
    let layout = Layout {
        position_bits: 14,
        normal_bits: 10,
        texcoord_bits: 12,
        has_colors: true,
        joints: 4,
        morphs: vec![MorphLayout { has_normals: true }],
    };
    let mut mesh = QuantisedMesh {
        morphs: vec![Vec::new()],
        morph_normals: vec![Vec::new()],
        ..QuantisedMesh::default()
    };
    for y in 0..=side {
        for x in 0..=side {
            let (dx, dy) = (x - side / 2, y - side / 2);
            let height = dx * dx + dy * dy;
            mesh.positions.push([x * 40, y * 40, 3 * height]);
            let share = ((128 + dx * 4).clamp(1, 254)) as u8;
            let mut skin = vec![(1, share), (2, 255 - share)];
            skin.sort_by_key(|i| (std::cmp::Reverse(i.1), i.0));
            mesh.skins.push(skin);
            mesh.morphs[0].push(if dx > 4 { [0, dx * 2, -dy] } else { [0; 3] });
            mesh.wedge_points.push(mesh.wedge_points.len() as u32);
            let normal = [-240 * dx, -240 * dy, 1600];
            mesh.normals.push(geometry::on_octahedron(normal, 10));
            mesh.texcoords.push([x * 50, y * 50]);
            mesh.colors.push([(x * 3) as u8, (y * 3) as u8, 7, 255]);
            mesh.morph_normals[0].push(if dx > 4 { [dx, 0, 0] } else { [0; 3] });
        }
    }
    for y in 0..side {
        for x in 0..side {
            let at = |x: i32, y: i32| (y * (side + 1) + x) as u32;
            mesh.faces.push([at(x, y), at(x + 1, y), at(x + 1, y + 1)]);
            mesh.faces.push([at(x, y), at(x + 1, y + 1), at(x, y + 1)]);
        }
    }
    (layout, discovered(&mesh))
}

#[test]
fn a_smooth_surface_costs_little() {
    let (layout, mesh) = hill(40);
    mesh.check(&layout).unwrap();
    let bytes = encoded(&mesh, &layout, (0, 0));
    // Affine and quadratic values need less than a tenth of their raw bits. A wedge has 20 raw bits
    // of normal, 24 of texture coordinates, 32 of colour, 8 and 2 of skin, and those of the morph.
    assert!(
        bytes.len() * 8 < mesh.wedges() * 10,
        "{} bytes",
        bytes.len()
    );
    assert_eq!(decoded(&mesh, &layout, (0, 0), &bytes), mesh);
}

#[test]
fn a_fan_of_many_faces_takes_no_time() {
    let (layout, _) = hill(1);
    let layout = Layout {
        morphs: Vec::new(),
        ..layout
    };
    let count = 60_000u32;
    let mesh = QuantisedMesh {
        positions: (0..=count as i32)
            .map(|i| [i & 1023, i >> 10, i % 7])
            .collect(),
        skins: vec![vec![(0, 255)]; count as usize + 1],
        wedge_points: (0..=count).collect(),
        normals: vec![[5, 5]; count as usize + 1],
        texcoords: vec![[9, 9]; count as usize + 1],
        colors: vec![[1; 4]; count as usize + 1],
        faces: (1..count).map(|i| [0, i, i + 1]).collect(),
        ..QuantisedMesh::default()
    };
    let bytes = encoded(&mesh, &layout, (0, 0));
    assert_eq!(decoded(&mesh, &layout, (0, 0), &bytes), mesh);
}

proptest! {
    #[test]
    fn values_come_back((layout, mesh, known) in meshes()) {
        mesh.check(&layout).unwrap();
        let bytes = encoded(&mesh, &layout, known);
        prop_assert_eq!(decoded(&mesh, &layout, known, &bytes), mesh);
    }

    #[test]
    fn broken_bytes_make_a_valid_mesh(
        (layout, mesh, known) in meshes(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        noise in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let mut bytes = encoded(&mesh, &layout, known);
        for (at, byte) in changes.iter().filter(|_| !mesh.faces.is_empty() && !noise.is_empty()) {
            if !bytes.is_empty() {
                let at = at.index(bytes.len());
                bytes[at] ^= byte;
            }
        }
        let short = bytes[..cut.index(bytes.len() + 1)].to_vec();
        for bytes in [bytes, short, noise] {
            let got = decoded(&mesh, &layout, known, &bytes);
            // Two wedges or points may be equal; every other fault is an error.
            if let Err(error) = got.check(&layout) {
                prop_assert!(error.what.contains("the values of another"), "{}", error);
            }
        }
    }
}
