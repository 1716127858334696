//! Clips under construction, shared by motions, interpolators and poses.

use super::fields::{Reader, folded};
use super::figure::Figure;
use super::frames::Frames;
use super::meshes::X3dMeshes;
use super::scene::NodeId;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::hanim_table;
use articula_core::same_hemisphere;
use articula_core::source::{Channel, Interpolation, Property, evaluate};
use glam::{DQuat, DVec3, Quat};
use std::collections::HashMap;

/// Context of all functions that make clips.
pub(super) struct Stage<'s> {
    pub(super) figure: &'s Figure,
    pub(super) frames: &'s Frames,
    pub(super) shown: &'s X3dMeshes,
    joint_of_node: HashMap<NodeId, usize>,
    joint_of_name: HashMap<String, usize>,
}

/// A clip under construction.
#[derive(Debug)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) duration_secs: f32,
    pub(super) channels: Vec<Channel>,
    /// Weights of single displacers; a mesh has one channel for all of its targets.
    pub(super) weights: Vec<WeightTrack>,
}

/// The weight of one displacer over time.
#[derive(Debug)]
pub(super) struct WeightTrack {
    pub(super) displacer: NodeId,
    pub(super) times_secs: Vec<f32>,
    pub(super) values: Vec<f32>,
}

impl<'s> Stage<'s> {
    pub(super) fn new(figure: &'s Figure, frames: &'s Frames, shown: &'s X3dMeshes) -> Self {
        let joints = figure.joints.iter().enumerate();
        let mut joint_of_name = HashMap::new();
        for (index, joint) in joints.clone() {
            joint_of_name.entry(canonical(&joint.name)).or_insert(index);
        }
        Self {
            figure,
            frames,
            shown,
            joint_of_node: joints.map(|(index, joint)| (joint.id, index)).collect(),
            joint_of_name,
        }
    }

    /// Returns the joint of a node.
    pub(super) fn joint(&self, id: NodeId) -> Option<usize> {
        self.joint_of_node.get(&id).copied()
    }

    /// Returns the joint of a name, in the spelling of any version of the standard.
    pub(super) fn joint_called(&self, name: &str) -> Option<usize> {
        self.joint_of_name.get(&canonical(name)).copied()
    }

    /// Returns whether a node is a displacer of a drawn mesh.
    pub(super) fn is_seen(&self, displacer: NodeId) -> bool {
        self.shown.targets_of_displacer.contains_key(&displacer)
    }

    /// Adds translation keys of a joint.
    pub(super) fn translations(
        &self,
        joint: usize,
        times_secs: Vec<f32>,
        values: impl Iterator<Item = DVec3>,
    ) -> Channel {
        let local = &self.frames.locals[joint];
        let values = values.flat_map(|v| local.translation(v).to_array());
        self.channel(joint, Property::Translation, times_secs, values.collect())
    }

    /// Adds rotation keys of a joint.
    pub(super) fn rotations(
        &self,
        joint: usize,
        times_secs: Vec<f32>,
        values: impl Iterator<Item = DQuat>,
    ) -> Channel {
        let local = &self.frames.locals[joint];
        let mut last = Quat::IDENTITY;
        let values = values.flat_map(|v| {
            last = same_hemisphere(last, local.rotation(v));
            last.to_array()
        });
        self.channel(joint, Property::Rotation, times_secs, values.collect())
    }

    /// Adds scale keys of a joint.
    pub(super) fn scales(
        &self,
        joint: usize,
        times_secs: Vec<f32>,
        values: impl Iterator<Item = DVec3>,
    ) -> Channel {
        let local = &self.frames.locals[joint];
        let values = values.flat_map(|v| local.scale(v).to_array());
        self.channel(joint, Property::Scale, times_secs, values.collect())
    }

    /// Adds a channel of a joint with linear interpolation.
    pub(super) fn channel(
        &self,
        joint: usize,
        property: Property,
        times_secs: Vec<f32>,
        values: Vec<f32>,
    ) -> Channel {
        Channel {
            target: joint + self.frames.first,
            property,
            interpolation: Interpolation::Linear,
            times_secs,
            values,
        }
    }
}

impl WeightTrack {
    /// Returns the weight at a time.
    pub(super) fn at(&self, time_secs: f32) -> f32 {
        let channel = Channel {
            target: 0,
            property: Property::Weights,
            interpolation: Interpolation::Linear,
            times_secs: self.times_secs.clone(),
            values: self.values.clone(),
        };
        let mut value = [0.0];
        evaluate::channel(&channel, time_secs, &mut value);
        value[0]
    }
}

/// Returns a joint's H-Anim 1.1 name in lower case, so that names of all versions compare equal.
fn canonical(name: &str) -> String {
    let name = folded(name.trim());
    if name == "humanoidroot" {
        return "humanoid_root".to_owned();
    }
    let standard = hanim_table::find(&name).map(|i| hanim_table::JOINTS[i].name);
    standard.map_or_else(|| name.into_owned(), str::to_owned)
}

/// Returns strictly ascending key times, each with the index of its key.
///
/// Two keys at one fraction form a jump: the first moves to just before the second. Keys outside of
/// the cycle are never reached and left out.
pub(super) fn key_times(
    reader: &mut Reader<'_>,
    id: NodeId,
    fractions: &[f64],
    cycle_secs: f64,
) -> Result<Vec<(f32, usize)>, ReadError> {
    let at = reader.scene.at(id);
    Limits::check(&at, "keys", fractions.len() as u64, reader.limits.frames)?;
    let mut times: Vec<(f32, usize)> = Vec::with_capacity(fractions.len());
    let mut wrong = 0;
    for (key, &fraction) in fractions.iter().enumerate() {
        let time = (fraction * cycle_secs) as f32;
        let last = times.last().map_or(-1.0, |(time, _)| *time);
        if !(0.0..=1.0).contains(&fraction) || time < last {
            wrong += 1;
            continue;
        }
        if time == last {
            let earlier = time.next_down();
            let before = times.len().checked_sub(2).map_or(-1.0, |i| times[i].0);
            let slot = times.len() - 1;
            if earlier > before && earlier >= 0.0 {
                times[slot].0 = earlier;
            } else {
                times.pop();
            }
        }
        times.push((time, key));
    }
    if wrong > 0 {
        let what = format!("{wrong} keys decrease or are outside of 0 to 1; left out");
        reader.warn(id, what);
    }
    Ok(times)
}
