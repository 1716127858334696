//! A clip as places of joints in model space, frame by frame: what writers of formats that know
//! neither scale nor other nodes than joints start from.

use articula_core::LocalPose;
use articula_core::source::{RawClip, Skeleton, evaluate};
use glam::{Affine3A, Mat3A, Quat, Vec3};

/// A position that moves by more than this share of the figure is written.
const STILL: f32 = 1e-5;

/// Where a joint is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// In model space, metres.
    pub(crate) position: Vec3,
    /// The way from the parent, in model space; computed without the position, so that it
    /// keeps its digits far from the origin. A root's position.
    pub(crate) from_parent: Vec3,
    /// Of the joint's axes in model space.
    pub(crate) rotation: Quat,
}

/// Joints to write, each followed by its descendants: without a skin all of them, with one its
/// joints and what stands above them.
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

/// Places of all joints at rest.
pub(crate) fn rest(skeleton: &Skeleton) -> Vec<Place> {
    places(skeleton, &rest_pose(skeleton))
}

/// Shows the places of all joints at every frame of a clip, sampled at a uniform rate.
pub(crate) fn each_frame(
    skeleton: &Skeleton,
    clip: &RawClip,
    rate_hz: f32,
    mut show: impl FnMut(&[Place]),
) {
    let mut pose = rest_pose(skeleton);
    let count = (clip.duration_secs.max(0.0) * rate_hz).round() as usize + 1;
    for frame in 0..count {
        let time_secs = (frame as f64 / f64::from(rate_hz)) as f32;
        evaluate::pose(clip, skeleton, time_secs, &mut pose);
        show(&places(skeleton, &pose));
    }
}

/// The distance below which a joint does not move against its parent, in metres.
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

/// The rotation in a matrix; none if it is singular.
fn rotation(matrix: Mat3A) -> Quat {
    let (_, rotation, _) = Affine3A::from_mat3(matrix.into()).to_scale_rotation_translation();
    let whole = rotation.is_finite() && rotation.length() > 0.5;
    if whole {
        rotation.normalize()
    } else {
        Quat::IDENTITY
    }
}
