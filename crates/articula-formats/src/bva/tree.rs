//! Assembly of unconnected segments into a figure, by the meaning of their names.
//!
//! Every known segment is attached to its nearest ancestor in the H-Anim tree, an unknown one to
//! the known segment against which it moves least. The assembled figure reproduces the segments'
//! positions in every frame: a segment whose distance to its parent changes gets translation keys.

use super::reader;
use crate::error::{Parsed, Warning};
use crate::motion_file::MotionFile;
use crate::sampled::still_metres;
use articula_core::Transform;
use articula_core::hanim_table::{self, JOINTS};
use articula_core::joint_names::Segments;
use articula_core::source::{Channel, Character, Joint, Property, RawClip, Skeleton};
use glam::{Quat, Vec3};

/// Number of frames in which an unknown segment is compared with the known ones.
const FRAMES_LOOKED_AT: usize = 16;

/// Weight of a metre of distance relative to a metre of relative movement.
const NEARER: f32 = 0.01;

/// Maximum number of unknown segments that are compared; further ones are attached to the root.
const MAX_COMPARED: usize = 512;

/// Connects the segments of a file to a joint hierarchy, by the H-Anim joint of each segment
/// (`articula-build` maps their names): returns a tree with the same motion and warnings about how
/// it was made, or `None` if there is no motion or no segment is the root of a human.
///
/// At rest every segment has zero rotations, as in BVH; if the figure would not be upright then,
/// the first frame is its rest pose. Scale is left out, since children would inherit it.
pub fn tree(file: &MotionFile, segments: &Segments) -> Option<Parsed<Character>> {
    let clip = file.character.clips.first()?;
    let skeleton = &file.character.skeleton;
    if segments.joints.len() != skeleton.joints.len() {
        return None;
    }
    let world = World::new(clip, skeleton);
    let mut meanings = segments.joints.clone();
    let root = meanings.iter().position(|m| *m == Some(0))?;
    name_spine(&world, segments, root, &mut meanings);
    let order = ordered(&world, &meanings, root);
    let mut warnings = vec![Warning::new(
        "file",
        format!(
            "the format has no hierarchy; {} of {} segments are connected by their names (joint \
             map {})",
            meanings.iter().flatten().count(),
            meanings.len(),
            segments.profile
        ),
    )];
    let character = world.figure(file, &order, &meanings, &mut warnings);
    Some(Parsed {
        value: character,
        warnings,
    })
}

/// A segment and the index of its parent in the order.
type Slot = (usize, Option<usize>);

/// World transforms of the segments, frame by frame.
struct World {
    /// Transforms by segment, then by frame; never empty.
    frames: Vec<Vec<Transform>>,
    count: usize,
}

impl World {
    fn new(clip: &RawClip, skeleton: &Skeleton) -> Self {
        let rests = skeleton.joints.iter().map(|j| vec![j.rest]);
        let mut frames: Vec<Vec<Transform>> = rests.collect();
        for channel in &clip.channels {
            let own = &mut frames[channel.target];
            let first = own[0];
            own.resize(channel.times_secs.len().max(1), first);
            for (frame, values) in own.iter_mut().zip(keys(channel)) {
                match channel.property {
                    Property::Translation => frame.translation = Vec3::from_slice(values),
                    Property::Rotation => frame.rotation = Quat::from_slice(values),
                    _ => frame.scale = Vec3::from_slice(values),
                }
            }
        }
        Self {
            count: frames.iter().map(Vec::len).max().unwrap_or(1),
            frames,
        }
    }

    /// Returns the transform of a segment; one that ends early stays at its last transform.
    fn at(&self, segment: usize, frame: usize) -> Transform {
        let own = &self.frames[segment];
        own[frame.min(own.len() - 1)]
    }

    /// Returns position and rotation of a segment in the axes of another.
    fn within(&self, segment: usize, parent: usize, frame: usize) -> (Vec3, Quat) {
        let (own, above) = (self.at(segment, frame), self.at(parent, frame));
        let back = above.rotation.inverse();
        let place = back * (own.translation - above.translation);
        (place, (back * own.rotation).normalize())
    }

    fn mean_offset(&self, segment: usize, parent: usize) -> Vec3 {
        let places = (0..self.count).map(|f| self.within(segment, parent, f).0.as_dvec3());
        (places.sum::<glam::DVec3>() / self.count as f64).as_vec3()
    }

    /// Returns how far the position within another segment varies over some frames, plus a small
    /// term for the distance: of two equally rigid candidates the nearer one is better.
    fn drift(&self, segment: usize, parent: usize) -> f32 {
        let step = self.count.div_ceil(FRAMES_LOOKED_AT);
        let places = (0..self.count).step_by(step);
        let places = places.map(|f| self.within(segment, parent, f).0);
        let (low, high) = places.fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(p), h.max(p)));
        (high - low).length() + NEARER * low.length()
    }

    fn figure(
        &self,
        file: &MotionFile,
        order: &[Slot],
        meanings: &[Option<usize>],
        warnings: &mut Vec<Warning>,
    ) -> Character {
        let offset = |(segment, parent): &Slot| match parent {
            None => self.at(*segment, 0).translation,
            Some(p) => self.mean_offset(*segment, order[*p].0),
        };
        let offsets: Vec<Vec3> = order.iter().map(offset).collect();
        let stands = stands(order, &offsets, meanings);
        if !stands {
            let what = "with all rotations at zero the segments do not form a standing figure; \
                        the first frame is used as the rest pose";
            warnings.push(Warning::new("file", what));
        }
        let rest = |(segment, parent): &Slot| match parent {
            _ if stands => Quat::IDENTITY,
            None => self.at(*segment, 0).rotation,
            Some(p) => self.within(*segment, order[*p].0, 0).1,
        };
        let joint = |(slot, offset): (&Slot, &Vec3)| Joint {
            name: file.character.skeleton.joints[slot.0].name.clone(),
            parent: slot.1,
            rest: Transform {
                translation: *offset,
                rotation: rest(slot),
                scale: Vec3::ONE,
            },
            in_skin: true,
        };
        let still = still_metres(
            file.character
                .skeleton
                .joints
                .iter()
                .map(|j| j.rest.translation),
        );
        let mut channels = Vec::new();
        for (index, (segment, parent)) in order.iter().enumerate() {
            let local = |frame| match parent {
                None => {
                    let own = self.at(*segment, frame);
                    (own.translation, own.rotation)
                }
                Some(p) => self.within(*segment, order[*p].0, frame),
            };
            let frames = (0..self.count).map(|frame| {
                let (translation, rotation) = local(frame);
                Transform {
                    translation,
                    rotation,
                    scale: Vec3::ONE,
                }
            });
            let away = |frame| local(frame).0.distance(offsets[index]) > still;
            let moves = parent.is_none() || (0..self.count).any(away);
            let keys = reader::keys(index, file.frame_time_secs, frames);
            channels.extend(
                keys.into_iter()
                    .filter(|c| moves || c.property == Property::Rotation),
            );
        }
        if self
            .frames
            .iter()
            .flatten()
            .any(|f| f.scale.distance(Vec3::ONE) > 1e-4)
        {
            warnings.push(Warning::new("file", "the scale of segments is left out"));
        }
        let clips = file.character.clips.iter().map(|clip| RawClip {
            channels: channels.clone(),
            ..clip.clone()
        });
        Character {
            skeleton: Skeleton {
                joints: order.iter().zip(&offsets).map(joint).collect(),
            },
            clips: clips.collect(),
            ..Character::default()
        }
    }
}

fn keys(channel: &Channel) -> impl Iterator<Item = &[f32]> {
    let width = if channel.property == Property::Rotation {
        4
    } else {
        3
    };
    channel.values.chunks_exact(width)
}

/// Assigns vertebrae to the segments of the spine, by their arc length between hips and neck.
fn name_spine(world: &World, segments: &Segments, root: usize, meanings: &mut [Option<usize>]) {
    let place = |segment: usize| world.at(segment, 0).translation;
    let named = |name: &&str| {
        let joint = hanim_table::find(name);
        meanings.iter().position(|m| m.is_some() && *m == joint)
    };
    let top = ["vc7", "vc4", "vc2", "skullbase", "l_shoulder"];
    let top = top.iter().find_map(named).unwrap_or(root);
    let up = place(top) - place(root);
    let far = |segment: &usize| (place(*segment) - place(root)).dot(up);
    let mut spine = segments.spine.clone();
    spine.sort_by(|a, b| far(a).total_cmp(&far(b)));
    for (segment, vertebra) in spine.iter().zip(&segments.vertebrae) {
        meanings[*segment] = Some(*vertebra);
    }
}

/// Orders the segments parents first.
fn ordered(world: &World, meanings: &[Option<usize>], root: usize) -> Vec<Slot> {
    let mut segment_of = vec![None; JOINTS.len()];
    for (segment, meaning) in meanings.iter().enumerate() {
        if let Some(joint) = meaning {
            segment_of[*joint] = Some(segment);
        }
    }
    let mut order: Vec<Slot> = vec![(root, None)];
    let mut slot_of = vec![None; JOINTS.len()];
    slot_of[0] = Some(0);
    // The table has parents before children, and the root first.
    for (joint, segment) in segment_of.iter().enumerate().skip(1) {
        let Some(segment) = segment else { continue };
        let mut above = JOINTS[joint].parent;
        while let Some(joint) = above.filter(|j| slot_of[*j].is_none()) {
            above = JOINTS[joint].parent;
        }
        slot_of[joint] = Some(order.len());
        order.push((*segment, above.and_then(|j| slot_of[j]).or(Some(0))));
    }
    let known = order.len();
    let unknown = (0..meanings.len()).filter(|&s| meanings[s].is_none());
    for (index, segment) in unknown.enumerate() {
        let parents = if index < MAX_COMPARED { known } else { 1 };
        let drift = |slot: &usize| world.drift(segment, order[*slot].0);
        let parent = (0..parents).min_by(|a, b| drift(a).total_cmp(&drift(b)));
        order.push((segment, parent.or(Some(0))));
    }
    order
}

/// Returns whether the head is above the hips and a knee or foot below, with all rotations at zero.
fn stands(order: &[Slot], offsets: &[Vec3], meanings: &[Option<usize>]) -> bool {
    let mut heights: Vec<f32> = Vec::with_capacity(order.len());
    for ((_, parent), offset) in order.iter().zip(offsets) {
        heights.push(parent.map_or(0.0, |p| heights[p]) + offset.y);
    }
    let of = |name: &str| {
        let joint = hanim_table::find(name);
        let slot = order
            .iter()
            .position(|(s, _)| joint.is_some() && meanings[*s] == joint);
        slot.map(|slot| heights[slot] - heights[0])
    };
    let head = of("skullbase")
        .or_else(|| of("vc4"))
        .or_else(|| of("l_shoulder"));
    let foot = of("l_ankle").or_else(|| of("l_knee"));
    head.is_none_or(|h| h > 0.0) && foot.is_none_or(|h| h < 0.0)
}
