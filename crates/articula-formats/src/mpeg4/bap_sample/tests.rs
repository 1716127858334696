//! BAP on the standard humanoid: joint positions computed by hand, and round trips of any motion.

use crate::mpeg4::bap::{self, BAPS, BapClip, BapError, BapFrame, Motion, TABLE};
use crate::{Limits, ReadOptions, WriteError, bvh, joint_map};
use articula_core::hanim_table::{BODY_JOINTS, JOINTS, find};
use articula_core::source::{Channel, Character, Interpolation, Property, RawClip, evaluate};
use articula_core::{Articulation, LocalPose};
use articula_mutate::Dice;
use glam::{Affine3A, Quat, Vec3};
use real::bytes;

#[path = "../../../tests/it/real/mod.rs"]
mod real;

/// A quarter turn in units of BAP.
const QUARTER: i32 = 157_080;

fn number(name: &str) -> usize {
    TABLE.iter().position(|b| b.name == name).unwrap()
}

/// A clip of one frame with these values.
fn pose(values: &[(&str, i32)]) -> BapClip {
    let mut frame = BapFrame {
        number: 0,
        values: vec![0; BAPS],
    };
    for (name, value) in values {
        frame.values[number(name)] = *value;
    }
    BapClip {
        name: "pose".into(),
        rate_hz: 25.0,
        coded: vec![true; BAPS],
        frames: vec![frame],
    }
}

/// Returns the positions of the joints, by plain matrix products.
fn places(character: &Character, time_secs: f32) -> Vec<Vec3> {
    globals(character, time_secs)
        .iter()
        .map(|m| m.translation.into())
        .collect()
}

fn globals(character: &Character, time_secs: f32) -> Vec<Affine3A> {
    let joints = &character.skeleton.joints;
    let mut local = LocalPose {
        translations: joints.iter().map(|j| j.rest.translation).collect(),
        rotations: joints.iter().map(|j| j.rest.rotation).collect(),
        scales: joints.iter().map(|j| j.rest.scale).collect(),
    };
    if let Some(clip) = character.clips.first() {
        evaluate::pose(clip, &character.skeleton, time_secs, &mut local);
    }
    let mut matrices: Vec<Affine3A> = Vec::new();
    for (index, joint) in joints.iter().enumerate() {
        let own = local.get(index).to_affine();
        matrices.push(joint.parent.map_or(own, |p| matrices[p] * own));
    }
    matrices
}

fn articulation(character: &Character) -> Articulation {
    let map = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
    assert!(map.humanoid);
    map.articulation
}

#[test]
fn at_rest_every_joint_stands_at_its_centre() {
    let character = bap::character(&pose(&[]));
    assert_eq!(character.skeleton.joints.len(), BODY_JOINTS);
    assert!(character.clips[0].channels.is_empty(), "nothing moves");
    for (place, joint) in places(&character, 0.0).iter().zip(&JOINTS) {
        assert!(place.distance(joint.center) < 1e-6, "{}", joint.name);
    }
    let names = articulation(&character);
    for (joint, standard) in names.joints.iter().zip(&JOINTS) {
        assert_eq!(joint.hanim.as_deref(), Some(standard.name));
    }
}

/// Parameters with their values, a joint, and its expected position.
type Case = (&'static [(&'static str, i32)], &'static str, [f32; 3]);

#[test]
fn quarter_turns_by_hand() {
    // Expected positions. Offsets are those of the table, rotated by hand.
    let cases: [Case; 8] = [
        // The hanging left arm (-0.0045, -0.5713, -0.0196) swings forward.
        (
            &[("l_shoulder_flexion", QUARTER)],
            "l_wrist",
            [0.1984, 1.4180, 0.5326],
        ),
        // The right arm rises to the right: about +Z, so with negative values.
        (
            &[("r_shoulder_abduct", -QUARTER)],
            "r_wrist",
            [-0.7742, 1.4331, -0.0583],
        ),
        (
            &[("l_elbow_flexion", QUARTER)],
            "l_wrist",
            [0.1984, 1.1456, 0.2012],
        ),
        // One axis for the whole sagittal plane: a knee bends back with negative values.
        (
            &[("r_knee_flexion", -QUARTER)],
            "r_ankle",
            [-0.1101, 0.5911, -0.3903],
        ),
        // The parent's side comes first: flexion rotates what abduction has raised.
        (
            &[("l_hip_flexion", QUARTER), ("l_hip_abduct", QUARTER)],
            "l_knee",
            [0.5218, 0.9433, -0.0080],
        ),
        // The body turns to its left.
        (
            &[("humanoid_root_rt_body_turn", QUARTER)],
            "l_hip",
            [-0.0278, 0.9124, -0.0684],
        ),
        // Millimetres up, to the left, to the front.
        (
            &[
                ("humanoid_root_tr_vertical", 100),
                ("humanoid_root_tr_lateral", -50),
                ("humanoid_root_tr_frontal", 200),
            ],
            "humanoid_root",
            [-0.05, 0.924, 0.2277],
        ),
        // Fingers curl towards the thigh with negative values, on either side.
        (
            &[("r_index1_flexion", -QUARTER)],
            "r_index2",
            [-0.1531, 0.7781, -0.0248],
        ),
    ];
    for (values, joint, wanted) in cases {
        let places = places(&bap::character(&pose(values)), 0.0);
        let found = places[find(joint).unwrap()];
        // A quarter turn is 1.6e-6 rad more than 157080 units.
        assert!(
            found.distance(Vec3::from(wanted)) < 2e-5,
            "{values:?}: {joint} at {found}"
        );
    }
}

#[test]
fn frame_numbers_are_times() {
    let mut clip = pose(&[("vl5_tilt", 1000)]);
    clip.frames[0].number = 10;
    clip.frames.push(BapFrame {
        number: 60,
        ..clip.frames[0].clone()
    });
    let character = bap::character(&clip);
    let channel = &character.clips[0].channels[0];
    assert_eq!(
        (channel.target, channel.property),
        (find("vl5").unwrap(), Property::Rotation)
    );
    assert_eq!(channel.times_secs, [0.0, 2.0]);
    assert_eq!(character.clips[0].duration_secs, 2.0);
    clip.frames.clear();
    assert!(bap::character(&clip).clips.is_empty());
}

/// Smooth random angles that start at rest; the middle of three stays away from a quarter turn,
/// where two axes coincide.
fn random_clip(dice: &mut Dice, frames: u32) -> BapClip {
    let mut clip = pose(&[]);
    let swings: Vec<(f32, f32)> = TABLE
        .iter()
        .map(|bap| {
            let most = match bap.motion {
                Motion::Turn(_) => 120_000.0,
                Motion::Shift(_) => 2000.0,
            };
            let unit = |dice: &mut Dice| dice.roll(2001) as f32 / 1000.0 - 1.0;
            (most * unit(dice), 0.1 * unit(dice))
        })
        .collect();
    clip.frames = (0..frames)
        .map(|number| {
            let value = |(most, speed): &(f32, f32)| (most * (speed * number as f32).sin()) as i32;
            BapFrame {
                number,
                values: swings.iter().map(value).collect(),
            }
        })
        .collect();
    clip
}

#[test]
fn what_bap_says_comes_back_as_it_was() {
    let mut dice = Dice::new(7);
    let clip = random_clip(&mut dice, 60);
    let character = bap::character(&clip);
    let names = articulation(&character);
    let back = bap::sample(&character, &names, 0, clip.rate_hz).unwrap();
    // Single precision leaves 1e-6 rad per joint, over chains of up to 89 joints.
    assert!(back.residuals.is_empty(), "{:?}", back.residuals);
    for (a, b) in clip.frames.iter().zip(&back.clip.frames) {
        for (bap, (x, y)) in TABLE.iter().zip(a.values.iter().zip(&b.values)) {
            assert!(
                (x - y).abs() <= 3,
                "{} in frame {}: {x} {y}",
                bap.name,
                a.number
            );
        }
    }
    let again = bap::character(&back.clip);
    for frame in 0..60 {
        let time = frame as f32 / clip.rate_hz;
        for (a, b) in places(&character, time).iter().zip(&places(&again, time)) {
            assert!(a.distance(*b) < 2e-4, "{frame}: {a} {b}");
        }
    }
}

/// Returns the standard humanoid with the rotations since rest of a rig's joints, by quaternions.
fn shown_by_the_standard(rig: &Character, only: impl Fn(&str) -> bool) -> Character {
    let names = articulation(rig);
    let source = |name: &str| {
        let mut known = names.joints.iter().map(|j| j.hanim.as_deref());
        known.position(|n| n == Some(name))
    };
    let mut figure = bap::figure();
    let clip = &rig.clips[0];
    let count = (clip.duration_secs * 30.0) as usize;
    let times: Vec<f32> = (0..=count).map(|f| f as f32 / 30.0).collect();
    let mut rest_only = rig.clone();
    rest_only.clips.clear();
    let quat = |m: &Affine3A| m.to_scale_rotation_translation().1;
    let rest: Vec<Quat> = globals(&rest_only, 0.0).iter().map(quat).collect();
    let mut values: Vec<Vec<f32>> = vec![Vec::new(); BODY_JOINTS];
    for time in &times {
        let moved = globals(rig, *time);
        let mut turned: Vec<Quat> = Vec::new();
        for (index, joint) in JOINTS[..BODY_JOINTS].iter().enumerate() {
            let parent = joint.parent.map_or(Quat::IDENTITY, |p| turned[p]);
            let own = source(joint.name).filter(|_| only(joint.name));
            let own = own.map_or(parent, |j| quat(&moved[j]) * rest[j].inverse());
            values[index].extend((parent.inverse() * own).normalize().to_array());
            turned.push(own);
        }
    }
    let channels = values
        .into_iter()
        .enumerate()
        .map(|(target, values)| Channel {
            target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: times.clone(),
            values,
        });
    figure.clips.push(RawClip {
        name: "shown".into(),
        duration_secs: *times.last().unwrap(),
        channels: channels.collect(),
    });
    figure
}

#[test]
fn a_captured_walk_is_as_far_off_as_the_residuals_say() {
    let Some(text) = bytes("bvh/cmu_12_01_walk.bvh") else {
        println!("skipped: no data");
        return;
    };
    let read = bvh::read(&text, &ReadOptions::default(), &Limits::default());
    let walk = read.unwrap().value.character;
    // CMU rests with arms out, the standard with arms down; legs, spine and head agree at rest.
    let figure = shown_by_the_standard(&walk, |joint| {
        let arm = ["clavicular", "shoulder", "elbow", "wrist", "thumb", "index"];
        !arm.iter().any(|part| joint.contains(part))
    });
    let sampled = bap::sample(&figure, &articulation(&figure), 0, 30.0).unwrap();
    let off = |joint: &str| {
        let found = sampled.residuals.iter().find(|r| r.joint == joint);
        found.map_or(1e-4, |r| r.max_radians)
    };
    // Knees and ankles lack one rotation of three, toes two; hips twist to align the knees.
    for residual in &sampled.residuals {
        let part = &residual.joint[2..];
        assert!(
            [
                "hip",
                "knee",
                "ankle",
                "subtalar",
                "midtarsal",
                "metatarsal"
            ]
            .contains(&part),
            "{residual:?}"
        );
        assert!(residual.mean_radians <= residual.max_radians);
    }
    let written = bap::write(&sampled.clip);
    let read = bap::read(&written, bap::AbsentPolicy::Hold, &Limits::default()).unwrap();
    let back = bap::character(&read.value);
    let mut worst = 0.0_f32;
    for frame in 0..=(figure.clips[0].duration_secs * 30.0) as usize {
        let time = frame as f32 / 30.0;
        let (a, b) = (places(&figure, time), places(&back, time));
        // The error of a joint is bounded by the residuals of its ancestors, each times its offset.
        let mut bounds: Vec<f32> = Vec::new();
        for (index, joint) in JOINTS[..BODY_JOINTS].iter().enumerate() {
            let bound = joint.parent.map_or(1e-6, |p| {
                let length = joint.center.distance(JOINTS[p].center);
                bounds[p] + off(JOINTS[p].name) * length + 1e-5
            });
            bounds.push(bound);
            let apart = a[index].distance(b[index]);
            assert!(
                apart <= bound,
                "{} in frame {frame}: {apart} m, {bound}",
                joint.name
            );
            worst = worst.max(apart);
        }
    }
    println!(
        "worst joint {worst} m, worst residual {:?}",
        sampled.residuals.first()
    );
    // Measured: 15 mm at the toes; without aligned hinges 121 mm.
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn figures_that_rest_in_another_pose_are_refused() {
    let mut figure = bap::character(&pose(&[("l_hip_flexion", 10)]));
    let names = articulation(&figure);
    let refused =
        |figure: &Character, clip, rate| bap::sample(figure, &names, clip, rate).unwrap_err();
    assert_eq!(
        refused(&figure, 1, 30.0),
        BapError::Write(WriteError::NoClip { index: 1, count: 1 })
    );
    assert!(matches!(refused(&figure, 0, 0.0), BapError::Write(_)));
    figure.clips[0].duration_secs = 1e9;
    assert!(matches!(
        refused(&figure, 0, 30.0),
        BapError::TooLong { .. }
    ));
    figure.clips[0].duration_secs = 0.0;
    let arm = find("l_shoulder").unwrap();
    figure.skeleton.joints[arm].rest.rotation = Quat::from_rotation_z(1.4);
    let error = refused(&figure, 0, 30.0);
    assert!(
        matches!(
            error,
            BapError::Rest {
                joint: "l_shoulder",
                ..
            }
        ),
        "{error}"
    );
    assert!(
        error.to_string().contains("differs by 80 degrees"),
        "{error}"
    );
    let mut nameless = names.clone();
    nameless.joints[0].hanim = None;
    assert_eq!(
        bap::sample(&figure, &nameless, 0, 30.0),
        Err(BapError::NoRoot)
    );
    nameless.joints.pop();
    assert!(matches!(
        bap::sample(&figure, &nameless, 0, 30.0),
        Err(BapError::Articulation { .. })
    ));
}
