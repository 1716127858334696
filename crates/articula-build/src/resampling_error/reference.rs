//! Clips evaluated in double precision: the keys of a file, and what is played in their place.
//!
//! Written for measurements alone. It shares with what makes clips the masks of expressions and the
//! times of jumps, and no evaluation; `oracle/resampling.mjs` shares nothing.

use super::Played;
use crate::expression::resolve;
use articula_core::LibmQuat;
use articula_core::source::{
    Channel, Character, Expression, Interpolation, JointBinding, Property, RawClip, Skeleton,
};
use articula_core::{Clip, Mesh, Track, Transform};
use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4, Quat, Vec3};

/// A local transform.
#[derive(Debug, Clone, Copy)]
struct Local {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

/// A pose of joints in model space, and the weights of the morph slots.
#[derive(Debug, Clone)]
pub(super) struct Pose {
    pub(super) model: Vec<DAffine3>,
    pub(super) weights: Vec<f64>,
}

/// Poses a character.
#[derive(Clone, Copy)]
pub(super) struct Reference<'a> {
    pub(super) character: &'a Character,
    pub(super) mesh: &'a Mesh,
}

impl From<Transform> for Local {
    fn from(t: Transform) -> Self {
        Self {
            translation: t.translation.as_dvec3(),
            rotation: t.rotation.as_dquat(),
            scale: t.scale.as_dvec3(),
        }
    }
}

impl Reference<'_> {
    /// The pose of what is played at a time.
    pub(super) fn played(&self, played: &Played<'_>, secs: f64) -> Pose {
        match played {
            Played::Frames(clip) => self.frames(clip, secs),
            Played::Keys { clip, .. } => self.keys(clip, secs),
        }
    }

    /// The pose of the keys of a clip at a time, with the expressions that they drive.
    pub(super) fn keys(&self, clip: &RawClip, secs: f64) -> Pose {
        let (mut locals, mut weights) = self.rest();
        let mut driven = vec![0.0f32; self.character.expressions.len()];
        for channel in &clip.channels {
            let value = at(channel, secs);
            let target = channel.target;
            match channel.property {
                Property::Translation => locals[target].translation = DVec3::from_slice(&value),
                Property::Scale => locals[target].scale = DVec3::from_slice(&value),
                Property::Rotation => locals[target].rotation = unit(DVec4::from_slice(&value)),
                Property::Weights => {
                    let first = self.mesh.morph_slots[target];
                    let slots = weights.iter_mut().skip(first);
                    slots.zip(value).for_each(|(slot, value)| *slot = value);
                }
                Property::Expression => driven[target] = value[0] as f32,
            }
        }
        let expressions = &self.character.expressions;
        for (expression, value) in expressions.iter().zip(resolve(expressions, &driven)) {
            self.drive(expression, f64::from(value), &mut locals, &mut weights);
        }
        self.placed(&locals, weights)
    }

    fn drive(
        &self,
        expression: &Expression,
        value: f64,
        locals: &mut [Local],
        weights: &mut [f64],
    ) {
        if value == 0.0 {
            return;
        }
        for morph in &expression.morphs {
            let slot = self.mesh.morph_slots[morph.mesh] + morph.target;
            weights[slot] += value * f64::from(morph.weight);
        }
        for JointBinding { joint, full } in &expression.joints {
            let rest = Local::from(self.character.skeleton.joints[*joint].rest);
            let full = Local::from(*full);
            let local = &mut locals[*joint];
            local.translation += value * (full.translation - rest.translation);
            local.scale += value * (full.scale - rest.scale);
            let turn = rest.rotation.conjugate() * full.rotation;
            local.rotation *= DQuat::IDENTITY.libm_slerp(turn, value);
        }
    }

    /// The pose of a clip of uniform rate at a time.
    fn frames(&self, clip: &Clip, secs: f64) -> Pose {
        let (mut locals, mut weights) = self.rest();
        let tracks = clip.tracks();
        let frame = Frame::new(clip, secs);
        let vector = |v: Vec3| v.as_dvec3().extend(0.0);
        for track in &tracks.translations {
            locals[usize::from(track.target)].translation = frame.value(track, vector).truncate();
        }
        for track in &tracks.scales {
            locals[usize::from(track.target)].scale = frame.value(track, vector).truncate();
        }
        for track in &tracks.rotations {
            let value = frame.value(track, |q: Quat| DVec4::from(q.as_dquat()));
            locals[usize::from(track.target)].rotation = unit(value);
        }
        for track in &tracks.morphs {
            let value = frame.value(track, |w: f32| DVec4::splat(f64::from(w)));
            if let Some(weight) = weights.get_mut(usize::from(track.target)) {
                *weight = value.x;
            }
        }
        self.placed(&locals, weights)
    }

    fn rest(&self) -> (Vec<Local>, Vec<f64>) {
        let joints = self.character.skeleton.joints.iter();
        let weights = self.mesh.morph_weights.iter().map(|w| f64::from(*w));
        (joints.map(|j| j.rest.into()).collect(), weights.collect())
    }

    fn placed(&self, locals: &[Local], weights: Vec<f64>) -> Pose {
        let Skeleton { joints } = &self.character.skeleton;
        let mut model: Vec<DAffine3> = Vec::with_capacity(locals.len());
        for (local, joint) in locals.iter().zip(joints) {
            let turned = DMat3::from_quat(local.rotation);
            let matrix3 = turned * DMat3::from_diagonal(local.scale);
            let own = DAffine3::from_mat3_translation(matrix3, local.translation);
            let above = joint.parent.and_then(|p| model.get(p)).copied();
            model.push(above.map_or(own, |above| above * own));
        }
        Pose { model, weights }
    }
}

/// A time between two frames.
struct Frame {
    /// The frame that steps show.
    held: usize,
    before: usize,
    blend: f64,
}

impl Frame {
    fn new(clip: &Clip, secs: f64) -> Self {
        let last = (clip.frames() - 1) as f64;
        let at = (secs * f64::from(clip.rate_hz())).clamp(0.0, last);
        Self {
            // A key that differs from a frame by rounding is that frame.
            held: (at + 1e-3).min(last) as usize,
            before: at as usize,
            blend: at.fract(),
        }
    }

    /// The value of a track, as a vector that the caller normalises where it is a rotation.
    fn value<T: Copy>(&self, track: &Track<T>, vector: impl Fn(T) -> DVec4) -> DVec4 {
        let last = track.values.len() - 1;
        if track.step {
            return vector(track.values[self.held.min(last)]);
        }
        let before = vector(track.values[self.before.min(last)]);
        let after = vector(track.values[(self.before + 1).min(last)]);
        before + (after - before) * self.blend
    }
}

/// The value of a channel at a time, as appendix C of the glTF 2.0 specification defines it.
fn at(channel: &Channel, secs: f64) -> Vec<f64> {
    let parts = match channel.interpolation {
        Interpolation::CubicSpline => 3,
        _ => 1,
    };
    let times = &channel.times_secs;
    let width = channel.values.len() / (parts * times.len());
    let part = |key: usize, part: usize| {
        let first = (key * parts + part) * width;
        let floats = channel.values[first..first + width].iter();
        floats.map(|v| f64::from(*v)).collect::<Vec<f64>>()
    };
    let value = |key| part(key, parts / 2);
    let next = times.partition_point(|t| f64::from(*t) <= secs);
    if next == 0 || next == times.len() || channel.interpolation == Interpolation::Step {
        return value(next.saturating_sub(1));
    }
    let (from, to) = (f64::from(times[next - 1]), f64::from(times[next]));
    let span = to - from;
    let u = (secs - from) / span;
    let (a, b) = (value(next - 1), value(next));
    match (channel.interpolation, channel.property) {
        (Interpolation::CubicSpline, _) => {
            let (leaving, arriving) = (part(next - 1, 2), part(next, 0));
            let weights = [
                (1.0 + 2.0 * u) * (1.0 - u) * (1.0 - u),
                span * u * (1.0 - u) * (1.0 - u),
                u * u * (3.0 - 2.0 * u),
                span * u * u * (u - 1.0),
            ];
            let blend = |i: usize| {
                let of = [a[i], leaving[i], b[i], arriving[i]];
                of.iter().zip(weights).map(|(v, w)| v * w).sum()
            };
            (0..width).map(blend).collect()
        }
        (_, Property::Rotation) => {
            let [a, b] = [a, b].map(|v| unit(DVec4::from_slice(&v)));
            let b = if a.dot(b) < 0.0 { -b } else { b };
            a.libm_slerp(b, u).to_array().to_vec()
        }
        _ => a.iter().zip(&b).map(|(a, b)| a + (b - a) * u).collect(),
    }
}

fn unit(value: DVec4) -> DQuat {
    let length = value.length();
    if length > 1e-12 {
        DQuat::from_vec4(value / length)
    } else {
        DQuat::IDENTITY
    }
}
