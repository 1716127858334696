//! Figures of a few joints, worked by hand.

use super::seen_at;
use articula_core::crowd::{CharacterState, ClipEvent, ClipState, RootDelta, RootTrajectory};
use articula_core::joint_state::{Ease, LoaRange, PassivePolicy, TransitionOptions};
use articula_core::playback::{
    FigureModel, FigurePlayer, FigureSkin, FullDetail, LayerMode, LoaController, MotionLayer,
};
use articula_core::source::{Joint, MorphTarget, Primitive, RawMesh, Skeleton, Skin};
use articula_core::{
    Articulation, Clip, DriftController, DriftOptions, GroupedSkin, JointArticulation,
    JointErrorBounds, JointSet, LocalPose, Mesh, PosedMesh, Region, Rig, Track, Tracks, Transform,
    angle_between,
};
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;

/// A chain of joints, each a metre above the one before.
pub(crate) fn chain(joints: usize) -> Rig {
    let joint = |j: usize| Joint {
        name: format!("j{j}"),
        parent: j.checked_sub(1),
        rest: Transform::from_translation(if j == 0 { Vec3::ZERO } else { Vec3::Y }),
        in_skin: true,
    };
    let skeleton = Skeleton {
        joints: (0..joints).map(joint).collect(),
    };
    let known = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![known; joints],
    };
    Rig::new(&skeleton, articulation).unwrap()
}

/// The root moves along x by a metre in each frame.
pub(crate) fn counting(frames: usize) -> Tracks {
    Tracks {
        translations: vec![Track {
            target: 0,
            step: false,
            values: (0..frames).map(|i| Vec3::X * i as f32).collect(),
        }],
        ..Tracks::default()
    }
}

/// Every joint turns about x by `radians` in each of ten frames of a tenth of a second.
pub(crate) fn turning(joints: usize, radians: f32) -> Clip {
    let track = |target| Track {
        target,
        step: false,
        values: (0..=10)
            .map(|i| Quat::from_rotation_x(radians * i as f32))
            .collect(),
    };
    let tracks = Tracks {
        rotations: (0..joints as u16).map(track).collect(),
        morphs: vec![Track {
            target: 0,
            step: false,
            values: (0..=10).map(|i| 0.1 * i as f32).collect(),
        }],
        ..Tracks::default()
    };
    Clip::new("turn", 10.0, 11, joints, tracks).unwrap()
}

fn about_x(pose: &LocalPose, joint: usize, radians: f32) -> bool {
    angle_between(pose.rotations[joint], Quat::from_rotation_x(radians)) < 1e-4
}

#[test]
fn fades_events_and_the_way_go_on_while_nothing_moves() {
    let rig = chain(2);
    let clips = [turning(2, 0.1), turning(2, 0.0)];
    let ahead = |metres: f32| {
        let place = |i: usize| RootDelta {
            offset: Vec3::Z * metres * i as f32,
            yaw_radians: 0.0,
        };
        RootTrajectory::new(10.0, (0..=10).map(place).collect()).unwrap()
    };
    let event = |secs, id| ClipEvent { secs, id };
    let model = FigureModel::new(rig.clone(), &clips)
        .unwrap()
        .with_events(vec![vec![event(0.75, 2), event(0.25, 1)], vec![]])
        .unwrap()
        .with_root_motion(vec![Some(ahead(1.0)), Some(ahead(3.0))])
        .unwrap();
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let range = LoaRange::new(vec![JointSet::EMPTY], 0).unwrap();
    let opts = TransitionOptions::default();
    let mut nothing = LoaController::new(&rig, range, opts, FullDetail::default());
    let mut heard = Vec::new();
    let mut step = |player: &mut FigurePlayer, dt| {
        let way = player.advance(dt, &mut |e| heard.push((e.event.id, e.weight)));
        player.control(&mut nothing, seen_at(100.0));
        way.offset.z
    };
    assert!((step(&mut player, 0.5) - 5.0).abs() < 1e-5);
    player.fade_to(ClipState::new(&model, 1), 1.0);
    // From 0 to 0.5 of the fade: the way of a step is that of its start.
    assert!((step(&mut player, 0.5) - 5.0).abs() < 1e-5);
    // Half of 1 m a frame and half of 3 m.
    assert!((step(&mut player, 0.1) - 2.0).abs() < 1e-5);
    assert!(
        about_x(player.pose(), 1, 0.5),
        "held where it was at the start"
    );
    assert_eq!(heard, [(1, 1.0), (2, 1.0)]);
    assert!(FigureModel::new(chain(3), &clips).is_err());
    assert!(
        model
            .clone()
            .with_events(vec![vec![event(9.0, 1)], vec![]])
            .is_err()
    );
    assert!(model.with_root_motion(vec![None]).is_err());
}

#[test]
fn a_level_falls_and_rises_in_transitions_of_either_kind() {
    let rig = chain(2);
    let clips = [turning(2, 0.1)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    for (ease, half) in [(Ease::Linear, 0.5f32), (Ease::Smoothstep, 0.5)] {
        let opts = TransitionOptions {
            secs: 0.2,
            ease,
            policy: PassivePolicy::HoldLast,
        };
        // The device allows level 1 at most, where play starts: the root alone.
        let levels = vec![rig.all(), JointSet::first(1), JointSet::EMPTY];
        let range = LoaRange::new(levels, 1).unwrap();
        let mut loa = LoaController::new(&rig, range, opts, FullDetail::default());
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let frame = |player: &mut FigurePlayer, loa: &mut LoaController<FullDetail>, dt| {
            player.advance(dt, &mut |_| {});
            *player.control(loa, seen_at(100.0))
        };
        frame(&mut player, &mut loa, 0.0);
        assert_eq!(loa.level(), 1);
        frame(&mut player, &mut loa, 0.3);
        assert!(about_x(player.pose(), 0, 0.3) && about_x(player.pose(), 1, 0.0));
        loa.request(0);
        assert_eq!(loa.level(), 1, "the cap of the device holds");
        loa.articulate(rig.all());
        frame(&mut player, &mut loa, 0.0);
        let report = frame(&mut player, &mut loa, 0.1);
        assert_eq!(report.in_transition, JointSet::from_iter([1]));
        // Half-way from the held 0 to the 0.4 of the clip.
        assert!(about_x(player.pose(), 1, 0.4 * half));
        // Interrupted: it starts from what is shown, 0.2 behind the clip.
        loa.request(2);
        frame(&mut player, &mut loa, 0.0);
        assert!(about_x(player.pose(), 1, 0.2));
        let report = frame(&mut player, &mut loa, 0.25);
        assert!(report.in_transition.is_empty());
        assert!(about_x(player.pose(), 1, 0.2), "held where it was shown");
    }
}

/// A passive root keeps its translation and its turn about the vertical.
#[test]
fn a_passive_root_travels_on_and_joints_below_stand_still() {
    let rig = chain(2);
    let turn = |i: usize| Quat::from_rotation_y(0.1 * i as f32) * Quat::from_rotation_x(0.05);
    let lean = |i: usize| turn(i) * Quat::from_rotation_x(0.02 * i as f32);
    let mut tracks = counting(11);
    tracks.rotations = vec![Track {
        target: 0,
        step: false,
        values: (0..=10).map(lean).collect(),
    }];
    let clips = [Clip::new("walk", 10.0, 11, 2, tracks).unwrap()];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let opts = TransitionOptions {
        secs: 0.0,
        ..TransitionOptions::default()
    };
    let range = LoaRange::new(vec![JointSet::EMPTY], 0).unwrap();
    let mut none = LoaController::new(&rig, range, opts, FullDetail::default());
    // A metric that would hold everything does not hold the way either.
    let bound = JointErrorBounds {
        lever_metres: 0.01,
        speed_metres_per_sec: 0.01,
        share: 1.0,
    };
    let drift = DriftController::new(rig.rest_pose(), vec![bound; 2], DriftOptions::default());
    let range = LoaRange::one(JointSet::EMPTY);
    let mut bounded = LoaController::new(&rig, range, opts, drift);
    let mut beside = FigurePlayer::new(model.clone(), &[]);
    for i in 0..10 {
        player.control(&mut none, seen_at(1.0));
        beside.control(&mut bounded, seen_at(1e-3));
        assert_eq!(beside.pose(), player.pose(), "frame {i}");
        beside.advance(0.1, &mut |_| {});
        let root = player.pose().get(0);
        assert!((root.translation - Vec3::X * i as f32).length() < 1e-4);
        assert!(angle_between(root.rotation, turn(i)) < 1e-3, "frame {i}");
        player.advance(0.1, &mut |_| {});
    }
}

#[test]
fn an_additive_layer_adds_its_difference_and_hooks_have_the_last_word() {
    let rig = chain(3);
    let clips = [turning(3, 0.1), turning(3, 0.05)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &[0.25, 0.5]);
    let over = CharacterState::from(ClipState::new(&*model, 1).at_secs(&*model, 0.2));
    let reference = rig.rest_pose().clone();
    let mode = LayerMode::Additive(reference.clone());
    let layer = MotionLayer::new(over, vec![0.0, 1.0, 0.5], mode.clone()).unwrap();
    player.add_layer(layer).unwrap();
    player.advance(0.2, &mut |_| {});
    let report = *player.control(&mut FullDetail::default(), seen_at(1.0));
    // The base turns by 0.2; the layer, at 0.4 s, by 0.2.
    assert!(about_x(player.pose(), 0, 0.2));
    assert!(about_x(player.pose(), 1, 0.4));
    assert!(about_x(player.pose(), 2, 0.3));
    assert_eq!((report.sampled.len(), report.transforms_sampled), (3, 5));
    // The track of both clips drives the first weight: 0.2 + 0.4; the second has none.
    assert!((player.morph_weights()[0] - 0.6).abs() < 1e-5);
    assert_eq!(player.morph_weights()[1], 0.5);
    player.hierarchy();
    player.edit(&mut |pose| pose.rotations[2] = Quat::IDENTITY);
    assert_eq!(player.hierarchy(), 1, "only the last joint changed");
    assert_eq!(player.report().matrices, 1);
    player.control(&mut FullDetail::default(), seen_at(1.0));
    assert!(about_x(player.pose(), 2, 0.3), "a hook changes one frame");
    let bad = MotionLayer::new(over, vec![2.0; 3], LayerMode::Override);
    assert_eq!(bad.unwrap_err().at, "mask[0]");
    assert!(MotionLayer::new(over, vec![1.0; 2], mode).is_err());
    let short = MotionLayer::new(over, vec![1.0; 2], LayerMode::Override).unwrap();
    assert!(player.add_layer(short).is_err());
}

#[test]
fn a_budget_is_spent_in_turn_and_pinned_joints_are_exact() {
    let rig = chain(4);
    let clips = [turning(4, 0.1)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let mut full = FullDetail::default();
    player.control(&mut full, seen_at(1.0));
    player.max_joints = 1;
    player.pin(1);
    let mut turns = Vec::new();
    for i in 1..=4 {
        player.advance(0.1, &mut |_| {});
        let report = player.control(&mut full, seen_at(1.0));
        turns.extend(report.updated.iter().filter(|j| *j > 1));
        assert!(
            about_x(player.pose(), 0, 0.1 * i as f32) && about_x(player.pose(), 1, 0.1 * i as f32)
        );
        player.hierarchy();
        // Two metres above the root at rest; the attachment follows the clip.
        let tip = player.joint(1).transform_point3(Vec3::Y);
        let angle = 0.1 * i as f32;
        let exact =
            Quat::from_rotation_x(angle) * (Vec3::Y + Quat::from_rotation_x(angle) * Vec3::Y);
        assert!((tip - exact).length() < 1e-4);
    }
    assert_eq!(turns, [2, 3], "joints 0 and 1 had their turns in between");
}

fn skinned_mesh() -> Mesh {
    let moved = MorphTarget {
        positions: vec![Vec3::ZERO, Vec3::ZERO, Vec3::Z],
        normals: vec![],
    };
    let mesh = RawMesh {
        name: "strip".into(),
        skin: Skin {
            joints: vec![0, 1, 2],
            inverse_bind: (0..3)
                .map(|j| Affine3A::from_translation(Vec3::NEG_Y * j as f32))
                .collect(),
        },
        primitives: vec![Primitive {
            positions: vec![Vec3::ZERO, Vec3::Y, Vec3::Y * 2.0],
            influences: 1,
            joints: vec![0, 1, 2],
            weights: vec![1.0; 3],
            triangles: vec![[0, 1, 2]],
            morphs: vec![moved],
            ..Primitive::default()
        }],
        morph_weights: vec![0.0],
        ..RawMesh::default()
    };
    Mesh::new(&[mesh], 3).unwrap()
}

#[test]
fn the_skin_is_that_of_plain_skinning_and_nothing_is_skinned_twice() {
    let rig = chain(3);
    let mesh = Arc::new(skinned_mesh());
    let clips = [turning(3, 0.1)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &mesh.morph_weights);
    let groups = GroupedSkin::new(&mesh);
    let mut skin = FigureSkin::new(mesh.clone(), groups);
    let mut posed = PosedMesh::new(&rig, &mesh);
    for _ in 0..5 {
        player.control(&mut FullDetail::default(), seen_at(1.0));
        player.hierarchy();
        assert_eq!(skin.skin(player.model_pose(), player.morph_weights()), 3);
        let plain = posed.pose(player.pose()).skinned(player.morph_weights());
        for (a, b) in skin.skinned().positions.iter().zip(&plain.positions) {
            assert!((*a - *b).length() < 1e-6);
        }
        assert_eq!(skin.skin(player.model_pose(), player.morph_weights()), 0);
        player.advance(0.1, &mut |_| {});
    }
}

#[test]
fn a_figure_moves_to_refined_clips_within_the_time() {
    let rig = Arc::new(chain(2));
    let coarse = [turning(2, 0.1), turning(2, 0.5)];
    let model = Arc::new(FigureModel::new(rig.clone(), coarse).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &[0.0]);
    player.max_joints = 7;
    let mut controller = FullDetail::default();
    let mut shown = |player: &mut FigurePlayer, secs: f32| {
        player.advance(secs, &mut |_| {});
        player.control(&mut controller, seen_at(5.0));
        player.pose().clone()
    };
    assert!(about_x(&shown(&mut player, 0.2), 1, 0.2));

    // Another version of one clip; the other one is shared.
    let mut clips = model.clips().to_vec();
    clips[0] = turning(2, 0.3);
    let finer = Arc::new(FigureModel::new(model.rig().clone(), clips).unwrap());
    assert!(std::ptr::eq(
        model.clips()[1].tracks(),
        finer.clips()[1].tracks()
    ));
    let mut jumping = player.clone();
    jumping.set_model(finer.clone(), 0.0).unwrap();
    assert!(about_x(&shown(&mut jumping, 0.0), 1, 0.6));
    // The difference at 0.2 s is -0.4 rad; half of it is left after half of the time, during which
    // the new clip turns on by 0.3 rad.
    let mut moving = player.clone();
    moving.set_model(finer.clone(), 0.2).unwrap();
    assert_eq!(moving.max_joints, 7);
    assert!(about_x(&shown(&mut moving, 0.0), 1, 0.2));
    let half = shown(&mut moving, 0.1);
    assert!(angle_between(half.rotations[1], Quat::from_rotation_x(0.9 - 0.2)) < 2e-3);
    assert!(about_x(&shown(&mut moving, 0.1), 1, 1.2));
    assert!(about_x(&shown(&mut moving, 0.1), 1, 1.5));
    // Refined again in the middle, it goes on from where it was.
    let mut again = player.clone();
    again.set_model(finer.clone(), 0.2).unwrap();
    let half = shown(&mut again, 0.1);
    again.set_model(finer, 0.2).unwrap();
    let after = shown(&mut again, 0.0);
    assert!(angle_between(half.rotations[1], after.rotations[1]) < 1e-5);

    let still = Clip::new("still", 10.0, 2, 2, Tracks::default()).unwrap();
    let shorter = FigureModel::new(rig.clone(), [still.clone(), still]).unwrap();
    let fewer = FigureModel::new(rig, [turning(2, 0.3)]).unwrap();
    let longer = FigureModel::new(chain(3), [turning(3, 0.1), turning(3, 0.1)]).unwrap();
    let mut refused = player.clone();
    for (other, at) in [
        (shorter, "model.clips"),
        (fewer, "model.clips"),
        (longer, "model.rig"),
    ] {
        assert_eq!(refused.set_model(other, 0.2).unwrap_err().at, at);
    }
    assert!(Arc::ptr_eq(refused.model(), &model));
    assert_eq!(shown(&mut refused, 0.1), shown(&mut player, 0.1));
}
