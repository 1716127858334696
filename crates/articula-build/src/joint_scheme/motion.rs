//! Clips in which a joint is removed, and others take its motion.
//!
//! With `P`, `J` and `C` the local transforms of a joint's parent, of itself and of a child, the
//! child is at `P · J · C` before. A rotation `D` goes to the parent, and the child becomes
//! `D⁻¹ · J · C`, so that `(P · D) · (D⁻¹ · J · C)` is the same; other children `S` of the parent
//! become `D⁻¹ · S`. `D` is the rotation of the joint against its rest if the parent takes it, and
//! the identity if the children do.

use crate::clip_edit::channel;
use crate::clip_edit::pieces::{self, ComputedJoint, blend};
use crate::clip_edit::similarity::Similarity;
use crate::key_times::rising;
use articula_core::source::evaluate::{self, Sampler};
use articula_core::source::{Channel, Interpolation, JUMP_SECS, Property, RawClip, Skeleton};
use articula_core::{LocalPose, Mismatch, Transform, angle_between};
use glam::{DQuat, DVec3, Vec3};

/// Maximum error between two keys of the joints that take the motion.
const SAME_METRES: f32 = 2e-4;
const SAME_RADIANS: f32 = 2e-3;

/// Greatest difference of a key from rest at which a joint counts as still.
const STILL: f32 = 1e-6;

/// What takes the rotation of a removed joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Into {
    Parent,
    Children,
}

/// A joint that is removed, in the skeleton that still has it.
pub(super) struct Merge<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) joint: usize,
    pub(super) parent: usize,
    pub(super) children: Vec<usize>,
    /// Other children of the parent.
    pub(super) siblings: Vec<usize>,
    pub(super) into: Into,
}

/// Local transforms at a time, as they become.
struct Frame {
    /// That of the parent, then those of its children.
    locals: Vec<Transform>,
    /// All of them in the space above the parent.
    placed: Vec<Transform>,
}

impl Merge<'_> {
    /// The transform of a joint at rest, if it is a similarity.
    pub(super) fn even(&self, joint: usize) -> Result<Similarity, Mismatch> {
        self.similarity(joint, self.skeleton.joints[joint].rest)
    }

    fn similarity(&self, joint: usize, local: Transform) -> Result<Similarity, Mismatch> {
        if Similarity::is(local) {
            return Ok(Similarity::of(local));
        }
        let at = format!("joint \"{}\"", self.skeleton.joints[joint].name);
        let what = "its scale differs along its axes, so a joint next to it cannot be merged";
        Err(Mismatch::new(at, what))
    }

    /// Returns a clip without the joint. Targets keep their numbers.
    pub(super) fn clip(&self, clip: &RawClip) -> Result<RawClip, Mismatch> {
        let rest = self.even(self.joint)?;
        let own = |c: &&Channel| c.property.is_of_joint() && c.target == self.joint;
        let own: Vec<&Channel> = clip.channels.iter().filter(own).collect();
        let mut out = if own.iter().all(|c| self.is_still(c)) {
            self.still(clip, rest)
        } else {
            self.moving(clip)?
        };
        channel::keep_length(&mut out);
        Ok(out)
    }

    /// Whether a channel of the joint stays at rest.
    fn is_still(&self, channel: &Channel) -> bool {
        let rest = self.skeleton.joints[self.joint].rest;
        let rest = match channel.property {
            Property::Translation => rest.translation.to_array().to_vec(),
            Property::Scale => rest.scale.to_array().to_vec(),
            _ => rest.rotation.to_array().to_vec(),
        };
        let is_near = |value: &[f32], sign: f32| {
            let mut pairs = value.iter().zip(&rest);
            pairs.all(|(a, b)| (a - sign * b).abs() <= STILL)
        };
        let is_turn = channel.property == Property::Rotation;
        let at_rest = |key| {
            let value = channel::key_value(channel, key);
            is_near(value, 1.0) || is_turn && is_near(value, -1.0)
        };
        let is_spline = channel.interpolation == Interpolation::CubicSpline;
        let width = rest.len();
        let tangents = channel.values.chunks_exact(width).enumerate();
        let mut tangents = tangents.filter(|(i, _)| is_spline && i % 3 != 1);
        (0..channel.times_secs.len()).all(at_rest)
            && tangents.all(|(_, t)| t.iter().all(|x| x.abs() <= STILL))
    }

    /// The clip of a joint that stays at rest: all keys stay, seen from the parent.
    fn still(&self, clip: &RawClip, rest: Similarity) -> RawClip {
        let mut out = self.without_joint(clip);
        for channel in &mut out.channels {
            if !channel.property.is_of_joint() || !self.children.contains(&channel.target) {
                continue;
            }
            let spline = channel.interpolation == Interpolation::CubicSpline;
            let width = if channel.property == Property::Rotation {
                4
            } else {
                3
            };
            for (i, value) in channel.values.chunks_exact_mut(width).enumerate() {
                let is_tangent = spline && i % 3 != 1;
                seen_from_parent(rest, channel.property, value, is_tangent);
            }
        }
        out
    }

    fn without_joint(&self, clip: &RawClip) -> RawClip {
        let is_other = |c: &&Channel| !c.property.is_of_joint() || c.target != self.joint;
        RawClip {
            name: clip.name.clone(),
            duration_secs: clip.duration_secs,
            channels: clip.channels.iter().filter(is_other).cloned().collect(),
        }
    }

    /// The clip of a joint that moves: the joints that take its motion get linear keys.
    fn moving(&self, clip: &RawClip) -> Result<RawClip, Mismatch> {
        let (parent_takes, joints) = (self.into == Into::Parent, self.taking());
        let is_used = |c: &&Channel| {
            let has = c.target == self.joint || joints.contains(&c.target);
            c.property.is_of_joint() && has
        };
        let used = RawClip {
            channels: clip.channels.iter().filter(is_used).cloned().collect(),
            ..RawClip::default()
        };
        let mut pose: LocalPose = self.skeleton.joints.iter().map(|j| j.rest).collect();
        let mut sampler = Sampler::new(&used, self.skeleton);
        for time in times(&used, clip.duration_secs) {
            sampler.pose(time, &mut pose);
            for joint in [self.joint, self.parent] {
                self.similarity(joint, pose.get(joint))?;
            }
        }
        let unit_metres = self.unit_metres();
        let follows = |a: &Frame, b: &Frame, t: f32, between: &Frame| {
            let blended = a.locals.iter().zip(&b.locals);
            let blended: Vec<Transform> = blended.map(|(a, b)| blend(*a, *b, t)).collect();
            let shown = placed(&blended);
            shown.iter().zip(&between.placed).all(|(shown, wanted)| {
                let apart = shown.translation.distance(wanted.translation) * unit_metres;
                let turned = angle_between(shown.rotation, wanted.rotation);
                apart <= SAME_METRES && turned <= SAME_RADIANS
            })
        };
        let mut frame = |secs: f32| {
            evaluate::pose(&used, self.skeleton, secs, &mut pose);
            self.frame(&pose)
        };
        let times = pieces::times(&times(&used, clip.duration_secs), &mut frame, &follows);
        let frames: Vec<Frame> = times.iter().map(|t| frame(*t)).collect();
        let mut out = self.without_joint(clip);
        for (i, joint) in std::iter::once(self.parent)
            .chain(joints_below(self))
            .enumerate()
        {
            if i == 0 && !parent_takes {
                continue;
            }
            let computed = |property: Property| i > 0 || property == Property::Rotation;
            let old = |c: &Channel| c.property.is_of_joint() && c.target == joint;
            let keyed: Vec<Property> = out
                .channels
                .iter()
                .filter(|c| old(c))
                .map(|c| c.property)
                .collect();
            out.channels.retain(|c| !old(c) || !computed(c.property));
            let locals: Vec<Transform> = frames.iter().map(|f| f.locals[i]).collect();
            let new = ComputedJoint {
                joint,
                rest: self.new_rest(joint)?,
                is_keyed: &|property| keyed.contains(&property),
            };
            let new = new.channels(&times, &locals);
            out.channels
                .extend(new.into_iter().filter(|c| computed(c.property)));
        }
        Ok(out)
    }

    /// The joints whose local transforms change.
    fn taking(&self) -> Vec<usize> {
        std::iter::once(self.parent)
            .chain(joints_below(self))
            .collect()
    }

    fn new_rest(&self, joint: usize) -> Result<Transform, Mismatch> {
        let rest = self.skeleton.joints[joint].rest;
        if self.children.contains(&joint) {
            return Ok(self.even(self.joint)?.after(rest));
        }
        Ok(rest)
    }

    fn frame(&self, pose: &LocalPose) -> Frame {
        let joint = Similarity::of(pose.get(self.joint));
        let rest = self.skeleton.joints[self.joint].rest.rotation.as_dquat();
        let turn = match self.into {
            Into::Parent => joint.rotation * rest.normalize().conjugate(),
            Into::Children => DQuat::IDENTITY,
        };
        let back = Similarity {
            translation: DVec3::ZERO,
            rotation: turn.conjugate(),
            scale: 1.0,
        };
        let mut parent = pose.get(self.parent);
        parent.rotation = (parent.rotation.as_dquat() * turn).normalize().as_quat();
        let mut locals = vec![parent];
        let children = self.children.iter();
        locals.extend(children.map(|c| (back * joint).after(pose.get(*c))));
        if self.into == Into::Parent {
            locals.extend(self.siblings.iter().map(|s| back.after(pose.get(*s))));
        }
        Frame {
            placed: placed(&locals),
            locals,
        }
    }

    /// Metres per unit in the space above the parent, at rest.
    fn unit_metres(&self) -> f32 {
        let above = self.skeleton.joints[self.parent].parent;
        let model = self.skeleton.model_rest();
        above.map_or(1.0, |above| model[above].matrix3.x_axis.length())
    }
}

/// The joints below the parent whose local transforms change.
fn joints_below(merge: &Merge<'_>) -> impl Iterator<Item = usize> {
    let siblings = merge.siblings.iter().filter(|_| merge.into == Into::Parent);
    merge.children.iter().chain(siblings).copied()
}

/// A parent and its children in the space above the parent.
fn placed(locals: &[Transform]) -> Vec<Transform> {
    let parent = Similarity::of(locals[0]);
    let children = locals[1..].iter().map(|child| parent.after(*child));
    std::iter::once(locals[0]).chain(children).collect()
}

/// All key times of a clip, its ends, and times just before jumps.
fn times(clip: &RawClip, end_secs: f32) -> Vec<f32> {
    let mut times = vec![0.0, end_secs.max(0.0)];
    for channel in &clip.channels {
        times.extend(&channel.times_secs);
        if channel.interpolation == Interpolation::Step {
            times.extend(channel.times_secs[1..].iter().map(|t| t - JUMP_SECS));
        }
    }
    times.retain(|t| *t >= 0.0);
    rising(times)
}

/// A key of a child of a joint that stays at rest, as the joint's parent sees it.
fn seen_from_parent(rest: Similarity, property: Property, value: &mut [f32], is_tangent: bool) {
    match property {
        Property::Rotation => {
            // Also right for tangents, which are not unit quaternions.
            let [x, y, z, w] = [0, 1, 2, 3].map(|i| f64::from(value[i]));
            let turned = rest.rotation * DQuat::from_xyzw(x, y, z, w);
            if rest.rotation != DQuat::IDENTITY {
                value.copy_from_slice(&turned.as_quat().to_array());
            }
        }
        Property::Translation => {
            let v = Vec3::from_slice(value).as_dvec3() * rest.scale;
            let turned = rest.rotation * v;
            let offset = if is_tangent {
                DVec3::ZERO
            } else {
                rest.translation
            };
            value.copy_from_slice(&(turned + offset).as_vec3().to_array());
        }
        _ => value.iter_mut().for_each(|v| *v *= rest.scale as f32),
    }
}
