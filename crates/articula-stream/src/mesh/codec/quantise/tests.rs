//! Quantisation computed by hand, and its error bounds.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// A unit square of two triangles; the second has its own wedges along the diagonal.
fn square() -> Primitive {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let at = |[x, y]: [f32; 2]| Vec3::new(x, y, 0.0);
    let order = [0, 1, 2, 0, 2, 3];
    Primitive {
        positions: order.iter().map(|i| at(corners[*i])).collect(),
        normals: vec![Vec3::Z; 6],
        texcoords: vec![
            Vec2::ZERO,
            Vec2::X,
            Vec2::ONE,
            Vec2::ZERO,
            Vec2::new(0.25, 0.25),
            Vec2::Y,
        ],
        influences: 1,
        joints: vec![0; 6],
        weights: vec![1.0; 6],
        ..Primitive::default()
    }
}

fn quantised(part: &Primitive, levels: &[Vec<[u32; 3]>]) -> Quantised {
    let precision = Precision::default();
    let grid = Grid::new(std::slice::from_ref(part), precision.position_bits).unwrap();
    let out = quantise(part, levels, &grid, &precision).unwrap();
    for level in &out.levels {
        level.check(&out.layout).unwrap();
    }
    out
}

#[test]
fn equal_vertices_become_one() {
    let out = quantised(&square(), &[vec![[0, 1, 2], [3, 4, 5]]]);
    let mesh = &out.levels[0];
    assert_eq!(mesh.points(), 4);
    // Vertex 3 equals vertex 0; vertex 4 has another texture coordinate than vertex 2.
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 3, 4]]);
    assert_eq!(mesh.wedge_points, [0, 1, 2, 2, 3]);
    let last = (1 << 14) - 1;
    assert_eq!(mesh.positions[2], [last, last, 0]);
    // round(4095 / 4) = 1024.
    assert_eq!(mesh.texcoords[3], [1024, 1024]);
    assert_eq!(mesh.skins[3], [(0, 255)]);
    assert_eq!(out.layout.joints, 1);
}

#[test]
fn faces_that_rounding_takes_are_counted() {
    let mut part = square();
    // Less than half a step of 1/16383 from vertex 1.
    part.positions.push(Vec3::new(1.0, 2e-5, 0.0));
    part.normals.push(Vec3::Z);
    part.texcoords.push(Vec2::X);
    part.joints.push(0);
    part.weights.push(1.0);
    let fine = vec![[0, 1, 2], [1, 6, 2], [2, 0, 1], [3, 4, 5], [0, 2, 1]];
    let out = quantised(&part, &[fine]);
    assert_eq!((out.degenerate_faces, out.duplicate_faces), (1, 1));
    assert_eq!(out.levels[0].faces.len(), 3, "the other side is no copy");
}

#[test]
fn a_coarse_level_uses_what_the_fine_one_has() {
    let mut part = square();
    // A second wedge at vertex 1, whose only fine face vanishes by rounding.
    part.positions
        .extend([Vec3::X, Vec3::new(1.0, 1e-5, 0.0), Vec3::X]);
    part.normals.extend([Vec3::X; 3]);
    part.texcoords.extend([Vec2::X; 3]);
    part.joints.extend([0; 3]);
    part.weights.extend([1.0; 3]);
    let fine = vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]];
    let coarse = vec![[0, 6, 2]];
    let out = quantised(&part, &[fine.clone(), coarse]);
    let [fine_mesh, coarse] = &out.levels[..] else {
        panic!("two levels");
    };
    assert_eq!(coarse.normals, vec![fine_mesh.normals[0]; 3]);
    // A vertex that the finer level does not name is kept: levels of one region.
    let strange = quantised(&part, &[vec![[0, 1, 2]], vec![[0, 6, 2]]]);
    let normals = |level: usize| strange.levels[level].normals.clone();
    assert_eq!(normals(0)[0], normals(1)[0]);
    assert_ne!(normals(0)[1], normals(1)[1]);
}

#[test]
fn wrong_input_is_named() {
    let precision = Precision::default();
    let grid = Grid::new(&[square()], 14).unwrap();
    let error = |change: fn(&mut Primitive)| {
        let mut part = square();
        change(&mut part);
        quantise(&part, &[vec![[0, 1, 2]]], &grid, &precision)
            .unwrap_err()
            .at
    };
    assert_eq!(error(|p| p.positions[2].y = f32::NAN), "positions[2]");
    assert_eq!(error(|p| p.normals[1].x = f32::INFINITY), "normals[1]");
    assert_eq!(error(|p| p.texcoords[5].x = f32::NAN), "texcoords[5]");
    assert_eq!(error(|p| p.weights[3] = -1.0), "weights of vertex 3");
    assert_eq!(error(|p| p.joints[3] = u16::MAX), "joints");
    assert_eq!(error(|p| p.colors = vec![Vec4::ONE; 5]), "colors");
    let far = |p: &mut Primitive| {
        p.morphs.push(MorphTarget {
            positions: vec![Vec3::splat(1e6); 6],
            normals: Vec::new(),
        });
    };
    assert_eq!(error(far), "morphs[0].positions[0]");
    let outside = quantise(&square(), &[vec![[0, 1, 6]]], &grid, &precision);
    assert_eq!(outside.unwrap_err().at, "levels[0]");
    assert_eq!(Grid::new(&[square()], 21).unwrap_err().at, "position_bits");
    let empty = quantise(&Primitive::default(), &[vec![]], &grid, &precision).unwrap();
    assert_eq!(empty.levels, [QuantisedMesh::default()]);
}

#[test]
fn a_restored_mesh_by_hand() {
    let layout = Layout {
        position_bits: 4,
        normal_bits: 3,
        texcoord_bits: 4,
        has_colors: true,
        joints: 8,
        morphs: vec![
            MorphLayout { has_normals: true },
            MorphLayout { has_normals: false },
        ],
    };
    let mesh = QuantisedMesh {
        positions: vec![[0, 1, 2], [15, 0, 4]],
        skins: vec![vec![(7, 255)], vec![(3, 204), (1, 51)]],
        morphs: vec![vec![[0; 3], [2, -4, 0]], vec![[8, 0, 0], [0; 3]]],
        wedge_points: vec![1, 0, 1],
        // Three bits: steps from 0 to 6, the pole at 3.
        normals: vec![[3, 3], [6, 3], [3, 0]],
        texcoords: vec![[0, 0], [4, 8], [15, 1]],
        colors: vec![[0, 51, 255, 102], [255; 4], [0; 4]],
        morph_normals: vec![vec![[127, 0, -254], [0; 3], [0; 3]], Vec::new()],
        faces: vec![[0, 1, 2]],
    };
    let scale = Scale {
        grid: Grid {
            origin: Vec3::new(1.0, 0.0, -1.0),
            step: 0.25,
        },
        texcoord_origin: Vec2::new(0.5, -1.0),
        texcoord_step: 0.125,
    };
    let found = restore(&mesh, &layout, &scale);
    let [a, b] = [Vec3::new(4.75, 0.0, 0.0), Vec3::new(1.0, 0.25, -0.5)];
    assert_eq!(found.positions, [a, b, a]);
    assert_eq!(found.normals, [Vec3::Z, Vec3::X, Vec3::NEG_Y]);
    let texcoords = [[0.5, -1.0], [1.0, 0.0], [2.375, -0.875]];
    assert_eq!(found.texcoords, texcoords.map(Vec2::from));
    assert_eq!(found.colors[0], Vec4::new(0.0, 0.2, 1.0, 0.4));
    assert_eq!(found.colors[1..], [Vec4::ONE, Vec4::ZERO]);
    // The second influence of the other point has the weight 0.
    assert_eq!(found.influences, 2);
    assert_eq!(found.joints, [3, 1, 7, 7, 3, 1]);
    assert_eq!(found.weights, [0.8, 0.2, 1.0, 0.0, 0.8, 0.2]);
    let moved = Vec3::new(0.5, -1.0, 0.0);
    assert_eq!(found.morphs[0].positions, [moved, Vec3::ZERO, moved]);
    let turned = [Vec3::new(1.0, 0.0, -2.0), Vec3::ZERO, Vec3::ZERO];
    assert_eq!(found.morphs[0].normals, turned);
    let moved = Vec3::new(2.0, 0.0, 0.0);
    assert_eq!(found.morphs[1].positions, [Vec3::ZERO, moved, Vec3::ZERO]);
    assert!(found.morphs[1].normals.is_empty());
    assert_eq!(found.triangles, [[0, 1, 2]]);
}

/// Random vertices with every kind of value, and triangles of them.
fn parts() -> impl Strategy<Value = (Primitive, Vec<[u32; 3]>)> {
    let vertex = (
        prop::array::uniform3(-0.3f32..0.9),
        prop::array::uniform3(-1.0f32..1.0),
        prop::array::uniform4(0.0f32..1.0),
        prop::array::uniform3((0u16..5, 0.01f32..1.0)),
        prop::array::uniform3(-0.1f32..0.1),
    );
    let faces = prop::collection::vec(prop::array::uniform3(0u32..24), 0..60);
    (prop::collection::vec(vertex, 24), faces).prop_map(|(vertices, faces)| {
        let mut part = Primitive {
            influences: 3,
            morphs: vec![MorphTarget::default()],
            ..Primitive::default()
        };
        for (position, normal, color, skin, offset) in vertices {
            part.positions.push(Vec3::from(position));
            part.normals.push(Vec3::from(normal).normalize_or(Vec3::Y));
            part.colors.push(Vec4::from(color));
            part.texcoords.push(Vec2::new(color[0] * 3.0, color[3]));
            let sum: f32 = skin.iter().map(|s| s.1).sum();
            part.joints.extend(skin.map(|s| s.0));
            part.weights.extend(skin.map(|s| s.1 / sum));
            part.morphs[0].positions.push(Vec3::from(offset));
            part.morphs[0].normals.push(Vec3::from(normal) * 0.5);
        }
        (part, faces)
    })
}

/// The value of a wedge, independent of its id.
fn wedge_value(mesh: &QuantisedMesh, w: usize) -> impl Ord + use<> {
    let p = mesh.wedge_points[w] as usize;
    let morphs: Vec<_> = mesh.morphs.iter().map(|m| m[p]).collect();
    let turns: Vec<_> = mesh.morph_normals.iter().map(|m| m[w]).collect();
    let point = (mesh.positions[p], mesh.skins[p].clone(), morphs);
    let own = (mesh.normals[w], mesh.texcoords[w], mesh.colors[w], turns);
    (point, own)
}

proptest! {
    #[test]
    fn rounding_is_half_a_step((part, faces) in parts()) {
        let out = quantised(&part, std::slice::from_ref(&faces));
        let kept = out.levels[0].faces.len() + out.degenerate_faces + out.duplicate_faces;
        prop_assert_eq!(kept, faces.len());
        let back = restore(&out.levels[0], &out.layout, &out.scale);
        let (step, uv_step) = (out.scale.grid.step, out.scale.texcoord_step);
        prop_assert!(out.rounding_metres <= step * 0.5 * 3f32.sqrt() * 1.001);
        // Each restored vertex corresponds to one of the part, within half a step of each kind.
        for v in 0..back.positions.len() {
            let near = |i: &usize| {
                let within = |a: Vec3, b: Vec3, most: f32| (a - b).abs().max_element() <= most;
                let offsets = |p: &Primitive, i: usize| p.morphs[0].positions[i];
                let turns = |p: &Primitive, i: usize| p.morphs[0].normals[i];
                within(back.positions[v], part.positions[*i], step * 0.501)
                    && within(offsets(&back, v), offsets(&part, *i), step * 0.501)
                    && within(turns(&back, v), turns(&part, *i), 0.501 / 127.0)
                    && back.normals[v].distance(part.normals[*i]) < 1.7 / 511.0
                    && (back.texcoords[v] - part.texcoords[*i]).abs().max_element()
                        <= uv_step * 0.501
                    && (back.colors[v] - part.colors[*i]).abs().max_element() <= 0.501 / 255.0
            };
            prop_assert!((0..part.positions.len()).any(|i| near(&i)), "vertex {}", v);
        }
    }

    #[test]
    fn what_is_whole_stays((part, faces) in parts()) {
        let once = quantised(&part, &[faces]);
        let mesh = &once.levels[0];
        let back = restore(mesh, &once.layout, &once.scale);
        let precision = Precision::default();
        let levels = [back.triangles.clone()];
        let mut twice = quantise(&back, &levels, &once.scale.grid, &precision).unwrap();
        if twice.scale == once.scale {
            prop_assert_eq!(&twice.levels[0], mesh);
        }
        // The range of texture coordinates is that of the remaining vertices; the rest is the same.
        twice.levels[0].texcoords.clone_from(&mesh.texcoords);
        prop_assert_eq!(&twice.levels[0], mesh);
        prop_assert!(twice.rounding_metres == 0.0);
    }

    #[test]
    fn coarse_levels_are_subsets_by_value(
        (part, faces) in parts(),
        keep in prop::collection::vec(any::<prop::sample::Index>(), 0..20),
    ) {
        prop_assume!(!faces.is_empty());
        // Any faces of the vertices of the fine level.
        let corner = |i: &prop::sample::Index| *i.get(faces.as_flattened());
        let coarse: Vec<[u32; 3]> =
            keep.chunks_exact(3).map(|c| [corner(&c[0]), corner(&c[1]), corner(&c[2])]).collect();
        let precision = Precision { position_bits: 2, ..Precision::default() };
        let grid = Grid::new(std::slice::from_ref(&part), 2).unwrap();
        let out = quantise(&part, &[faces, coarse], &grid, &precision).unwrap();
        let values = |mesh: &QuantisedMesh| -> BTreeSet<_> {
            (0..mesh.wedges()).map(|w| wedge_value(mesh, w)).collect()
        };
        for level in &out.levels {
            level.check(&out.layout).unwrap();
        }
        prop_assert!(values(&out.levels[1]).is_subset(&values(&out.levels[0])));
    }

    #[test]
    fn parts_that_touch_stay_closed((part, faces) in parts(), shift in 0.0f32..3.0) {
        // A second part shares the first one's vertices and extends further.
        let mut other = part.clone();
        other.positions[0] += Vec3::X * shift;
        let grid = Grid::new(&[part.clone(), other.clone()], 14).unwrap();
        let precision = Precision::default();
        let levels = [faces.into_iter().filter(|f| !f.contains(&0)).collect::<Vec<_>>()];
        let places = [part, other].map(|p| {
            let out = quantise(&p, &levels, &grid, &precision).unwrap();
            restore(&out.levels[0], &out.layout, &out.scale).positions
        });
        prop_assert_eq!(&places[0], &places[1]);
    }
}
