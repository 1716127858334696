//! Selection of the keys of one channel that are kept, and the first selection by that channel's
//! own share of the bound.

use super::super::channel;
use super::super::subject::EditSubject;
use super::observed::Observed;
use super::{ReduceOptions, Timelines};
use crate::motion_error::keys::central_rotation;
use crate::motion_error::runs::long_runs;
use articula_core::LibmQuat;
use articula_core::source::{Channel, Interpolation, Property};
use articula_core::{angle_between, same_hemisphere};
use glam::Quat;

/// Larger rotations are followed regardless of what they move: between two keys of a slerp the
/// shorter arc must not be in doubt.
const MAX_RADIANS: f32 = 0.5;

/// Share of the bound with which every channel starts, more than the whole: putting keys back where
/// errors add up is cheaper than finding out where they do not. On captured and hand-made motion of
/// 25 to 163 joints, at 1 and 10 mm, half of this share results in up to a third more floats, four
/// times this share in the same within 3 %.
const FIRST_SHARE: f32 = 2.0;

/// Maximum error of an expression value, whose range is 1. The displacement depends on all other
/// expressions that are driven at once; a full expression moves skin by centimetres, so this
/// corresponds to micrometres.
const SAME_EXPRESSION: f32 = 1e-4;

/// The part of a channel that is kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum KeptKeys {
    /// Nothing: the rest pose has the same value.
    Rest,
    /// One constant value.
    Still(Vec<f32>),
    /// Some of its keys, ascending; the first and the last are among them.
    Keys(Vec<usize>),
}

/// A channel of the source and its kept keys.
#[derive(Debug, Clone)]
pub(super) struct Choice<'a> {
    pub(super) source: &'a Channel,
    pub(super) kept: KeptKeys,
    /// Value at rest.
    rest: Vec<f32>,
}

impl<'a> Choice<'a> {
    /// The channel that is played; a channel at rest too, so that indices stay the same.
    pub(super) fn shown(&self) -> Channel {
        let still = |value: &[f32]| Channel {
            interpolation: match self.source.interpolation {
                Interpolation::Step => Interpolation::Step,
                _ => Interpolation::Linear,
            },
            times_secs: vec![0.0],
            values: value.to_vec(),
            ..self.source.clone()
        };
        match &self.kept {
            KeptKeys::Rest => still(&self.rest),
            KeptKeys::Still(value) => still(value),
            KeptKeys::Keys(keys) => {
                let floats = self.source.values.len() / self.source.times_secs.len();
                let values = keys
                    .iter()
                    .map(|k| &self.source.values[k * floats..(k + 1) * floats]);
                Channel {
                    target: self.source.target,
                    property: self.source.property,
                    interpolation: self.source.interpolation,
                    times_secs: keys.iter().map(|k| self.source.times_secs[*k]).collect(),
                    values: values.flatten().copied().collect(),
                }
            }
        }
    }

    /// The dropped key nearest to a time, among those between the kept keys around that time.
    pub(super) fn missing(&self, secs: f32) -> Option<usize> {
        let times = &self.source.times_secs;
        let nearest = |from: usize, to: usize| {
            let distance = |k: &usize| (times[*k] - secs).abs();
            (from..to).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let KeptKeys::Keys(keys) = &self.kept else {
            return nearest(0, times.len());
        };
        let after = keys.partition_point(|k| times[*k] <= secs);
        let (before, after) = (*keys.get(after.checked_sub(1)?)?, *keys.get(after)?);
        if self.source.interpolation == Interpolation::Step {
            return (before + 1..after).rev().find(|k| times[*k] <= secs);
        }
        nearest(before + 1, after)
    }

    /// Whether it keeps keys, and not this one.
    pub(super) fn lacks(&self, key: usize) -> bool {
        matches!(&self.kept, KeptKeys::Keys(keys) if keys.binary_search(&key).is_err())
    }

    /// Whether it keeps more than one value.
    pub(super) fn keeps_keys(&self) -> bool {
        matches!(self.kept, KeptKeys::Keys(_))
    }

    /// Keeps the keys of another channel, if it kept none.
    pub(super) fn join(&mut self, kept: KeptKeys) {
        if !self.keeps_keys() {
            self.kept = kept;
        }
    }

    /// Keeps one more key and returns the interval in which the channel has changed.
    pub(super) fn keep(&mut self, key: usize) -> (f32, f32) {
        let last = self.source.times_secs.len() - 1;
        let KeptKeys::Keys(keys) = &mut self.kept else {
            let mut keys = vec![0, key, last];
            keys.dedup();
            self.kept = KeptKeys::Keys(keys);
            return (f32::NEG_INFINITY, f32::INFINITY);
        };
        let at = keys.partition_point(|k| *k < key);
        if keys.get(at) == Some(&key) {
            // It came with the keys of another channel.
            return (f32::NEG_INFINITY, f32::INFINITY);
        }
        keys.insert(at, key);
        let times = &self.source.times_secs;
        (times[keys[at - 1]], times[keys[at + 1]])
    }
}

/// The first selection for every channel, at its share of the bound.
pub(super) fn first<'a>(observed: &Observed<'a>, opts: &ReduceOptions) -> Vec<Choice<'a>> {
    let (subject, clip, morphs) = (observed.subject, observed.clip, &observed.morphs);
    let levers = observed.watch.levers(subject);
    let near: Vec<_> = clip
        .channels
        .iter()
        .enumerate()
        .map(|(c, source)| {
            let metres = if source.property == Property::Weights {
                // The other half is left to the joints that carry the same skin.
                0.5 * opts.bound_metres
            } else {
                FIRST_SHARE * opts.bound_metres
            };
            let tolerance = tolerance(subject, source, &levers, metres);
            move |a: &[f32], b: &[f32]| match source.property {
                Property::Weights => morphs.is_within(c, a, b, metres),
                _ => distance(source.property, a, b) <= tolerance,
            }
        })
        .collect();
    let each = clip.channels.iter().zip(&near);
    let mut choices: Vec<Choice<'a>> = each
        .map(|(source, near)| {
            let rest = rest(subject, source);
            Choice {
                kept: kept(source, &rest, opts.drop_rest, near),
                rest,
                source,
            }
        })
        .collect();
    if opts.timelines == Timelines::Shared {
        share(&mut choices, &near);
    }
    choices
}

/// Lets channels whose keys have the same times keep the same ones: the ends of the longest runs that
/// all of them can omit.
fn share(choices: &mut [Choice<'_>], near: &[impl Fn(&[f32], &[f32]) -> bool]) {
    let keeps = |choice: &Choice<'_>| {
        let is_linear = choice.source.interpolation != Interpolation::CubicSpline;
        is_linear && choice.keeps_keys()
    };
    let mut is_done = vec![false; choices.len()];
    for first in 0..choices.len() {
        if is_done[first] || !keeps(&choices[first]) {
            continue;
        }
        let times = choices[first].source.times_secs.clone();
        let is_member = |c: &usize| keeps(&choices[*c]) && choices[*c].source.times_secs == times;
        let members: Vec<usize> = (first..choices.len()).filter(is_member).collect();
        let fits = |from: usize, to: usize| {
            members.iter().all(|c| {
                let source = choices[*c].source;
                (from + 1..to)
                    .all(|k| near[*c](&between(source, from, to, k), channel::key_value(source, k)))
            })
        };
        let ends = long_runs(times.len() - 1, fits);
        let keys: Vec<usize> = std::iter::once(0).chain(ends).collect();
        for c in members {
            is_done[c] = true;
            choices[c].kept = KeptKeys::Keys(keys.clone());
        }
    }
}

/// Restores all keys of channels that have lost so few that the times of the remaining ones, which
/// they share with no other channel, cost more than they save; returns whether it did.
pub(super) fn give_back(choices: &mut [Choice<'_>]) -> bool {
    let mut groups: Vec<(&[f32], Vec<usize>, usize)> = Vec::new();
    for (c, choice) in choices.iter().enumerate() {
        let times = choice.source.times_secs.as_slice();
        let KeptKeys::Keys(keys) = &choice.kept else {
            continue;
        };
        let width = choice.source.values.len() / times.len();
        // Kept keys with separate times, compared with all values.
        let saved = (keys.len() * (width + 1)).saturating_sub(times.len() * width);
        if keys.len() == times.len() || saved == 0 {
            continue;
        }
        match groups.iter_mut().find(|(t, _, _)| *t == times) {
            Some((_, members, sum)) => {
                members.push(c);
                *sum += saved;
            }
            None => groups.push((times, vec![c], saved)),
        }
    }
    groups.retain(|(times, _, saved)| *saved > times.len());
    let members: Vec<usize> = groups
        .into_iter()
        .flat_map(|(_, members, _)| members)
        .collect();
    for c in &members {
        let keys = choices[*c].source.times_secs.len();
        choices[*c].kept = KeptKeys::Keys((0..keys).collect());
    }
    !members.is_empty()
}

/// The kept part of a channel whose values may differ as far as `near` accepts.
fn kept(
    source: &Channel,
    rest: &[f32],
    drop_rest: bool,
    near: impl Fn(&[f32], &[f32]) -> bool,
) -> KeptKeys {
    let keys = source.times_secs.len();
    let value = |k: usize| channel::key_value(source, k);
    let all_near = |to: &[f32]| (0..keys).all(|k| near(value(k), to));
    // A spline is constant only if nothing bends it, and loses no keys otherwise.
    let cubic = source.interpolation == Interpolation::CubicSpline;
    if cubic && keys > 1 && !is_flat(source) {
        return KeptKeys::Keys((0..keys).collect());
    }
    if drop_rest && all_near(rest) {
        return KeptKeys::Rest;
    }
    let middle = middle(source);
    if all_near(&middle) {
        return KeptKeys::Still(middle);
    }
    let fits = |from: usize, to: usize| {
        (from + 1..to).all(|k| near(&between(source, from, to, k), value(k)))
    };
    let ends = long_runs(keys - 1, fits);
    KeptKeys::Keys(std::iter::once(0).chain(ends).collect())
}

/// Whether a spline has one value and no slope.
fn is_flat(source: &Channel) -> bool {
    let width = channel::width(source);
    let first = channel::key_value(source, 0);
    source.values.chunks(3 * width).all(|key| {
        let slopes = key[..width].iter().chain(&key[2 * width..]);
        key[width..2 * width] == *first && slopes.into_iter().all(|s| *s == 0.0)
    })
}

/// The constant value with the smallest maximum error; the value itself if it never changes.
fn middle(source: &Channel) -> Vec<f32> {
    let first = channel::key_value(source, 0);
    let keys = source.times_secs.len();
    let values = || (0..keys).map(|k| channel::key_value(source, k));
    if values().all(|v| v == first) {
        return first.to_vec();
    }
    if source.property == Property::Rotation {
        let turns: Vec<Quat> = values().map(Quat::from_slice).collect();
        let central = central_rotation(&turns).unwrap_or(turns[0]);
        return central.to_array().to_vec();
    }
    let (mut low, mut high) = (first.to_vec(), first.to_vec());
    for value in values() {
        for (i, v) in value.iter().enumerate() {
            low[i] = low[i].min(*v);
            high[i] = high[i].max(*v);
        }
    }
    low.iter().zip(&high).map(|(l, h)| 0.5 * (l + h)).collect()
}

/// The value that two keys interpolate at the time of a key between them.
fn between(source: &Channel, from: usize, to: usize, at: usize) -> Vec<f32> {
    let [a, b] = [from, to].map(|k| channel::key_value(source, k));
    if source.interpolation == Interpolation::Step {
        return a.to_vec();
    }
    let secs = |k: usize| source.times_secs[k];
    let t = (secs(at) - secs(from)) / (secs(to) - secs(from));
    if source.property == Property::Rotation {
        let [a, b] = [a, b].map(Quat::from_slice);
        return a.libm_slerp(same_hemisphere(a, b), t).to_array().to_vec();
    }
    a.iter().zip(b).map(|(a, b)| a + (b - a) * t).collect()
}

/// Distance of two values: radians for rotations, otherwise in the unit of the values.
pub(super) fn distance(property: Property, a: &[f32], b: &[f32]) -> f32 {
    if property == Property::Rotation {
        return angle_between(Quat::from_slice(a), Quat::from_slice(b));
    }
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f32>().sqrt()
}

/// Tolerance of a channel's values with which nothing below the joint moves by more than `metres`.
fn tolerance(subject: &EditSubject<'_>, source: &Channel, levers: &[f32], metres: f32) -> f32 {
    let joint = source.target;
    match source.property {
        Property::Rotation => (metres / levers[joint]).min(MAX_RADIANS),
        Property::Translation => {
            let parent = subject.rig.parent(joint);
            metres / parent.map_or(1.0, |p| subject.scale_at_rest(p))
        }
        Property::Scale => {
            let scale = subject.rig.rest_pose().scales[joint];
            metres / levers[joint] * scale.abs().min_element()
        }
        Property::Weights => metres,
        Property::Expression => SAME_EXPRESSION,
    }
}

/// As [`tolerance`], and for weights of morph targets in their unit.
pub(super) fn value_tolerance(
    subject: &EditSubject<'_>,
    source: &Channel,
    levers: &[f32],
    metres: f32,
) -> f32 {
    if source.property != Property::Weights {
        return tolerance(subject, source, levers, metres);
    }
    let mesh = &subject.mesh;
    let first = mesh.morph_slots[source.target];
    let slots = first..first + subject.morph_counts[source.target];
    let own = mesh
        .morphs
        .iter()
        .filter(|m| slots.contains(&usize::from(m.slot)));
    let offsets = own.flat_map(|morph| &morph.positions);
    let reach = offsets.map(|offset| offset.length()).fold(0.0, f32::max);
    (metres / reach.max(1e-6)).min(1.0)
}

fn rest(subject: &EditSubject<'_>, source: &Channel) -> Vec<f32> {
    if source.property == Property::Weights {
        let slot = subject.mesh.morph_slots[source.target];
        let count = subject.morph_counts[source.target];
        return subject.mesh.morph_weights[slot..slot + count].to_vec();
    }
    if source.property == Property::Expression {
        return vec![0.0];
    }
    let rest = subject.rig.rest_pose().get(source.target);
    match source.property {
        Property::Rotation => rest.rotation.to_array().to_vec(),
        Property::Scale => rest.scale.to_array().to_vec(),
        _ => rest.translation.to_array().to_vec(),
    }
}
