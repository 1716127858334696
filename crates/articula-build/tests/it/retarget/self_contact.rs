//! Hands that rest on the own body, or meet, on a body of other proportions.

use super::figure::{Human, posed, reference, retarget};
use articula_build::retarget::RetargetOptions;
use articula_core::source::RawClip;
use glam::{Quat, Vec3};

/// A human with short arms and a broad trunk.
fn stout(human: &Human) -> Human {
    human.resized(1.0, |name, offset| match &name[1..] {
        "_elbow" | "_wrist" => 0.8 * offset,
        "_shoulder" => Vec3::new(1.25 * offset.x, offset.y, offset.z),
        _ => offset,
    })
}

fn distance(human: &Human, clip: &RawClip, [a, b]: [&str; 2], time: f32) -> f32 {
    let at = human.positions(clip, time);
    at[human.find(a)].distance(at[human.find(b)])
}

fn made(source: &Human, target: &Human, clip: &RawClip, self_contact: bool) -> RawClip {
    let options = RetargetOptions {
        self_contact,
        ..RetargetOptions::default()
    };
    let made = retarget(source.figure(), target.figure(), clip, &options);
    made.unwrap().clip
}

#[test]
fn hands_that_clap_meet() {
    let human = reference();
    let clip = posed(
        &human,
        &[
            ("l_shoulder", |t| {
                Quat::from_rotation_y(-0.1 - 0.25 * (3.0 * t).cos()) * Quat::from_rotation_x(-1.1)
            }),
            ("r_shoulder", |t| {
                Quat::from_rotation_y(0.1 + 0.25 * (3.0 * t).cos()) * Quat::from_rotation_x(-1.1)
            }),
        ],
    );
    let stout = stout(&human);
    let wrists = ["l_wrist", "r_wrist"];
    let times = (0..60).map(|f| f as f32 / 30.0);
    let closest = times.min_by(|a, b| {
        distance(&human, &clip, wrists, *a).total_cmp(&distance(&human, &clip, wrists, *b))
    });
    let time = closest.unwrap();
    let was = distance(&human, &clip, wrists, time);
    assert!(was < 0.18, "the hands of the motion come near: {was} m");
    let [without, with] = [false, true].map(|keep| {
        let made = made(&human, &stout, &clip, keep);
        distance(&stout, &made, wrists, time)
    });
    assert!(
        (with - was).abs() < 0.01,
        "{was} m, {with} m with the option"
    );
    assert!(
        (without - was).abs() > 0.05,
        "{was} m, {without} m without it"
    );
}

#[test]
fn a_hand_on_the_hip_stays_there() {
    let human = reference();
    let clip = posed(
        &human,
        &[
            ("l_shoulder", |_| {
                Quat::from_rotation_z(0.55) * Quat::from_rotation_x(0.25)
            }),
            ("l_elbow", |_| Quat::from_rotation_z(-1.6)),
            ("vl5", |t| Quat::from_rotation_z(0.1 * (3.0 * t).sin())),
        ],
    );
    let was = distance(&human, &clip, ["l_wrist", "l_hip"], 1.0);
    assert!(was < 0.25, "the hand rests near the hip: {was} m");
    let stout = stout(&human);
    let [without, with] = [false, true].map(|keep| {
        let made = made(&human, &stout, &clip, keep);
        distance(&stout, &made, ["l_wrist", "l_hip"], 1.0)
    });
    assert!(
        with < was + 0.03,
        "{was} m, {with} m with the option, {without} m without"
    );
    assert!(
        without > was + 0.05,
        "{was} m, {without} m without the option"
    );
}

#[test]
fn a_figure_of_the_same_size_moves_as_before() {
    let human = reference();
    for name in ["walk", "wave", "idle"] {
        let clip = human.clip(name);
        let made = made(&human, &human, clip, true);
        for time in [0.0, 0.3, 0.7] {
            let time = time * clip.duration_secs;
            let (was, is) = (human.positions(clip, time), human.positions(&made, time));
            for (was, is) in was.iter().zip(&is) {
                assert!(was.distance(*is) < 3e-3, "{name} at {time} s");
            }
        }
    }
}
