//! Root motion: separates the travel of the hips over the ground from the rest of a motion.
//!
//! The trajectory is a rigid transform over the ground at every time: the displacement of the hips
//! since the first frame, and their turn about the vertical. It starts at the identity, so the
//! first frame never changes. Extracted, it becomes the motion of a joint above the hips, and
//! whatever hangs from that joint moves against it, so that all world poses stay as they are. In
//! place, it is removed.
//!
//! All computations are in model space, so turned parents (a Z-up root) or scaled ones (an armature
//! of scale 100) need no special treatment.

mod carrier;
pub(super) mod trajectory;

pub use trajectory::TrajectoryKey;

use super::channel;
use super::grid::grid;
use super::pieces::{self, ComputedJoint, blend};
use super::similarity::Similarity;
use super::subject::{EditSubject, Posed};
use crate::clip::steps_at;
use crate::key_times::{SAME_SECS, rising};
use articula_core::source::evaluate::Sampler;
use articula_core::source::{Channel, Interpolation, JUMP_SECS, Property, RawClip};
use articula_core::{Mismatch, Transform, angle_between};
use carrier::Carrier;
use trajectory::Trajectory;

/// Treatment of the trajectory of the hips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RootMotionMode {
    /// The clip stays as it is; the trajectory is only measured.
    #[default]
    Keep,
    /// The trajectory becomes the motion of a joint above the hips.
    Extract,
    /// The trajectory is removed: the figure stays where it starts.
    InPlace,
}

/// Options of root motion extraction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RootMotionOptions {
    /// Treatment of the trajectory.
    pub mode: RootMotionMode,
    /// Length in seconds over which the path of the hips is averaged to give the trajectory, so
    /// that the sway of the hips stays in the clip; 0 follows the hips exactly.
    pub smooth_secs: f32,
    /// Whether [`RootMotion::worst_metres`] is left at 0, which saves most of the time.
    pub is_unmeasured: bool,
}

/// A clip after root motion was measured, extracted or removed, and its trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct RootMotion {
    /// The clip; unchanged if the trajectory is kept or if no joint can carry it.
    pub clip: RawClip,
    /// The joint whose trajectory it is.
    pub hips: usize,
    /// The joint above the hips that can carry the trajectory, and does if it is extracted.
    pub carrier: Option<usize>,
    /// The trajectory, at the keys that the resulting clip has.
    pub trajectory: Vec<TrajectoryKey>,
    /// Maximum distance in metres of any joint from its position in the source, with the trajectory
    /// added back; 0 if the clip is unchanged or that is not measured.
    pub worst_metres: f32,
}

/// Maximum error between two keys of joints that move against the carrier.
const SAME_METRES: f32 = 5e-5;
const SAME_RADIANS: f32 = 1e-4;

/// Separates the trajectory of the hips from a clip.
///
/// The joints that move against it get linear keys, as many as the accuracy needs; all other
/// channels stay as they are.
///
/// # Errors
/// A [`Mismatch`] if the clip does not belong to this character or is longer than can be verified.
pub fn split_root_motion(
    subject: &EditSubject<'_>,
    clip: &RawClip,
    opts: &RootMotionOptions,
) -> Result<RootMotion, Mismatch> {
    subject.check(clip)?;
    steps_at(clip, clip.duration_secs, super::grid::VERIFIED_HZ, 1)?;
    let found = Carrier::find(subject, clip);
    let carrier = found.clone().unwrap_or_else(|| Carrier::world(subject));
    let near = near(subject, clip, &carrier);
    let trajectory = Trajectory::new(subject, &near, opts.smooth_secs);
    let in_place = opts.mode == RootMotionMode::InPlace;
    let mut split = Split::new(subject, [clip, &near], &trajectory, carrier, in_place);
    let mut out = RootMotion {
        clip: clip.clone(),
        hips: subject.hips(),
        carrier: found.as_ref().and_then(|c| c.joint),
        trajectory: Vec::new(),
        worst_metres: 0.0,
    };
    let changes = in_place || opts.mode == RootMotionMode::Extract && found.is_some();
    let times = split.times();
    out.trajectory = trajectory.keys(&times);
    if changes {
        out.clip = split.clip(&times);
        if !opts.is_unmeasured {
            out.worst_metres = split.worst(&out.clip);
        }
    }
    Ok(out)
}

/// A clip without the channels of joints that hang below the hips and the children of the carrier: they move
/// neither.
fn near(subject: &EditSubject<'_>, clip: &RawClip, carrier: &Carrier) -> RawClip {
    let moved = [subject.hips()]
        .into_iter()
        .chain(carrier.children.iter().copied());
    let moved: Vec<usize> = moved.chain(carrier.joint).collect();
    let moves = |joint: usize| moved.iter().any(|j| subject.rig.is_at_or_below(*j, joint));
    let channels = clip.channels.iter().filter(|c| moves(c.target));
    RawClip {
        channels: channels.cloned().collect(),
        name: clip.name.clone(),
        ..*clip
    }
}

/// Working state for moving joints against the trajectory.
struct Split<'a> {
    subject: &'a EditSubject<'a>,
    clip: &'a RawClip,
    /// The channels that move hips, carrier and its children.
    near: Sampler<'a>,
    trajectory: &'a Trajectory<'a>,
    hips: usize,
    carrier: Carrier,
    /// The children of the carrier that move against it.
    children: Vec<usize>,
    in_place: bool,
    /// Key times of the channels that move the hips, the carrier and its children.
    keys: Vec<f32>,
    /// Key times at which something may jump.
    jumps: Vec<f32>,
    posed: Posed,
    /// Model-from-carrier in the first frame.
    first: Similarity,
}

/// Local transforms of the carrier and its children at a time, and the wanted ones.
struct Frame {
    parent: Similarity,
    carrier: Similarity,
    children: Vec<Transform>,
    /// Model space.
    wanted: Vec<Transform>,
}

impl<'a> Split<'a> {
    fn new(
        subject: &'a EditSubject<'a>,
        [clip, near]: [&'a RawClip; 2],
        trajectory: &'a Trajectory<'a>,
        carrier: Carrier,
        in_place: bool,
    ) -> Self {
        let mut posed = subject.rest();
        subject.pose(clip, 0.0, &mut posed);
        let (mut keys, mut jumps) = (vec![0.0, clip.duration_secs], Vec::new());
        for channel in clip.channels.iter().filter(|c| c.property.is_of_joint()) {
            let joint = channel.target;
            if subject.rig.is_at_or_below(subject.hips(), joint)
                || carrier.children.contains(&joint)
            {
                keys.extend(&channel.times_secs);
                if channel.interpolation == Interpolation::Step {
                    jumps.extend(&channel.times_secs[1..]);
                }
            }
        }
        Self {
            keys: rising(keys),
            jumps: rising(jumps),
            // In place, what is static in the world stays static.
            children: if in_place {
                carrier.moving_children(subject, clip)
            } else {
                carrier.children.clone()
            },
            first: carrier.placed(subject, &posed).1,
            subject,
            clip,
            near: subject.sampler(near),
            trajectory,
            hips: subject.hips(),
            carrier,
            in_place,
            posed,
        }
    }

    fn frame(&mut self, secs: f32) -> Frame {
        let at = (&mut self.near, secs);
        self.subject.next_pose_above(at, self.hips, &mut self.posed);
        let step = self.trajectory.step(secs, &self.posed);
        let (parent, carrier) = self.carrier.placed(self.subject, &self.posed);
        let (placed, seen) = if self.in_place {
            (self.first, step.inverse())
        } else {
            (step * self.first, Similarity::IDENTITY)
        };
        let locals = self.children.iter().map(|j| self.posed.local.get(*j));
        let wanted: Vec<Transform> = locals.map(|t| (seen * carrier).after(t)).collect();
        let against = placed.inverse();
        Frame {
            parent,
            carrier: parent.inverse() * placed,
            children: wanted.iter().map(|t| against.after(*t)).collect(),
            wanted,
        }
    }

    /// The times at which all changed joints get keys: those of the source, and more where straight
    /// pieces between them would be too far from the wanted motion.
    fn times(&mut self) -> Vec<f32> {
        let before_jumps = self.jumps.iter().map(|t| t - JUMP_SECS);
        let mut times: Vec<f32> = self.keys.iter().copied().chain(before_jumps).collect();
        times.retain(|t| (0.0..=self.clip.duration_secs).contains(t));
        pieces::times(&rising(times), &mut |secs| self.frame(secs), &follows)
    }

    /// The clip with new channels for the carrier and the joints that move against it.
    fn clip(&mut self, times: &[f32]) -> RawClip {
        let frames: Vec<Frame> = times.iter().map(|t| self.frame(*t)).collect();
        let mut moved: Vec<(usize, Vec<Transform>)> = Vec::new();
        if let Some(joint) = self.carrier.joint {
            let locals = frames.iter().map(|f| f.carrier.transform());
            moved.push((joint, locals.collect()));
        }
        for (i, child) in self.children.iter().enumerate() {
            moved.push((*child, frames.iter().map(|f| f.children[i]).collect()));
        }
        let is_moved = |joint: usize| moved.iter().any(|(j, _)| *j == joint);
        let mut out = self.clip.clone();
        out.channels
            .retain(|c| !c.property.is_of_joint() || !is_moved(c.target));
        for (joint, locals) in &moved {
            out.channels.extend(self.channels(*joint, times, locals));
        }
        channel::keep_length(&mut out);
        out
    }

    fn channels(&self, joint: usize, times: &[f32], locals: &[Transform]) -> Vec<Channel> {
        let channels = self.clip.channels.iter();
        let keyed: Vec<Property> = channels
            .filter(|c| c.target == joint)
            .map(|c| c.property)
            .collect();
        let computed = ComputedJoint {
            joint,
            rest: self.subject.rig.rest_pose().get(joint),
            is_keyed: &|property| keyed.contains(&property),
        };
        computed.channels(times, locals)
    }

    /// Maximum distance of any joint from its position in the source, with the trajectory added
    /// back.
    fn worst(&mut self, out: &RawClip) -> f32 {
        let rig = &self.subject.rig;
        let moves = |joint: usize| self.children.iter().any(|c| rig.is_at_or_below(joint, *c));
        let joints: Vec<usize> = (0..rig.len()).filter(|j| moves(*j)).collect();
        let mut shown = self.subject.rest();
        let mut worst = 0.0f32;
        let in_jump = |secs: f32| {
            let next = self.jumps.partition_point(|t| *t <= secs);
            let next = self.jumps.get(next);
            next.is_some_and(|t| t - secs < JUMP_SECS - SAME_SECS)
        };
        let mut times = grid([self.clip, out], self.clip.duration_secs);
        times.retain(|t| !in_jump(*t));
        let (mut from, mut to) = (self.subject.sampler(self.clip), self.subject.sampler(out));
        for secs in times {
            self.subject.next_pose(&mut from, secs, &mut self.posed);
            self.subject.next_pose(&mut to, secs, &mut shown);
            let back = if self.in_place {
                self.trajectory.step(secs, &self.posed)
            } else {
                Similarity::IDENTITY
            };
            for j in &joints {
                let there = back.point(shown.model.position(*j).as_dvec3()).as_vec3();
                worst = worst.max(there.distance(self.posed.model.position(*j)));
            }
        }
        worst
    }
}

/// Whether straight pieces between two frames pass through a frame between them.
fn follows(a: &Frame, b: &Frame, t: f32, between: &Frame) -> bool {
    let carrier = blend(a.carrier.transform(), b.carrier.transform(), t);
    let placed = between.parent * Similarity::of(carrier);
    let ends = a.children.iter().zip(&b.children);
    ends.zip(&between.wanted).all(|((a, b), wanted)| {
        let shown = placed.after(blend(*a, *b, t));
        let apart = shown.translation.distance(wanted.translation);
        apart <= SAME_METRES && angle_between(shown.rotation, wanted.rotation) <= SAME_RADIANS
    })
}

#[cfg(test)]
mod tests {
    use super::super::test_clips::{bar, line};
    use super::*;
    use articula_core::source::Character;
    use glam::Vec3;
    use std::f32::consts::TAU;

    /// A root node, hips below it, and another node below the root that nothing moves.
    fn figure(root_scale: Vec3) -> (Character, articula_core::Articulation) {
        let (mut character, articulation) = bar(3);
        let joints = &mut character.skeleton.joints;
        joints[0].in_skin = false;
        joints[0].rest.scale = root_scale;
        joints[2].parent = Some(0);
        joints[2].in_skin = false;
        (character, articulation)
    }

    fn walk() -> RawClip {
        let mut clip = line(&[0.0, 1.0], &[1.0, 3.0]);
        clip.channels[0].target = 1;
        clip
    }

    fn done(character: &Character, clip: &RawClip, mode: RootMotionMode) -> RootMotion {
        let (_, articulation) = figure(Vec3::ONE);
        let subject = EditSubject::new(character, articulation, &[]).unwrap();
        let opts = RootMotionOptions {
            mode,
            ..RootMotionOptions::default()
        };
        split_root_motion(&subject, clip, &opts).unwrap()
    }

    fn keyed(clip: &RawClip) -> Vec<(usize, Property, usize)> {
        let channels = clip.channels.iter();
        channels
            .map(|c| (c.target, c.property, c.times_secs.len()))
            .collect()
    }

    #[test]
    fn a_straight_walk_by_hand() {
        let (character, _) = figure(Vec3::ONE);
        let kept = done(&character, &walk(), RootMotionMode::Keep);
        assert_eq!((kept.hips, kept.carrier, &kept.clip), (1, Some(0), &walk()));
        assert_eq!(kept.trajectory.last().unwrap().x_metres, 2.0);
        let out = done(&character, &walk(), RootMotionMode::Extract);
        // The node that was static moves against the root, so that it stays static.
        use Property::Translation;
        assert_eq!(
            keyed(&out.clip),
            [
                (0, Translation, 2),
                (1, Translation, 1),
                (2, Translation, 2)
            ]
        );
        assert_eq!(out.clip.channels[0].values, [0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
        assert_eq!(out.clip.channels[1].values, [1.0, 0.0, 0.0]);
        assert!(out.worst_metres < 1e-6);
        let out = done(&character, &walk(), RootMotionMode::InPlace);
        // One constant value, and a second key for the length of the clip.
        assert_eq!(keyed(&out.clip), [(1, Translation, 2)]);
        assert_eq!(out.clip.channels[0].values, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn what_stretches_carries_nothing_but_the_figure_can_stay_in_place() {
        let (character, _) = figure(Vec3::new(1.0, 2.0, 1.0));
        let out = done(&character, &walk(), RootMotionMode::Extract);
        assert_eq!((out.carrier, &out.clip), (None, &walk()));
        let out = done(&character, &walk(), RootMotionMode::InPlace);
        assert_eq!(out.carrier, None);
        assert!(out.worst_metres < 1e-6);
        let again = done(&character, &out.clip, RootMotionMode::Keep);
        assert!(again.trajectory.iter().all(|k| k.x_metres.abs() < 1e-6));
    }

    #[test]
    fn a_somersault_does_not_turn_around() {
        let (character, _) = figure(Vec3::ONE);
        let times: Vec<f32> = (0..=40).map(|i| i as f32 / 40.0).collect();
        // Not quite straight, as captured ones are.
        let turns = times.iter().flat_map(|t| {
            (glam::Quat::from_rotation_x(TAU * t) * glam::Quat::from_rotation_y(0.1)).to_array()
        });
        let mut clip = walk();
        clip.channels.push(Channel {
            target: 1,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            values: turns.collect(),
            times_secs: times,
        });
        let out = done(&character, &clip, RootMotionMode::Extract);
        let widest = out.trajectory.iter().map(|k| k.yaw_radians.abs());
        assert!(widest.fold(0.0, f32::max) < 0.2);
        assert!(out.worst_metres < 1e-4);
    }
}
