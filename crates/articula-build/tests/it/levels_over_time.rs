//! Levels of articulation over a walk: changes with transitions, and what goes on at no level.

use crate::evaluate::{FRAMES, RATE, STEP, asset, clip_of};
use articula_build::evaluate::{
    ClipEvaluator, EvaluationSetup, LevelSchedule, Method, MethodOptions, RequestedLevel,
    ScheduleFrame, ScheduledLevel, play, play_schedule,
};
use articula_build::{ClipOptions, hold_joints_in_clip};
use articula_core::joint_state::{Ease, PassivePolicy, TransitionOptions};
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{JointSet, Wrap};
use glam::Quat;

/// `loa(None)` in an evaluation and in a reduced clip: nothing moves but the way over the ground
/// and the heading.
#[test]
fn at_no_joint_the_figure_travels_as_in_a_reduced_clip() {
    let asset = asset();
    let turn = |i: usize| {
        let lean = Quat::from_rotation_x(0.1 + 0.3 * (0.2 * i as f32).sin());
        Quat::from_rotation_y(0.03 * i as f32) * lean
    };
    let times: Vec<f32> = (0..FRAMES).map(|i| i as f32 / RATE).collect();
    let channel = |target, property, values| Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: times.clone(),
        values,
    };
    let way = (0..FRAMES).flat_map(|i| [0.01 * i as f32, 0.9, 0.02 * i as f32]);
    let turned = (0..FRAMES).flat_map(|i| turn(i).to_array());
    let waved = (0..FRAMES).flat_map(|i| Quat::from_rotation_z(STEP * i as f32).to_array());
    let source = RawClip {
        name: "walk".into(),
        duration_secs: times[FRAMES - 1],
        channels: vec![
            channel(0, Property::Translation, way.collect()),
            channel(0, Property::Rotation, turned.collect()),
            channel(1, Property::Rotation, waved.collect()),
        ],
    };
    let rate = ClipOptions {
        rate_hz: Some(RATE),
    };
    for policy in [
        PassivePolicy::HoldLast,
        PassivePolicy::Rest,
        PassivePolicy::KeyPose,
    ] {
        for level in [JointSet::EMPTY, JointSet::first(1)] {
            let reduced = hold_joints_in_clip(&asset.rig, &source, &level, policy);
            let expected = clip_of(&asset, reduced, &rate);
            let clip = clip_of(&asset, source.clone(), &rate);
            let options = MethodOptions {
                transition: TransitionOptions {
                    secs: 0.0,
                    policy,
                    ..TransitionOptions::default()
                },
                ..MethodOptions::default()
            };
            let stage = ClipEvaluator::new(&asset, &clip, EvaluationSetup::default(), options);
            let (_, passes) = play(&stage, &Method::Loa(vec![level]), 0.0);
            let mut pose = asset.rig.rest_pose().clone();
            for (frame, shown) in passes[0].shown.iter().enumerate() {
                let secs = frame as f64 / f64::from(RATE);
                articula_core::sample(&expected, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
                for (a, b) in shown.iter().zip(&pose.rotations) {
                    let off = articula_core::angle_between(*a, *b);
                    assert!(off < 1e-3, "{policy:?}, {level:?}, frame {frame}: {off}");
                }
            }
        }
    }
}

/// A figure walks while its level falls and rises, also in the middle of a transition.
#[test]
fn no_joint_jumps_more_than_its_transition_allows() {
    let asset = crate::reference_human::asset_of_2000();
    let clip = asset.clips.iter().find(|c| c.name == "walk").unwrap();
    let (setup, options) = (EvaluationSetup::default(), MethodOptions::default());
    let stage = ClipEvaluator::new(asset, clip, setup, options);
    let at = |secs, level| ScheduledLevel {
        secs,
        level: RequestedLevel::Level(level),
    };
    let hands = JointSet::from_iter([asset.rig.find("l_wrist").unwrap_or(3)]);
    let schedule = LevelSchedule {
        changes: vec![
            at(0.5, 5),
            at(1.0, 0),
            at(1.1, 6),
            at(1.6, 1),
            ScheduledLevel {
                secs: 2.1,
                level: RequestedLevel::Joints(hands),
            },
            at(2.6, 0),
        ],
        finest_allowed: 1,
        display_hz: 60.0,
        tail_secs: 0.5,
        distance_m: 3.5,
    };
    let run = |ease, secs| {
        let transition = TransitionOptions {
            secs,
            ease,
            policy: PassivePolicy::HoldLast,
        };
        play_schedule(&stage, &schedule, transition)
    };
    let none = run(Ease::Linear, 0.0);
    let greatest = |frames: &[ScheduleFrame], of: fn(&ScheduleFrame) -> f32| {
        frames.iter().map(of).fold(0.0, f32::max)
    };
    // The angle that a transition has to bridge at most; a blend turns fastest half-way.
    let gap = greatest(&none, |f| f.gap_radians);
    let most = |slope: f32| slope / 60.0 / 0.2 * 4.0 * (0.25 * gap).tan() + 1e-3;
    for (ease, slope) in [(Ease::Linear, 1.0), (Ease::Smoothstep, 1.5)] {
        let frames = run(ease, 0.2);
        let jump = greatest(&frames, |f| f.jump_radians);
        assert!(
            jump <= most(slope),
            "{ease:?}: {jump} rad, allowed {}",
            most(slope)
        );
        let switched = greatest(&none, |f| f.jump_radians);
        assert!(
            switched > 2.0 * most(slope),
            "without transitions {switched} rad"
        );
        for (frame, plain) in frames.iter().zip(&none) {
            assert_eq!(frame.articulation, plain.articulation);
            // Play starts at the cap of the device, which no change passes.
            assert!(frame.articulation.len() < asset.rig.len());
        }
        let near = |secs: f64| frames.iter().find(|f| f.secs >= secs).unwrap();
        assert!(near(0.75).in_transition == 0 && near(0.6).in_transition > 0);
        assert!(
            near(0.95).error_px > near(0.4).error_px,
            "held joints are off"
        );
        assert!(near(0.95).sampled < near(0.4).sampled);
        assert_eq!(
            near(2.9).articulation,
            frames[0].articulation,
            "level 1 again"
        );
    }
}
