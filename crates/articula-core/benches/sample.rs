//! Cost of sampling a clip, joint by joint.

mod human;

use articula_core::{JointSet, Wrap, sample};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// The walk, with different numbers of active joints.
#[divan::bench(args = [8, 24, 48, 89])]
fn walk(bencher: Bencher<'_, '_>, joints: usize) {
    let rig = &human::asset().rig;
    let (clip, times) = human::walk(64);
    let mut order: Vec<usize> = (0..rig.len()).collect();
    order.sort_by_key(|j| rig.articulation().joints[*j].level);
    let active: JointSet = order.into_iter().take(joints).collect();
    let mut pose = rig.rest_pose().clone();
    bencher.counter(times.len()).bench_local(|| {
        for secs in &times {
            let secs = f64::from(*secs);
            sample(clip, secs, Wrap::Loop, black_box(&active), &mut pose);
        }
    });
}
