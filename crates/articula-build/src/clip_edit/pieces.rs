//! Linear pieces that follow a motion: the times of their keys, and channels of them.

use articula_core::LibmQuat;
use articula_core::source::{Channel, Interpolation, JUMP_SECS, Property};
use articula_core::{Transform, same_hemisphere};

/// Maximum number of halvings of one interval between two keys of the source.
const MAX_HALVINGS: usize = 5;

/// Returns rising key times with more of them where straight pieces do not follow the motion.
/// `frame` is the motion at a time; `follows` tells whether the piece between two frames passes
/// through a third one at a fraction of the time between them. There must be a key.
pub(crate) fn times<F>(
    keys: &[f32],
    frame: &mut dyn FnMut(f32) -> F,
    follows: &dyn Fn(&F, &F, f32, &F) -> bool,
) -> Vec<f32> {
    let mut all = vec![keys[0]];
    let mut before = (keys[0], frame(keys[0]));
    let mut pieces = Pieces { frame, follows };
    for t in &keys[1..] {
        let after = (*t, (pieces.frame)(*t));
        pieces.refine(&before, &after, MAX_HALVINGS, &mut all);
        all.push(*t);
        before = after;
    }
    all
}

struct Pieces<'a, F> {
    frame: &'a mut dyn FnMut(f32) -> F,
    follows: &'a dyn Fn(&F, &F, f32, &F) -> bool,
}

impl<F> Pieces<'_, F> {
    fn refine(&mut self, a: &(f32, F), b: &(f32, F), halvings: usize, times: &mut Vec<f32>) {
        let secs = 0.5 * (a.0 + b.0);
        if halvings == 0 || b.0 - a.0 <= 2.0 * JUMP_SECS {
            return;
        }
        let at = |t: f32| a.0 + (b.0 - a.0) * t;
        let mut follows = |t: &f32| (self.follows)(&a.1, &b.1, *t, &(self.frame)(at(*t)));
        if [0.25, 0.5, 0.75].iter().all(&mut follows) {
            return;
        }
        let middle = (secs, (self.frame)(secs));
        self.refine(a, &middle, halvings - 1, times);
        times.push(secs);
        self.refine(&middle, b, halvings - 1, times);
    }
}

/// A joint whose local transforms are computed.
pub(crate) struct ComputedJoint<'a> {
    pub(crate) joint: usize,
    pub(crate) rest: Transform,
    /// Whether a property has a channel, which is then kept even if the joint rests.
    pub(crate) is_keyed: &'a dyn Fn(Property) -> bool,
}

impl ComputedJoint<'_> {
    /// Returns linear channels of local transforms at rising times; one key where they are constant,
    /// no channel where they are at rest.
    pub(crate) fn channels(&self, times: &[f32], locals: &[Transform]) -> Vec<Channel> {
        let mut locals = locals.to_vec();
        for i in 1..locals.len() {
            let before = locals[i - 1].rotation;
            locals[i].rotation = same_hemisphere(before, locals[i].rotation);
        }
        let channel = |property, width: usize, value: fn(&Transform) -> Vec<f32>| {
            let mut out = Channel {
                target: self.joint,
                property,
                interpolation: Interpolation::Linear,
                times_secs: times.to_vec(),
                values: locals.iter().flat_map(value).collect(),
            };
            let same = |a: &[f32], b: &[f32]| {
                let size = b.iter().fold(1e-3f32, |s, v| s.max(v.abs()));
                a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * size)
            };
            let first = out.values[..width].to_vec();
            if out.values.chunks(width).all(|v| same(v, &first)) {
                out.times_secs.truncate(1);
                out.values.truncate(width);
            }
            let needed = out.times_secs.len() > 1
                || !same(&first, &value(&self.rest))
                || (self.is_keyed)(property);
            needed.then_some(out)
        };
        let turns = |t: &Transform| t.rotation.to_array().to_vec();
        [
            channel(Property::Translation, 3, |t| {
                t.translation.to_array().to_vec()
            }),
            channel(Property::Rotation, 4, turns),
            channel(Property::Scale, 3, |t| t.scale.to_array().to_vec()),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// The transform at a fraction of a straight piece.
pub(crate) fn blend(a: Transform, b: Transform, t: f32) -> Transform {
    Transform {
        translation: a.translation.lerp(b.translation, t),
        rotation: a
            .rotation
            .libm_slerp(same_hemisphere(a.rotation, b.rotation), t),
        scale: a.scale.lerp(b.scale, t),
    }
}
