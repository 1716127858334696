//! What a report says about a motion.

use super::feet::walking;
use super::figure::{Human, arms_up, as_it_is, reference, retarget};
use articula_build::retarget::{
    RestPose, RetargetFinding, RetargetOptions, RetargetReport, Retargeter,
};
use articula_core::source::{Property, RawClip};
use glam::Quat;

fn report(source: &Human, target: &Human, clip: &RawClip) -> RetargetReport {
    let options = RetargetOptions::default();
    let made = retarget(source.figure(), target.figure(), clip, &options);
    made.unwrap().report
}

#[test]
fn a_good_motion_gives_no_reason_to_look() {
    let human = walking();
    let found = report(&human, &human, human.clip("forward"));
    assert_eq!(found.findings, []);
    assert_eq!(found.source_rest, RestPose::OfFile);
}

#[test]
fn a_first_frame_of_another_pose_is_told() {
    let human = reference();
    let mut clip = human.clip("walk").clone();
    let shoulder = human.find("l_shoulder");
    let channel = clip
        .channels
        .iter_mut()
        .find(|c| c.target == shoulder && c.property == Property::Rotation)
        .unwrap();
    let raised = Quat::from_rotation_z(1.2) * Quat::from_slice(&channel.values[..4]);
    channel.values[..4].copy_from_slice(&raised.to_array());
    let found = report(&human, &human, &clip);
    let (joint, radians) = found.first_frame_jump.unwrap();
    assert_eq!(joint, shoulder);
    assert!((radians - 1.2).abs() < 0.2, "{radians}");
    assert!(matches!(
        found.findings[..],
        [RetargetFinding::FirstFrameJumps(..)]
    ));
}

#[test]
fn joints_that_nothing_drives_are_named() {
    let human = reference();
    let without = |gone: &dyn Fn(&str) -> bool| {
        let mut cut = human.without(gone);
        // A motion of what is left.
        cut.clips = vec![RawClip {
            duration_secs: 1.0,
            ..RawClip::default()
        }];
        cut
    };
    let headless = without(&|name| matches!(name, "skullbase" | "l_elbow"));
    let found = report(&headless, &human, &headless.clips[0]);
    assert_eq!(found.not_driven, ["skullbase", "l_elbow"]);
    let stumps = without(&|name| {
        let ends = ["_knee", "_ankle", "_elbow", "_wrist"];
        ends.iter().any(|end| name.ends_with(end)) || name == "skullbase"
    });
    let pair = Retargeter::new(stumps.figure(), human.figure()).unwrap();
    let missing = pair.not_driven();
    assert_eq!(missing.joints.len(), 7, "{missing:?}");
    assert!((missing.share - 7.0 / 13.0).abs() < 1e-6);
}

#[test]
fn a_rest_pose_that_does_not_stand_is_told() {
    let human = walking();
    let seated = human.rebound(
        |name| match name {
            "l_hip" | "r_hip" => Quat::from_rotation_x(-1.5),
            "l_knee" | "r_knee" => Quat::from_rotation_x(1.5),
            _ => Quat::IDENTITY,
        },
        as_it_is,
    );
    let onto = human.rebound(arms_up(60.0), as_it_is);
    let found = report(&seated, &onto, seated.clip("forward"));
    assert_eq!(found.findings, [RetargetFinding::SourceRestFound]);
    assert!(matches!(found.source_rest, RestPose::Found { .. }));
}
