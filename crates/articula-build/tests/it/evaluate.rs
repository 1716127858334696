//! All methods on motions whose results are computed by hand.

use articula_build::ClipOptions;
use articula_build::evaluate::{
    CameraKey, ClipEvaluator, EvaluationSetup, Method, MethodOptions, MethodRun, PathMethod,
    SkinErrors, SkinPxVariant, calibrate, play, play_camera_path, pose_key_frames, sweep,
    uniform_key_frames,
};
use articula_build::levers;
use articula_build::pose_keys;
use articula_build::{Asset, character};
use articula_build::{ChainTolerance, joint_bounds};
use articula_build::{key_table, table_hashes};
use articula_core::playback::{Threshold, ThresholdCurve};
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Primitive, Property, RawClip, RawMesh, Skeleton, Skin,
};
use articula_core::{
    Articulation, DriftOptions, JointArticulation, JointSet, KeyMode, PosedMesh, Region, Track,
    Tracks, Transform, Wrap,
};
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;

pub(crate) const RATE: f32 = 30.0;
pub(crate) const FRAMES: usize = 61;
/// Rotation of the arm per frame, radians.
pub(crate) const STEP: f32 = 0.01;

/// A root, and an arm of one metre along x that turns about z, seen square on from the front.
pub(crate) fn asset() -> Asset {
    let joint = |name: &str, parent| Joint {
        name: name.into(),
        parent,
        rest: Transform::IDENTITY,
        in_skin: true,
    };
    let times: Vec<f32> = (0..FRAMES).map(|i| i as f32 / RATE).collect();
    let turn = |i: usize| Quat::from_rotation_z(STEP * i as f32).to_array();
    let source = Character {
        skeleton: Skeleton {
            joints: vec![joint("root", None), joint("arm", Some(0))],
        },
        meshes: vec![RawMesh {
            name: "arm".into(),
            skin: Skin {
                joints: vec![1],
                inverse_bind: vec![Affine3A::IDENTITY],
            },
            primitives: vec![Primitive {
                positions: vec![Vec3::X, Vec3::X, Vec3::X],
                influences: 1,
                joints: vec![0; 3],
                weights: vec![1.0; 3],
                triangles: vec![[0, 1, 2]],
                ..Primitive::default()
            }],
            ..RawMesh::default()
        }],
        clips: vec![RawClip {
            name: "turn".into(),
            duration_secs: times[FRAMES - 1],
            channels: vec![Channel {
                target: 1,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                values: (0..FRAMES).flat_map(turn).collect(),
                times_secs: times,
            }],
        }],
        ..Character::default()
    };
    let entry = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Arms,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![entry; 2],
    };
    character(&source, Some(articulation), &ClipOptions::default()).unwrap()
}

fn run(method: &Method, parameter: f32) -> MethodRun {
    let asset = asset();
    let setup = EvaluationSetup {
        azimuths_deg: vec![0.0],
        ..EvaluationSetup::default()
    };
    let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, MethodOptions::default());
    assert_eq!(
        stage.moving,
        JointSet::from_iter([1]),
        "the root is never counted"
    );
    play(&stage, method, parameter).0
}

fn near(found: f32, expected: f32) -> bool {
    (found - expected).abs() < 2e-4
}

#[test]
fn every_frame_costs_everything_and_errs_nothing() {
    for method in [Method::SkipHold, Method::SkipLerp] {
        let t = run(&method, 1.0);
        assert_eq!(
            (t.joint_update_gain, t.evaluations_saved, t.joints_sampled),
            (0.0, 0.0, 1.0)
        );
        assert!(t.error.max < 1e-6);
    }
}

#[test]
fn skipping_holds_one_step_less_than_it_skips() {
    // Every fourth of sixty frames: three steps behind at worst, a metre away.
    let t = run(&Method::SkipHold, 4.0);
    assert!(near(t.joint_update_gain, 0.75) && near(t.evaluations_saved, 0.75));
    assert!(near(t.error.max, 3.0 * STEP), "{:?}", t.error);
    // A steady rotation loses nothing under ideal interpolation.
    let t = run(&Method::SkipLerp, 4.0);
    assert!(near(t.joint_update_gain, 0.75) && t.error.max < 1e-5);
}

#[test]
fn ours_holds_as_long_as_the_tolerance_allows() {
    // 35 mm at a metre: three steps of 10 mm are within, the fourth is shown.
    let t = run(&Method::SkinPx(SkinPxVariant::Hold), 0.035);
    assert!(
        near(t.joint_update_gain, 0.75) && near(t.error.max, 3.0 * STEP),
        "{t:?}"
    );
    // A central key covers three and a half steps to either side: runs of eight frames.
    let t = run(&Method::SkinPx(SkinPxVariant::KeyPose), 0.036);
    assert!(
        near(t.joint_update_gain, 1.0 - 7.0 / 60.0) && near(t.error.max, 3.5 * STEP),
        "{t:?}"
    );
    let t = run(&Method::SkinPx(SkinPxVariant::Linear), 0.001);
    assert!(
        near(t.joint_update_gain, 59.0 / 60.0),
        "one blend spans the clip: {t:?}"
    );
    // Without a moving ancestor there is nothing to cancel: closed loop equals hold.
    let hold = run(&Method::SkinPx(SkinPxVariant::Hold), 0.02);
    let closed = run(&Method::SkinPx(SkinPxVariant::ClosedLoop), 0.02);
    assert_eq!(hold.joint_update_gain, closed.joint_update_gain);
}

#[test]
fn what_moves_along_the_line_of_sight_is_held_longer() {
    let asset = asset();
    // The arm points along x at first and turns about z; from the side (along x) its tip at
    // first moves across the line of sight, from straight above it would too; seen along the
    // direction of its own motion (here: y, not a level view) it would not. Level views see
    // the vertical motion wholly, so the two forms agree.
    let setup = EvaluationSetup {
        azimuths_deg: vec![0.0, 90.0],
        ..EvaluationSetup::default()
    };
    let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, MethodOptions::default());
    let (hold, _) = play(&stage, &Method::SkinPx(SkinPxVariant::Hold), 0.035);
    let (view, passes) = play(&stage, &Method::SkinPx(SkinPxVariant::View), 0.035);
    assert_eq!(passes.len(), 2, "one pass for each view");
    assert!(view.joint_update_gain >= hold.joint_update_gain);
    let updates = |p: usize| passes[p].updated.iter().map(JointSet::len).sum::<usize>();
    // From the side the sine of the growing angle hides a part of the motion.
    assert!(
        updates(1) < updates(0),
        "{} from the side, {} from the front",
        updates(1),
        updates(0)
    );
}

#[test]
fn the_thesis_freezes_a_steady_turn_for_ever() {
    // The difference of neighbouring frames is constant: above the threshold always, below it
    // never.
    assert_eq!(run(&Method::Thesis, 0.5).joint_update_gain, 0.0);
    let frozen = run(&Method::Thesis, 1.01);
    assert_eq!(frozen.joint_update_gain, 1.0);
    let chord = 2.0 * (0.5 * STEP * (FRAMES - 1) as f32).sin();
    assert!(
        near(frozen.error.max, chord),
        "{} m, not {chord}",
        frozen.error.max
    );
}

#[test]
fn fixed_levels_hold_what_is_not_in_them() {
    let levels = vec![JointSet::first(2), JointSet::first(1)];
    let all = run(&Method::Loa(levels.clone()), 0.0);
    assert!(all.joint_update_gain == 0.0 && all.error.max < 1e-6);
    let none = run(&Method::Loa(levels), 1.0);
    // The key pose lies halfway: thirty steps to either end.
    assert!(none.joint_update_gain == 1.0 && near(none.error.max, 2.0 * (0.15f32).sin()));
}

#[test]
fn a_held_hand_is_seen_by_the_worst_vertex_and_by_its_part_alone() {
    // The tip of the arm becomes a hand of three vertices on a body of three hundred, which also
    // smiles: a morph target that opens by 0.2 m along the arm at its end.
    let mut asset = asset();
    let (mesh, rig) = (Arc::make_mut(&mut asset.mesh), &asset.rig);
    let mut joints = rig.articulation().joints.clone();
    joints[0].region = Region::Torso;
    joints[1].region = Region::Hands;
    let articulation = Articulation {
        joints,
        ..rig.articulation().clone()
    };
    mesh.bindings.push(articula_core::Binding {
        joint: 0,
        inverse_bind: Affine3A::IDENTITY,
    });
    mesh.positions.extend([Vec3::Y; 300]);
    mesh.normals.extend([Vec3::Z; 300]);
    mesh.binding_indices.extend([1; 300]);
    mesh.weights.extend([1.0; 300]);
    mesh.morph_weights.push(0.0);
    mesh.morphs.push(articula_core::Morph {
        slot: 0,
        vertices: vec![0],
        positions: vec![0.2 * Vec3::X],
        normals: vec![Vec3::ZERO],
    });
    let skeleton = Skeleton {
        joints: (0..2)
            .map(|j| Joint {
                name: rig.name(j).to_owned(),
                parent: rig.parent(j),
                rest: rig.rest_pose().get(j),
                in_skin: true,
            })
            .collect(),
    };
    asset.rig = Arc::new(articula_core::Rig::new(&skeleton, articulation).unwrap());
    let clip = &asset.clips[0];
    let tracks = Tracks {
        morphs: vec![Track {
            target: 0,
            step: false,
            values: (0..FRAMES)
                .map(|i| i as f32 / (FRAMES - 1) as f32)
                .collect(),
        }],
        ..clip.tracks().clone()
    };
    asset.clips[0] = articula_core::Clip::new("turn", RATE, FRAMES, 2, tracks).unwrap();
    let setup = EvaluationSetup {
        azimuths_deg: vec![0.0],
        ..EvaluationSetup::default()
    };
    let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, MethodOptions::default());
    // The whole figure is held in its key pose, half-way: thirty steps to the end, seen from the
    // front, and the opened morph target is 1.2 m from the joint.
    let method = Method::Loa(vec![JointSet::first(1)]);
    let (run, playbacks) = play(&stage, &method, 0.0);
    assert_eq!(
        run.error.max, 0.0,
        "three of three hundred are no percentile"
    );
    let found = stage.skin_errors(&playbacks);
    let chord = |radius: f32| 2.0 * radius * (0.15f32).sin();
    assert!(near(found.worst_vertex, chord(1.2)), "{found:?}");
    let hands = found.hands.unwrap();
    assert!(near(hands.worst_vertex, chord(1.2)));
    // At the end two vertices at 1 m and one at 1.2 m: nine tenths of the way to the last.
    let p95 = chord(1.0) + 0.9 * (chord(1.2) - chord(1.0));
    assert!(near(hands.frames.max, p95), "{hands:?} {p95}");
    assert!(found.face.is_none() && found.feet.is_none());
    // Without a head joint the face is what is given, here the tip and the body; a vertex that the
    // mesh does not have is no part of it.
    let stage = stage.with_face(vec![0, 3, 4, 5000]);
    let with_face = stage.skin_errors(&playbacks);
    let face = with_face.face.unwrap();
    assert!(near(face.worst_vertex, chord(1.2)), "{face:?}");
    // Of three vertices two stand still: nine tenths of the way to the third.
    assert!(near(face.frames.max, 0.9 * chord(1.2)), "{face:?}");
    assert_eq!(
        SkinErrors {
            face: None,
            ..with_face
        },
        found,
        "nothing else changes"
    );
}

#[test]
fn calibration_takes_the_greatest_gain_within_the_limit() {
    let asset = asset();
    let stage = ClipEvaluator::new(
        &asset,
        &asset.clips[0],
        EvaluationSetup::default(),
        MethodOptions::default(),
    );
    let swept = sweep(&stage, &Method::SkipHold);
    // At 45 degrees and 720 px a centimetre is 1 px at 8.69 m: one skipped frame, no more.
    let trial = calibrate(&stage, &Method::SkipHold, &swept, 9.0, 1.0).unwrap();
    assert_eq!(trial.parameter, 2.0);
    let skin = SkinErrors::default();
    let row = stage.row((trial, skin), 9.0);
    assert!(row.error_px.p95 <= 1.0 && row.error_px.p95 > 0.9);
    assert!(near(
        stage.row((trial, skin), 18.0).error_px.p95,
        0.5 * row.error_px.p95
    ));
    assert!(calibrate(&stage, &Method::SkipHold, &[], 9.0, 1.0).is_none());
}

#[test]
fn calibration_finds_the_parameter_between_the_steps_of_the_sweep() {
    let asset = asset();
    let setup = EvaluationSetup {
        azimuths_deg: vec![0.0],
        ..EvaluationSetup::default()
    };
    let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, MethodOptions::default());
    let method = Method::SkinPx(SkinPxVariant::Hold);
    let swept = sweep(&stage, &method);
    // An arm of one metre turns by 10 mm per frame, so n frames are held with a tolerance of 10 n mm
    // and more. The steps of the sweep are 36 % apart: 107 mm lies between two of them.
    let metres = 0.107;
    let limit_px = metres * stage.setup.viewport.pixels_per_metre(9.0);
    let found = calibrate(&stage, &method, &swept, 9.0, limit_px).unwrap();
    let best_step = swept.iter().filter(|run| run.error.p95 <= metres);
    let best_step = best_step
        .map(|run| run.joint_update_gain)
        .fold(0.0, f32::max);
    assert!(found.error.p95 <= metres);
    assert!(found.joint_update_gain > best_step, "{found:?} {best_step}");
    // No parameter does better: not one of a thousand up to twice the limit.
    for i in 1..1000 {
        let (run, _) = play(&stage, &method, 2.0 * metres * i as f32 / 1000.0);
        let is_better = run.error.p95 <= metres && run.joint_update_gain > found.joint_update_gain;
        assert!(!is_better, "{run:?} {found:?}");
    }
}

#[test]
fn tables_are_nested_and_fit_only_their_own_clip() {
    let asset = asset();
    let clip = &asset.clips[0];
    let levers = levers(&asset.rig, &asset.mesh);
    for mode in [KeyMode::Hold, KeyMode::Linear] {
        let table = key_table(&asset, clip, &levers, mode);
        table
            .check(&table_hashes(&asset.rig, clip, &asset.mesh))
            .unwrap();
        let counts: Vec<usize> = table.keys[1].iter().map(Vec::len).collect();
        assert!(counts.windows(2).all(|w| w[1] <= w[0]), "{counts:?}");
        assert!(counts[0] > counts[9] || mode == KeyMode::Linear);
        assert!(
            table.keys[0].iter().all(Vec::is_empty),
            "the root does not move"
        );
    }
    let mut other = asset.clone();
    other.clips[0] = {
        let opts = ClipOptions {
            rate_hz: Some(15.0),
        };
        let source = RawClip {
            duration_secs: 1.0,
            ..RawClip::default()
        };
        clip_of(&asset, source, &opts)
    };
    let table = key_table(&asset, clip, &levers, KeyMode::Hold);
    let e = table
        .check(&table_hashes(&other.rig, &other.clips[0], &other.mesh))
        .unwrap_err();
    assert_eq!(e.at, "hashes.clip");
}

#[test]
fn palettes_blended_between_pose_keys_stay_within_their_level() {
    let asset = asset();
    let clip = &asset.clips[0];
    let keys = pose_keys(&asset, clip, 3, 1);
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    assert_eq!((keys.tick_hz, keys.ticks), (120.0, 240));
    let mut at = |tick: u32| {
        let mut point = [Vec3::ZERO];
        posed
            .pose_at(clip, f64::from(tick) / 120.0, Wrap::Clamp)
            .points(&[0], &mut point);
        point[0]
    };
    // An arc of 0.6 rad leaves its chord by 1 - cos(0.3): 45 mm, level 7 and coarser need no key
    // between the ends. 0.5 mm allow 0.0632 rad, 25 ticks of 0.0025: ten spans at least.
    let counts: Vec<usize> = keys.levels.iter().flatten().map(Vec::len).collect();
    assert_eq!((counts.len(), counts[0], counts[7]), (10, 11, 2));
    for (level, ticks) in keys.levels.iter().flatten().enumerate() {
        assert_eq!((ticks[0], ticks[ticks.len() - 1]), (0, 240));
        for span in ticks.windows(2) {
            for tick in span[0]..=span[1] {
                let u = (tick - span[0]) as f32 / (span[1] - span[0]) as f32;
                let gap = at(span[0]).lerp(at(span[1]), u).distance(at(tick));
                assert!(gap <= keys.base_metres * (1 << level) as f32 + 1e-6);
            }
        }
    }
}

/// The frames of one pass at which whole poses are evaluated: a chord over `n` frames misses the
/// fist's arc by `1 - cos(n / 2 · 0.01)` metres, 1.25 mm for ten frames and 1.5 mm for eleven.
#[test]
fn straight_lines_between_whole_poses_leave_an_arc_as_paper_says() {
    let asset = asset();
    let still = &asset.clips[0];
    // The same arm on a root that jumps over the ground: the camera follows it.
    let thrown = |i: usize| Vec3::new((3.0 * i as f32).sin(), 0.0, (7 * i % 5) as f32);
    let tracks = Tracks {
        rotations: still.tracks().rotations.to_vec(),
        translations: vec![Track {
            target: 0,
            step: false,
            values: (0..still.frames()).map(thrown).collect(),
        }],
        ..Tracks::default()
    };
    let moved = articula_core::Clip::new("thrown", RATE, still.frames(), 2, tracks).unwrap();
    for clip in [still, &moved] {
        let stage = ClipEvaluator::new(
            &asset,
            clip,
            EvaluationSetup::default(),
            MethodOptions::default(),
        );
        let tens: Vec<usize> = (0..=60).step_by(10).collect();
        assert_eq!(pose_key_frames(&stage, 0.0013), tens);
        assert_eq!(uniform_key_frames(&stage, 0.0013), tens);
        // Slightly too little for ten frames: spans of nine, and the remainder of sixty.
        assert_eq!(
            pose_key_frames(&stage, 0.0012),
            [0, 9, 18, 27, 36, 45, 54, 60]
        );
        let all: Vec<usize> = (0..=60).collect();
        assert_eq!(pose_key_frames(&stage, 0.0), all);
        assert_eq!(uniform_key_frames(&stage, 0.0), all);
        assert_eq!(pose_key_frames(&stage, 1.0), [0, 60]);
    }
}

fn with_motion(frames: usize, interpolation: Interpolation, angle: impl Fn(usize) -> f32) -> Asset {
    let mut asset = asset();
    let source = RawClip {
        name: "other".into(),
        duration_secs: (frames - 1) as f32 / RATE,
        channels: vec![Channel {
            target: 1,
            property: Property::Rotation,
            interpolation,
            times_secs: (0..frames).map(|i| i as f32 / RATE).collect(),
            values: (0..frames)
                .flat_map(|i| Quat::from_rotation_z(angle(i)).to_array())
                .collect(),
        }],
    };
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    asset.clips = vec![clip_of(&asset, source, &opts)];
    asset
}

#[test]
fn a_clip_of_ten_minutes_takes_seconds() {
    // A tremor below the tolerance of coarse levels: the longest possible runs.
    let asset = with_motion(18_000, Interpolation::Linear, |i| {
        2e-3 * (0.3 * i as f32).sin()
    });
    let clip = &asset.clips[0];
    let setup = EvaluationSetup {
        points: 3,
        ..EvaluationSetup::default()
    };
    let stage = ClipEvaluator::new(&asset, clip, setup, MethodOptions::default());
    use SkinPxVariant::{ClosedLoop, Hold, KeyPose, Linear, View};
    let ours = [Hold, View, KeyPose, ClosedLoop, Linear].map(Method::SkinPx);
    let levels = Method::Loa(vec![JointSet::EMPTY]);
    let others = [Method::Thesis, Method::Ahn, Method::SkipLerp, levels];
    for method in ours.iter().chain(&others) {
        let harshest = *sweep_end(method);
        let (trial, _) = play(&stage, method, harshest);
        assert!(trial.joint_update_gain > 0.9, "{method:?}: {trial:?}");
    }
    let levers = levers(&asset.rig, &asset.mesh);
    for mode in [KeyMode::Hold, KeyMode::Linear] {
        let table = key_table(&asset, clip, &levers, mode);
        assert!(table.keys[1][9].len() < 100);
    }
    let keys = pose_keys(&asset, clip, 3, 1);
    assert!(keys.levels[9].as_ref().unwrap().len() < 100);
}

fn sweep_end(method: &Method) -> &'static f32 {
    match method {
        Method::SkipLerp => &26.0,
        Method::Loa(_) => &0.0,
        Method::Thesis => &1.1,
        _ => &0.4,
    }
}

#[test]
fn nothing_bounds_the_speed_of_a_jump() {
    let asset = with_motion(9, Interpolation::Step, |i| if i < 4 { 0.0 } else { 1.0 });
    let levers = levers(&asset.rig, &asset.mesh);
    let rest_metres: Vec<f32> = levers.iter().map(|l| l.rest_metres).collect();
    let bounds = joint_bounds(&asset, &asset.clips[0], &rest_metres, ChainTolerance::Whole);
    assert_eq!(bounds[1].speed_metres_per_sec, f32::INFINITY);
    assert_eq!(bounds[0].speed_metres_per_sec, 0.0);
}

#[test]
fn an_open_loop_is_shown_at_once_from_afar_too() {
    let asset = asset();
    let clip = &asset.clips[0];
    let stage = ClipEvaluator::new(
        &asset,
        clip,
        EvaluationSetup::default(),
        MethodOptions::default(),
    );
    let key = |secs| CameraKey {
        secs,
        eye: Vec3::Z * 100.0,
        target: Vec3::ZERO,
    };
    let opts = DriftOptions::default();
    for hz in [24.0, 60.0, 143.0] {
        let run =
            play_camera_path(&stage, &[key(0.0), key(9.0)], hz, &PathMethod::Drift(opts)).unwrap();
        for f in &run.frames {
            let px = f.joint_error_px;
            assert!(px <= opts.bound_px() + 5e-3, "{px} px at {} s", f.secs);
        }
    }
}

/// Test 3 of `docs/methods/motion-lod.md` part 10: one joint turns by a degree a second for a
/// minute, another quickly.
#[test]
fn the_thesis_never_updates_a_slow_joint_beside_a_quick_one() {
    let slow = |i: usize| Quat::from_rotation_z((i as f32 / RATE).to_radians());
    let quick = |i: usize| Quat::from_rotation_x((0.7 * i as f32).sin());
    let joint = |name: &str, parent: Option<usize>| Joint {
        name: name.into(),
        parent,
        rest: Transform::from_translation(Vec3::X),
        in_skin: true,
    };
    let frames = 60 * 30 + 1;
    let channel = |target: usize, turn: &dyn Fn(usize) -> Quat| Channel {
        target,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: (0..frames).map(|i| i as f32 / RATE).collect(),
        values: (0..frames).flat_map(|i| turn(i).to_array()).collect(),
    };
    let source = Character {
        skeleton: Skeleton {
            joints: vec![
                joint("root", None),
                joint("slow", Some(0)),
                joint("quick", Some(0)),
            ],
        },
        clips: vec![RawClip {
            name: "minute".into(),
            duration_secs: 60.0,
            channels: vec![channel(1, &slow), channel(2, &quick)],
        }],
        ..Character::default()
    };
    let mut articulation = asset().rig.articulation().clone();
    articulation.joints.push(articulation.joints[0].clone());
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    let asset = character(&source, Some(articulation), &opts).unwrap();
    let stage = ClipEvaluator::new(
        &asset,
        &asset.clips[0],
        EvaluationSetup::default(),
        MethodOptions::default(),
    );
    let updates = |method: &Method, parameter| {
        let (_, passes) = play(&stage, method, parameter);
        passes[0].updated.iter().filter(|u| u.contains(1)).count()
    };
    // Frame to frame it turns by 6e-4 rad; the quick joint by up to 0.7.
    assert_eq!(updates(&Method::Thesis, 1e-3), 0);
    // A pixel at 5 m is 5.8 mm: with the minimum lever of 10 mm, a correction every 33 degrees.
    let pixel = stage.default_parameter(&Method::SkinPx(SkinPxVariant::Hold), 5.0);
    assert_eq!(updates(&Method::SkinPx(SkinPxVariant::Hold), pixel), 1);
}

/// A clip for the rig of an asset.
pub(crate) fn clip_of(asset: &Asset, source: RawClip, opts: &ClipOptions) -> articula_core::Clip {
    let source = Character {
        skeleton: skeleton_of(asset),
        clips: vec![source],
        ..Character::default()
    };
    let articulation = asset.rig.articulation().clone();
    let built = character(&source, Some(articulation), opts).unwrap();
    built.clips.into_iter().next().unwrap()
}

pub(crate) fn skeleton_of(asset: &Asset) -> Skeleton {
    let joint = |j: usize| Joint {
        name: asset.rig.name(j).to_owned(),
        parent: asset.rig.parent(j),
        rest: asset.rig.rest_pose().get(j),
        in_skin: true,
    };
    Skeleton {
        joints: (0..asset.rig.len()).map(joint).collect(),
    }
}

#[test]
fn a_moving_camera_keeps_the_bound_and_saves_most_from_afar() {
    let asset = asset();
    let stage = ClipEvaluator::new(
        &asset,
        &asset.clips[0],
        EvaluationSetup::default(),
        MethodOptions::default(),
    );
    let key = |secs, z| CameraKey {
        secs,
        eye: Vec3::Z * z,
        target: Vec3::ZERO,
    };
    let opts = DriftOptions::default();
    let run = play_camera_path(
        &stage,
        &[key(0.0, 25.0), key(4.6, 2.0)],
        60.0,
        &PathMethod::Drift(opts),
    )
    .unwrap();
    assert_eq!(run.frames.len(), 277);
    for f in &run.frames {
        // The clip's loop is open: where it jumps, the controller must show the jump at once.
        assert!(
            f.joint_error_px <= opts.bound_px() + 5e-3,
            "{} px at {} s",
            f.joint_error_px,
            f.secs
        );
    }
    let updates = |from: usize, to: usize| {
        run.frames[from..to]
            .iter()
            .map(|f| f.updated.len())
            .sum::<usize>()
    };
    assert!(updates(0, 60) < updates(200, 260), "nearer costs more");
    assert!(play_camera_path(&stage, &[], 60.0, &PathMethod::Drift(opts)).is_none());
}

fn run_with(options: MethodOptions, method: &Method, parameter: f32) -> MethodRun {
    let asset = asset();
    let setup = EvaluationSetup {
        azimuths_deg: vec![0.0],
        ..EvaluationSetup::default()
    };
    let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, options);
    play(&stage, method, parameter).0
}

#[test]
fn stored_tables_are_played_at_the_nearest_stored_tolerance() {
    let tables = Method::SkinPx(SkinPxVariant::Tables);
    // 35 mm are level 6, 32 mm: three steps of 10 mm are within.
    let t = run(&tables, 0.035);
    assert!(
        near(t.joint_update_gain, 0.75) && near(t.error.max, 3.0 * STEP),
        "{t:?}"
    );
    // Below 0.5 mm nothing is stored, so every frame is sampled.
    assert_eq!(run(&tables, 0.0004).joint_update_gain, 0.0);
    // A table of a file is played as it is; one of another clip is not.
    let asset = asset();
    let levers = levers(&asset.rig, &asset.mesh);
    let mut table = key_table(&asset, &asset.clips[0], &levers, KeyMode::Hold);
    table.keys[1] = vec![vec![0, 30]; 10];
    let stage = |table| {
        let clip = &asset.clips[0];
        let (setup, options) = (EvaluationSetup::default(), MethodOptions::default());
        ClipEvaluator::new(&asset, clip, setup, options).with_key_table(table)
    };
    let gain = |table| play(&stage(table), &tables, 0.035).0.joint_update_gain;
    assert!(near(gain(table.clone()), 59.0 / 60.0));
    table.frames += 1;
    assert!(near(gain(table), 0.75));
}

#[test]
fn an_articulation_bounds_what_a_metric_may_choose() {
    let bounded = MethodOptions {
        articulation: Some(JointSet::first(1)),
        ..MethodOptions::default()
    };
    // The arm shows its key pose, thirty steps from either end.
    for method in [Method::SkinPx(SkinPxVariant::Hold), Method::Thesis] {
        let t = run_with(bounded, &method, 1e-6);
        assert_eq!(t.joint_update_gain, 1.0, "{method:?}");
        assert!(near(t.error.max, 2.0 * (0.15f32).sin()), "{t:?}");
    }
    // What may move is left to the metric.
    let free = MethodOptions {
        articulation: Some(JointSet::first(2)),
        ..MethodOptions::default()
    };
    let hold = Method::SkinPx(SkinPxVariant::Hold);
    assert_eq!(run_with(free, &hold, 0.035), run(&hold, 0.035));
}

#[test]
fn a_rarer_look_up_of_the_thesis_changes_its_mind_later() {
    // The normalised error is 1 from the third frame on; before that the arm starts.
    let every = |lookup_every| {
        let options = MethodOptions {
            lookup_every,
            ..MethodOptions::default()
        };
        run_with(options, &Method::Thesis, 1.01).joint_update_gain
    };
    assert_eq!(every(1), 1.0);
    // Frozen at frame 20 only: 19 of 60 updates.
    assert!(near(every(20), 41.0 / 60.0), "{}", every(20));
}

#[test]
fn the_thesis_renews_its_threshold_before_a_moving_camera() {
    let asset = asset();
    let (setup, options) = (EvaluationSetup::default(), MethodOptions::default());
    let stage = ClipEvaluator::new(&asset, &asset.clips[0], setup, options);
    let key = |secs, z| CameraKey {
        secs,
        eye: Vec3::Z * z,
        target: Vec3::ZERO,
    };
    let threshold = Threshold {
        thr_init: 0.1,
        thr_max: 2.0,
        d_min_metres: 3.0,
        d_max_metres: 20.0,
        curve: ThresholdCurve::Fixed,
    };
    let path = [key(0.0, 3.0), key(1.9, 20.0)];
    let run = play_camera_path(&stage, &path, 30.0, &PathMethod::Thesis(threshold)).unwrap();
    // The error of the steady turn is 1: passive from u² = 0.9 / 1.9 on, at 14.7 m.
    let crossing = 3.0 + 17.0 * (0.9f32 / 1.9).sqrt();
    for pair in run.frames.windows(2).skip(3) {
        let far = pair[1].distance_m > crossing;
        assert_eq!(pair[1].updated.is_empty(), far, "{} m", pair[1].distance_m);
    }
    assert!(run.frames[50].error_px > run.frames[20].error_px);
    let none = PathMethod::Loa(JointSet::EMPTY);
    let still = play_camera_path(&stage, &path, 30.0, &none).unwrap();
    assert_eq!(still.joint_update_gain, 1.0);
    for method in [
        PathMethod::Tables(1.0),
        PathMethod::DriftInView(DriftOptions::default()),
    ] {
        let run = play_camera_path(&stage, &path, 30.0, &method).unwrap();
        let bound = method.bound_px().unwrap();
        for frame in &run.frames {
            let scale = stage.setup.viewport.pixels_per_metre(frame.distance_m);
            let most = bound + 1e-4 * scale;
            assert!(
                frame.joint_error_px <= most,
                "{method:?}: {}",
                frame.joint_error_px
            );
        }
        // The arm moves by 0.3 m/s, too fast for the drift controller to freeze it for 100 ms.
        let saves = method == PathMethod::Tables(1.0);
        assert_eq!(run.joint_update_gain > 0.1, saves, "{method:?}");
    }
}
