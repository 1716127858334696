//! Cost of forward kinematics for one local pose.

mod human;

use articula_core::{LocalPose, ModelPose, Wrap, local_to_model, sample};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// All joints of the reference human in poses of its walk.
#[divan::bench]
fn walk(bencher: Bencher<'_, '_>) {
    let rig = &human::asset().rig;
    let (clip, times) = human::walk(64);
    let poses = times.iter().map(|secs| {
        let mut pose = rig.rest_pose().clone();
        sample(clip, f64::from(*secs), Wrap::Loop, &rig.all(), &mut pose);
        pose
    });
    let poses: Vec<LocalPose> = poses.collect();
    let mut model = ModelPose::new(rig.len());
    bencher.counter(poses.len()).bench_local(|| {
        for pose in &poses {
            local_to_model(rig, black_box(pose), &mut model);
        }
    });
}
