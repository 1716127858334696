//! Clips: what motions, interpolators and poses have in common.
//!
//! - `motion`: `HAnimMotion`, frames of joint angles
//! - `routes`: time sensors, interpolators and routes
//! - `pose`: `HAnimPose`
//!
//! A joint that a clip does not move keeps what the file's own fields say; where that is not
//! the rest pose, the clip holds it.

use super::fields::{Reader, folded};
use super::figure::Figure;
use super::frames::Frames;
use super::meshes::Shown;
use super::scene::NodeId;
use super::{motion, pose, routes};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::hanim_table;
use articula_core::source::{Channel, Clip, Interpolation, Property, evaluate};
use articula_core::{Transform, angle_between, same_hemisphere};
use glam::{DQuat, DVec3, Quat};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Name of the clip that shows joints as the file leaves them, where no motion moves them.
const STORED_POSE: &str = "stored pose";

/// What all makers of clips need.
pub(super) struct Stage<'s> {
    pub(super) figure: &'s Figure,
    pub(super) frames: &'s Frames,
    pub(super) shown: &'s Shown,
    joint_of_node: HashMap<NodeId, usize>,
    joint_of_name: HashMap<String, usize>,
}

/// A clip while it is made.
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

/// Makes all clips of a figure.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    figure: &Figure,
    frames: &Frames,
    shown: &Shown,
) -> Result<Vec<Clip>, ReadError> {
    let stage = Stage::new(figure, frames, shown);
    let mut drafts = motion::read_all(reader, &stage)?;
    drafts.extend(routes::read_all(reader, &stage)?);
    let nothing_moves = drafts.is_empty();
    drafts.extend(pose::read_all(reader, &stage)?);
    if nothing_moves && stage.is_posed() {
        drafts.push(Draft {
            name: STORED_POSE.to_owned(),
            duration_secs: 0.0,
            channels: Vec::new(),
            weights: Vec::new(),
        });
    }
    let mut clips = Vec::new();
    for (index, draft) in drafts.into_iter().enumerate() {
        clips.push(stage.finished(reader, draft, index)?);
    }
    Ok(clips)
}

impl<'s> Stage<'s> {
    fn new(figure: &'s Figure, frames: &'s Frames, shown: &'s Shown) -> Self {
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

    /// The joint that a node is.
    pub(super) fn joint(&self, id: NodeId) -> Option<usize> {
        self.joint_of_node.get(&id).copied()
    }

    /// The joint of a name, in the spelling of any version of the standard.
    pub(super) fn joint_called(&self, name: &str) -> Option<usize> {
        self.joint_of_name.get(&canonical(name)).copied()
    }

    /// Whether a node is a displacer of something that is drawn.
    pub(super) fn is_seen(&self, displacer: NodeId) -> bool {
        self.shown.targets_of_displacer.contains_key(&displacer)
    }

    /// Translation keys of a joint.
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

    /// Rotation keys of a joint.
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

    /// Scale keys of a joint.
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

    fn channel(
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

    /// Rest and stored transform of a joint.
    fn rest_and_stored(&self, joint: usize) -> (Transform, Transform) {
        let rest = self.frames.skeleton.joints[joint + self.frames.first].rest;
        (rest, self.frames.stored[joint])
    }

    /// Whether the file's fields show another pose than that of rest.
    fn is_posed(&self) -> bool {
        let differs = |joint: usize| {
            let (rest, stored) = self.rest_and_stored(joint);
            differing(&rest, &stored).iter().any(|d| *d)
        };
        (0..self.figure.joints.len()).any(differs)
    }

    fn finished(
        &self,
        reader: &mut Reader<'_>,
        draft: Draft,
        index: usize,
    ) -> Result<Clip, ReadError> {
        let mut keyed = HashSet::new();
        let mut channels = draft.channels;
        channels.retain(|c| keyed.insert((c.target, c.property)));
        for joint in 0..self.figure.joints.len() {
            let (rest, stored) = self.rest_and_stored(joint);
            let values = [
                (
                    Property::Translation,
                    stored.translation.to_array().to_vec(),
                ),
                (Property::Rotation, stored.rotation.to_array().to_vec()),
                (Property::Scale, stored.scale.to_array().to_vec()),
            ];
            for ((property, values), differs) in values.into_iter().zip(differing(&rest, &stored)) {
                if differs && keyed.insert((joint + self.frames.first, property)) {
                    channels.push(self.channel(joint, property, vec![0.0], values));
                }
            }
        }
        channels.extend(self.weights(reader, &draft.weights)?);
        let name = match draft.name {
            name if name.is_empty() => format!("clip_{index}"),
            name => name,
        };
        let mut clip = Clip {
            name,
            duration_secs: draft.duration_secs,
            channels,
        };
        hold_to_the_end(&mut clip);
        Ok(clip)
    }

    /// One channel for each mesh of which a displacer moves.
    fn weights(
        &self,
        reader: &mut Reader<'_>,
        tracks: &[WeightTrack],
    ) -> Result<Vec<Channel>, ReadError> {
        let mut of_mesh: BTreeMap<usize, BTreeMap<usize, &WeightTrack>> = BTreeMap::new();
        for track in tracks {
            let targets = self.shown.targets_of_displacer.get(&track.displacer);
            for &(mesh, target) in targets.into_iter().flatten() {
                let of_target = of_mesh.entry(mesh).or_default();
                of_target.entry(target).or_insert(track);
            }
        }
        let mut channels = Vec::new();
        for (mesh, tracks) in of_mesh {
            let mut times: Vec<f32> = tracks.values().flat_map(|t| t.times_secs.clone()).collect();
            times.sort_by(f32::total_cmp);
            times.dedup();
            let rest = &self.shown.meshes[mesh].morph_weights;
            let count = times.len().saturating_mul(rest.len());
            reader.charge(self.figure.id, count)?;
            let mut values = Vec::with_capacity(count);
            for &time in &times {
                let first = values.len();
                values.extend_from_slice(rest);
                for (&target, track) in &tracks {
                    values[first + target] = track.at(time);
                }
            }
            channels.push(Channel {
                target: mesh,
                property: Property::Weights,
                interpolation: Interpolation::Linear,
                times_secs: times,
                values,
            });
        }
        Ok(channels)
    }
}

impl WeightTrack {
    fn at(&self, time_secs: f32) -> f32 {
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

/// Which parts of two transforms differ: translation, rotation, scale.
fn differing(a: &Transform, b: &Transform) -> [bool; 3] {
    [
        a.translation.distance(b.translation) > 1e-7 * a.translation.length().max(1e-3),
        angle_between(a.rotation, b.rotation) > 1e-6,
        a.scale.distance(b.scale) > 1e-7,
    ]
}

/// A clip ends with its last key, so some channel must have one at its end.
fn hold_to_the_end(clip: &mut Clip) {
    let end = clip.duration_secs;
    let last = |c: &Channel| c.times_secs.last().copied().unwrap_or(0.0);
    if clip.channels.iter().any(|c| last(c) >= end) {
        return;
    }
    if let Some(channel) = clip.channels.first_mut() {
        let keys = channel.times_secs.len();
        let width = channel.values.len() / keys.max(1);
        let tail = channel.values[channel.values.len() - width..].to_vec();
        channel.values.extend(tail);
        channel.times_secs.push(end);
    }
}

/// A joint's name in lower case and the words of H-Anim 1.1, so that names of all versions meet.
fn canonical(name: &str) -> String {
    let name = folded(name.trim());
    if name == "humanoidroot" {
        return "humanoid_root".to_owned();
    }
    let standard = hanim_table::find(&name).map(|i| hanim_table::JOINTS[i].name);
    standard.map_or_else(|| name.into_owned(), str::to_owned)
}

/// Times of keys, strictly increasing, each with the key that it belongs to.
///
/// Two keys at one fraction make a jump: the first moves to just before the second. Keys outside
/// of the cycle are never reached and left out.
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
        let what = format!("{wrong} keys go back or lie outside of 0 to 1; left out");
        reader.warn(id, what);
    }
    Ok(times)
}
