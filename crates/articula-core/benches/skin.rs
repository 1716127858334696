//! Cost of skinning a mesh and of its morph targets.

mod human;

use articula_core::{
    GroupedSkin, Mesh, ModelPose, Morph, SkinnedMesh, Wrap, local_to_model, palette, sample, skin,
};
use divan::{Bencher, black_box};
use glam::{Affine3A, Vec3};

fn main() {
    divan::main();
}

/// Positions and normals of all vertices of the reference human, by the plain version.
#[divan::bench]
fn plain(bencher: Bencher<'_, '_>) {
    let mesh = &human::asset().mesh;
    let matrices = matrices();
    let mut out = SkinnedMesh::new(mesh);
    bencher
        .counter(mesh.len())
        .bench_local(|| skin(mesh, black_box(&matrices), &mesh.morph_weights, &mut out));
}

/// The same with vertices grouped by their number of influences.
#[divan::bench]
fn grouped(bencher: Bencher<'_, '_>) {
    let mesh = &human::asset().mesh;
    let affine = matrices();
    let mut matrices = vec![[[0.0; 4]; 3]; affine.len()];
    GroupedSkin::rows(&affine, &mut matrices);
    let grouped = GroupedSkin::new(mesh);
    let mut out = SkinnedMesh::new(mesh);
    bencher
        .counter(mesh.len())
        .bench_local(|| grouped.skin(grouped.rest(), black_box(&matrices), &mut out));
}

/// The palette of a pose of the walk.
fn matrices() -> Vec<Affine3A> {
    let asset = human::asset();
    let (clip, times) = human::walk(2);
    let mut local = asset.rig.rest_pose().clone();
    let secs = f64::from(times[1]);
    sample(clip, secs, Wrap::Loop, &asset.rig.all(), &mut local);
    let mut model = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, &local, &mut model);
    let mut matrices = vec![Affine3A::IDENTITY; asset.mesh.bindings.len()];
    palette(&asset.mesh, &model, &mut matrices);
    matrices
}

/// Number of morph targets of a head, and how many of them have a weight in a frame of speech.
const TARGETS: usize = 52;
const ACTIVE: usize = 12;

/// The reference human's mesh with targets that each move a run of its vertices, as many in all as
/// those of ARKit on a scanned body: between 1 and 12 % of the vertices each.
fn morphed() -> Mesh {
    let mut mesh = Mesh::clone(&human::asset().mesh);
    let count = mesh.len();
    let target = |slot: usize| {
        let moved = count / 100 * (1 + slot * 7 % 12);
        let first = slot * 389 % (count - moved);
        let offset = |v: usize| Vec3::new((v % 7) as f32, (v % 5) as f32, 1.0) * 1e-3;
        Morph {
            slot: slot as u16,
            vertices: (first..first + moved).map(|v| v as u32).collect(),
            positions: (0..moved).map(offset).collect(),
            normals: (0..moved).map(offset).collect(),
        }
    };
    mesh.morphs = (0..TARGETS).map(target).collect();
    mesh.morph_weights = vec![0.0; TARGETS];
    mesh
}

/// Weights of two frames in turn: the same targets, another face.
fn faces() -> [Vec<f32>; 2] {
    [0.3, 0.6].map(|weight| {
        let mut weights = vec![0.0; TARGETS];
        for i in 0..ACTIVE {
            weights[i * 4] = weight + 0.02 * i as f32;
        }
        weights
    })
}

/// Morph targets alone, as a frame of one figure adds them before it skins.
#[divan::bench]
fn morph_grouped(bencher: Bencher<'_, '_>) {
    let mesh = morphed();
    let grouped = GroupedSkin::new(&mesh);
    let (mut shape, mut stale) = (grouped.rest().clone(), grouped.stale());
    let (faces, mut frame) = (faces(), 0);
    bencher.counter(mesh.len()).bench_local(|| {
        frame += 1;
        let weights = black_box(&faces[frame % 2]);
        grouped.morph(weights, &mut shape, &mut stale);
    });
}

/// The plain form: all vertices at rest, then the vertices of each target with a weight.
#[divan::bench]
fn morph_plain(bencher: Bencher<'_, '_>) {
    let mesh = morphed();
    let mut out = SkinnedMesh::new(&mesh);
    let (faces, mut frame) = (faces(), 0);
    bencher.counter(mesh.len()).bench_local(|| {
        frame += 1;
        let weights = black_box(&faces[frame % 2]);
        out.positions.copy_from_slice(&mesh.positions);
        out.normals.copy_from_slice(&mesh.normals);
        for morph in &mesh.morphs {
            let weight = weights[usize::from(morph.slot)];
            if weight != 0.0 {
                let offsets = morph.positions.iter().zip(&morph.normals);
                for (v, (dp, dn)) in morph.vertices.iter().zip(offsets) {
                    out.positions[*v as usize] += *dp * weight;
                    out.normals[*v as usize] += *dn * weight;
                }
            }
        }
        black_box(&out);
    });
}

/// The dense form of renderers that store every target for every vertex: all targets, all vertices.
#[divan::bench]
fn morph_dense(bencher: Bencher<'_, '_>) {
    let mesh = morphed();
    let dense = mesh.morphs.iter().map(|morph| {
        let mut offsets = vec![[Vec3::ZERO; 2]; mesh.len()];
        let each = morph.positions.iter().zip(&morph.normals);
        for (v, (dp, dn)) in morph.vertices.iter().zip(each) {
            offsets[*v as usize] = [*dp, *dn];
        }
        offsets
    });
    let dense: Vec<Vec<[Vec3; 2]>> = dense.collect();
    let mut out = SkinnedMesh::new(&mesh);
    let (faces, mut frame) = (faces(), 0);
    bencher.counter(mesh.len()).bench_local(|| {
        frame += 1;
        let weights = black_box(&faces[frame % 2]);
        out.positions.copy_from_slice(&mesh.positions);
        out.normals.copy_from_slice(&mesh.normals);
        for (offsets, weight) in dense.iter().zip(weights) {
            let places = out.positions.iter_mut().zip(&mut out.normals);
            for ((position, normal), [dp, dn]) in places.zip(offsets) {
                *position += *dp * *weight;
                *normal += *dn * *weight;
            }
        }
        black_box(&out);
    });
}
