//! Hands alone, onto a whole figure.

use super::figure::{Human, matrices, posed, reference, rest_pose, rotation};
use articula_build::retarget::{RetargetOptions, RotationOrigin, is_hands_alone, retarget_hands};
use articula_core::angle_between;
use articula_core::source::{RawClip, evaluate};
use glam::{Affine3A, Quat};

/// Fingers of both hands that close and spread.
fn closing(human: &Human) -> RawClip {
    posed(
        human,
        &[
            ("l_index1", |t| Quat::from_rotation_z(0.4 * t)),
            ("l_index2", |t| Quat::from_rotation_z(0.6 * t)),
            ("l_thumb2", |t| Quat::from_rotation_x(0.3 * t)),
            ("r_pinky1", |t| Quat::from_rotation_z(-0.5 * t)),
            ("r_middle3", |t| Quat::from_rotation_z(-0.7 * t)),
            // Of arms, where there are any; the fingers are told against the wrist.
            ("l_elbow", |t| Quat::from_rotation_x(-0.5 * t)),
            ("l_wrist", |t| Quat::from_rotation_x(0.4 * t)),
        ],
    )
}

const HANDS: [&str; 6] = ["wrist", "thumb", "index", "middle", "ring", "pinky"];
const WITH_ARMS: [&str; 8] = [
    "shoulder", "elbow", "wrist", "thumb", "index", "middle", "ring", "pinky",
];

/// The hands of a human and their motion, without the rest of the body but for `parts`.
fn hands(human: &Human, sides: &[&str], parts: &[&str]) -> Human {
    let clip = closing(human);
    let is_of_hand = |name: &str| {
        let of_side = sides.iter().any(|side| name.starts_with(side));
        of_side && parts.iter().any(|part| name[2..].starts_with(part))
    };
    let mut hands = human.without(|name| !is_of_hand(name));
    let moved = clip.channels.into_iter().filter_map(|mut channel| {
        let name = &human.skeleton.joints[channel.target].name;
        let joints = &hands.skeleton.joints;
        channel.target = joints.iter().position(|j| j.name == *name)?;
        Some(channel)
    });
    hands.clips = vec![RawClip {
        name: "closing".to_owned(),
        duration_secs: 2.0,
        channels: moved.collect(),
    }];
    hands
}

/// Rotation of a joint against its wrist at a time.
fn against_wrist(human: &Human, clip: &RawClip, name: &str, time: f32) -> Quat {
    let mut pose = rest_pose(&human.skeleton);
    evaluate::pose(clip, &human.skeleton, time, &mut pose);
    let model = matrices(&human.skeleton, |j| pose.get(j));
    let wrist = human.find(&format!("{}wrist", &name[..2]));
    rotation(&model[wrist]).inverse() * rotation(&model[human.find(name)])
}

#[test]
fn fingers_move_as_those_of_the_capture() {
    let human = reference();
    let whole = closing(&human);
    let turned = |j: usize| Affine3A::from_quat(Quat::from_rotation_y(0.3 + j as f32));
    for (sides, parts) in [
        (&["l_"][..], &HANDS[..]),
        (&["l_", "r_"], &HANDS),
        (&["l_", "r_"], &WITH_ARMS),
    ] {
        // Other axes, and hands that point elsewhere than those of the body.
        let hands = hands(&human, sides, parts).rebound(
            |name| match name {
                "l_wrist" => Quat::from_rotation_x(1.0),
                _ => Quat::IDENTITY,
            },
            turned,
        );
        assert!(is_hands_alone(&hands.figure()) && !is_hands_alone(&human.figure()));
        let options = RetargetOptions::default();
        let made = retarget_hands(&hands.figure(), &human.figure(), &hands.clips[0], &options);
        let made = made.unwrap();
        for name in ["l_index1", "l_index3", "l_thumb2", "r_pinky2", "r_middle3"] {
            let moves = sides.contains(&&name[..2]);
            for time in [0.5, 1.7] {
                let is = against_wrist(&human, &made.clip, name, time);
                let still = against_wrist(&human, &RawClip::default(), name, time);
                let should = if moves {
                    against_wrist(&human, &whole, name, time)
                } else {
                    still
                };
                let off = angle_between(is, should).to_degrees();
                assert!(off < 1.0, "{name} at {time} s is off by {off} degrees");
            }
        }
        let elbow = human.find("l_elbow");
        assert!(made.clip.channels.iter().all(|c| c.target > elbow));
        assert_eq!(made.report.joints[elbow].origin, RotationOrigin::Held);
        let index = human.find("l_index2");
        let RotationOrigin::Mapped { source } = made.report.joints[index].origin else {
            panic!("{:?}", made.report.joints[index]);
        };
        assert_eq!(hands.skeleton.joints[source].name, "l_index2");
    }
}

#[test]
fn a_malformed_clip_of_hands_is_refused() {
    let human = reference();
    let mut hands = hands(&human, &["l_"], &HANDS);
    hands.clips[0].channels[0].target = 900;
    let options = RetargetOptions::default();
    let made = retarget_hands(&hands.figure(), &human.figure(), &hands.clips[0], &options);
    assert!(
        made.unwrap_err()
            .to_string()
            .contains("joint 900 is out of range")
    );
}
