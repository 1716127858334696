//! Clips of takes: channels of joints and of morph targets.

use super::shapes;
use super::skeleton::{Bones, differing};
use super::source::Reader;
use super::surface::Shown;
use super::takes::{Frame, STILL, Take, place};
use crate::error::ReadError;
use articula_core::LibmQuat;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{Transform, angle_between, same_hemisphere};
use glam::{Quat, Vec3};

/// Differences up to this size between a frame of its own and the blend of those around it do not count: metres
/// and scales, radians, weights.
const BLENDED: f32 = 1e-3;

/// Distance in metres between rest and stored pose from which a file without a take gets a clip of the latter.
const POSED: f64 = 1e-3;

/// Makes clips of the takes; each holds the stored pose where it is not at rest.
pub(super) fn finished(
    reader: &mut Reader<'_>,
    bones: &Bones,
    shown: &Shown,
    takes: Vec<Take>,
) -> Result<Vec<RawClip>, ReadError> {
    let mut clips = Vec::new();
    for take in takes {
        let moved = &take.stack.moved;
        let of_joint = |node: &usize| reader.scene.is_called(*node, moved);
        if !take.stack.moves_shapes && !moved.is_empty() && !bones.nodes.iter().any(of_joint) {
            let what = "a take moves nothing that is read; left out";
            reader.kinds.note(|| place(&take.stack), what);
            continue;
        }
        clips.push(finish(reader, bones, shown, take, clips.len())?);
    }
    if clips.is_empty() {
        clips.extend(posed(bones));
    }
    Ok(clips)
}

fn finish(
    reader: &mut Reader<'_>,
    bones: &Bones,
    shown: &Shown,
    take: Take,
    index: usize,
) -> Result<RawClip, ReadError> {
    let mut channels = Vec::new();
    let at = place(&take.stack);
    for (joint, &node) in bones.nodes.iter().enumerate() {
        let rest = &bones.skeleton.joints[joint].rest;
        let track = &take.tracks[node];
        let first = Transform {
            translation: track.translations[0],
            rotation: track.rotations[0],
            scale: track.scales[0],
        };
        let [moved, turned, scaled] = differing(rest, &first);
        let mut add = |property, values: Values<'_>| {
            reader.charge(&at, 5 * values.len())?;
            channels.push(channel(joint, property, &take.frames, &values));
            Ok::<(), ReadError>(())
        };
        if moved || track.translations.len() > 1 {
            add(Property::Translation, Values::Vectors(&track.translations))?;
        }
        if turned || track.rotations.len() > 1 {
            add(Property::Rotation, Values::Turns(&track.rotations))?;
        }
        if scaled || track.scales.len() > 1 {
            add(Property::Scale, Values::Vectors(&track.scales))?;
        }
    }
    for (mesh, targets) in shown.targets.iter().enumerate() {
        let weights = shapes::weights(targets, &take.amounts);
        let stored = &shown.meshes[mesh].morph_weights;
        let rests = |frame: &Vec<f32>| {
            frame
                .iter()
                .zip(stored)
                .all(|(a, b)| (a - b).abs() <= STILL)
        };
        if stored.is_empty() || weights.iter().all(rests) {
            continue;
        }
        reader.charge(&at, weights.len() * (1 + stored.len()))?;
        channels.push(channel(
            mesh,
            Property::Weights,
            &take.frames,
            &Values::Weights(&weights),
        ));
    }
    let name = match take.stack.name {
        name if name.is_empty() => format!("clip_{index}"),
        name => name,
    };
    let mut clip = RawClip {
        name,
        duration_secs: take.duration_secs,
        channels,
    };
    hold_to_the_end(&mut clip, bones);
    Ok(clip)
}

/// Values of a channel, one for each frame or a single one.
enum Values<'v> {
    Vectors(&'v [Vec3]),
    Turns(&'v [Quat]),
    Weights(&'v [Vec<f32>]),
}

impl Values<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Vectors(list) => list.len(),
            Self::Turns(list) => list.len(),
            Self::Weights(list) => list.len(),
        }
    }

    fn push(&self, frame: usize, out: &mut Vec<f32>) {
        match self {
            Self::Vectors(list) => out.extend(list[frame].to_array()),
            Self::Turns(list) => out.extend(list[frame].to_array()),
            Self::Weights(list) => out.extend(&list[frame]),
        }
    }

    /// Whether a frame differs from the blend of two others.
    fn differs(&self, frame: usize, [from, to]: [usize; 2], share: f32) -> bool {
        match self {
            Self::Vectors(list) => list[from].lerp(list[to], share).distance(list[frame]) > BLENDED,
            Self::Turns(list) => {
                let blend = list[from].libm_slerp(same_hemisphere(list[from], list[to]), share);
                angle_between(blend, list[frame]) > BLENDED
            }
            Self::Weights(list) => {
                let ends = list[from].iter().zip(&list[to]);
                let blends = ends.map(|(a, b)| a + (b - a) * share);
                blends
                    .zip(&list[frame])
                    .any(|(a, b)| (a - b).abs() > BLENDED)
            }
        }
    }
}

/// Makes a channel; frames between those of the rate are kept where a blend of these differs from them.
fn channel(target: usize, property: Property, frames: &[Frame], values: &Values<'_>) -> Channel {
    let mut made = Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: Vec::with_capacity(values.len()),
        values: Vec::new(),
    };
    if values.len() == 1 {
        made.times_secs.push(0.0);
        values.push(0, &mut made.values);
        return made;
    }
    let mut before = 0;
    for (index, frame) in frames.iter().enumerate() {
        if !frame.is_extra {
            before = index;
        } else if let Some(behind) = frame.next {
            let (from, to) = (frames[before].secs, frames[behind].secs);
            let share = (frame.secs - from) / (to - from);
            if !values.differs(index, [before, behind], share) {
                continue;
            }
        }
        made.times_secs.push(frame.secs);
        values.push(index, &mut made.values);
    }
    made
}

/// A clip ends with its last key, so at least one channel gets a key at its end.
fn hold_to_the_end(clip: &mut RawClip, bones: &Bones) {
    let end = clip.duration_secs;
    let last = |c: &Channel| c.times_secs.last().copied().unwrap_or(0.0);
    if clip.channels.iter().any(|c| last(c) >= end) {
        return;
    }
    if clip.channels.is_empty() {
        let rest = bones.skeleton.joints[0].rest;
        clip.channels.push(Channel {
            target: 0,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: rest.rotation.to_array().to_vec(),
        });
    }
    if let Some(channel) = clip.channels.first_mut().filter(|c| last(c) < end) {
        let width = channel.values.len() / channel.times_secs.len().max(1);
        let tail = channel.values.len() - width;
        channel.values.extend_from_within(tail..);
        channel.times_secs.push(end);
    }
}

/// The stored pose of a file without a take as a clip, if it is not the rest pose.
fn posed(bones: &Bones) -> Option<RawClip> {
    let rest = bones.skeleton.model_rest();
    let apart = rest.iter().zip(&bones.stored_world).any(|(rest, stored)| {
        let apart = rest.translation.as_dvec3() - stored.translation;
        apart.length() > POSED
    });
    if !apart {
        return None;
    }
    let mut clip = RawClip {
        name: "pose".to_owned(),
        duration_secs: 0.0,
        channels: Vec::new(),
    };
    for (target, (joint, stored)) in bones.skeleton.joints.iter().zip(&bones.stored).enumerate() {
        let values = [
            (
                Property::Translation,
                stored.translation.to_array().to_vec(),
            ),
            (Property::Rotation, stored.rotation.to_array().to_vec()),
            (Property::Scale, stored.scale.to_array().to_vec()),
        ];
        for ((property, values), differs) in values.into_iter().zip(differing(&joint.rest, stored))
        {
            if differs {
                clip.channels.push(Channel {
                    target,
                    property,
                    interpolation: Interpolation::Linear,
                    times_secs: vec![0.0],
                    values,
                });
            }
        }
    }
    Some(clip)
}
