//! How far joints and skin are from where they were.

use super::tree::Tree;
use crate::key_times::rising;
use articula_core::LocalPose;
use articula_core::source::{Character, JUMP_SECS, Primitive, RawClip, Skeleton, Skin, evaluate};
use glam::{Affine3A, Vec3};

/// Maximum number of times at which a clip is measured.
const MAX_TIMES: usize = 400;

/// Maximum distance of a kept joint, and of a vertex, from where it was.
pub(super) fn largest_distances(before: &Character, after: &Tree) -> (f32, f32) {
    let vertices = vertices(before, after);
    let (mut joints, mut skin) = (0.0_f32, 0.0_f32);
    let clips = before.clips.iter().zip(&after.character.clips);
    for (old, new) in clips {
        let mut channels = old.channels.iter().filter(|c| c.property.is_of_joint());
        let moves = channels.any(|c| after.removed.contains(&c.target));
        let times = if moves { times(old, new) } else { vec![0.0] };
        for secs in times {
            let was = model(&before.skeleton, old, secs);
            let is = model(&after.character.skeleton, new, secs);
            for (now, then) in is.iter().zip(&after.before) {
                if let Some(then) = then {
                    joints = joints.max(now.translation.distance(was[*then].translation));
                }
            }
            for vertex in &vertices {
                let apart = vertex.old.place(&was).distance(vertex.new.place(&is));
                skin = skin.max(apart);
            }
        }
    }
    (joints, skin)
}

/// Keys of both clips and the times halfway between them, without the moves that stand for jumps.
fn times(old: &RawClip, new: &RawClip) -> Vec<f32> {
    let channels = old.channels.iter().chain(&new.channels);
    let keys = rising(channels.flat_map(|c| &c.times_secs).copied().collect());
    let between = keys.windows(2).filter(|w| w[1] - w[0] > 2.0 * JUMP_SECS);
    let between: Vec<f32> = between.map(|w| 0.5 * (w[0] + w[1])).collect();
    let all = rising(keys.into_iter().chain(between).collect());
    let step = all.len().div_ceil(MAX_TIMES).max(1);
    all.into_iter().step_by(step).collect()
}

fn model(skeleton: &Skeleton, clip: &RawClip, secs: f32) -> Vec<Affine3A> {
    let mut pose: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
    evaluate::pose(clip, skeleton, secs, &mut pose);
    let mut model: Vec<Affine3A> = Vec::with_capacity(skeleton.joints.len());
    for (j, joint) in skeleton.joints.iter().enumerate() {
        let above = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
        model.push(above * pose.get(j).to_affine());
    }
    model
}

/// A vertex before and after.
struct Vertex {
    old: Bound,
    new: Bound,
}

/// Position of a vertex in the space of each joint that moves it, with its weight.
struct Bound(Vec<(usize, f32, Vec3)>);

impl Bound {
    fn of(skin: &Skin, primitive: &Primitive, vertex: usize) -> Self {
        let position = primitive.positions[vertex];
        let slots = vertex * primitive.influences..(vertex + 1) * primitive.influences;
        let influences = primitive.joints[slots.clone()]
            .iter()
            .zip(&primitive.weights[slots]);
        let bound = influences
            .filter(|(_, w)| **w > 0.0)
            .filter_map(|(slot, weight)| {
                let slot = usize::from(*slot);
                let (joint, bind) = (skin.joints.get(slot)?, skin.inverse_bind.get(slot)?);
                Some((*joint, *weight, bind.transform_point3(position)))
            });
        Self(bound.collect())
    }

    fn place(&self, model: &[Affine3A]) -> Vec3 {
        let parts = self.0.iter();
        parts
            .map(|(joint, weight, at)| model[*joint].transform_point3(*at) * *weight)
            .sum()
    }
}

/// The vertices that a removed joint moved, or moves that took its rotation.
fn vertices(before: &Character, after: &Tree) -> Vec<Vertex> {
    let is_named = |joint: &usize| after.removed.contains(joint) || after.taking.contains(joint);
    let mut found = Vec::new();
    for (old, new) in before.meshes.iter().zip(&after.character.meshes) {
        if !old.skin.joints.iter().any(is_named) {
            continue;
        }
        for (a, b) in old.primitives.iter().zip(&new.primitives) {
            let each = a.influences;
            let fits = |p: &Primitive| {
                let slots = p.positions.len() * each;
                p.joints.len() == slots && p.weights.len() == slots
            };
            if !fits(a) || !fits(b) || b.influences != each {
                continue;
            }
            for vertex in 0..a.positions.len() {
                let bound = Bound::of(&old.skin, a, vertex);
                if bound.0.iter().any(|(joint, ..)| is_named(joint)) {
                    found.push(Vertex {
                        old: bound,
                        new: Bound::of(&new.skin, b, vertex),
                    });
                }
            }
        }
    }
    found
}
