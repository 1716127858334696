//! Baking of a clip's expressions into morph weights and joint transforms.
//!
//! The effects of several expressions on one morph target or joint add up, on top of the clip's own
//! channels.

use super::resolve;
use crate::clip::MAX_NUMBERS;
use crate::key_times::SAME_SECS;
use crate::sampling_rate::source_rate_hz;
use articula_core::LibmQuat;
use articula_core::source::{
    Channel, Character, Expression, Interpolation, JUMP_SECS, JointBinding, Property, RawClip,
    evaluate,
};
use articula_core::{Mismatch, Transform, same_hemisphere};
use glam::{Quat, Vec3};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Differences from rest, as an angle and for other values, up to which a property counts as not
/// driven.
const STILL_RADIANS: f32 = 1e-6;
const STILL: f32 = 1e-7;

/// Minimum frame rate where values bend or jump between keys.
const MIN_RATE_HZ: f32 = 30.0;

/// Converts the expressions of a clip to channels of morph weights and joints, which replace the
/// channels that drive expressions. Returns the clip itself if it drives no expression.
///
/// Where everything is linear between keys, the result is exact; where it bends or jumps (masks,
/// binary expressions, values beyond 0 and 1, splines) it is exact at all keys and at frames of the
/// clip's own rate, at least 30 per second, and linear between them.
///
/// # Errors
/// A [`Mismatch`] if a channel or a binding refers to something that does not exist or has too few
/// values, or if the result would exceed the memory limit.
pub fn bake<'a>(character: &Character, clip: &'a RawClip) -> Result<Cow<'a, RawClip>, Mismatch> {
    let is_driver = |c: &Channel| c.property == Property::Expression;
    if !clip.channels.iter().any(is_driver) {
        return Ok(Cow::Borrowed(clip));
    }
    for (c, channel) in clip.channels.iter().enumerate() {
        check(character, channel)
            .map_err(|what| Mismatch::new(format!("clip \"{}\".channels[{c}]", clip.name), what))?;
    }
    let baking = Baking::new(character, clip);
    let times = baking.times()?;
    let values = baking.values(&times);
    let mut channels: Vec<Channel> = Vec::new();
    for mesh in &baking.meshes {
        channels.push(baking.weights(*mesh, &times, &values));
    }
    for (joint, property) in &baking.joints {
        channels.push(baking.joint(*joint, *property, &times, &values));
    }
    let is_replaced = |c: &Channel| is_driver(c) || baking.is_replaced(c);
    let kept = clip.channels.iter().filter(|c| !is_replaced(c)).cloned();
    Ok(Cow::Owned(RawClip {
        name: clip.name.clone(),
        duration_secs: clip.duration_secs,
        channels: kept.chain(channels).collect(),
    }))
}

/// State of baking one clip.
struct Baking<'a> {
    character: &'a Character,
    clip: &'a RawClip,
    /// The channels that drive expressions, at most one per expression.
    drivers: Vec<&'a Channel>,
    /// Meshes that the driven expressions change.
    meshes: BTreeSet<usize>,
    joints: Vec<(usize, Property)>,
}

impl<'a> Baking<'a> {
    fn new(character: &'a Character, clip: &'a RawClip) -> Self {
        let is_driver = |c: &&Channel| c.property == Property::Expression;
        let drivers: Vec<&Channel> = clip.channels.iter().filter(is_driver).collect();
        let driven = || drivers.iter().map(|c| &character.expressions[c.target]);
        let morphs = driven().flat_map(|e| &e.morphs);
        let meshes = morphs.map(|m| m.mesh).collect();
        let mut joints: Vec<(usize, Property)> = Vec::new();
        for binding in driven().flat_map(|e| &e.joints) {
            let rest = character.skeleton.joints[binding.joint].rest;
            let parts = driven_parts(rest, binding.full);
            joints.extend(parts.map(|property| (binding.joint, property)));
        }
        joints.sort_by_key(|(joint, property)| (*joint, order(*property)));
        joints.dedup();
        Self {
            character,
            clip,
            drivers,
            meshes,
            joints,
        }
    }

    fn driven(&self) -> impl Iterator<Item = &'a Expression> {
        let expressions = &self.character.expressions;
        self.drivers.iter().map(|c| &expressions[c.target])
    }

    /// Whether a channel of the clip is merged into a generated one.
    fn is_replaced(&self, channel: &Channel) -> bool {
        match channel.property {
            Property::Weights => self.meshes.contains(&channel.target),
            Property::Expression => false,
            property => self.joints.contains(&(channel.target, property)),
        }
    }

    fn own(&self, target: usize, property: Property) -> Option<&'a Channel> {
        let mut channels = self.clip.channels.iter();
        channels.find(|c| c.target == target && c.property == property)
    }

    /// The channels that the result depends on.
    fn involved(&self) -> impl Iterator<Item = &'a Channel> {
        let own = self.clip.channels.iter().filter(|c| self.is_replaced(c));
        self.drivers.iter().copied().chain(own)
    }

    fn all_step(&self) -> bool {
        self.involved()
            .all(|c| c.interpolation == Interpolation::Step)
    }

    /// Whether straight lines between the keys would be wrong.
    fn bends(&self) -> bool {
        let is_plain = |e: &Expression| !e.is_binary && e.masks.is_empty();
        let within = |c: &&Channel| c.values.iter().all(|v| (0.0..=1.0).contains(v));
        let straight = self
            .involved()
            .all(|c| c.interpolation == Interpolation::Linear);
        // Two rotations of one joint do not combine linearly.
        let turns = self.joints.iter().any(|(_, p)| *p == Property::Rotation);
        turns || !straight || !self.driven().all(is_plain) || !self.drivers.iter().all(within)
    }

    /// The times of the generated keys, sorted.
    fn times(&self) -> Result<Vec<f32>, Mismatch> {
        let duration = self.clip.duration_secs.max(0.0);
        let mut times: Vec<f32> = Vec::new();
        if self.bends() && !self.all_step() {
            let rate = source_rate_hz(self.clip);
            let rate = rate * (MIN_RATE_HZ / rate).ceil().max(1.0);
            let frames = (f64::from(duration) * f64::from(rate)).ceil();
            self.check_size(frames + 2.0 * self.key_count())?;
            times.extend((0..frames as usize).map(|i| i as f32 / rate));
            times.push(duration);
            times.extend(self.between(&times, duration));
        } else {
            self.check_size(self.key_count())?;
            times.extend(self.involved().flat_map(|c| &c.times_secs));
        }
        times.sort_by(f32::total_cmp);
        times.dedup();
        Ok(times)
    }

    /// Key times that are none of rising frame times: values bend there. Before a jump there is one too,
    /// so that it does not become a ramp.
    fn between(&self, frames: &[f32], duration: f32) -> Vec<f32> {
        let keys = self.involved().flat_map(|c| c.times_secs.iter().copied());
        let jumps = self.involved().flat_map(Channel::jump_times);
        let is_new = |t: &f32| {
            let after = frames.partition_point(|f| *f < t - SAME_SECS);
            let is_frame = frames.get(after).is_some_and(|f| *f <= t + SAME_SECS);
            (0.0..=duration).contains(t) && !is_frame
        };
        let all = keys.chain(jumps.map(|t| t - JUMP_SECS));
        all.filter(is_new).collect()
    }

    fn key_count(&self) -> f64 {
        self.involved().map(|c| c.times_secs.len() as f64).sum()
    }

    fn check_size(&self, times: f64) -> Result<(), Mismatch> {
        let bindings = self.driven().map(|e| 1 + e.morphs.len() + e.joints.len());
        let masks = self.driven().map(|e| e.masks.len());
        let weights = self.meshes.iter();
        let weights = weights.map(|m| self.character.meshes[*m].morph_weights.len());
        let each = bindings.sum::<usize>()
            + masks.sum::<usize>()
            + weights.sum::<usize>()
            + 4 * self.joints.len();
        let numbers = times * each as f64;
        if numbers <= MAX_NUMBERS as f64 {
            return Ok(());
        }
        let what =
            format!("its baked expressions take {numbers:.0} values, the limit is {MAX_NUMBERS}");
        Err(Mismatch::new(format!("clip \"{}\"", self.clip.name), what))
    }

    /// The resolved value of each driver's expression at each time, in the order of the drivers.
    fn values(&self, times: &[f32]) -> Vec<Vec<f32>> {
        // Expressions that are not driven have no effect and mask nothing.
        let mut place = vec![usize::MAX; self.character.expressions.len()];
        for (i, driver) in self.drivers.iter().enumerate() {
            place[driver.target] = i;
        }
        let narrowed = |e: &Expression| {
            let mut e = Expression {
                is_binary: e.is_binary,
                masks: e.masks.clone(),
                ..Expression::default()
            };
            let known = |target: usize| place.get(target).copied();
            e.masks.retain_mut(|mask| {
                mask.target = known(mask.target).unwrap_or(usize::MAX);
                mask.target != usize::MAX
            });
            e
        };
        let narrow: Vec<Expression> = self.driven().map(narrowed).collect();
        let at = |time: &f32| {
            let driver = |c: &&Channel| {
                let mut value = [0.0];
                evaluate::channel(c, *time, &mut value);
                value[0]
            };
            let drivers: Vec<f32> = self.drivers.iter().map(driver).collect();
            resolve(&narrow, &drivers)
        };
        times.iter().map(at).collect()
    }

    fn weights(&self, mesh: usize, times: &[f32], values: &[Vec<f32>]) -> Channel {
        let rest = &self.character.meshes[mesh].morph_weights;
        let own = self.own(mesh, Property::Weights);
        let mut out = Vec::with_capacity(times.len() * rest.len());
        for (time, shown) in times.iter().zip(values) {
            let first = out.len();
            out.extend_from_slice(rest);
            let weights = &mut out[first..];
            if let Some(own) = own {
                evaluate::channel(own, *time, weights);
            }
            for (expression, value) in self.driven().zip(shown) {
                for morph in expression.morphs.iter().filter(|m| m.mesh == mesh) {
                    weights[morph.target] += value * morph.weight;
                }
            }
        }
        self.channel(mesh, Property::Weights, times, out)
    }

    fn joint(
        &self,
        joint: usize,
        property: Property,
        times: &[f32],
        values: &[Vec<f32>],
    ) -> Channel {
        let rest = self.character.skeleton.joints[joint].rest;
        let own = self.own(joint, property);
        let mut out = Vec::with_capacity(times.len() * 4);
        for (time, shown) in times.iter().zip(values) {
            let mut part = floats(rest, property);
            if let Some(own) = own {
                evaluate::channel(own, *time, &mut part);
            }
            for (expression, value) in self.driven().zip(shown) {
                for binding in expression.joints.iter().filter(|b| b.joint == joint) {
                    drive(&mut part, property, rest, binding, *value);
                }
            }
            out.extend_from_slice(&part);
        }
        self.channel(joint, property, times, out)
    }

    fn channel(
        &self,
        target: usize,
        property: Property,
        times: &[f32],
        values: Vec<f32>,
    ) -> Channel {
        let interpolation = match self.all_step() {
            true => Interpolation::Step,
            false => Interpolation::Linear,
        };
        Channel {
            target,
            property,
            interpolation,
            times_secs: times.to_vec(),
            values,
        }
    }
}

/// Checks that the targets of a channel that drives an expression exist and that its keys have
/// values. Other channels are checked when they are resampled, but must have the values read here.
fn check(character: &Character, channel: &Channel) -> Result<(), String> {
    let meshes = &character.meshes;
    let joints = character.skeleton.joints.len();
    let expressions = &character.expressions;
    let (kind, count) = match channel.property {
        Property::Weights => ("mesh", meshes.len()),
        Property::Expression => ("expression", expressions.len()),
        _ => ("joint", joints),
    };
    if channel.target >= count {
        return Err(format!(
            "{kind} {} is out of range: there are {count}",
            channel.target
        ));
    }
    let width = match channel.property {
        Property::Weights => meshes[channel.target].morph_weights.len(),
        Property::Expression => 1,
        Property::Rotation => 4,
        Property::Translation | Property::Scale => 3,
    };
    let parts = match channel.interpolation {
        Interpolation::CubicSpline => 3,
        _ => 1,
    };
    let (keys, found) = (channel.times_secs.len(), channel.values.len());
    if keys == 0 || found < keys * width * parts {
        let floats = width * parts;
        return Err(format!(
            "{found} values, but {keys} keys need {floats} floats each"
        ));
    }
    if channel.property != Property::Expression {
        return Ok(());
    }
    let expression = &expressions[channel.target];
    let has_morph = |mesh: usize, target| {
        let mesh = meshes.get(mesh);
        mesh.is_some_and(|m| target < m.morph_weights.len())
    };
    let name = &expression.name;
    if let Some(m) = expression
        .morphs
        .iter()
        .find(|m| !has_morph(m.mesh, m.target))
    {
        let (mesh, target) = (m.mesh, m.target);
        return Err(format!(
            "expression \"{name}\": morph target {target} of mesh {mesh} does not exist"
        ));
    }
    match expression.joints.iter().find(|b| b.joint >= joints) {
        Some(b) => Err(format!(
            "expression \"{name}\": joint {} is out of range: there are {joints} joints",
            b.joint
        )),
        None => Ok(()),
    }
}

/// The parts of a joint's transform that a binding changes.
fn driven_parts(rest: Transform, full: Transform) -> impl Iterator<Item = Property> {
    let differs = |a: Vec3, b: Vec3| (a - b).abs().max_element() > STILL;
    let turns = articula_core::angle_between(rest.rotation, full.rotation) > STILL_RADIANS;
    [
        (
            Property::Translation,
            differs(rest.translation, full.translation),
        ),
        (Property::Rotation, turns),
        (Property::Scale, differs(rest.scale, full.scale)),
    ]
    .into_iter()
    .filter_map(|(property, is_driven)| is_driven.then_some(property))
}

/// Adds the effect of a binding at a value to one part of its joint's transform.
fn drive(
    part: &mut [f32],
    property: Property,
    rest: Transform,
    binding: &JointBinding,
    value: f32,
) {
    if property == Property::Rotation {
        let whole = rest.rotation.conjugate() * binding.full.rotation;
        let whole = same_hemisphere(Quat::IDENTITY, whole);
        let turn = Quat::IDENTITY.libm_slerp(whole, value);
        let turned = (Quat::from_slice(part) * turn).normalize();
        part.copy_from_slice(&turned.to_array());
        return;
    }
    let (from, to) = (floats(rest, property), floats(binding.full, property));
    for ((x, from), to) in part.iter_mut().zip(from).zip(to) {
        *x += value * (to - from);
    }
}

fn floats(t: Transform, property: Property) -> Vec<f32> {
    match property {
        Property::Rotation => t.rotation.to_array().to_vec(),
        Property::Scale => t.scale.to_array().to_vec(),
        _ => t.translation.to_array().to_vec(),
    }
}

fn order(property: Property) -> u8 {
    match property {
        Property::Translation => 0,
        Property::Rotation => 1,
        _ => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::angle_between;
    use articula_core::source::{Joint, MorphBinding, RawMesh, Skeleton};

    fn near(found: &[f32], wanted: &[f32]) {
        assert_eq!(found.len(), wanted.len());
        for (f, w) in found.iter().zip(wanted) {
            assert!((f - w).abs() < 1e-6, "{found:?}, not {wanted:?}");
        }
    }

    /// A mesh with two morph targets, two joints, and expressions to be filled in.
    fn character(expressions: Vec<Expression>) -> Character {
        let joint = |parent| Joint {
            name: String::new(),
            parent,
            rest: Transform::from_translation(Vec3::Y),
            in_skin: true,
        };
        Character {
            skeleton: Skeleton {
                joints: vec![joint(None), joint(Some(0))],
            },
            meshes: vec![RawMesh {
                morph_weights: vec![0.0, 0.125],
                ..RawMesh::default()
            }],
            expressions,
            ..Character::default()
        }
    }

    fn channel(target: usize, property: Property, times: &[f32], values: &[f32]) -> Channel {
        Channel {
            target,
            property,
            interpolation: Interpolation::Linear,
            times_secs: times.to_vec(),
            values: values.to_vec(),
        }
    }

    fn clip(channels: Vec<Channel>) -> RawClip {
        let last = channels.iter().filter_map(|c| c.times_secs.last());
        RawClip {
            name: "c".into(),
            duration_secs: last.copied().fold(0.0, f32::max),
            channels,
        }
    }

    fn morph(target: usize, weight: f32) -> MorphBinding {
        MorphBinding {
            mesh: 0,
            target,
            weight,
        }
    }

    #[test]
    fn straight_expressions_are_exact_at_the_keys_of_all() {
        let open = Expression {
            morphs: vec![morph(0, 0.5), morph(1, 1.0)],
            ..Expression::default()
        };
        let character = character(vec![Expression::default(), open]);
        let own = channel(0, Property::Weights, &[0.0, 4.0], &[0.0, 0.0, 0.4, 0.0]);
        let drive = channel(1, Property::Expression, &[1.0, 3.0], &[0.0, 1.0]);
        let idle = channel(0, Property::Expression, &[0.0], &[1.0]);
        let clip = clip(vec![own, drive, idle]);
        let baked = bake(&character, &clip).unwrap();
        assert_eq!(baked.channels.len(), 1);
        assert_eq!(baked.channels[0].times_secs, [0.0, 1.0, 3.0, 4.0]);
        near(
            &baked.channels[0].values,
            &[0.0, 0.0, 0.1, 0.0, 0.8, 1.0, 0.9, 1.0],
        );
        assert_eq!(baked.duration_secs, 4.0);
    }

    #[test]
    fn joints_turn_by_their_share_on_top_of_the_clip() {
        let rest = Transform::from_translation(Vec3::Y);
        let full = Transform {
            rotation: Quat::from_rotation_x(1.0),
            translation: Vec3::new(0.0, 3.0, 0.0),
            scale: Vec3::ONE,
        };
        let jaw = Expression {
            joints: vec![JointBinding { joint: 1, full }],
            ..Expression::default()
        };
        let character = character(vec![jaw]);
        let q = Quat::from_rotation_z(0.5);
        let turned = channel(1, Property::Rotation, &[0.0], &q.to_array());
        let drive = channel(0, Property::Expression, &[0.0, 1.0], &[0.0, 1.0]);
        let clip = clip(vec![turned, drive]);
        let baked = bake(&character, &clip).unwrap();
        let properties: Vec<_> = baked.channels.iter().map(|c| c.property).collect();
        assert_eq!(properties, [Property::Translation, Property::Rotation]);
        let mut at = LocalAt::of(&baked, &character);
        assert!(at(0.5).translation.distance(Vec3::new(0.0, 2.0, 0.0)) < 1e-5);
        let wanted = q * Quat::from_rotation_x(0.5);
        assert!(angle_between(at(0.5).rotation, wanted) < 1e-3);
        assert_eq!(at(0.5).scale, rest.scale);
        assert!(angle_between(at(1.0).rotation, q * full.rotation) < 1e-3);
    }

    /// Evaluates joint 1 of a clip.
    struct LocalAt;

    impl LocalAt {
        fn of<'a>(
            clip: &'a RawClip,
            character: &'a Character,
        ) -> impl FnMut(f32) -> Transform + 'a {
            let joints = &character.skeleton.joints;
            let mut pose = articula_core::LocalPose::from_iter(joints.iter().map(|j| j.rest));
            move |t| {
                evaluate::pose(clip, &character.skeleton, t, &mut pose);
                pose.get(1)
            }
        }
    }

    #[test]
    fn a_binary_expression_switches_within_a_frame() {
        let blink = Expression {
            morphs: vec![morph(0, 1.0)],
            is_binary: true,
            ..Expression::default()
        };
        let character = character(vec![blink]);
        let clip = clip(vec![channel(
            0,
            Property::Expression,
            &[0.0, 1.0],
            &[0.0, 1.0],
        )]);
        let baked = bake(&character, &clip).unwrap();
        let at = |t: f32| {
            let mut w = [0.0; 2];
            evaluate::channel(&baked.channels[0], t, &mut w);
            w[0]
        };
        near(&[at(0.5), at(0.5 + 1.0 / 30.0), at(1.0)], &[0.0, 1.0, 1.0]);
    }

    #[test]
    fn steps_stay_steps() {
        let smile = Expression {
            morphs: vec![morph(0, 1.0)],
            ..Expression::default()
        };
        let character = character(vec![smile]);
        let mut drive = channel(0, Property::Expression, &[0.0, 0.7], &[0.25, 0.75]);
        drive.interpolation = Interpolation::Step;
        let clip = clip(vec![drive]);
        let baked = bake(&character, &clip).unwrap();
        assert_eq!(baked.channels[0].interpolation, Interpolation::Step);
        near(&baked.channels[0].values, &[0.25, 0.125, 0.75, 0.125]);
    }

    #[test]
    fn clips_without_expressions_are_passed_on() {
        let clip = clip(vec![channel(9, Property::Rotation, &[0.0], &[])]);
        let baked = bake(&character(vec![]), &clip).unwrap();
        assert!(matches!(baked, Cow::Borrowed(_)));
    }

    #[test]
    fn refuses_what_is_not_there_and_what_is_endless() {
        let why = |expressions: Vec<Expression>, channel: Channel| {
            let clip = clip(vec![channel]);
            bake(&character(expressions), &clip).unwrap_err().what
        };
        let drive = || channel(0, Property::Expression, &[0.0, 1.0], &[0.0, 1.0]);
        assert_eq!(
            why(vec![], drive()),
            "expression 0 is out of range: there are 0"
        );
        let wrong = Expression {
            morphs: vec![morph(2, 1.0)],
            ..Expression::default()
        };
        assert!(why(vec![wrong], drive()).contains("morph target 2 of mesh 0 does not exist"));
        let short = channel(0, Property::Expression, &[0.0, 1.0], &[0.0]);
        assert!(why(vec![Expression::default()], short).contains("1 values, but 2 keys"));
        let long = channel(0, Property::Expression, &[0.0, 1e8], &[0.0, 2.0]);
        assert!(why(vec![Expression::default()], long).contains("values, the limit is"));
    }
}
