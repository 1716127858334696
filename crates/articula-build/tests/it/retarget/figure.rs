//! Figures for the tests: the reference human, rebound in any pose and with any axes, with fewer
//! joints, other sizes and other limbs.

use crate::reference_human::of_2000;
use articula_build::retarget::{RetargetFigure, RetargetOptions, Retargeted, Retargeter};
use articula_core::source::{Channel, Interpolation, Joint, Property, RawClip, Skeleton, evaluate};
use articula_core::{
    Articulation, JointArticulation, LocalPose, Mismatch, Region, Transform, same_hemisphere,
};
use glam::{Affine3A, Mat4, Quat, Vec3};

/// A figure with its motions.
#[derive(Debug, Clone)]
pub(crate) struct Human {
    pub(crate) skeleton: Skeleton,
    pub(crate) articulation: Articulation,
    pub(crate) clips: Vec<RawClip>,
}

/// Retargets one clip to another figure.
pub(crate) fn retarget(
    source: RetargetFigure<'_>,
    target: RetargetFigure<'_>,
    clip: &RawClip,
    options: &RetargetOptions,
) -> Result<Retargeted, Mismatch> {
    Retargeter::new(source, target)?.retarget(clip, options)
}

/// The reference human, arms hanging, with `idle`, `walk` and `wave`.
pub(crate) fn reference() -> Human {
    let character = of_2000().clone();
    Human {
        articulation: character.articulation.unwrap(),
        skeleton: character.skeleton,
        clips: character.clips,
    }
}

impl Human {
    pub(crate) fn figure(&self) -> RetargetFigure<'_> {
        RetargetFigure {
            skeleton: &self.skeleton,
            articulation: &self.articulation,
            clips: &self.clips,
        }
    }

    pub(crate) fn clip(&self, name: &str) -> &RawClip {
        self.clips.iter().find(|c| c.name == name).unwrap()
    }

    pub(crate) fn find(&self, hanim: &str) -> usize {
        let joints = &self.articulation.joints;
        let is = |j: &JointArticulation| j.hanim.as_deref() == Some(hanim);
        joints.iter().position(is).unwrap()
    }

    /// Model-from-joint matrices of a clip at a time.
    pub(crate) fn matrices(&self, clip: &RawClip, time: f32) -> Vec<Affine3A> {
        let mut pose = rest_pose(&self.skeleton);
        evaluate::pose(clip, &self.skeleton, time, &mut pose);
        matrices(&self.skeleton, |j| pose.get(j))
    }

    pub(crate) fn positions(&self, clip: &RawClip, time: f32) -> Vec<Vec3> {
        let matrices = self.matrices(clip, time);
        matrices.iter().map(|m| m.translation.into()).collect()
    }

    /// The same figure and motions, with each joint of the rest pose rotated by `turn` against its
    /// parent (in model space), and each joint's own axes changed by `axes`, which may mirror.
    /// Joints move through the world as before.
    pub(crate) fn rebound(
        &self,
        turn: impl Fn(&str) -> Quat,
        axes: impl Fn(usize) -> Affine3A,
    ) -> Self {
        let joints = &self.skeleton.joints;
        let rest = matrices(&self.skeleton, |j| joints[j].rest);
        let posed = matrices(&self.skeleton, |j| {
            let around = joints[j]
                .parent
                .map_or(Quat::IDENTITY, |p| rotation(&rest[p]));
            let turn = around.inverse() * turn(&joints[j].name) * around;
            Transform {
                rotation: turn * joints[j].rest.rotation,
                ..joints[j].rest
            }
        });
        let local = |model: &[Affine3A], j: usize| {
            let own = model[j] * axes(j);
            let above = joints[j].parent.map(|p| model[p] * axes(p));
            let matrix = above.map_or(own, |a| a.inverse() * own);
            Transform::from_matrix(Mat4::from(matrix)).unwrap()
        };
        let mut new = self.clone();
        for (j, joint) in new.skeleton.joints.iter_mut().enumerate() {
            joint.rest = local(&posed, j);
        }
        for clip in &mut new.clips {
            let times = clip.channels[0].times_secs.clone();
            let poses: Vec<Vec<Affine3A>> = times.iter().map(|t| self.matrices(clip, *t)).collect();
            clip.channels = keyed(joints.len(), &times, |j, f| local(&poses[f], j));
        }
        new
    }

    /// The same figure with each joint's offset from its parent changed; the motions' rotations
    /// stay and their translations are scaled.
    pub(crate) fn resized(&self, scale: f32, offset: impl Fn(&str, Vec3) -> Vec3) -> Self {
        let mut new = self.clone();
        for joint in &mut new.skeleton.joints {
            joint.rest.translation = scale * offset(&joint.name, joint.rest.translation);
        }
        for channel in new.clips.iter_mut().flat_map(|c| &mut c.channels) {
            if channel.property == Property::Translation {
                channel.values.iter_mut().for_each(|v| *v *= scale);
            }
        }
        new
    }

    /// The figure without some joints; their children hang from the nearest remaining ancestor. No
    /// motions.
    pub(crate) fn without(&self, gone: impl Fn(&str) -> bool) -> Self {
        let joints = &self.skeleton.joints;
        let rest = matrices(&self.skeleton, |j| joints[j].rest);
        let mut new_index = vec![None; joints.len()];
        let mut skeleton = Skeleton::default();
        let mut articulation = Articulation::default();
        for (j, joint) in joints.iter().enumerate() {
            if gone(&joint.name) {
                new_index[j] = joint.parent.and_then(|p| new_index[p]);
                continue;
            }
            let parent = joint.parent.and_then(|p| new_index[p]);
            let mut above = joint.parent;
            while let Some(p) = above.filter(|p| gone(&joints[*p].name)) {
                above = joints[p].parent;
            }
            let local = above.map_or(rest[j], |p| rest[p].inverse() * rest[j]);
            new_index[j] = Some(skeleton.joints.len());
            skeleton.joints.push(Joint {
                parent,
                rest: Transform::from_matrix(Mat4::from(local)).unwrap(),
                ..joint.clone()
            });
            articulation
                .joints
                .push(self.articulation.joints[j].clone());
        }
        Self {
            skeleton,
            articulation,
            clips: Vec::new(),
        }
    }

    /// Inserts a joint without a twin between `above` and `below`, in line or as a sibling.
    pub(crate) fn with_joint(&self, name: &str, above: &str, below: &str, in_line: bool) -> Self {
        let (above, below) = (self.find(above), self.find(below));
        let mut new = self.clone();
        new.clips.clear();
        let offset = self.skeleton.joints[below].rest.translation;
        let at = above + 1;
        for joint in &mut new.skeleton.joints {
            joint.parent = joint.parent.map(|p| if p >= at { p + 1 } else { p });
        }
        let rest = Transform::from_translation(0.5 * offset);
        let joint = Joint {
            name: name.to_owned(),
            parent: Some(above),
            rest,
            in_skin: true,
        };
        new.skeleton.joints.insert(at, joint);
        new.articulation.joints.insert(
            at,
            JointArticulation {
                hanim: None,
                level: 5,
                region: Region::Arms,
            },
        );
        if in_line {
            new.skeleton.joints[below + 1].parent = Some(at);
            new.skeleton.joints[below + 1].rest.translation = 0.5 * offset;
        }
        new
    }
}

pub(crate) fn rest_pose(skeleton: &Skeleton) -> LocalPose {
    skeleton.joints.iter().map(|j| j.rest).collect()
}

pub(crate) fn matrices(skeleton: &Skeleton, local: impl Fn(usize) -> Transform) -> Vec<Affine3A> {
    let mut matrices: Vec<Affine3A> = Vec::new();
    for (j, joint) in skeleton.joints.iter().enumerate() {
        let local = local(j).to_affine();
        matrices.push(joint.parent.map_or(local, |p| matrices[p] * local));
    }
    matrices
}

pub(crate) fn rotation(matrix: &Affine3A) -> Quat {
    matrix.to_scale_rotation_translation().1
}

/// Channels of rotation and translation of every joint.
fn keyed(joints: usize, times: &[f32], local: impl Fn(usize, usize) -> Transform) -> Vec<Channel> {
    let mut channels = Vec::new();
    for j in 0..joints {
        let mut last = Quat::IDENTITY;
        let mut rotations = Vec::new();
        let mut translations = Vec::new();
        for f in 0..times.len() {
            let transform = local(j, f);
            last = same_hemisphere(last, transform.rotation);
            rotations.extend(last.to_array());
            translations.extend(transform.translation.to_array());
        }
        for (property, values) in [
            (Property::Rotation, rotations),
            (Property::Translation, translations),
        ] {
            channels.push(Channel {
                target: j,
                property,
                interpolation: Interpolation::Linear,
                times_secs: times.to_vec(),
                values,
            });
        }
    }
    channels
}

/// Maximum distance between the joints of two lists.
pub(crate) fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    let away = a.iter().zip(b).map(|(a, b)| a.distance(*b));
    away.fold(0.0, f32::max)
}

/// Rotations of the reference human's joints that raise the arms: by 90 degrees for a T-pose, by 45
/// for an A-pose.
pub(crate) fn arms_up(degrees: f32) -> impl Fn(&str) -> Quat {
    move |name| match name {
        "l_shoulder" => Quat::from_rotation_z(degrees.to_radians()),
        "r_shoulder" => Quat::from_rotation_z(-degrees.to_radians()),
        _ => Quat::IDENTITY,
    }
}

/// No change of axes.
pub(crate) fn as_it_is(_: usize) -> Affine3A {
    Affine3A::IDENTITY
}

/// An H-Anim joint and its rotation from rest at a time in seconds.
pub(crate) type Turned = (&'static str, fn(f32) -> Quat);

/// A motion of the reference human whose joints are turned from rest, in model space, by an amount
/// that depends on time.
pub(crate) fn posed(human: &Human, turns: &[Turned]) -> RawClip {
    let times: Vec<f32> = (0..=60).map(|f| f as f32 / 30.0).collect();
    let channel = |(name, turn): &Turned| {
        let joint = human.find(name);
        // The reference human's joints are not turned at rest.
        assert_eq!(human.skeleton.joints[joint].rest.rotation, Quat::IDENTITY);
        Channel {
            target: joint,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: times.clone(),
            values: times.iter().flat_map(|t| turn(*t).to_array()).collect(),
        }
    };
    RawClip {
        name: "posed".to_owned(),
        duration_secs: 2.0,
        channels: turns.iter().map(channel).collect(),
    }
}
