//! Walking in place, as on a treadmill: the feet determine the pose of the body.
//!
//! Source: the common description of gait (stance for 62 % of the cycle, heel strike, foot flat,
//! heel off, toe off); angles and distances are chosen within the range of published curves.

use crate::leg::{Foothold, stand};
use crate::motion::{Pose, Side, cycle};
use crate::skeleton::{centers, joint};
use crate::weights::smooth_step;
use articula_core::source::RawClip;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Number of frames of one cycle (two steps).
const FRAMES: usize = 32;
/// Speed of the ground in m/s.
const SPEED: f32 = 1.3;
/// Distance covered in one cycle, in metres.
const STRIDE: f32 = SPEED * FRAMES as f32 / 30.0;
/// Share of the cycle during which a foot is on the ground.
const STANCE: f32 = 0.62;
/// Phases at which the foot is flat and at which the heel leaves the ground.
const FLAT: f32 = 0.11;
const HEEL_OFF: f32 = 0.34;
/// Phase at which the ankle passes under the hip.
const UNDER: f32 = 0.245;
/// Foot pitch at heel strike and at toe off, in radians.
const STRIKE: f32 = -0.33;
const TOE_OFF: f32 = 0.85;
/// z at which heel and ball touch the floor at rest.
const HEEL: f32 = -0.068;
const BALL: f32 = 0.094;

/// The walk clip; one cycle.
pub(crate) fn walk() -> RawClip {
    cycle("walk", FRAMES, pose)
}

fn pose(phase: f32) -> Pose {
    let wave = |offset: f32| (TAU * (phase - offset)).sin();
    let (step, sway) = ((TAU * phase).cos(), wave(0.02));
    let bob = -0.038 - 0.019 * (2.0 * TAU * (phase - 0.055)).cos();
    let mut pose = Pose::rest();
    pose.root += Vec3::new(0.017 * sway, bob, 0.006 * (2.0 * TAU * phase).sin());
    // The hip of the front leg moves ahead; the swinging side drops.
    pose.turn(0, [2.0, -5.5 * step, 2.6 * sway]);
    pose.turn_spine("vl5", "vt1", [4.5, 11.0 * step, -3.8 * sway]);
    pose.turn_spine("vc7", "vc1", [-3.5, -4.0 * step, 0.8 * sway]);
    pose.turn(joint("skullbase"), [-2.0, -1.5 * step, 0.4 * sway]);
    for side in Side::BOTH {
        let phase = (phase + if side == Side::Left { 0.0 } else { 0.5 }).fract();
        swing_arm(&mut pose, side, phase);
        stand(&mut pose, side, foothold(side, phase));
    }
    pose
}

/// The arm swings against the leg of its side; the elbow bends more in front.
fn swing_arm(pose: &mut Pose, side: Side, phase: f32) {
    let back = (TAU * (phase - 0.02)).cos();
    let late = (TAU * (phase - 0.07)).cos();
    pose.turn_side(side, "sternoclavicular", [0.0, 2.5 * back, 0.0]);
    pose.turn_side(side, "shoulder", [13.0 * back + 3.0, 4.0, 0.5]);
    pose.turn_side(side, "elbow", [-22.0 + 8.0 * late, 0.0, 0.0]);
    pose.turn_side(side, "wrist", [2.0 * late, 0.0, -3.0]);
    pose.curl(side, 9.0 - 2.0 * late);
}

/// Target of a foot at a phase of its own cycle, which begins with its heel strike.
fn foothold(side: Side, phase: f32) -> Foothold {
    if phase <= STANCE {
        on_ground(side, phase)
    } else {
        in_air(side, phase)
    }
}

fn on_ground(side: Side, phase: f32) -> Foothold {
    let rest = centers()[side.joint("ankle")];
    let landing = STRIKE * (1.0 - smooth_step(0.0, FLAT, phase));
    let rising = TOE_OFF * ((phase - HEEL_OFF) / (STANCE - HEEL_OFF)).max(0.0).powi(2);
    let (pivot, pitch) = if phase < FLAT {
        (HEEL, landing)
    } else {
        (BALL, rising)
    };
    let pivot = Vec3::new(rest.x, 0.0, pivot);
    let ground = STRIDE * (UNDER - phase) - rest.z;
    let ankle = pivot + Quat::from_rotation_x(pitch) * (rest - pivot);
    Foothold {
        ankle: ankle + Vec3::new(-0.012 * side.sign(), 0.0, ground),
        pitch,
        toes: pitch.max(0.0),
    }
}

fn in_air(side: Side, phase: f32) -> Foothold {
    const SLICE: f32 = 0.004;
    let along = (phase - STANCE) / (1.0 - STANCE);
    let (a, b) = (on_ground(side, STANCE), on_ground(side, 0.0));
    let (before, after) = (on_ground(side, STANCE - SLICE), on_ground(side, SLICE));
    let scale = (1.0 - STANCE) / SLICE;
    let (va, vb) = (
        (a.ankle - before.ankle) * scale,
        (after.ankle - b.ankle) * scale,
    );
    let lift = Vec3::Y * (0.027 * (std::f32::consts::PI * along).sin().powi(2));
    let pitch_speed = (a.pitch - before.pitch) * scale;
    Foothold {
        ankle: hermite([a.ankle, va, b.ankle, vb], along) + lift,
        pitch: hermite(
            [a.pitch, pitch_speed * 0.6, b.pitch, 0.0].map(Vec3::splat),
            along,
        )
        .x,
        toes: a.toes * (1.0 - smooth_step(0.1, 0.7, along)),
    }
}

/// Cubic from a value and slope at 0 to a value and slope at 1.
fn hermite([a, da, b, db]: [Vec3; 4], t: f32) -> Vec3 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0)
        + da * (t3 - 2.0 * t2 + t)
        + b * (3.0 * t2 - 2.0 * t3)
        + db * (t3 - t2)
}
