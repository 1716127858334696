//! Round trips of levels: equal by value in any order; altered bytes are errors.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Positions and texture coordinates; enough for points, wedges and seams.
fn layout() -> Layout {
    Layout {
        position_bits: 10,
        texcoord_bits: 6,
        ..Layout::default()
    }
}

/// A mesh of faces; each corner is a position and a texture coordinate.
fn mesh_of(faces: &[[([i32; 3], [i32; 2]); 3]]) -> QuantisedMesh {
    let corners = || faces.iter().flatten();
    let points: BTreeSet<[i32; 3]> = corners().map(|c| c.0).collect();
    let points: Vec<[i32; 3]> = points.into_iter().collect();
    let wedges: BTreeSet<([i32; 3], [i32; 2])> = corners().copied().collect();
    let wedges: Vec<([i32; 3], [i32; 2])> = wedges.into_iter().collect();
    let wedge = |c: &([i32; 3], [i32; 2])| wedges.binary_search(c).unwrap() as u32;
    let mut seen = BTreeSet::new();
    let is_face =
        |f: &&[([i32; 3], [i32; 2]); 3]| f[0].0 != f[1].0 && f[1].0 != f[2].0 && f[2].0 != f[0].0;
    let faces = faces.iter().filter(is_face).map(|f| {
        let [a, b, c] = f.each_ref().map(wedge);
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    });
    let faces: Vec<[u32; 3]> = faces.filter(|f| seen.insert(*f)).collect();
    let point = |w: &([i32; 3], [i32; 2])| points.binary_search(&w.0).unwrap() as u32;
    QuantisedMesh {
        wedge_points: wedges.iter().map(point).collect(),
        texcoords: wedges.iter().map(|w| w.1).collect(),
        positions: points,
        faces,
        ..QuantisedMesh::default()
    }
}

/// The faces by value, each from its lowest corner on.
fn soup(mesh: &QuantisedMesh) -> BTreeSet<[([i32; 3], [i32; 2]); 3]> {
    let corner = |w: u32| {
        let w = w as usize;
        (
            mesh.positions[mesh.wedge_points[w] as usize],
            mesh.texcoords[w],
        )
    };
    let turned = |f: [u32; 3]| {
        let [a, b, c] = f.map(corner);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
    };
    mesh.faces.iter().map(|&f| turned(f)).collect()
}

/// The same mesh with its points, wedges and faces in another order.
fn shuffled(mesh: &QuantisedMesh, seed: u64) -> QuantisedMesh {
    let order = |count: usize, salt: u64| -> Vec<u32> {
        let mut ids: Vec<u32> = (0..count as u32).collect();
        ids.sort_by_key(|&i| (u64::from(i) + 1).wrapping_mul(seed | 1).wrapping_mul(salt) >> 7);
        ids
    };
    let points = order(mesh.points(), 0x9e37_79b9_7f4a_7c15);
    let wedges = order(mesh.wedges(), 0xc2b2_ae3d_27d4_eb4f);
    let place = |list: &[u32], id: u32| list.iter().position(|&x| x == id).unwrap() as u32;
    let mut other = mesh.picked(&points, &wedges);
    for p in &mut other.wedge_points {
        *p = place(&points, *p);
    }
    for f in order(mesh.faces.len(), 0x1656_67b1_9e37_79f9) {
        let [a, b, c] = mesh.faces[f as usize].map(|w| place(&wedges, w));
        other.faces.push([b, c, a]);
    }
    other
}

fn check_chain(coarse: &QuantisedMesh, fine: &QuantisedMesh) {
    let (layout, limits) = (layout(), StreamLimits::default());
    let alone = encode_level(None, fine, &layout).unwrap();
    assert_eq!(
        soup(&decode_level(None, &alone, &layout, &limits).unwrap()),
        soup(fine)
    );
    assert_eq!(
        encode_level(None, &shuffled(fine, 7), &layout).unwrap(),
        alone
    );

    let bytes = encode_level(Some(coarse), fine, &layout).unwrap();
    let found = decode_level(Some(coarse), &bytes, &layout, &limits).unwrap();
    assert_eq!(soup(&found), soup(fine));
    assert_eq!(found.positions[..coarse.points()], coarse.positions);
    assert_eq!(found.wedge_points[..coarse.wedges()], coarse.wedge_points);
    assert_eq!(found.texcoords[..coarse.wedges()], coarse.texcoords);
    let other = shuffled(coarse, 99);
    assert_eq!(
        encode_level(Some(&other), &shuffled(fine, 5), &layout).unwrap(),
        bytes
    );
    let found = decode_level(Some(&other), &bytes, &layout, &limits).unwrap();
    assert_eq!(soup(&found), soup(fine));
}

/// A torus of `n` by `m` quads, or a part of it that leaves a border.
fn grid(n: i32, m: i32, is_closed: [bool; 2], seam: i32) -> Vec<[([i32; 3], [i32; 2]); 3]> {
    let turns =
        |i: i32, count: i32| f64::from(i % count) / f64::from(count) * std::f64::consts::TAU;
    let corner = |i: i32, j: i32| {
        let (u, v) = (turns(i, n), turns(j, m));
        let radius = 300.0 + 120.0 * v.cos();
        let at = [radius * u.cos(), radius * u.sin(), 120.0 * v.sin()];
        let uv = [
            if i * 2 < n { 1 } else { 2 + seam },
            if j == m { 9 } else { 0 },
        ];
        (at.map(|x| x.round() as i32 + 500), uv)
    };
    let mut faces = Vec::new();
    for i in 0..n - i32::from(!is_closed[0]) {
        for j in 0..m - i32::from(!is_closed[1]) {
            let q = [
                corner(i, j),
                corner(i + 1, j),
                corner(i + 1, j + 1),
                corner(i, j + 1),
            ];
            faces.push([q[0], q[1], q[2]]);
            faces.push([q[0], q[2], q[3]]);
        }
    }
    faces
}

/// A coarser mesh: corners of faces are moved onto others, as collapses do.
fn coarser(fine: &QuantisedMesh, seed: u64) -> QuantisedMesh {
    let corner = |w: u32| {
        let w = w as usize;
        (mesh_position(fine, w), fine.texcoords[w])
    };
    let mut onto: Vec<usize> = (0..fine.points()).collect();
    for (f, face) in fine.faces.iter().enumerate() {
        let [a, b, _] = face.map(|w| fine.wedge_points[w as usize] as usize);
        let is_picked = (f as u64 + 1).wrapping_mul(seed | 1) >> 3 & 3 == 0;
        let is_goal = onto.iter().enumerate().any(|(i, &o)| o == a && i != a);
        if is_picked && onto[a] == a && onto[b] == b && !is_goal {
            onto[a] = b;
        }
    }
    let moved = |w: u32| {
        let point = fine.wedge_points[w as usize] as usize;
        let to = onto[point];
        if to == point {
            return corner(w);
        }
        let wedge = fine
            .wedge_points
            .iter()
            .position(|&p| p as usize == to)
            .unwrap();
        corner(wedge as u32)
    };
    let faces: Vec<[([i32; 3], [i32; 2]); 3]> = fine.faces.iter().map(|f| f.map(moved)).collect();
    let faces: Vec<_> = faces
        .into_iter()
        .filter(|f| f[0].0 != f[1].0 && f[1].0 != f[2].0 && f[2].0 != f[0].0)
        .collect();
    mesh_of(&faces)
}

fn mesh_position(mesh: &QuantisedMesh, wedge: usize) -> [i32; 3] {
    mesh.positions[mesh.wedge_points[wedge] as usize]
}

#[test]
fn nothing_comes_back_as_nothing() {
    let none = QuantisedMesh::empty(&layout());
    check_chain(&none, &none);
    assert!(encode_level(None, &none, &layout()).unwrap().len() <= 4);
}

#[test]
fn surfaces_with_handles_holes_and_seams_come_back() {
    for closed in [[true, true], [true, false], [false, true], [false, false]] {
        for seam in [-1, 0] {
            let fine = mesh_of(&grid(17, 11, closed, seam));
            let coarse = coarser(&fine, 0x5851_f42d_4c95_7f2d);
            assert!(coarse.faces.len() * 10 < fine.faces.len() * 9);
            check_chain(&coarse, &fine);
        }
    }
}

#[test]
fn a_regular_torus_costs_little() {
    let fine = mesh_of(&grid(60, 30, [true, true], -1));
    let nothing = QuantisedMesh::default();
    let coarse = Coarse::new(&nothing);
    let faces: Vec<[u32; 3]> = fine.point_faces().collect();
    let matches = vec![NONE; fine.points()];
    let mut truth = Truth::new(&faces, &matches, 0);
    let mut encoder = Encoder::new();
    connectivity::walk(&mut encoder, &coarse, Some(&mut truth), faces.len()).unwrap();
    let bytes = encoder.finish().len();
    // All valences are 6, so only the handle and the learning of the models cost bits.
    assert!(
        bytes * 8 < faces.len() / 4,
        "{bytes} bytes, {} faces",
        faces.len()
    );
}

fn any_soup() -> impl Strategy<Value = QuantisedMesh> {
    let corner = (0i32..5, 0i32..3, 0i32..2, 0i32..2)
        .prop_map(|(x, y, z, u)| ([x * 90, y * 70, z * 50], [u, 0]));
    prop::collection::vec([corner.clone(), corner.clone(), corner], 0..60).prop_map(|faces| {
        let faces: Vec<_> = faces
            .into_iter()
            .filter(|f| f[0].0 != f[1].0 && f[1].0 != f[2].0 && f[2].0 != f[0].0)
            .collect();
        mesh_of(&faces)
    })
}

fn any_surface() -> impl Strategy<Value = QuantisedMesh> {
    let sizes = (3i32..12, 3i32..12, any::<[bool; 2]>(), -1i32..1);
    (sizes, any::<u64>(), 0u64..4).prop_map(|((n, m, closed, seam), seed, drop)| {
        let faces = grid(n, m, closed, seam).into_iter().enumerate();
        let is_kept = |f: usize| (f as u64 + 1).wrapping_mul(seed | 1) >> 5 & 15 >= drop;
        let faces: Vec<_> = faces.filter(|(f, _)| is_kept(*f)).map(|f| f.1).collect();
        mesh_of(&faces)
    })
}

/// A level may drop a wedge that a finer one has again; it keeps its id.
#[test]
fn what_comes_back_keeps_its_id() {
    let (layout, limits) = (layout(), StreamLimits::default());
    let first = mesh_of(&grid(6, 5, [true, true], 0));
    let second = QuantisedMesh {
        faces: first.faces[..20].to_vec(),
        ..first.clone()
    };
    let bytes = encode_level(Some(&first), &second, &layout).unwrap();
    let kept = decode_level(Some(&first), &bytes, &layout, &limits).unwrap();
    assert_eq!(kept.wedge_points, first.wedge_points);
    assert_eq!(soup(&kept), soup(&second));
    let bytes = encode_level(Some(&second), &first, &layout).unwrap();
    let found = decode_level(Some(&kept), &bytes, &layout, &limits).unwrap();
    assert_eq!(found.positions, first.positions);
    assert_eq!(found.texcoords, first.texcoords);
    assert_eq!(soup(&found), soup(&first));
}

proptest! {
    #[test]
    fn any_faces_come_back(fine in any_soup(), seed: u64) {
        check_chain(&coarser(&fine, seed), &fine);
    }

    #[test]
    fn surfaces_come_back(fine in any_surface(), seed: u64) {
        let coarse = coarser(&fine, seed);
        check_chain(&coarser(&coarse, seed >> 1), &coarse);
        check_chain(&coarse, &fine);
    }

    /// Unrelated levels.
    #[test]
    fn strangers_come_back(coarse in any_soup(), fine in any_soup()) {
        check_chain(&coarse, &fine);
    }

    #[test]
    fn damage_is_refused_or_harmless(
        fine in any_surface(),
        seed: u64,
        at: prop::sample::Index,
        flip in 1u8..=255,
    ) {
        let (layout, limits) = (layout(), StreamLimits::default());
        let coarse = coarser(&fine, seed);
        let bytes = encode_level(Some(&coarse), &fine, &layout).unwrap();
        let cut = at.index(bytes.len().max(1));
        if let Ok(found) = decode_level(Some(&coarse), &bytes[..cut.min(bytes.len())], &layout, &limits) {
            found.check(&layout).unwrap();
        }
        let mut altered = bytes.clone();
        if let Some(byte) = altered.get_mut(cut) {
            *byte ^= flip;
        }
        if let Ok(found) = decode_level(Some(&coarse), &altered, &layout, &limits) {
            found.check(&layout).unwrap();
        }
    }

    #[test]
    fn any_bytes_are_harmless(bytes in prop::collection::vec(any::<u8>(), 0..200), coarse in any_soup()) {
        let limits = StreamLimits { elements: 20_000, ..StreamLimits::default() };
        if let Ok(found) = decode_level(Some(&coarse), &bytes, &layout(), &limits) {
            found.check(&layout()).unwrap();
        }
    }
}

#[test]
fn the_limit_counts_every_value() {
    use super::super::mesh::MorphLayout;
    let check = |layout: &Layout, elements| check_size(layout, &Bounds { elements }, 5, 7).is_ok();
    // Points of 3 coordinates, wedges of 8 numbers.
    let plain = Layout::default();
    assert!(check(&plain, 5 * 3 + 7 * 8));
    assert!(!check(&plain, 5 * 3 + 7 * 8 - 1));
    // A skin is 8 numbers per point, each of two targets 3 per point and 3 per wedge.
    let full = Layout {
        joints: 1,
        morphs: vec![
            MorphLayout { has_normals: true },
            MorphLayout { has_normals: false },
        ],
        ..Layout::default()
    };
    assert!(check(&full, 5 * (3 + 8 + 6) + 7 * (8 + 6)));
    assert!(!check(&full, 5 * (3 + 8 + 6) + 7 * (8 + 6) - 1));
}

#[test]
fn the_limit_counts_every_face() {
    // A torus has half as many points as faces, so that the faces need more memory than the values.
    let mesh = mesh_of(&grid(5, 4, [true, true], 0));
    let bytes = encode_level(None, &mesh, &layout()).unwrap();
    let is_read = |elements| {
        let limits = StreamLimits {
            elements,
            ..StreamLimits::default()
        };
        decode_level(None, &bytes, &layout(), &limits).is_ok()
    };
    let elements = mesh.faces.len() as u64 * FACE_ELEMENTS;
    assert!(is_read(elements));
    assert!(!is_read(elements - 1));
}
