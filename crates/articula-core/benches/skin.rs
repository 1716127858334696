//! Cost of skinning a mesh.

mod human;

use articula_core::{
    GroupedSkin, ModelPose, SkinnedMesh, Wrap, local_to_model, palette, sample, skin,
};
use divan::{Bencher, black_box};
use glam::Affine3A;

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
