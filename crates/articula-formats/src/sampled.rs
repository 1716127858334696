//! Joint positions and rotations of a clip in model space, frame by frame: the input of writers
//! whose formats have neither scale nor nodes other than joints.

use articula_core::LocalPose;
use articula_core::source::evaluate::Sampler;
use articula_core::source::{Channel, RawClip, Skeleton};
use glam::{Affine3A, Mat3A, Quat, Vec3};

/// Smallest movement of a position that is written, as a fraction of the figure's size.
const STILL: f32 = 1e-5;

/// Share of a frame by which a frame that shows a jump may be before it.
const JUMP_SHARE: f32 = 1e-3;

/// Position and rotation of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// In model space, metres.
    pub(crate) position: Vec3,
    /// Offset from the parent, in model space; computed without the position, so that it stays
    /// precise far from the origin. For a root, its position.
    pub(crate) from_parent: Vec3,
    /// Rotation of the joint's axes in model space.
    pub(crate) rotation: Quat,
}

/// Returns the joints to write, each followed by its descendants: without a skin all joints,
/// otherwise those of the skin and their ancestors.
pub(crate) fn depth_first(skeleton: &Skeleton) -> Vec<usize> {
    let joints = &skeleton.joints;
    let any_skin = joints.iter().any(|j| j.in_skin);
    let mut wanted: Vec<bool> = joints.iter().map(|j| j.in_skin || !any_skin).collect();
    let mut children = vec![Vec::new(); joints.len()];
    for (index, joint) in joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            wanted[parent] |= wanted[index];
            children[parent].push(index);
        }
    }
    let mut open: Vec<usize> = (0..joints.len())
        .rev()
        .filter(|&j| joints[j].parent.is_none())
        .collect();
    let mut order = Vec::new();
    while let Some(joint) = open.pop() {
        if wanted[joint] {
            order.push(joint);
            open.extend(&children[joint]);
        }
    }
    order
}

/// Returns position and rotation of all joints at rest.
pub(crate) fn rest(skeleton: &Skeleton) -> Vec<Place> {
    places(skeleton, &rest_pose(skeleton))
}

/// Calls a function with position and rotation of all joints at every frame of a clip, sampled at a
/// uniform rate.
pub(crate) fn each_frame(
    skeleton: &Skeleton,
    clip: &RawClip,
    rate_hz: f32,
    mut show: impl FnMut(&[Place]),
) {
    let mut pose = rest_pose(skeleton);
    let count = (clip.duration_secs.max(0.0) * rate_hz).round() as usize + 1;
    let mut jumps: Vec<f32> = clip.channels.iter().flat_map(Channel::jump_times).collect();
    jumps.sort_by(f32::total_cmp);
    let mut sampler = Sampler::new(clip, skeleton);
    for frame in 0..count {
        let time_secs = (frame as f64 / f64::from(rate_hz)) as f32;
        // A frame that differs from a jump by rounding shows what is after it.
        let near = JUMP_SHARE / rate_hz;
        let next = jumps.partition_point(|t| *t < time_secs);
        let jump = jumps.get(next).filter(|t| **t - time_secs < near);
        let time_secs = jump.copied().unwrap_or(time_secs);
        sampler.pose(time_secs, &mut pose);
        show(&places(skeleton, &pose));
    }
}

/// Returns the distance below which a joint counts as not moving against its parent, in metres.
pub(crate) fn still_metres(places: impl Iterator<Item = Vec3>) -> f32 {
    let (low, high) = places.fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(p), h.max(p)));
    STILL * (high - low).max_element()
}

fn rest_pose(skeleton: &Skeleton) -> LocalPose {
    let rests = || skeleton.joints.iter().map(|j| j.rest);
    LocalPose {
        translations: rests().map(|r| r.translation).collect(),
        rotations: rests().map(|r| r.rotation).collect(),
        scales: rests().map(|r| r.scale).collect(),
    }
}

fn places(skeleton: &Skeleton, pose: &LocalPose) -> Vec<Place> {
    let mut matrices: Vec<Affine3A> = Vec::with_capacity(skeleton.joints.len());
    let mut places = Vec::with_capacity(skeleton.joints.len());
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let local = pose.get(index).to_affine();
        let above = joint.parent.map_or(Affine3A::IDENTITY, |p| matrices[p]);
        let matrix = above * local;
        places.push(Place {
            position: matrix.translation.into(),
            from_parent: above.transform_vector3(local.translation.into()),
            rotation: rotation(matrix.matrix3),
        });
        matrices.push(matrix);
    }
    places
}

/// Returns the rotation of a matrix; the identity if it is singular.
fn rotation(matrix: Mat3A) -> Quat {
    let (_, rotation, _) = Affine3A::from_mat3(matrix.into()).to_scale_rotation_translation();
    let whole = rotation.is_finite() && rotation.length() > 0.5;
    if whole {
        rotation.normalize()
    } else {
        Quat::IDENTITY
    }
}
