//! Poses over time, and clips made from them: common parts of the three motions.
//!
//! Angles are given for the left side; the right side uses the mirror image, so that one function
//! poses both.

use crate::skeleton::{centers, joint, skeleton};
use articula_core::hanim_table::{BODY_JOINTS, JOINTS};
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use glam::{EulerRot, Quat, Vec3};

/// Key rate in Hz.
pub(crate) const RATE: f32 = 30.0;

/// Side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// +X.
    Left,
    /// -X.
    Right,
}

impl Side {
    /// Both sides.
    pub(crate) const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The joint of this side with the given name after the prefix of the side.
    pub(crate) fn joint(self, name: &str) -> usize {
        match self {
            Self::Left => joint(&format!("l_{name}")),
            Self::Right => joint(&format!("r_{name}")),
        }
    }

    /// 1 on the left, -1 on the right.
    pub(crate) fn sign(self) -> f32 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// Local rotations of every joint, and the position of the root.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pose {
    pub(crate) root: Vec3,
    pub(crate) rotations: Vec<Quat>,
}

impl Pose {
    /// The rest pose.
    pub(crate) fn rest() -> Self {
        Self {
            root: centers()[0],
            rotations: vec![Quat::IDENTITY; BODY_JOINTS],
        }
    }

    /// Rotates a joint by pitch (about x), yaw (y) and roll (z) in degrees, on top of its rotation.
    pub(crate) fn turn(&mut self, joint: usize, degrees: [f32; 3]) {
        let [x, y, z] = degrees.map(f32::to_radians);
        self.rotations[joint] *= Quat::from_euler(EulerRot::ZYX, z, y, x);
    }

    /// Rotates a joint of one side; angles are those of the left side.
    pub(crate) fn turn_side(&mut self, side: Side, name: &str, [x, y, z]: [f32; 3]) {
        let s = side.sign();
        self.turn(side.joint(name), [x, y * s, z * s]);
    }

    /// Distributes a rotation evenly over the vertebrae from one name to another.
    pub(crate) fn turn_spine(&mut self, from: &str, to: &str, degrees: [f32; 3]) {
        let (first, last) = (joint(from), joint(to));
        let count = (last - first + 1) as f32;
        for j in first..=last {
            self.turn(j, degrees.map(|d| d / count));
        }
    }

    /// Curls the four fingers of a hand by this angle per joint, and the thumb by less.
    pub(crate) fn curl(&mut self, side: Side, degrees: f32) {
        for (f, finger) in ["index", "middle", "ring", "pinky"].iter().enumerate() {
            let more = 1.0 + 0.12 * f as f32;
            for (digit, part) in [(1, 0.8), (2, 1.0), (3, 0.6)] {
                self.turn_side(
                    side,
                    &format!("{finger}{digit}"),
                    [0.0, 0.0, -degrees * part * more],
                );
            }
        }
        self.turn_side(side, "thumb2", [0.3 * degrees, 0.0, -0.2 * degrees]);
        self.turn_side(side, "thumb3", [0.4 * degrees, 0.0, -0.2 * degrees]);
    }

    /// Position and orientation of a joint in model space.
    pub(crate) fn model(&self, joint: usize) -> (Vec3, Quat) {
        let rest = centers();
        let mut chain = vec![joint];
        while let Some(parent) = JOINTS[chain[chain.len() - 1]].parent {
            chain.push(parent);
        }
        let (mut position, mut rotation) = (self.root, self.rotations[0]);
        for pair in chain.windows(2).rev() {
            position += rotation * (rest[pair[0]] - rest[pair[1]]);
            rotation *= self.rotations[pair[0]];
        }
        (position, rotation)
    }
}

/// A looping clip: `pose` is evaluated at phases in 0..1, and the last key equals the first.
pub(crate) fn cycle(name: &str, frames: usize, pose: impl Fn(f32) -> Pose) -> RawClip {
    let mut poses: Vec<Pose> = (0..frames)
        .map(|f| pose(f as f32 / frames as f32))
        .collect();
    poses.push(poses[0].clone());
    let times: Vec<f32> = (0..=frames).map(|f| f as f32 / RATE).collect();
    let channel = |target, property, values| Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: times.clone(),
        values,
    };
    let roots = poses.iter().flat_map(|p| p.root.to_array()).collect();
    let mut channels = vec![channel(0, Property::Translation, roots)];
    for j in 0..skeleton().joints.len() {
        if poses.iter().any(|p| p.rotations[j] != Quat::IDENTITY) {
            let keys = near_keys(poses.iter().map(|p| p.rotations[j]));
            channels.push(channel(j, Property::Rotation, keys));
        }
    }
    RawClip {
        name: name.to_owned(),
        duration_secs: frames as f32 / RATE,
        channels,
    }
}

/// Unit quaternions with w not negative (no joint rotates by half a turn).
fn near_keys(rotations: impl Iterator<Item = Quat>) -> Vec<f32> {
    rotations
        .flat_map(|q| {
            let q = q.normalize();
            if q.w < 0.0 {
                (-q).to_array()
            } else {
                q.to_array()
            }
        })
        .collect()
}
