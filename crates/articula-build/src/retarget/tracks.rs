//! Converts frames of the target to a clip of keyed channels.

use super::plan::{Drive, Plan};
use super::pose::Pose;
use super::side::Side;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{angle_between, same_hemisphere};
use glam::{Quat, Vec3};

/// Differences between keys below which a channel is constant and keeps one key.
const STILL_RADIANS: f32 = 1e-6;
const STILL_METRES: f32 = 1e-7;

/// Keys of one clip, collected frame by frame.
#[derive(Debug)]
pub(super) struct Tracks {
    rotations: Vec<(usize, Vec<Quat>)>,
    translations: Vec<(usize, Vec<Vec3>)>,
}

impl Tracks {
    /// Allocates keys for every joint that the plan or `more` rotates.
    pub(super) fn new(plan: &Plan, target: &Side, more: &[usize], frames: usize) -> Self {
        let turned = |j: &usize| plan.drives[*j] != Drive::Held || more.contains(j);
        let moved = |j: &usize| plan.floats[*j].is_some() || *j == target.body.root;
        let joints = || 0..target.rest.len();
        Self {
            rotations: joints()
                .filter(turned)
                .map(|j| (j, Vec::with_capacity(frames)))
                .collect(),
            translations: joints()
                .filter(moved)
                .map(|j| (j, Vec::with_capacity(frames)))
                .collect(),
        }
    }

    /// Appends one frame.
    pub(super) fn push(&mut self, target: &Side, pose: &Pose) {
        for (j, keys) in &mut self.rotations {
            let key = pose.local_rotation(target, *j);
            // Neighbouring keys are in one hemisphere, so that any blend takes the shorter arc.
            let last = keys.last().copied().unwrap_or(Quat::IDENTITY);
            keys.push(same_hemisphere(last, key));
        }
        for (j, keys) in &mut self.translations {
            keys.push(pose.local_translation(target, *j));
        }
    }

    /// Maximum rotation speed between two frames, radians per second, and its joint.
    pub(super) fn fastest(&self, rate_hz: f32) -> Option<(usize, f32)> {
        let speed = |keys: &[Quat]| {
            let steps = keys.windows(2).map(|w| angle_between(w[0], w[1]));
            rate_hz * steps.fold(0.0, f32::max)
        };
        let speeds = self.rotations.iter().map(|(j, keys)| (*j, speed(keys)));
        speeds.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The finished clip.
    pub(super) fn clip(self, name: &str, times_secs: &[f32]) -> RawClip {
        let mut channels = Vec::with_capacity(self.rotations.len() + self.translations.len());
        for (target, keys) in self.translations {
            let still = keys.iter().all(|k| k.distance(keys[0]) < STILL_METRES);
            let values = keys.iter().flat_map(|k| k.to_array()).collect();
            channels.push(channel(
                target,
                Property::Translation,
                values,
                still,
                times_secs,
            ));
        }
        for (target, keys) in self.rotations {
            let still = keys
                .iter()
                .all(|k| angle_between(*k, keys[0]) < STILL_RADIANS);
            let values = keys.iter().flat_map(|k| k.to_array()).collect();
            channels.push(channel(
                target,
                Property::Rotation,
                values,
                still,
                times_secs,
            ));
        }
        RawClip {
            name: name.to_owned(),
            duration_secs: times_secs.last().copied().unwrap_or(0.0),
            channels,
        }
    }
}

fn channel(
    target: usize,
    property: Property,
    mut values: Vec<f32>,
    still: bool,
    times_secs: &[f32],
) -> Channel {
    let mut times_secs = times_secs.to_vec();
    if still && times_secs.len() > 1 {
        values.truncate(values.len() / times_secs.len());
        times_secs.truncate(1);
    }
    Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs,
        values,
    }
}
