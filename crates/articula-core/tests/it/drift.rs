//! Properties of the drift controller: acceptance tests 3, 4, 6, 7, 11 and 13 of
//! `docs/methods/motion-lod.md` part 10, no allocation in a frame.

use articula_core::joint_state::{JointState, JointStates, PassivePolicy, TransitionOptions};
use articula_core::source::{self, Joint, MorphTarget, Primitive, Skeleton, Skin};
use articula_core::{
    Articulation, Clip, DriftController, DriftOptions, JointArticulation, JointErrorBounds,
    JointSet, JointViewScales, LocalPose, Mesh, ModelPose, Region, Rig, SkinnedMesh, Track, Tracks,
    Transform, Viewport, Wrap, angle_between, local_to_model, palette, sample, sample_morphs, skin,
};
use glam::{Affine3A, Quat, Vec3};

const LEVER: f32 = 0.3;

/// One joint that rotates about x by `angle(t)`, sampled at `rate`.
fn turning(secs: f32, rate: f32, angle: impl Fn(f32) -> f32) -> Clip {
    let frames = (secs * rate).round() as usize + 1;
    let values = (0..frames)
        .map(|i| Quat::from_rotation_x(angle(i as f32 / rate)))
        .collect();
    let tracks = Tracks {
        rotations: vec![Track {
            target: 0,
            step: false,
            values,
        }],
        ..Tracks::default()
    };
    Clip::new("turn", rate, frames, 1, tracks).unwrap()
}

fn speed_bound(clip: &Clip) -> f32 {
    let keys = &clip.tracks().rotations[0].values;
    // Between frames a normalised blend rotates fastest in the middle: 4 tan(angle / 4).
    let fastest = keys
        .windows(2)
        .map(|w| 4.0 * (angle_between(w[0], w[1]) / 4.0).tan())
        .fold(0.0, f32::max);
    LEVER * fastest * clip.rate_hz()
}

fn rest() -> LocalPose {
    LocalPose::from_iter([Transform::IDENTITY])
}

/// Result of one frame.
#[derive(Clone, Copy)]
struct Shown {
    secs: f64,
    error_px: f32,
    state: JointState,
    updates: u64,
}

/// Plays a clip at a display rate, with the pixels per metre as a function of time.
fn play(clip: &Clip, display_hz: f64, opts: DriftOptions, ppm: impl Fn(f64) -> f32) -> Vec<Shown> {
    let bounds = JointErrorBounds {
        lever_metres: LEVER,
        speed_metres_per_sec: speed_bound(clip),
        share: 1.0,
    };
    let mut drift = DriftController::new(&rest(), vec![bounds], opts);
    let (mut wanted, mut truth) = (rest(), rest());
    let frames = (f64::from(clip.duration_secs()) * display_hz).floor() as usize;
    (0..=frames)
        .map(|i| {
            let secs = i as f64 / display_hz;
            let views = JointViewScales {
                pixels_per_metre: &[ppm(secs)],
                attention: &[1.0],
            };
            let due = drift.due(secs, views);
            sample(clip, secs, Wrap::Clamp, &due, &mut wanted);
            let shown = drift.step(secs, views, &due, &wanted).rotations[0];
            sample(clip, secs, Wrap::Clamp, &JointSet::first(1), &mut truth);
            Shown {
                secs,
                error_px: LEVER * angle_between(shown, truth.rotations[0]) * ppm(secs),
                state: drift.states().state(0),
                updates: drift.updates(),
            }
        })
        .collect()
}

fn still_camera(distance: f32) -> impl Fn(f64) -> f32 {
    move |_| Viewport::default().pixels_per_metre(distance)
}

/// Angles come from f32 quaternions: about 3e-7 rad, some thousandths of a pixel at close range.
const ROUNDING_PX: f32 = 2e-3;

#[test]
fn a_slow_turn_is_followed() {
    let clip = turning(60.0, 30.0, |t| t.to_radians());
    let opts = DriftOptions::default();
    let run = play(&clip, 30.0, opts, still_camera(5.0));
    assert!(
        run.iter()
            .all(|s| s.error_px <= opts.bound_px() + ROUNDING_PX)
    );
    let updates = run.last().unwrap().updates;
    // One degree moves the skin by 5.2 mm, 0.91 px at 5 m: some fifty corrections a minute, not
    // none and not one for each of the 1800 frames.
    assert!((30..900).contains(&updates), "{updates} updates");
}

#[test]
fn hold_times_do_not_depend_on_the_frame_rate() {
    let opts = DriftOptions {
        pop_px: f32::INFINITY,
        ..DriftOptions::default()
    };
    let corrections = |hz: f64| -> Vec<f64> {
        let clip = turning(8.0, hz as f32, |t| 0.15 * t);
        let run = play(&clip, hz, opts, still_camera(6.0));
        run.windows(2)
            .filter(|w| w[1].state == JointState::Passive && w[1].updates > w[0].updates)
            .map(|w| w[1].secs)
            .collect()
    };
    let holds = |hz| {
        corrections(hz)
            .windows(2)
            .map(|w| w[1] - w[0])
            .collect::<Vec<_>>()
    };
    let (slow, mid, fast) = (holds(30.0), holds(60.0), holds(120.0));
    assert!(slow.len() > 10);
    for (a, b) in slow.iter().zip(&mid).chain(slow.iter().zip(&fast)) {
        assert!((a - b).abs() <= 1.0 / 30.0 + 1e-6, "{a} s and {b} s");
    }
}

#[test]
fn an_error_around_the_threshold_does_not_chatter() {
    let opts = DriftOptions::default();
    for amplitude in [0.004f32, 0.008, 0.016, 0.03] {
        for hz in [0.5f32, 1.5, 4.0, 9.0] {
            let clip = turning(10.0, 60.0, |t| {
                amplitude * (std::f32::consts::TAU * hz * t).sin()
            });
            let run = play(&clip, 60.0, opts, still_camera(5.0));
            let moving = |s: &Shown| matches!(s.state, JointState::Active | JointState::ToActive);
            let changes: Vec<f64> = run
                .windows(2)
                .filter(|w| moving(&w[0]) != moving(&w[1]))
                .map(|w| w[1].secs)
                .collect();
            for pair in changes.windows(2) {
                let gap = pair[1] - pair[0];
                assert!(
                    gap >= f64::from(opts.dwell_secs) - 1e-3,
                    "{gap} s at {amplitude} rad, {hz} Hz"
                );
            }
        }
    }
}

#[test]
fn a_nod_of_a_leaf_is_kept_wherever_it_spans_two_pixels() {
    let amplitude = 0.12f32;
    let clip = turning(4.0, 30.0, |t| amplitude * (std::f32::consts::PI * t).sin());
    for distance in [2.0f32, 3.5, 5.65, 9.05, 16.0, 25.6, 40.0] {
        let ppm = Viewport::default().pixels_per_metre(distance);
        let span_px = 2.0 * amplitude * LEVER * ppm;
        let run = play(&clip, 30.0, DriftOptions::default(), still_camera(distance));
        let updates = run.last().unwrap().updates - run[0].updates;
        if span_px > 2.0 {
            assert!(updates >= 2, "{span_px} px at {distance} m were frozen");
        }
        assert!(
            run.iter()
                .all(|s| s.error_px <= DriftOptions::default().bound_px() + ROUNDING_PX)
        );
    }
}

#[test]
fn a_dolly_and_a_cut_never_show_more_than_the_bound() {
    let opts = DriftOptions::default();
    let viewport = Viewport::default();
    let clip = turning(12.0, 30.0, |t| 0.5 * (0.9 * t).sin() + 0.02 * t);
    // 5 m/s from 25 m to 2 m; the same, with the character running towards the camera at 6 m/s.
    for speed in [5.0f64, 11.0] {
        let ppm = move |t: f64| viewport.pixels_per_metre((25.0 - speed * t).max(2.0) as f32);
        for display in [30.0, 60.0, 144.0] {
            for s in play(&clip, display, opts, ppm) {
                assert!(
                    s.error_px <= opts.bound_px() + ROUNDING_PX,
                    "{} px at {} s",
                    s.error_px,
                    s.secs
                );
            }
        }
    }
    let cut = |t: f64| viewport.pixels_per_metre(if t < 3.0 { 40.0 } else { 2.0 });
    for s in play(&clip, 60.0, opts, cut) {
        assert!(
            s.error_px <= opts.bound_px() + ROUNDING_PX,
            "{} px after the cut",
            s.error_px
        );
    }
}

#[test]
fn a_joint_that_suddenly_needs_care_wakes() {
    let opts = DriftOptions::default();
    let ppm = [100.0];
    let clip = turning(8.0, 30.0, |t| 0.05 * t);
    let bounds = JointErrorBounds {
        lever_metres: LEVER,
        speed_metres_per_sec: speed_bound(&clip),
        share: 1.0,
    };
    // As at a foot contact: the tolerance drops to a quarter at once.
    for touch in 60..120 {
        let mut drift = DriftController::new(&rest(), vec![bounds], opts);
        let (mut wanted, mut truth) = (rest(), rest());
        for i in 0..200 {
            let secs = f64::from(i) / 60.0;
            let attention = [if i < touch { 1.0 } else { 0.25 }];
            let views = JointViewScales {
                pixels_per_metre: &ppm,
                attention: &attention,
            };
            let due = drift.due(secs, views);
            sample(&clip, secs, Wrap::Clamp, &due, &mut wanted);
            let shown = drift.step(secs, views, &due, &wanted).rotations[0];
            sample(&clip, secs, Wrap::Clamp, &JointSet::first(1), &mut truth);
            let error_px = LEVER * angle_between(shown, truth.rotations[0]) * ppm[0];
            assert!(
                error_px <= opts.bound_px() * attention[0] + ROUNDING_PX,
                "{error_px} px, touched at {touch}, now {i}"
            );
        }
    }
}

#[test]
fn a_held_joint_does_not_fade_away() {
    // Rotates for a second, then rests: the held pose must stay, whatever the policy is.
    let clip = turning(9.0, 30.0, |t| t.min(1.0));
    let opts = DriftOptions {
        transition: TransitionOptions {
            policy: PassivePolicy::BlendToRest { secs: 0.5 },
            ..TransitionOptions::default()
        },
        ..DriftOptions::default()
    };
    for s in play(&clip, 60.0, opts, still_camera(5.0)) {
        assert!(
            s.error_px <= opts.bound_px() + ROUNDING_PX,
            "{} px at {} s",
            s.error_px,
            s.secs
        );
    }
}

#[test]
fn transitions_are_continuous_even_when_interrupted() {
    let step = 1e-3;
    // A clip slow enough that its own motion and the blend stay below the bound per step: 0.008 rad
    // of range, blended over 200 ms at a rate of at most 1.5 / 0.2 s.
    let clip = turning(4.0, 1000.0, |t| 0.004 * (3.0 * t).sin());
    let mut states = JointStates::new(&rest(), TransitionOptions::default());
    let mut pose = rest();
    let mut before: Option<Quat> = None;
    for i in 0..4000 {
        let secs = f64::from(i) * step;
        sample(&clip, secs, Wrap::Clamp, &JointSet::first(1), &mut pose);
        match i {
            500 | 700 | 1600 | 1650 | 1700 => states.passivate(0, secs, &pose.get(0)),
            // 600 interrupts a transition half-way, and 700 interrupts that one.
            600 | 1500 | 1625 | 1675 | 2400 => states.activate(0, secs),
            _ => {}
        }
        let shown = states.step(secs, &pose).rotations[0];
        if let Some(b) = before {
            let jump = angle_between(b, shown);
            assert!(jump < 1e-4, "{jump} rad within 1 ms at {secs} s");
        }
        before = Some(shown);
    }
}

#[test]
fn a_frame_does_not_allocate() {
    let offsets = [Vec3::ZERO, Vec3::Y, Vec3::Y, Vec3::X];
    let skeleton = Skeleton {
        joints: (0..4)
            .map(|j: usize| Joint {
                name: format!("j{j}"),
                parent: j.checked_sub(1),
                rest: Transform::from_translation(offsets[j]),
                in_skin: true,
            })
            .collect(),
    };
    let joint = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![joint; 4],
    };
    let rig = Rig::new(&skeleton, articulation).unwrap();
    let track = |target| Track {
        target,
        step: false,
        values: (0..31)
            .map(|i| Quat::from_rotation_x(0.05 * i as f32))
            .collect(),
    };
    let tracks = Tracks {
        rotations: (0..4).map(track).collect(),
        ..Tracks::default()
    };
    let clip = Clip::new("c", 30.0, 31, 4, tracks).unwrap();
    let bounds = JointErrorBounds {
        lever_metres: LEVER,
        speed_metres_per_sec: 1.0,
        share: 0.25,
    };
    let mut drift = DriftController::new(rig.rest_pose(), vec![bounds; 4], DriftOptions::default());
    let mut pose = rig.rest_pose().clone();
    let mut model = ModelPose::new(rig.len());
    let views = JointViewScales {
        pixels_per_metre: &[80.0; 4],
        attention: &[1.0; 4],
    };
    let mesh = skinned_triangle();
    let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
    let mut weights = mesh.morph_weights.clone();
    let mut skinned = SkinnedMesh::new(&mesh);
    let counted = allocation_counter::measure(|| {
        for i in 0..120 {
            let secs = f64::from(i) / 60.0;
            let due = drift.due(secs, views);
            sample(&clip, secs, Wrap::Loop, &due, &mut pose);
            sample_morphs(&clip, secs, Wrap::Loop, &mut weights);
            local_to_model(&rig, drift.step(secs, views, &due, &pose), &mut model);
            palette(&mesh, &model, &mut matrices);
            skin(&mesh, &matrices, &weights, &mut skinned);
        }
    });
    assert_eq!(counted.count_total, 0);
}

/// A triangle with one corner on each of the first three joints, and a morph target.
fn skinned_triangle() -> Mesh {
    let source = source::RawMesh {
        name: "triangle".into(),
        skin: Skin {
            joints: vec![0, 1, 2],
            inverse_bind: vec![Affine3A::IDENTITY; 3],
        },
        primitives: vec![Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            influences: 1,
            joints: vec![0, 1, 2],
            weights: vec![1.0; 3],
            triangles: vec![[0, 1, 2]],
            morphs: vec![MorphTarget {
                positions: vec![Vec3::Z; 3],
                normals: vec![],
            }],
            ..Primitive::default()
        }],
        morph_names: vec!["bulge".into()],
        morph_weights: vec![0.5],
        ..source::RawMesh::default()
    };
    Mesh::new(&[source], 4).unwrap()
}
