//! A hand-written evaluator for comparison: a list of joints with their keys, and for each
//! character a list of transforms and one of matrices.
//!
//! Keys are searched in each channel, rotations are interpolated by slerp, matrices are glam's. It
//! is the evaluator that the glTF tutorials lead to, and not slow on purpose.

use anyhow::{Result, ensure};
use articula_core::{Clip, Rig, Track, Transform};
use glam::{Mat4, Quat, Vec3};

/// A value at a time in seconds.
type Keys<T> = Vec<(f32, T)>;

struct Joint {
    parent: Option<usize>,
    rest: Transform,
    translations: Keys<Vec3>,
    rotations: Keys<Quat>,
    scales: Keys<Vec3>,
}

/// A rig with one clip.
pub(crate) struct Structs {
    joints: Vec<Joint>,
}

/// Buffers of a character.
#[derive(Debug, Clone)]
pub(crate) struct Character {
    local: Vec<Transform>,
    /// Model-from-joint matrices, in the order of the rig.
    pub(crate) model: Vec<Mat4>,
}

impl Structs {
    /// Collects the keys of every joint.
    pub(crate) fn new(rig: &Rig, clip: &Clip) -> Result<Self> {
        ensure!(clip.joints() == rig.len(), "the clip is of another rig");
        let rate_hz = clip.rate_hz();
        let joints = (0..rig.len()).map(|j| Joint {
            parent: rig.parent(j),
            rest: rig.rest_pose().get(j),
            translations: keys(&clip.tracks().translations, j, rate_hz),
            rotations: keys(&clip.tracks().rotations, j, rate_hz),
            scales: keys(&clip.tracks().scales, j, rate_hz),
        });
        Ok(Self {
            joints: joints.collect(),
        })
    }

    /// A character at rest.
    pub(crate) fn character(&self) -> Character {
        Character {
            local: self.joints.iter().map(|j| j.rest).collect(),
            model: vec![Mat4::IDENTITY; self.joints.len()],
        }
    }

    /// Poses a character at a time of the clip in seconds.
    pub(crate) fn evaluate(&self, secs: f32, character: &mut Character) {
        let lerp = |a: Vec3, b: Vec3, t: f32| a.lerp(b, t);
        for (joint, local) in self.joints.iter().zip(&mut character.local) {
            if let Some(translation) = at(&joint.translations, secs, lerp) {
                local.translation = translation;
            }
            if let Some(rotation) = at(&joint.rotations, secs, Quat::slerp) {
                local.rotation = rotation;
            }
            if let Some(scale) = at(&joint.scales, secs, lerp) {
                local.scale = scale;
            }
        }
        for (index, joint) in self.joints.iter().enumerate() {
            let Transform {
                translation,
                rotation,
                scale,
            } = character.local[index];
            let local = Mat4::from_scale_rotation_translation(scale, rotation, translation);
            character.model[index] = match joint.parent {
                Some(parent) => character.model[parent] * local,
                None => local,
            };
        }
    }
}

fn keys<T: Copy>(tracks: &[Track<T>], joint: usize, rate_hz: f32) -> Keys<T> {
    let track = tracks.iter().find(|t| usize::from(t.target) == joint);
    let values = track.map_or(&[][..], |t| &t.values);
    let times = (0..values.len()).map(|frame| frame as f32 / rate_hz);
    times.zip(values.iter().copied()).collect()
}

/// The value at a time, interpolated between the two keys around it. `None` without keys.
fn at<T: Copy>(keys: &[(f32, T)], secs: f32, blend: impl Fn(T, T, f32) -> T) -> Option<T> {
    let after = keys.partition_point(|(time, _)| *time <= secs);
    let before = keys.get(after.saturating_sub(1))?;
    Some(match keys.get(after) {
        Some(next) if next.0 > before.0 => {
            blend(before.1, next.1, (secs - before.0) / (next.0 - before.0))
        }
        _ => before.1,
    })
}
