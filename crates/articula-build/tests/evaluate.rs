//! Runs of every method on motions whose answers are known on paper.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use articula_build::character::{Asset, character};
use articula_build::clip::ClipOptions;
use articula_build::evaluate::{
    CameraKey, Method, MethodOptions, Setup, SkinPxVariant, Stage, Trial, calibrate, play,
    play_camera_path, sweep,
};
use articula_build::motion_error::levers::levers;
use articula_build::motion_error::tables::{hashes, key_table};
use articula_core::articulation::{Articulation, JointArticulation, Region};
use articula_core::drift::DriftOptions;
use articula_core::key_table::KeyMode;
use articula_core::loa::JointSet;
use articula_core::math::Transform;
use articula_core::source::{
    Channel, Character, Clip, Interpolation, Joint, Mesh, Primitive, Property, Skeleton, Skin,
};
use glam::{Affine3A, Quat, Vec3};

const RATE: f32 = 30.0;
const FRAMES: usize = 61;
/// Radians that the arm turns in a frame.
const STEP: f32 = 0.01;

/// A root, and an arm of one metre along x that turns about z, seen square on from the front.
fn asset() -> Asset {
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
        meshes: vec![Mesh {
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
            ..Mesh::default()
        }],
        clips: vec![Clip {
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

fn run(method: &Method, parameter: f32) -> Trial {
    let asset = asset();
    let setup = Setup {
        azimuths_deg: vec![0.0],
        ..Setup::default()
    };
    let stage = Stage::new(&asset, &asset.clips[0], setup, MethodOptions::default());
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
    // A steady turn loses nothing to ideal blending.
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
    // A central key serves three and a half steps to either side: runs of eight frames.
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
    let setup = Setup {
        azimuths_deg: vec![0.0, 90.0],
        ..Setup::default()
    };
    let stage = Stage::new(&asset, &asset.clips[0], setup, MethodOptions::default());
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
    // Neighbouring frames always differ alike: above the threshold always, below it never.
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
    // The key pose lies half-way: thirty steps to either end.
    assert!(none.joint_update_gain == 1.0 && near(none.error.max, 2.0 * (0.15f32).sin()));
}

#[test]
fn calibration_takes_the_greatest_gain_within_the_limit() {
    let asset = asset();
    let stage = Stage::new(
        &asset,
        &asset.clips[0],
        Setup::default(),
        MethodOptions::default(),
    );
    let swept = sweep(&stage, &Method::SkipHold);
    // At 45 degrees and 720 px a centimetre is 1 px at 8.69 m: one skipped frame, no more.
    let trial = calibrate(&stage, &swept, 9.0, 1.0).unwrap();
    assert_eq!(trial.parameter, 2.0);
    let row = stage.row(trial, 9.0);
    assert!(row.error_px.p95 <= 1.0 && row.error_px.p95 > 0.9);
    assert!(near(
        stage.row(trial, 18.0).error_px.p95,
        0.5 * row.error_px.p95
    ));
    assert!(calibrate(&stage, &[], 9.0, 1.0).is_none());
}

#[test]
fn tables_are_nested_and_fit_only_their_own_clip() {
    let asset = asset();
    let clip = &asset.clips[0];
    let levers = levers(&asset.rig, &asset.mesh);
    for mode in [KeyMode::Hold, KeyMode::Linear] {
        let table = key_table(&asset, clip, &levers, mode);
        table.check(&hashes(&asset.rig, clip, &asset.mesh)).unwrap();
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
        let source = Clip {
            duration_secs: 1.0,
            ..Clip::default()
        };
        articula_build::clip::resample(&source, &skeleton_of(&asset), &[], &[], &opts).unwrap()
    };
    let table = key_table(&asset, clip, &levers, KeyMode::Hold);
    let e = table
        .check(&hashes(&other.rig, &other.clips[0], &other.mesh))
        .unwrap_err();
    assert_eq!(e.at, "hashes.clip");
}

fn skeleton_of(asset: &Asset) -> Skeleton {
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
    let stage = Stage::new(
        &asset,
        &asset.clips[0],
        Setup::default(),
        MethodOptions::default(),
    );
    let key = |secs, z| CameraKey {
        secs,
        eye: Vec3::Z * z,
        target: Vec3::ZERO,
    };
    let opts = DriftOptions::default();
    let run = play_camera_path(&stage, &[key(0.0, 25.0), key(4.6, 2.0)], 60.0, opts).unwrap();
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
    assert!(play_camera_path(&stage, &[], 60.0, opts).is_none());
}
