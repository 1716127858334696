//! Cost of one character in a batch of eight, by palette form, storage and backend.
#![allow(clippy::unwrap_used, reason = "a bench may stop at the first surprise")]

mod human;

use articula_core::batch::{BatchEvaluator, BatchPose};
use articula_core::{
    Backend, ClipSet, ClipStorage, JointLods, PaletteForm, PaletteMap, PaletteRows,
};
use divan::{Bencher, black_box};

/// Characters per iteration.
const COUNT: usize = 96;

fn main() {
    divan::main();
}

/// Model matrices of all joints on the fastest backend, in every form.
const FORMS: [PaletteForm; 4] = [
    PaletteForm::Matrix,
    PaletteForm::HalfMatrix,
    PaletteForm::Rigid,
    PaletteForm::HalfRigid,
];

#[divan::bench(args = FORMS)]
fn form(bencher: Bencher<'_, '_>, form: PaletteForm) {
    walk(bencher, form, ClipStorage::Float, Backend::best(), 0.0);
}

/// The same as 3x4 matrices, on every backend of this machine.
#[divan::bench(args = Backend::ALL.into_iter().filter(|b| b.is_available()))]
fn backend(bencher: Bencher<'_, '_>, backend: Backend) {
    walk(
        bencher,
        PaletteForm::Matrix,
        ClipStorage::Float,
        backend,
        0.0,
    );
}

/// The same with clips stored as 16-bit integers.
#[divan::bench]
fn short_storage(bencher: Bencher<'_, '_>) {
    walk(
        bencher,
        PaletteForm::Matrix,
        ClipStorage::Short,
        Backend::best(),
        0.0,
    );
}

/// The same while every character cross-fades to another clip.
#[divan::bench]
fn cross_fade(bencher: Bencher<'_, '_>) {
    walk(
        bencher,
        PaletteForm::Matrix,
        ClipStorage::Float,
        Backend::best(),
        0.5,
    );
}

fn walk(
    bencher: Bencher<'_, '_>,
    form: PaletteForm,
    storage: ClipStorage,
    backend: Backend,
    fade: f32,
) {
    let asset = human::asset();
    let (walk, times) = human::walk(COUNT);
    let clip = asset
        .clips
        .iter()
        .position(|c| c.name == walk.name)
        .unwrap();
    let joint_lods = JointLods::whole(&asset.rig).unwrap();
    let map = PaletteMap::joints(&joint_lods);
    let clips = ClipSet::new(&asset.rig, joint_lods, &asset.clips, storage).unwrap();
    let evaluator = BatchEvaluator::new(&clips, &map, form, backend).unwrap();
    let mut scratch = evaluator.scratch();
    let shown: Vec<BatchPose> = times
        .into_iter()
        .map(|secs| BatchPose {
            from: clips.cursor(clip, secs),
            to: clips.cursor(0, secs),
            fade,
        })
        .collect();
    let lanes = evaluator.lanes();
    let rows = lanes * evaluator.rows(0);
    let mut floats = vec![[0.0; 4]; if form.is_half() { 0 } else { rows }];
    let mut halves = vec![[0; 4]; if form.is_half() { rows } else { 0 }];
    bencher.counter(COUNT).bench_local(|| {
        for batch in black_box(&shown).chunks(lanes) {
            let out = if form.is_half() {
                PaletteRows::Half(&mut halves)
            } else {
                PaletteRows::Float(&mut floats)
            };
            evaluator.evaluate(0, batch, out, &mut scratch);
        }
    });
}
