//! The controllers in a playback: bounds, tables, the thesis, and no allocation.

use super::by_hand::{chain, turning};
use super::seen_at;
use articula_core::crowd::{CharacterState, ClipState};
use articula_core::joint_state::{JointState, LoaRange, PassivePolicy, TransitionOptions};
use articula_core::playback::{
    ErrorMatrix, FigureModel, FigurePlayer, FigureSkin, FigureViews, FullDetail, LayerMode,
    LoaController, MotionController, MotionLayer, StoredKeys, TableController, ThesisController,
    Threshold,
};
use articula_core::{
    Camera, Clip, DriftController, DriftOptions, GroupedSkin, JointErrorBounds, JointSet, KeyMode,
    KeyTable, Rig, SecondMoment, TableHashes, Track, Tracks, Viewport, angle_between, nlerp,
    sample,
};
use glam::{Quat, Vec3};
use std::sync::Arc;

const LEVER: f32 = 0.3;

/// Joints that swing about x at different speeds, closed over two seconds at 30 Hz.
fn swinging(joints: usize) -> Clip {
    let swing = |joint: usize, i: usize| {
        let phase = std::f32::consts::TAU * i as f32 / 60.0;
        Quat::from_rotation_x(0.4 * (phase * (1 + joint % 3) as f32).sin())
    };
    let track = |joint: usize| Track {
        target: joint as u16,
        step: false,
        values: (0..=60).map(|i| swing(joint, i)).collect(),
    };
    let tracks = Tracks {
        rotations: (0..joints).map(track).collect(),
        ..Tracks::default()
    };
    Clip::new("swing", 30.0, 61, joints, tracks).unwrap()
}

fn bounds(clip: &Clip) -> Vec<JointErrorBounds> {
    let bound = |track: &Track<Quat>| {
        let turns = track.values.windows(2).map(|w| angle_between(w[0], w[1]));
        let fastest = turns.fold(0.0, f32::max);
        JointErrorBounds {
            lever_metres: LEVER,
            speed_metres_per_sec: LEVER * 1.01 * fastest * clip.rate_hz(),
            share: 1.0,
        }
    };
    clip.tracks().rotations.iter().map(bound).collect()
}

fn drift(rig: &Rig, clip: &Clip) -> DriftController {
    DriftController::new(rig.rest_pose(), bounds(clip), DriftOptions::default())
}

/// Largest error of any joint in pixels against the base motion.
fn error_px(player: &FigurePlayer, rig: &Rig, clips: &[Clip], scale: f32) -> f32 {
    let state = player.state().unwrap().clip_state();
    let mut truth = rig.rest_pose().clone();
    let clip = &clips[state.clip()];
    sample(
        clip,
        f64::from(state.secs()),
        state.wrap(),
        &rig.all(),
        &mut truth,
    );
    let pairs = player.pose().rotations.iter().zip(&truth.rotations);
    let angles = pairs.map(|(a, b)| angle_between(*a, *b));
    LEVER * scale * angles.fold(0.0, f32::max)
}

#[test]
fn drift_keeps_its_bound_at_every_rate_through_seeks_and_fades() {
    let rig = chain(4);
    let clips = [swinging(4), turning(4, 0.2)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    for hz in [24.0f32, 60.0, 144.0] {
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let mut control = drift(&rig, &clips[0]);
        let (mut held, mut frames) = (0, 0);
        for i in 0..(5.0 * hz) as usize {
            if i == hz as usize {
                let far = ClipState::new(&*model, 0).at_secs(&*model, 1.3);
                player.play(far);
            }
            player.advance(1.0 / hz, &mut |_| {});
            let report = player.control(&mut control, seen_at(20.0));
            assert_eq!(report.bound_px, Some(1.25));
            held += report.held.len();
            frames += 1;
            let error = error_px(&player, &rig, &clips, 20.0);
            assert!(error <= 1.25 + 5e-3, "{error} px at {hz} Hz, frame {i}");
        }
        assert!(
            held > frames,
            "most joints are held: {held} in {frames} frames"
        );
        // In a fade no bound on speed is known, so every joint is tested.
        player.fade_to(ClipState::new(&*model, 1), 0.5);
        player.advance(0.1, &mut |_| {});
        assert_eq!(
            player.control(&mut control, seen_at(20.0)).sampled,
            rig.all()
        );
    }
}

#[test]
fn drift_keeps_its_bound_when_a_fade_or_a_layer_is_over() {
    let rig = chain(4);
    let clips = [swinging(4)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let mut control = drift(&rig, &clips[0]);
    let over = CharacterState::from(ClipState::new(&*model, 0).at_secs(&*model, 0.5));
    let layer = MotionLayer::new(over, vec![1.0; 4], LayerMode::Override).unwrap();
    let top = player.add_layer(layer).unwrap();
    let mut measured = 0;
    for i in 0..400 {
        player.advance(1.0 / 60.0, &mut |_| {});
        player.layer_mut(top).unwrap().weight = f32::from(u8::from(i % 50 < 7));
        if i % 80 == 20 {
            let elsewhere = ClipState::new(&*model, 0).at_secs(&*model, 0.03 * i as f32);
            player.fade_to(elsewhere, 0.1);
        }
        player.control(&mut control, seen_at(20.0));
        if i % 50 >= 7 && player.state().unwrap().next().is_none() {
            let error = error_px(&player, &rig, &clips, 20.0);
            assert!(error <= 1.25 + 5e-3, "{error} px in frame {i}");
            measured += 1;
        }
    }
    assert!(measured > 250);
}

#[test]
fn drift_ahead_of_a_camera_counts_what_the_view_sees() {
    let rig = chain(1);
    let clips = [swinging(1)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    // The skin is a point a lever above the joint, which swings about x: along z.
    let moment = SecondMoment::of([(Vec3::Y * LEVER, 1.0)]);
    let updates = |direction: Vec3| {
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let mut control = drift(&rig, &clips[0]).with_second_moments(vec![moment]);
        for _ in 0..240 {
            player.advance(1.0 / 60.0, &mut |_| {});
            let views = FigureViews::Parallel {
                pixels_per_metre: 20.0,
                distance_metres: 5.0,
                directions: &[direction],
            };
            player.control(&mut control, views);
            player.hierarchy();
        }
        control.updates()
    };
    let (ahead, aside) = (updates(Vec3::Z), updates(Vec3::X));
    assert!(
        2 * ahead < aside,
        "{ahead} seen along the motion, {aside} across"
    );
}

#[test]
fn an_articulation_bounds_a_metric() {
    let rig = chain(4);
    let clips = [swinging(4)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let range = LoaRange::new(vec![JointSet::first(2)], 0).unwrap();
    let inner = drift(&rig, &clips[0]);
    let mut control = LoaController::new(&rig, range, TransitionOptions::default(), inner);
    player.control(&mut control, seen_at(1000.0));
    let start = player.pose().clone();
    let mut moved = JointSet::EMPTY;
    for _ in 0..60 {
        player.advance(1.0 / 60.0, &mut |_| {});
        let report = player.control(&mut control, seen_at(1000.0));
        assert!(report.sampled.difference(&JointSet::first(2)).is_empty());
        assert_eq!(
            report.bound_px, None,
            "what is not allowed to move has no bound"
        );
        moved = moved.union(&report.updated);
    }
    assert_eq!(moved, JointSet::first(2));
    assert_eq!(player.pose().get(3), start.get(3));
    // Far away the metric holds also what the articulation allows.
    let mut updates = 0;
    for _ in 0..60 {
        player.advance(1.0 / 60.0, &mut |_| {});
        updates += player.control(&mut control, seen_at(0.5)).updated.len();
    }
    assert!(updates < 30, "{updates} updates");
    // All may move again: joints 2 and 3 come in a transition.
    control.articulate(rig.all());
    player.advance(1.0 / 60.0, &mut |_| {});
    let report = *player.control(&mut control, seen_at(1000.0));
    assert!(report.in_transition.contains(2) && report.in_transition.contains(3));
}

fn table(clip: &Clip, mode: KeyMode, every: u32) -> KeyTable {
    let keys = |every: u32| -> Vec<u32> { (0..=60).step_by(every as usize).collect() };
    let joint = |j: usize| {
        if j == 0 {
            vec![vec![], vec![]]
        } else {
            vec![keys(every), keys(2 * every)]
        }
    };
    KeyTable {
        hashes: TableHashes::default(),
        rate_hz: clip.rate_hz(),
        frames: clip.frames() as u32,
        base_metres: 0.01,
        mode,
        keys: (0..clip.joints()).map(joint).collect(),
    }
}

#[test]
fn tables_show_the_span_of_the_nearest_stored_tolerance() {
    let rig = chain(3);
    let clips = [swinging(3)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let value = |joint: usize, frame: usize| clips[0].tracks().rotations[joint].values[frame];
    for mode in [KeyMode::Hold, KeyMode::Linear] {
        let table = Arc::new(table(&clips[0], mode, 5));
        // 1 px at 200, 80, 40 px/m is 5, 12.5 and 25 mm: evaluated, level 0, level 1.
        for (scale, every) in [(200.0, None), (80.0, Some(5)), (40.0, Some(10))] {
            let keys = StoredKeys::new(&clips[0], table.clone()).unwrap();
            let mut control = TableController::new(vec![Some(keys)], vec![1.0; 3], 1.0);
            let mut player = FigurePlayer::new(model.clone(), &[]);
            let mut updates = 0;
            for frame in 0..60 {
                let state = ClipState::new(&*model, 0).at_secs(&*model, frame as f32 / 30.0);
                player.advance_to(f64::from(frame) / 30.0, frame as f32 / 30.0);
                let report = *player.control(&mut control, seen_at(scale));
                assert_eq!(report.held.union(&report.updated), rig.all());
                updates += report.updated.difference(&JointSet::first(1)).len();
                let at = (state.secs() * 30.0).round() as usize;
                assert!(player.pose().rotations[0].dot(value(0, at)) > 0.999_99);
                let expected = match every {
                    None => value(2, at),
                    Some(every) => {
                        let from = at - at % every;
                        let u = (at - from) as f32 / every as f32;
                        match mode {
                            KeyMode::Hold => value(2, from),
                            KeyMode::Linear => nlerp(value(2, from), value(2, from + every), u),
                        }
                    }
                };
                let off = angle_between(player.pose().rotations[2], expected);
                assert!(off < 1e-4, "{mode:?} at {scale} px/m, frame {at}: {off}");
            }
            assert_eq!(updates, 2 * 60 / every.unwrap_or(1));
        }
        let mut other = KeyTable::clone(&table);
        other.frames = 60;
        assert_eq!(StoredKeys::new(&clips[0], other).unwrap_err().at, "frames");
        other = Arc::unwrap_or_clone(table);
        other.keys[2][0].push(61);
        assert_eq!(StoredKeys::new(&clips[0], other).unwrap_err().at, "keys[2]");
    }
}

/// Between the last frame of a key and the next key there is no jump: the tolerance holds at any
/// display rate.
#[test]
fn held_keys_keep_the_tolerance_between_frames() {
    let rig = chain(3);
    let clips = [swinging(3)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    // Keys as preparation makes them: renewed as soon as the error exceeds 10 mm.
    let held = |joint: usize| {
        let values = &clips[0].tracks().rotations[joint].values;
        let mut keys = vec![0u32];
        for (frame, value) in values.iter().enumerate() {
            let last = values[keys[keys.len() - 1] as usize];
            if LEVER * angle_between(last, *value) > 0.01 {
                keys.push(frame as u32);
            }
        }
        vec![keys]
    };
    let stored = KeyTable {
        keys: (0..3).map(held).collect(),
        ..table(&clips[0], KeyMode::Hold, 5)
    };
    let keys = StoredKeys::new(&clips[0], stored).unwrap();
    let mut control = TableController::new(vec![Some(keys)], vec![1.0; 3], 1.0);
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let mut blended = 0;
    for frame in 0..600 {
        player.advance(1.0 / 144.0, &mut |_| {});
        let report = *player.control(&mut control, seen_at(100.0));
        blended += report.updated.len();
        let error = error_px(&player, &rig, &clips, 100.0);
        assert!(error <= 1.0 + 1e-2, "{error} px in frame {frame}");
    }
    assert!(blended < 3 * 600, "some frames show held keys alone");
}

#[test]
fn the_thesis_looks_up_as_often_as_told_and_by_the_distance_of_the_frame() {
    let rig = chain(2);
    let clips = [swinging(2)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    // Joint 1 has the error 0.5 in odd frames, 0.1 in even ones; joint 0 always moves.
    let values = (0..=60).flat_map(|i| [1.0, if i % 2 == 1 { 0.5 } else { 0.1 }]);
    let matrix = Arc::new(ErrorMatrix::new(2, values.collect()).unwrap());
    assert!(ErrorMatrix::new(2, vec![0.0; 3]).is_err());
    assert!(matrix.frame(99).is_empty());
    let at_once = TransitionOptions {
        secs: 0.0,
        ..TransitionOptions::default()
    };
    let states = |threshold: Threshold, every: usize, distance_metres: f32| {
        let mut control =
            ThesisController::new(&rig, vec![Some(matrix.clone())], threshold, every, at_once);
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let views = FigureViews::Parallel {
            pixels_per_metre: 1.0,
            distance_metres,
            directions: &[],
        };
        let frame = |i: usize| {
            if i > 0 {
                player.advance(1.0 / 30.0, &mut |_| {});
            }
            player.control(&mut control, views).updated.contains(1)
        };
        (0..8).map(frame).collect::<Vec<bool>>()
    };
    let constant = Threshold::constant(0.3);
    let (t, f) = (true, false);
    assert_eq!(states(constant, 1, 1.0), [t, t, f, t, f, t, f, t]);
    // Consulted at frames 3 and 6: 0.5 keeps it going, 0.1 stops it.
    assert_eq!(states(constant, 3, 1.0), [t, t, t, t, t, t, f, f]);
    let by_distance = Threshold {
        thr_init: 0.05,
        thr_max: 0.6,
        ..Threshold::default()
    };
    assert_eq!(states(by_distance, 1, 0.1), [t; 8]);
    assert_eq!(states(by_distance, 1, 16.0), [t, f, f, f, f, f, f, f]);
}

/// Between two frames the figure moves as the entry of the later one says.
#[test]
fn the_thesis_reads_the_entry_of_the_motion_under_way() {
    let rig = chain(1);
    let clips = [swinging(1)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    // It moves into frame 2 only.
    let values = (0..=60).map(|i| if i == 2 { 1.0 } else { 0.0 });
    let matrix = Arc::new(ErrorMatrix::new(1, values.collect()).unwrap());
    let at_once = TransitionOptions {
        secs: 0.0,
        ..TransitionOptions::default()
    };
    let threshold = Threshold::constant(0.5);
    let mut control =
        ThesisController::new(&rig, vec![Some(matrix.clone())], threshold, 1, at_once);
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let moving = [0.0f32, 0.5, 1.0, 1.5, 2.0, 2.5].map(|frame| {
        player.advance_to(f64::from(frame) / 30.0, frame / 30.0);
        !player
            .control(&mut control, seen_at(1.0))
            .updated
            .is_empty()
    });
    assert_eq!(moving, [true, false, false, true, true, false]);
}

/// A matrix of keys, in a clip with two frames for each key.
#[test]
fn the_thesis_reads_keys_of_a_clip_that_is_sampled_more_densely() {
    let rig = chain(1);
    let clips = [swinging(1).with_frames_per_key(2)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    // It moves into key 2, frame 4, only.
    let values = (0..=30).map(|i| if i == 2 { 1.0 } else { 0.0 });
    let matrix = Arc::new(ErrorMatrix::new(1, values.collect()).unwrap());
    let at_once = TransitionOptions {
        secs: 0.0,
        ..TransitionOptions::default()
    };
    let threshold = Threshold::constant(0.5);
    let mut control = ThesisController::new(&rig, vec![Some(matrix)], threshold, 1, at_once);
    let mut player = FigurePlayer::new(model, &[]);
    let moving = [0.0f32, 1.0, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 60.0].map(|frame| {
        player.advance_to(f64::from(frame) / 30.0, frame / 30.0);
        let control = player.control(&mut control, seen_at(1.0));
        !control.updated.is_empty()
    });
    assert_eq!(
        moving,
        [true, false, false, true, true, true, true, false, false]
    );
}

#[test]
fn the_threshold_is_renewed_before_a_moving_camera() {
    let rig = chain(2);
    let clips = [swinging(2)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let matrix = Arc::new(ErrorMatrix::new(2, [1.0, 0.3].repeat(61)).unwrap());
    let threshold = Threshold {
        thr_init: 0.0,
        thr_max: 1.0,
        ..Threshold::default()
    };
    let opts = TransitionOptions::default();
    let mut control = ThesisController::new(&rig, vec![Some(matrix.clone())], threshold, 1, opts);
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let mut active = Vec::new();
    for distance in [2.0f32, 2.0, 14.0, 14.0, 2.0] {
        let camera = Camera::looking_at(Vec3::Z * distance, Vec3::ZERO, Viewport::default());
        player.control(&mut control, FigureViews::Cameras(&[camera]));
        player.advance(0.4, &mut |_| {});
        active.push(player.report().updated.contains(1));
    }
    // (14 / 16)² is above 0.3: a transition of 200 ms, over at the next frame.
    assert_eq!(active, [true, true, true, false, true]);
}

#[test]
fn no_frame_allocates() {
    let rig = chain(6);
    let clips = [swinging(6), turning(6, 0.1)];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let key_table = table(&clips[0], KeyMode::Linear, 5);
    let keys = StoredKeys::new(&clips[0], key_table).unwrap();
    let matrix = Arc::new(ErrorMatrix::new(6, vec![0.5; 6 * 61]).unwrap());
    let opts = TransitionOptions {
        policy: PassivePolicy::Rest,
        ..TransitionOptions::default()
    };
    let levels = || LoaRange::new(vec![rig.all(), JointSet::first(2)], 0).unwrap();
    let moments = vec![SecondMoment::default(); 6];
    let seeing = drift(&rig, &clips[0]).with_second_moments(moments);
    let thesis = ThesisController::new(
        &rig,
        vec![Some(matrix), None],
        Threshold::default(),
        2,
        opts,
    );
    let tables = TableController::new(vec![Some(keys), None], vec![1.0; 6], 1.0);
    let mut controllers: Vec<Box<dyn MotionController>> = vec![
        Box::new(FullDetail::default()),
        Box::new(LoaController::new(
            &rig,
            levels(),
            opts,
            FullDetail::default(),
        )),
        Box::new(seeing.clone()),
        Box::new(tables.clone()),
        Box::new(thesis.clone()),
        Box::new(LoaController::new(&rig, levels(), opts, seeing)),
        Box::new(LoaController::new(&rig, levels(), opts, thesis)),
    ];
    let mesh = articula_core::Mesh::default();
    let groups = GroupedSkin::new(&mesh);
    let mut skin = FigureSkin::new(mesh, groups);
    let camera = Camera::looking_at(Vec3::Z * 5.0, Vec3::Y, Viewport::default());
    let over = CharacterState::from(ClipState::new(&*model, 1));
    let layer = MotionLayer::new(over, vec![0.5; 6], LayerMode::Override).unwrap();
    for control in &mut controllers {
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let top = player.add_layer(layer.clone()).unwrap();
        let counted = allocation_counter::measure(|| {
            for i in 0..90 {
                player.advance(1.0 / 60.0, &mut |_| {});
                player.layer_mut(top).unwrap().weight = f32::from(u8::from(i % 9 == 0));
                if i == 40 {
                    player.fade_to(ClipState::new(&*model, 1), 0.2);
                }
                player.control(control.as_mut(), FigureViews::Cameras(&[camera]));
                player.edit(&mut |pose| pose.rotations[0] = Quat::IDENTITY);
                player.hierarchy();
                skin.skin(player.model_pose(), &[]);
            }
        });
        assert_eq!(counted.count_total, 0);
    }
    let mut loa = LoaController::new(&rig, levels(), opts, FullDetail::default());
    let counted = allocation_counter::measure(|| {
        loa.request(1);
    });
    assert_eq!(counted.count_total, 0);
}

/// A session of a server or a component of an engine holds all of them from frame to frame.
#[test]
fn what_is_kept_from_frame_to_frame_borrows_nothing() {
    fn is_owned<T: Send + Sync + 'static>() {}
    is_owned::<FigureModel>();
    is_owned::<FigurePlayer>();
    is_owned::<FigureSkin>();
    is_owned::<MotionLayer>();
    is_owned::<FullDetail>();
    is_owned::<DriftController>();
    is_owned::<StoredKeys>();
    is_owned::<TableController>();
    is_owned::<ThesisController>();
    is_owned::<LoaController<TableController>>();
}

/// The thesis compares neighbouring frames. Its values are divided by the clip's maximum; one quick
/// joint in the same clip puts a slow one permanently below every threshold.
#[test]
fn a_slow_turn_is_never_followed_by_the_thesis() {
    let rig = chain(1);
    // One degree per second for a minute.
    let frames = 60 * 30 + 1;
    let values = (0..frames).map(|i| Quat::from_rotation_x((i as f32 / 30.0).to_radians()));
    let tracks = Tracks {
        rotations: vec![Track {
            target: 0,
            step: false,
            values: values.collect(),
        }],
        ..Tracks::default()
    };
    let clips = [Clip::new("slow", 30.0, frames, 1, tracks).unwrap()];
    let model = Arc::new(FigureModel::new(rig.clone(), &clips).unwrap());
    let slow_of_quick = (1.0f32 / 30.0).to_radians() / 2.0f32.to_radians() * 0.01;
    let matrix = Arc::new(ErrorMatrix::new(1, vec![slow_of_quick; frames]).unwrap());
    let at_once = TransitionOptions {
        secs: 0.0,
        ..TransitionOptions::default()
    };
    let threshold = Threshold::constant(1e-3);
    let mut control =
        ThesisController::new(&rig, vec![Some(matrix.clone())], threshold, 1, at_once);
    let mut player = FigurePlayer::new(model.clone(), &[]);
    let mut worst: f32 = 0.0;
    for frame in 0..frames - 1 {
        player.advance_to(f64::from(frame as u32) / 30.0, frame as f32 / 30.0);
        player.control(&mut control, seen_at(1.0));
        worst = worst.max(error_px(&player, &rig, &clips, 1.0) / LEVER);
    }
    assert_eq!(control.states().state(0), JointState::Passive);
    assert!(
        worst > 59.0f32.to_radians(),
        "frozen at the first frame, {worst} rad away at last"
    );
}
