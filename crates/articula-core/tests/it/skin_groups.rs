//! Grouped skinning against the plain version: equal on any mesh, no more vertices than necessary,
//! no allocation.

use articula_core::{Binding, GroupedSkin, JointSet, Matrix3x4, Mesh, Morph, SkinnedMesh, skin};
use glam::{Affine3A, Mat3, Vec3};
use proptest::prelude::*;

/// Joints of the random meshes; each has two bindings.
const JOINTS: usize = 6;
const MORPHS: usize = 3;

/// Whether glam fuses multiplication and addition in this build, which rounds once instead of
/// twice.
const FUSED: bool = cfg!(target_feature = "fma");

fn vector() -> impl Strategy<Value = Vec3> {
    [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3::from_array)
}

/// Any matrix: sheared, mirrored, sometimes singular or not finite.
fn matrix() -> impl Strategy<Value = Affine3A> {
    let any = [vector(), vector(), vector(), vector()];
    let odd = prop_oneof![
        20 => Just(None),
        1 => Just(Some(0.0f32)),
        1 => Just(Some(f32::INFINITY)),
        1 => Just(Some(f32::NAN)),
    ];
    (any, odd).prop_map(|([x, y, z, t], odd)| {
        let x = odd.map_or(x, Vec3::splat);
        Affine3A::from_mat3_translation(Mat3::from_cols(x, y, z), t)
    })
}

fn palettes() -> impl Strategy<Value = Vec<Affine3A>> {
    prop::collection::vec(matrix(), 2 * JOINTS)
}

/// A vertex: position, normal, and the maximum number of influences.
type Row = (Vec3, Vec3, Vec<(u16, f32)>);

fn row() -> impl Strategy<Value = Row> {
    // Zero weights of real meshes are mostly at the end; here they are anywhere.
    let weight = prop_oneof![Just(0.0f32), 0.0f32..1.0, -0.2f32..0.2];
    let influence = (0..2 * JOINTS as u16, weight);
    (vector(), vector(), prop::collection::vec(influence, 6))
}

fn mesh_of(rows: &[Row], influences: usize, morphs: Vec<Morph>) -> Mesh {
    let kept = || rows.iter().flat_map(|r| &r.2[..influences]);
    let binding = |b: usize| Binding {
        joint: (b % JOINTS) as u16,
        inverse_bind: Affine3A::from_translation(Vec3::X * b as f32),
    };
    Mesh {
        positions: rows.iter().map(|r| r.0).collect(),
        normals: rows.iter().map(|r| r.1.normalize_or_zero()).collect(),
        influences,
        binding_indices: kept().map(|i| i.0).collect(),
        weights: kept().map(|i| i.1).collect(),
        bindings: (0..2 * JOINTS).map(binding).collect(),
        morphs,
        morph_weights: vec![0.0; MORPHS],
        ..Mesh::default()
    }
}

fn morph() -> impl Strategy<Value = (u16, Vec<bool>, Vec3, Vec3)> {
    let chosen = prop::collection::vec(any::<bool>(), 150);
    (0..MORPHS as u16, chosen, vector(), vector())
}

fn meshes() -> impl Strategy<Value = Mesh> {
    let rows = prop::collection::vec(row(), 0..150);
    let morphs = prop::collection::vec(morph(), 0..4);
    (rows, 1usize..=6, morphs).prop_map(|(rows, influences, morphs)| {
        let morphs = morphs.into_iter().map(|(slot, chosen, dp, dn)| {
            let vertices = (0..rows.len()).filter(|v| chosen[*v]);
            let vertices: Vec<u32> = vertices.map(|v| v as u32).collect();
            Morph {
                slot,
                positions: vec![dp; vertices.len()],
                normals: vec![dn; vertices.len()],
                vertices,
            }
        });
        let morphs = morphs.collect();
        mesh_of(&rows, influences, morphs)
    })
}

fn weights() -> impl Strategy<Value = Vec<f32>> {
    let weight = prop_oneof![Just(0.0f32), Just(1.0f32), -0.5f32..1.5];
    prop::collection::vec(weight, MORPHS)
}

fn rows_of(palette: &[Affine3A]) -> Vec<Matrix3x4> {
    let mut out = vec![[[0.0; 4]; 3]; palette.len()];
    GroupedSkin::rows(palette, &mut out);
    out
}

fn plain(mesh: &Mesh, palette: &[Affine3A], weights: &[f32]) -> SkinnedMesh {
    let mut out = SkinnedMesh::new(mesh);
    skin(mesh, palette, weights, &mut out);
    out
}

/// Equal, or both NaN. Fused sums of the positions here differ by less than 1e-4 (ten roundings of
/// sums below 126); normals of singular matrices by any amount.
fn check(found: &SkinnedMesh, expected: &SkinnedMesh) -> Result<(), TestCaseError> {
    let equal = |a: Vec3, b: Vec3, within: f32| {
        let mut pairs = a.to_array().into_iter().zip(b.to_array());
        pairs.all(|(a, b)| {
            let near = FUSED && (a - b).abs() <= within;
            a == b || near || (a.is_nan() && b.is_nan())
        })
    };
    for (v, (a, b)) in found.positions.iter().zip(&expected.positions).enumerate() {
        prop_assert!(equal(*a, *b, 1e-4), "position {v}: {a} is not {b}");
    }
    for (v, (a, b)) in found.normals.iter().zip(&expected.normals).enumerate() {
        prop_assert!(equal(*a, *b, f32::INFINITY), "normal {v}: {a} is not {b}");
    }
    Ok(())
}

proptest! {
    #[test]
    fn equals_the_plain_version(
        mesh in meshes(),
        palette in palettes(),
        weights in weights(),
    ) {
        let grouped = GroupedSkin::new(&mesh);
        let (mut shape, mut stale) = (grouped.rest().clone(), grouped.stale());
        grouped.morph(&weights, &mut shape, &mut stale);
        let mut out = SkinnedMesh::new(&mesh);
        grouped.skin(&shape, &rows_of(&palette), &mut out);
        check(&out, &plain(&mesh, &palette, &weights))?;
    }

    #[test]
    fn what_moved_is_skinned_again_and_nothing_far_from_it(
        mesh in meshes(),
        (before, after) in (palettes(), palettes()),
        moves in prop::collection::vec(prop::bool::weighted(0.2), JOINTS),
        (first, then) in (weights(), weights()),
    ) {
        let moved: JointSet = (0..JOINTS).filter(|j| moves[*j]).collect();
        let now: Vec<Affine3A> = (0..before.len())
            .map(|b| if moves[b % JOINTS] { after[b] } else { before[b] })
            .collect();
        let grouped = GroupedSkin::new(&mesh);
        let (mut shape, mut stale) = (grouped.rest().clone(), grouped.stale());
        let mut out = SkinnedMesh::new(&mesh);
        grouped.morph(&first, &mut shape, &mut stale);
        let all = grouped.skin_stale(&shape, &rows_of(&before), &mut stale, &mut out);
        prop_assert_eq!(all, mesh.len(), "at first nothing is up to date");

        let found = grouped.moved(&rows_of(&before), &rows_of(&now));
        prop_assert!(moved.difference(&found).is_empty(), "two random matrices differ");
        grouped.mark_joints(&moved, &mut stale);
        grouped.morph(&then, &mut shape, &mut stale);
        // Vertices that keep this value were not written.
        let mut again = SkinnedMesh {
            positions: vec![Vec3::splat(77.0); mesh.len()],
            normals: vec![Vec3::splat(77.0); mesh.len()],
        };
        let count = grouped.skin_stale(&shape, &rows_of(&now), &mut stale.clone(), &mut again);
        let written = again.positions.iter().filter(|p| **p != Vec3::splat(77.0)).count();
        prop_assert_eq!(written, count);
        grouped.skin_stale(&shape, &rows_of(&now), &mut stale, &mut out);
        check(&out, &plain(&mesh, &now, &then))?;
        prop_assert_eq!(
            grouped.skin_stale(&shape, &rows_of(&now), &mut stale, &mut out),
            0,
            "now all is up to date"
        );
    }
}

/// A strip of vertices, `each` of them for every joint in turn.
fn strip(each: usize) -> Mesh {
    let row = |v: usize| {
        let joint = (v / each) as u16;
        let influences = (0..6).map(|i| (joint, if i == 0 { 1.0 } else { 0.0 }));
        (Vec3::X * v as f32, Vec3::Y, influences.collect())
    };
    let rows: Vec<Row> = (0..each * JOINTS).map(row).collect();
    mesh_of(&rows, 4, Vec::new())
}

#[test]
fn one_joint_of_six_moves_its_own_blocks() {
    let mesh = strip(32);
    let grouped = GroupedSkin::new(&mesh);
    let mut stale = grouped.stale();
    let palette = rows_of(&[Affine3A::IDENTITY; 2 * JOINTS]);
    let mut out = SkinnedMesh::new(&mesh);
    grouped.skin_stale(grouped.rest(), &palette, &mut stale, &mut out);
    let mut turned = palette.clone();
    turned[2] = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 5.0],
        [0.0, 0.0, 1.0, 0.0],
    ];
    let moved = grouped.moved(&palette, &turned);
    assert_eq!(moved.iter().collect::<Vec<_>>(), [2]);
    grouped.mark_joints(&moved, &mut stale);
    let count = grouped.skin_stale(grouped.rest(), &turned, &mut stale, &mut out);
    assert_eq!(count, 32);
    for (v, position) in out.positions.iter().enumerate() {
        let height = if v / 32 == 2 { 5.0 } else { 0.0 };
        assert_eq!(*position, Vec3::new(v as f32, height, 0.0));
    }
}

#[test]
fn a_frame_allocates_nothing() {
    let mut mesh = strip(50);
    mesh.morphs = vec![Morph {
        slot: 1,
        vertices: vec![3, 60, 61],
        positions: vec![Vec3::Z; 3],
        normals: vec![Vec3::ZERO; 3],
    }];
    let grouped = GroupedSkin::new(&mesh);
    let (mut shape, mut stale) = (grouped.rest().clone(), grouped.stale());
    let palette = [Affine3A::IDENTITY; 2 * JOINTS];
    let mut matrices = rows_of(&palette);
    let mut out = SkinnedMesh::new(&mesh);
    let counted = allocation_counter::measure(|| {
        for frame in 0..5 {
            GroupedSkin::rows(&palette, &mut matrices);
            grouped.mark_joints(&JointSet::first(frame), &mut stale);
            let weights = [0.0, frame as f32, 0.0];
            grouped.morph(&weights, &mut shape, &mut stale);
            grouped.skin_stale(&shape, &matrices, &mut stale, &mut out);
            grouped.skin(&shape, &matrices, &mut out);
        }
    });
    assert_eq!(counted.count_total, 0);
    assert_eq!(out.positions[60], Vec3::new(60.0, 0.0, 4.0));
}

#[test]
fn half_way_between_two_joints_and_in_a_mirror() {
    let row = (Vec3::X, Vec3::X, vec![(0, 0.5), (1, 0.0), (1, 0.5)]);
    let grouped = GroupedSkin::new(&mesh_of(&[row], 3, Vec::new()));
    let mut palette = [Affine3A::IDENTITY; 2 * JOINTS];
    palette[1] = Affine3A::from_translation(Vec3::Y * 2.0);
    let mut out = SkinnedMesh {
        positions: vec![Vec3::ZERO],
        normals: vec![Vec3::ZERO],
    };
    grouped.skin(grouped.rest(), &rows_of(&palette), &mut out);
    assert_eq!(
        (out.positions[0], out.normals[0]),
        (Vec3::new(1.0, 1.0, 0.0), Vec3::X)
    );
    let mirror = Affine3A::from_scale(Vec3::new(-2.0, 1.0, 1.0));
    grouped.skin(grouped.rest(), &rows_of(&[mirror; 2 * JOINTS]), &mut out);
    assert_eq!(
        (out.positions[0], out.normals[0]),
        (Vec3::X * -2.0, Vec3::NEG_X)
    );
}

#[test]
fn no_vertices_and_vertices_that_nothing_holds() {
    let none = Mesh::default();
    let grouped = GroupedSkin::new(&none);
    grouped.skin(grouped.rest(), &[], &mut SkinnedMesh::new(&none));

    let mut loose = strip(1);
    loose.weights.fill(0.0);
    let grouped = GroupedSkin::new(&loose);
    let palette = [Affine3A::from_translation(Vec3::ONE); 2 * JOINTS];
    let mut out = SkinnedMesh::new(&loose);
    grouped.skin(grouped.rest(), &rows_of(&palette), &mut out);
    assert_eq!(out, plain(&loose, &palette, &[0.0; MORPHS]));
}

#[test]
#[should_panic(expected = "the palette must belong to this mesh")]
fn a_palette_of_another_mesh_is_refused() {
    let mesh = strip(1);
    let grouped = GroupedSkin::new(&mesh);
    grouped.skin(grouped.rest(), &[], &mut SkinnedMesh::new(&mesh));
}
