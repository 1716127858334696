//! Conditions and costs of single collapses, on surfaces small enough to judge by hand.

use super::super::shapes::{ball, mesh, sheet};
use super::super::test_surface::{TestSurface, charted, shaken, tangle};
use super::*;
use glam::DVec3;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn simplifier<'a>(of: &'a TestSurface, options: &SimplifyOptions) -> Simplifier<'a> {
    Simplifier::new(&of.mesh, &of.poses, options, &of.classes, &of.sources)
}

/// All pairs of neighbours.
fn pairs(surface: &Surface) -> BTreeSet<(u32, u32)> {
    let edges = |[a, b, c]: &[u32; 3]| [(*a, *b), (*b, *c), (*c, *a), (*b, *a), (*c, *b), (*a, *c)];
    surface.faces.iter().flat_map(edges).collect()
}

/// The link condition by its definition, over all faces.
fn links_stay(faces: &[[u32; 3]], from: u32, to: u32) -> bool {
    let near = |class: u32| -> BTreeSet<u32> {
        let around = faces.iter().filter(|f| f.contains(&class)).flatten();
        around.copied().filter(|c| *c != class).collect()
    };
    let removed = faces
        .iter()
        .filter(|f| f.contains(&from) && f.contains(&to));
    let opposite: BTreeSet<u32> = removed.flatten().copied().collect();
    let moved = |f: &[u32; 3]| -> BTreeSet<u32> {
        f.iter().map(|c| if *c == from { to } else { *c }).collect()
    };
    let stay = |f: &&[u32; 3]| f.contains(&from) && !f.contains(&to);
    let known: BTreeSet<BTreeSet<u32>> =
        faces.iter().map(|f| f.iter().copied().collect()).collect();
    near(from)
        .intersection(&near(to))
        .all(|c| opposite.contains(c))
        && faces
            .iter()
            .filter(stay)
            .all(|f| !known.contains(&moved(f)))
}

fn assert_links(triangles: Vec<[u32; 3]>) {
    let positions = (0..9)
        .map(|i| Vec3::new(i as f32, (i * i % 7) as f32, 0.0))
        .collect();
    let of = TestSurface::new(mesh(positions, triangles), &[]);
    let mut simplifier = simplifier(&of, &SimplifyOptions::default());
    for (from, to) in pairs(&of.surface) {
        simplifier.ring.look(&of.surface, from);
        let expected = links_stay(&of.surface.faces, from, to);
        assert_eq!(simplifier.keeps_links(to), expected, "{from} to {to}");
    }
}

proptest! {
    #[test]
    fn links_of_tangles_are_judged_by_the_definition((_, triangles) in tangle()) {
        assert_links(triangles);
    }
}

#[test]
fn a_tube_is_not_closed_across() {
    // Three rings of three vertices.
    let quad = |i: u32| {
        let (ring, a) = (i / 3 * 3, i % 3);
        let (p, q) = (ring + a, ring + (a + 1) % 3);
        [[p, q, q + 3], [p, q + 3, p + 3]]
    };
    let tube: Vec<[u32; 3]> = (0..6).flat_map(quad).collect();
    assert!(!links_stay(&tube, 3, 4) && links_stay(&tube, 3, 6));
    assert_links(tube);
}

#[test]
fn no_inner_edge_joins_two_vertices_of_a_mirrored_border() {
    let of = TestSurface::new(sheet(4), &[]);
    let options = SimplifyOptions {
        mirrored: true,
        ..SimplifyOptions::default()
    };
    let mut mirrored = simplifier(&of, &options);
    let on_border = |v: u32| [v % 5, v / 5].iter().any(|k| [0, 4].contains(k));
    assert!((0..25).all(|v| mirrored.rim[v as usize] == on_border(v)));
    let all = pairs(&of.surface);
    let mut refused = 0;
    for (from, to) in &all {
        mirrored.ring.look(&of.surface, *from);
        mirrored.keeps_links(*to);
        let new_edge = |n: u32| n != *to && all.contains(&(*from, n)) && !all.contains(&(*to, n));
        let joins = |n: u32| on_border(n) && new_edge(n);
        let expected = !on_border(*to) || on_border(*from) || !(0..25).any(joins);
        assert_eq!(mirrored.keeps_rim(*from, *to), expected, "{from} to {to}");
        refused += u32::from(!expected);
    }
    assert!(refused > 0);
    let plain = simplifier(&of, &SimplifyOptions::default());
    assert!(all.iter().all(|(from, to)| plain.keeps_rim(*from, *to)));
}

/// Largest angle in degrees by which a face that stays turns in any pose; 180 if one vanishes.
fn turn(of: &TestSurface, from: u32, to: u32) -> f64 {
    let stay = of
        .surface
        .faces
        .iter()
        .filter(|f| f.contains(&from) && !f.contains(&to));
    let mut most = 0.0f64;
    for face in stay {
        for pose in &of.poses {
            let at = |c: u32| pose[of.classes.first[c as usize] as usize].as_dvec3();
            let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            let before = normal(face.map(at));
            let after = normal(face.map(|c| at(if c == from { to } else { c })));
            let angle = before.normalize().dot(after.normalize_or_zero()).acos();
            most = most.max(if after == DVec3::ZERO {
                180.0
            } else {
                angle.to_degrees()
            });
        }
    }
    most
}

#[test]
fn no_face_turns_by_more_than_80_degrees_in_any_pose() {
    let mut uneven = ball(6);
    uneven.positions = shaken(&uneven.positions, 0.15);
    let pose = shaken(&uneven.positions, 0.3);
    let other = pose
        .iter()
        .map(|p| Vec3::new(p.z, p.x, p.y) * 2.0)
        .collect();
    // One of the faces has no area.
    let mut bent = sheet(3);
    bent.positions[5] = Vec3::Z * 1.5;
    for of in [
        TestSurface::new(uneven, &[other]),
        TestSurface::new(bent, &[]),
    ] {
        let mut simplifier = simplifier(&of, &SimplifyOptions::default());
        let mut counts = [0, 0];
        for (from, to) in pairs(&of.surface) {
            simplifier.ring.look(&of.surface, from);
            let angle = turn(&of, from, to);
            assert!((angle - 80.0).abs() > 1e-3, "too near to judge");
            let turns_over = simplifier.turns_over(from, to);
            assert_eq!(turns_over, angle > 80.0, "{from} to {to}: {angle}");
            counts[usize::from(turns_over)] += 1;
        }
        assert!(counts.iter().all(|n| *n > 8), "{counts:?}");
    }
}

/// A vertex with `count` faces, and two more rings of faces around it, in a plane.
fn wheel(count: u32) -> Mesh {
    let mut positions = vec![Vec3::ZERO];
    for (radius, shift) in [(1.0, 0.0), (2.0, 0.5)] {
        let angle = |i: u32| (i as f32 + shift) * std::f32::consts::TAU / count as f32;
        let point = |i| Vec3::new(angle(i).sin(), 0.0, angle(i).cos()) * radius;
        positions.extend((0..count).map(point));
    }
    let ring = |i: u32| {
        let next = (i + 1) % count;
        let [a, b, c, d] = [1 + i, 1 + next, 1 + count + i, 1 + count + next];
        [[0, a, b], [a, c, b], [b, c, d]]
    };
    mesh(positions, (0..count).flat_map(ring).collect())
}

#[test]
fn a_vertex_gets_no_more_than_forty_faces() {
    for (count, allowed) in [(20, true), (39, true), (40, false), (300, false)] {
        let of = TestSurface::new(wheel(count), &[]);
        let mut simplifier = simplifier(&of, &SimplifyOptions::default());
        // Five faces around vertex 1, two of them among the 39 that are there: 40 stay.
        assert_eq!(of.surface.valence(1), 5);
        assert_eq!(simplifier.is_allowed(1, 0), allowed, "{count}");
    }
}

#[test]
fn only_neighbours_are_targets() {
    let of = TestSurface::new(sheet(4), &[]);
    let mut simplifier = simplifier(&of, &SimplifyOptions::default());
    assert!(simplifier.is_allowed(12, 11));
    assert!(!simplifier.is_allowed(12, 10));
    assert!(
        !simplifier.is_allowed(2, 7),
        "from the border to the inside"
    );
    assert!(simplifier.is_allowed(2, 3), "along the border");
}

#[test]
fn places_of_several_regions_lie_between() {
    let mesh = charted(2, 1.0);
    let of = TestSurface::new(mesh, &[]);
    let with = |regions: Vec<u8>| {
        let options = SimplifyOptions {
            regions,
            ..SimplifyOptions::default()
        };
        super::regions(&options, &of.classes)
    };
    assert!(with(Vec::new()).is_empty());
    assert!(with(vec![3; 18]).is_empty());
    // Vertex 13 is at the place of vertex 4, all other copies have the region of their place.
    let mut regions: Vec<u8> = [1, 2, 3].repeat(6);
    regions[13] = 9;
    let expected = [1, 2, 3, 1, BETWEEN, 3, 1, 2, 3];
    assert_eq!(with(regions), expected);
}

#[test]
fn vertices_beside_another_region_wait_for_open_seams() {
    let of = TestSurface::new(sheet(4), &[]);
    let options = SimplifyOptions {
        regions: (0..25).map(|v| u8::from(v % 5 > 1)).collect(),
        ..SimplifyOptions::default()
    };
    let mut simplifier = simplifier(&of, &options);
    // Faces with vertices of both regions lie between the columns 1 and 2.
    let inside = |v: u32| ![1, 2].contains(&(v % 5));
    assert!((0..25).all(|v| simplifier.within_region(v) == inside(v)));
    simplifier.open_seams(false);
    assert!(!simplifier.within_region(6));
    simplifier.open_seams(true);
    assert!((0..25).all(|v| simplifier.within_region(v)));
}

#[test]
fn a_component_between_regions_vanishes_once_seams_are_open() {
    let mut pieces = sheet(4);
    for x in [10.0, 20.0] {
        let first = pieces.positions.len() as u32;
        let small = [
            Vec3::ZERO,
            Vec3::Z * 0.1,
            Vec3::X * 0.1,
            Vec3::new(0.1, 0.0, 0.1),
        ];
        pieces.positions.extend(small.map(|p| p + Vec3::X * x));
        let two = [[0, 1, 2], [2, 1, 3]].map(|t: [u32; 3]| t.map(|v| v + first));
        pieces.triangles.extend(two);
    }
    let of = TestSurface::new(mesh(pieces.positions, pieces.triangles), &[]);
    let mut regions = vec![0; 33];
    // The second piece is in one region, the third in two.
    regions[25..29].fill(1);
    regions[32] = 1;
    let options = SimplifyOptions {
        regions,
        ..SimplifyOptions::default()
    };
    let mut split = simplifier(&of, &options);
    split.vanish(2);
    assert_eq!(split.surface.live, 36);
    split.vanish(1);
    assert_eq!(split.surface.live, 34);
    assert!(!split.surface.is_alive(32) && split.surface.is_alive(34));
    split.open_seams(true);
    split.vanish(2);
    assert_eq!(split.surface.live, 32);
    let mut whole = simplifier(&of, &SimplifyOptions::default());
    whole.vanish(2);
    assert_eq!(whole.surface.live, 34);
}

#[test]
fn changes_of_attributes_cost_by_the_area_that_shows_them() {
    let mut mesh = charted(2, 1.0);
    mesh.normals.fill(Vec3::Y);
    for p in mesh.positions.iter_mut().filter(|p| p.x > 1.0) {
        p.x = 4.0;
    }
    let of = TestSurface::new(mesh.clone(), std::slice::from_ref(&mesh.positions));
    let options = SimplifyOptions {
        vertex_weights: vec![3.0; 18],
        ..SimplifyOptions::default()
    };
    let mut simplifier = simplifier(&of, &options);
    assert!(simplifier.is_allowed(4, 1));
    assert_eq!(simplifier.change_cost(4, 1), 0.0);
    assert!(simplifier.is_allowed(4, 3));
    // Three faces of 1.5 m² beyond the seam get texture coordinates that are off by 0.25 and 0.5,
    // a third of it for one corner of three. The extent is 4 m, the area around the vertex
    // 3 * 0.5 + 3 * 1.5 m², and the mean (4 * 0.5 + 4 * 1.5) * 3 / 9 m².
    let change = 2500.0 * (0.25f64.powi(2) + 0.5f64.powi(2));
    let sum = 3.0 * 1.5 * change * (4.0f64 * 0.01).powi(2) / 3.0;
    let expected = 3.0 * sum / (6.0f64 * 8.0 / 3.0).sqrt();
    let found = simplifier.change_cost(4, 3);
    assert!(
        (found - expected).abs() < 1e-6 * expected,
        "{found}, {expected}"
    );
}

#[test]
fn collapses_of_a_vertex_come_one_after_the_other_by_cost() {
    let mut hills = sheet(3);
    hills.positions = shaken(&hills.positions, 0.3);
    let of = TestSurface::new(hills, &[]);
    let mut simplifier = simplifier(&of, &SimplifyOptions::default());
    let all = pairs(&of.surface);
    for from in 0..16 {
        let mut expected: Vec<(u64, u32)> = all
            .iter()
            .filter(|(a, _)| *a == from)
            .map(|(_, to)| (simplifier.costs.of_move(from, *to).to_bits(), *to))
            .collect();
        expected.sort_unstable();
        let mut found = Vec::new();
        loop {
            simplifier.queue.clear();
            simplifier.push_next(from, found.last().copied());
            let Some(Reverse((bits, vertex, to, version, priced))) = simplifier.queue.pop() else {
                break;
            };
            assert_eq!((vertex, version, priced), (from, 1, false));
            found.push((bits, to));
        }
        assert_eq!(found, expected);
    }
}

#[test]
fn the_cheapest_vertex_goes_first() {
    for heights in [[0.2, 0.4], [0.4, 0.2]] {
        let mut hills = sheet(6);
        let free = [16u32, 32];
        for (v, height) in free.iter().zip(heights) {
            hills.positions[*v as usize].y = height;
        }
        let of = TestSurface::new(hills, &[]);
        let options = SimplifyOptions {
            locked: (0..49).filter(|v| !free.contains(v)).collect(),
            ..SimplifyOptions::default()
        };
        let mut simplifier = simplifier(&of, &options);
        let sources = Sources::default();
        let mut no_notes = Notes::new(&sources, std::iter::empty());
        simplifier.run(70, &mut no_notes);
        let lower = usize::from(heights[1] < heights[0]);
        assert_eq!(simplifier.surface.live, 70);
        assert_eq!(simplifier.surface.valence(free[lower]), 0);
        assert_eq!(simplifier.surface.valence(free[1 - lower]), 6);
        simplifier.run(0, &mut no_notes);
        assert_eq!(simplifier.surface.live, 68, "all others are locked");
    }
}

/// Two sheets that share their outline, with inner vertices at other places.
fn pancake() -> Mesh {
    let above = sheet(6);
    let is_inner = |v: usize| [v % 7, v / 7].iter().all(|k| (1..6).contains(k));
    let mut positions = above.positions.clone();
    let mut below: Vec<u32> = (0..49).collect();
    for v in (0..49).filter(|v| is_inner(*v)) {
        below[v] = positions.len() as u32;
        positions.push(above.positions[v] + Vec3::new(0.3, 0.0, 0.2));
    }
    let mut triangles = above.triangles.clone();
    let turned = |[a, b, c]: &[u32; 3]| [*a, *c, *b].map(|v| below[v as usize]);
    triangles.extend(above.triangles.iter().map(turned));
    mesh(positions, triangles)
}

#[test]
fn the_outline_of_a_flat_body_costs_the_distance_of_what_is_removed() {
    // All planes are one, so that quadrics alone do not tell the outline from the rest.
    let of = TestSurface::new(pancake(), &[]);
    for (measured, keeps) in [(true, true), (false, false)] {
        let options = SimplifyOptions {
            measured,
            ..SimplifyOptions::default()
        };
        let mut simplifier = simplifier(&of, &options);
        let sources = Sources::default();
        simplifier.run(20, &mut Notes::new(&sources, std::iter::empty()));
        assert!(simplifier.surface.live <= 20);
        let stays = [0, 6, 42, 48].map(|v| simplifier.surface.valence(v) > 0);
        assert_eq!(stays == [true; 4], keeps, "{stays:?}");
    }
}
