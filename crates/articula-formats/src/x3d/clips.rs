//! Clips: common code for motions, interpolators and poses.
//!
//! - `motion`: `HAnimMotion`, frames of joint angles
//! - `routes`: time sensors, interpolators and routes
//! - `pose`: `HAnimPose`
//!
//! A joint that a clip does not move keeps the transform of the file's fields; where that is not
//! the rest pose, the clip holds it.

use super::draft::{Draft, Stage, WeightTrack};
use super::fields::Reader;
use super::figure::Figure;
use super::frames::Frames;
use super::meshes::X3dMeshes;
use super::{motion, pose, routes};
use crate::error::ReadError;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{Transform, angle_between};
use std::collections::{BTreeMap, HashSet};

/// Reads all clips of a figure.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    figure: &Figure,
    frames: &Frames,
    shown: &X3dMeshes,
) -> Result<Vec<RawClip>, ReadError> {
    let stage = Stage::new(figure, frames, shown);
    let mut drafts = motion::read_all(reader, &stage)?;
    drafts.extend(routes::read_all(reader, &stage)?);
    drafts.extend(pose::read_all(reader, &stage)?);
    let mut clips = Vec::new();
    for (index, draft) in drafts.into_iter().enumerate() {
        clips.push(stage.finished(reader, draft, index)?);
    }
    Ok(clips)
}

impl Stage<'_> {
    /// Returns rest and stored transform of a joint.
    fn rest_and_stored(&self, joint: usize) -> (Transform, Transform) {
        let rest = self.frames.skeleton.joints[joint + self.frames.first].rest;
        (rest, self.frames.stored[joint])
    }

    fn finished(
        &self,
        reader: &mut Reader<'_>,
        draft: Draft,
        index: usize,
    ) -> Result<RawClip, ReadError> {
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
        let mut clip = RawClip {
            name,
            duration_secs: draft.duration_secs,
            channels,
        };
        hold_to_the_end(&mut clip);
        Ok(clip)
    }

    /// Makes one channel for each mesh with an animated displacer.
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

/// Returns which components of two transforms differ: translation, rotation, scale.
fn differing(a: &Transform, b: &Transform) -> [bool; 3] {
    [
        a.translation.distance(b.translation) > 1e-7 * a.translation.length().max(1e-3),
        angle_between(a.rotation, b.rotation) > 1e-6,
        a.scale.distance(b.scale) > 1e-7,
    ]
}

/// A clip ends with its last key, so at least one channel gets a key at its end.
fn hold_to_the_end(clip: &mut RawClip) {
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
