//! Clips of standing: idle, and waving a hand. The feet stay in place.

use crate::leg::{Foothold, stand};
use crate::motion::{Pose, Side, cycle};
use crate::skeleton::{centers, joint};
use crate::weights::smooth_step;
use articula_core::source::RawClip;
use glam::Vec3;
use std::f32::consts::TAU;

/// The idle clip of four seconds: breathing, shifting weight, small head turns.
pub(crate) fn idle() -> RawClip {
    cycle("idle", 120, |phase| standing(phase, 1.0))
}

/// The wave clip: the right hand rises, waves three times and is lowered.
pub(crate) fn wave() -> RawClip {
    cycle("wave", 84, |phase| {
        let mut pose = standing(phase, 0.6);
        raise(&mut pose, phase);
        pose
    })
}

/// Standing pose: one sway of the body and two breaths per cycle, all periodic.
pub(crate) fn standing(phase: f32, amount: f32) -> Pose {
    let once = |offset: f32| amount * (TAU * (phase - offset)).sin();
    let twice = |offset: f32| (2.0 * TAU * (phase - offset)).sin();
    let (shift, breath) = (once(0.0), twice(0.0));
    let mut pose = Pose::rest();
    pose.root += Vec3::new(
        0.012 * shift,
        -0.007 - 0.002 * amount * twice(0.12).abs().powi(2),
        0.003 * once(0.3),
    );
    pose.turn(0, [0.4 * once(0.1), 0.8 * once(0.2), 1.1 * shift]);
    pose.turn_spine("vl5", "vt12", [0.6, 0.0, -1.5 * shift]);
    pose.turn_spine(
        "vt11",
        "vt1",
        [-0.9 * breath, -0.6 * once(0.2), 0.2 * shift],
    );
    pose.turn_spine("vc7", "vc1", [0.5 * breath, 1.8 * once(0.31), 0.3 * shift]);
    pose.turn(
        joint("skullbase"),
        [0.7 * once(0.45), 1.2 * once(0.33), 0.2 * shift],
    );
    for side in Side::BOTH {
        pose.turn_side(side, "sternoclavicular", [0.0, 0.0, 0.9 * breath]);
        pose.turn_side(
            side,
            "shoulder",
            [
                0.8 * once(0.15) - 1.5,
                2.0,
                0.9 - 0.6 * breath - 0.5 * shift * side.sign(),
            ],
        );
        pose.turn_side(side, "elbow", [-7.0 - 1.2 * once(0.22), 0.0, 0.0]);
        pose.curl(
            side,
            8.0 + 2.5 * once(if side == Side::Left { 0.4 } else { 0.62 }),
        );
        let ankle = centers()[side.joint("ankle")];
        stand(
            &mut pose,
            side,
            Foothold {
                ankle,
                pitch: 0.0,
                toes: 0.0,
            },
        );
    }
    pose
}

/// Share of the wave clip in which the arm is raised; lowering takes as long.
const RAISE: f32 = 0.27;

fn raise(pose: &mut Pose, phase: f32) {
    let up = smooth_step(0.03, RAISE, phase) * smooth_step(0.97, 1.0 - RAISE, phase);
    // The elbow leads while rising, so that the hand does not sweep far out.
    let lead = smooth_step(0.03, 0.8 * RAISE, phase) * smooth_step(0.97, 1.0 - 0.8 * RAISE, phase);
    let waving = smooth_step(0.2, 0.32, phase) * smooth_step(0.82, 0.7, phase);
    let beat = waving * (TAU * 3.0 * (phase - 0.245) / 0.51).sin();
    let lag = waving * (TAU * 3.0 * (phase - 0.275) / 0.51).sin();
    let side = Side::Right;
    pose.turn_side(side, "sternoclavicular", [0.0, 0.0, 8.0 * up]);
    pose.turn_side(side, "acromioclavicular", [0.0, 0.0, 5.0 * up]);
    pose.turn_side(side, "shoulder", [-14.0 * up, 62.0 * up, 0.0]);
    let raised = glam::Quat::from_rotation_z(-(52.0 * up).to_radians());
    let shoulder = side.joint("shoulder");
    pose.rotations[shoulder] = raised * pose.rotations[shoulder];
    pose.turn_side(side, "elbow", [-112.0 * lead + 19.0 * beat, 22.0 * up, 0.0]);
    pose.turn_side(side, "wrist", [6.0 * up + 13.0 * lag, 0.0, 6.0 * up]);
    pose.curl(side, -7.0 * up);
    pose.turn_spine("vl5", "vt1", [0.0, 2.0 * up, 2.5 * up]);
    pose.turn_spine("vc7", "vc1", [0.0, -2.0 * up, -2.0 * up + 0.8 * lag]);
}
