//! The face apart in the errors of a clip.

use crate::evaluate::{asset, skeleton_of};
use articula_build::evaluate::{ClipEvaluator, EvaluationSetup, Method, MethodOptions, play};
use articula_core::{Articulation, Region};
use glam::Vec3;
use std::sync::Arc;

#[test]
fn a_head_joint_says_what_the_face_is() {
    let mut asset = asset();
    let mut joints = asset.rig.articulation().joints.clone();
    joints[1].region = Region::Face;
    let articulation = Articulation {
        joints,
        ..asset.rig.articulation().clone()
    };
    let skeleton = skeleton_of(&asset);
    asset.rig = Arc::new(articula_core::Rig::new(&skeleton, articulation).unwrap());
    // Farther out than the vertex that is given.
    Arc::make_mut(&mut asset.mesh).positions[1] = 2.0 * Vec3::X;
    let found = |face: Vec<u32>| {
        let setup = EvaluationSetup::default();
        let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, MethodOptions::default());
        let stage = stage.with_face(face);
        let (_, playbacks) = play(&stage, &Method::SkipHold, 8.0);
        stage.skin_errors(&playbacks)
    };
    let joint = found(Vec::new());
    assert_eq!(found(vec![0]), joint);
    assert_eq!(joint.face.unwrap().worst_vertex, joint.worst_vertex);
}
