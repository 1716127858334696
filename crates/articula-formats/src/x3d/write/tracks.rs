//! Clips: one time sensor each, one interpolator per channel, and routes.
//!
//! Every player of X3D and VRML97 supports interpolators and routes, and they keep the keys of the
//! source at their times (`HAnimMotion` has only frames of Euler angles). The first clip runs when
//! the file is opened; the others are disabled.
//!
//! Source: ISO/IEC 19775-1, 8.4.1 (TimeSensor), clause 19 (interpolators), 4.4.8 (routes). A clip
//! also holds at rest what only other clips move, as players keep the last values. Steps become two
//! keys at one time. Curves become linear pieces.

use super::super::names::Names;
use super::bodies::Body;
use super::bones::{Bone, Bones};
use super::markup::Markup;
use articula_core::LibmQuat;
use articula_core::source::{Channel, Character, Interpolation, Property, RawClip, evaluate};
use glam::{DQuat, Quat, Vec3};
use std::collections::HashSet;

/// Maximum length of a linear piece of a curve, in seconds.
const PIECE_SECS: f32 = 1.0 / 60.0;

/// An event path that is written after all nodes.
#[derive(Debug)]
pub(super) struct Route {
    from: (String, &'static str),
    to: (String, &'static str),
}

impl Route {
    pub(super) fn write(&self, markup: &mut Markup) {
        markup.open("ROUTE");
        markup
            .set("fromNode", &self.from.0)
            .set("fromField", self.from.1);
        markup.set("toNode", &self.to.0).set("toField", self.to.1);
        markup.close();
    }
}

/// Possible targets of channels, by their names in the file.
#[derive(Debug)]
pub(super) struct Driven<'w> {
    pub(super) character: &'w Character,
    pub(super) bones: &'w Bones,
    pub(super) bodies: &'w [Body],
    /// `DEF` of each bone.
    pub(super) bone_defs: &'w [String],
    /// `DEF` of each displacer, by body and target.
    pub(super) displacer_defs: &'w [Vec<Vec<String>>],
}

/// Writes one clip; returns its routes.
pub(super) fn write(
    markup: &mut Markup,
    names: &mut Names,
    driven: &Driven<'_>,
    clip: &RawClip,
    runs: bool,
) -> Vec<Route> {
    let mut writer = Writer {
        markup,
        names,
        routes: Vec::new(),
        sensor: String::new(),
        cycle_secs: if clip.duration_secs > 0.0 {
            f64::from(clip.duration_secs)
        } else {
            1.0
        },
    };
    writer.sensor(clip, runs);
    for channel in clip.channels.iter().chain(&held(driven.character, clip)) {
        match channel.property {
            Property::Weights => writer.weights(driven, channel),
            Property::Translation | Property::Rotation | Property::Scale => {
                let bone = driven.bones.of_joint[channel.target];
                if let Some(bone) = bone {
                    let name = &driven.bone_defs[bone];
                    writer.joint(&driven.bones.list[bone], name, channel);
                }
            }
            Property::Expression => {}
        }
    }
    writer.routes
}

/// Returns channels that hold what only other clips move: a player would keep the values of the
/// previous clip.
fn held(character: &Character, clip: &RawClip) -> Vec<Channel> {
    let key = |c: &Channel| (c.target, c.property);
    let own: HashSet<_> = clip.channels.iter().map(key).collect();
    let mut seen = HashSet::new();
    let all = character.clips.iter().flat_map(|c| &c.channels);
    let others = all.filter(|c| !own.contains(&key(c)) && seen.insert(key(c)));
    let at_rest = |c: &Channel| {
        let joint = || character.skeleton.joints[c.target].rest;
        let values = match c.property {
            Property::Translation => joint().translation.to_array().to_vec(),
            Property::Rotation => joint().rotation.to_array().to_vec(),
            Property::Scale => joint().scale.to_array().to_vec(),
            Property::Weights => character.meshes[c.target].morph_weights.clone(),
            Property::Expression => return None,
        };
        Some(Channel {
            target: c.target,
            property: c.property,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values,
        })
    };
    others.filter_map(at_rest).collect()
}

struct Writer<'m> {
    markup: &'m mut Markup,
    names: &'m mut Names,
    routes: Vec<Route>,
    sensor: String,
    cycle_secs: f64,
}

/// Times and values of a channel, flattened, as linear pieces.
struct Straight {
    times_secs: Vec<f32>,
    values: Vec<f32>,
}

impl Writer<'_> {
    fn sensor(&mut self, clip: &RawClip, runs: bool) {
        self.sensor = self.names.give(&clip.name, "clip");
        self.markup.open("TimeSensor").set("DEF", &self.sensor);
        if self.sensor != clip.name && !clip.name.is_empty() {
            self.markup.set("description", &clip.name);
        }
        self.markup.numbers("cycleInterval", 1, [self.cycle_secs]);
        self.markup.set("loop", "true");
        if !runs {
            self.markup.set("enabled", "false");
        }
        self.markup.close();
    }

    fn joint(&mut self, bone: &Bone, name: &str, channel: &Channel) {
        let width = if channel.property == Property::Rotation {
            4
        } else {
            3
        };
        let straight = straight(channel, width);
        let keys = straight.values.chunks_exact(width);
        match channel.property {
            Property::Rotation => {
                let turned = keys.map(|k| bone.rotation(Quat::from_slice(k).normalize()));
                let values = turned.flat_map(axis_angle);
                let to = (name, "set_rotation");
                let node = "OrientationInterpolator";
                self.interpolator(node, &straight.times_secs, (4, values), &[to]);
            }
            Property::Translation => {
                let values = keys.flat_map(|k| bone.translation(Vec3::from_slice(k)).to_array());
                let to = (name, "set_translation");
                let node = "PositionInterpolator";
                self.interpolator(node, &straight.times_secs, (3, values), &[to]);
            }
            _ => {
                let values = keys.flat_map(|k| bone.scale(Vec3::from_slice(k)).to_array());
                let to = (name, "set_scale");
                let node = "PositionInterpolator";
                self.interpolator(node, &straight.times_secs, (3, values), &[to]);
            }
        }
    }

    fn weights(&mut self, driven: &Driven<'_>, channel: &Channel) {
        let targets = driven.character.meshes[channel.target].morph_names.len();
        let Some(body) = driven.bodies.iter().position(|b| b.mesh == channel.target) else {
            return;
        };
        if targets == 0 {
            return;
        }
        let straight = straight(channel, targets);
        for (target, displacers) in driven.displacer_defs[body].iter().enumerate() {
            if displacers.is_empty() {
                continue;
            }
            let values = straight
                .values
                .iter()
                .skip(target)
                .step_by(targets)
                .copied();
            let ends: Vec<_> = displacers
                .iter()
                .map(|d| (d.as_str(), "set_weight"))
                .collect();
            self.interpolator(
                "ScalarInterpolator",
                &straight.times_secs,
                (1, values),
                &ends,
            );
        }
    }

    fn interpolator(
        &mut self,
        node: &'static str,
        times_secs: &[f32],
        (tuple, values): (usize, impl Iterator<Item = f32>),
        ends: &[(&str, &'static str)],
    ) {
        let field = ends[0].1.trim_start_matches("set_");
        let wish = format!("{}_{}_{field}", self.sensor, ends[0].0);
        let name = self.names.give(&wish, "keys");
        let cycle = self.cycle_secs;
        let fractions = times_secs.iter().map(|t| (f64::from(*t) / cycle).min(1.0));
        self.markup.open(node).set("DEF", &name);
        self.markup.numbers("key", 1, fractions);
        self.markup.numbers("keyValue", tuple, values);
        self.markup.close();
        self.routes.push(Route {
            from: (self.sensor.clone(), "fraction_changed"),
            to: (name.clone(), "set_fraction"),
        });
        for (node, field) in ends {
            self.routes.push(Route {
                from: (name.clone(), "value_changed"),
                to: ((*node).to_owned(), field),
            });
        }
    }
}

fn straight(channel: &Channel, width: usize) -> Straight {
    match channel.interpolation {
        Interpolation::Linear => Straight {
            times_secs: channel.times_secs.clone(),
            values: channel.values.clone(),
        },
        Interpolation::Step => {
            let mut straight = Straight {
                times_secs: Vec::new(),
                values: Vec::new(),
            };
            let keys: Vec<&[f32]> = channel.values.chunks_exact(width).collect();
            for (index, time) in channel.times_secs.iter().enumerate() {
                if index > 0 {
                    straight.times_secs.push(*time);
                    straight.values.extend_from_slice(keys[index - 1]);
                }
                straight.times_secs.push(*time);
                straight.values.extend_from_slice(keys[index]);
            }
            straight
        }
        Interpolation::CubicSpline => curve(channel, width),
    }
}

/// Samples a curve at its keys and often enough between them.
fn curve(channel: &Channel, width: usize) -> Straight {
    let mut times_secs = Vec::new();
    for pair in channel.times_secs.windows(2) {
        let span = pair[1] - pair[0];
        let pieces = (span / PIECE_SECS).ceil().clamp(1.0, 1e6) as usize;
        let step = |i: usize| pair[0] + span * (i as f32 / pieces as f32);
        times_secs.extend((0..pieces).map(step));
    }
    times_secs.extend(channel.times_secs.last());
    times_secs.dedup();
    let mut values = vec![0.0; width * times_secs.len()];
    for (value, time) in values.chunks_exact_mut(width).zip(&times_secs) {
        evaluate::channel(channel, *time, value);
    }
    Straight { times_secs, values }
}

/// Returns a rotation as the standard writes it: axis and angle in radians.
pub(super) fn axis_angle(rotation: DQuat) -> [f32; 4] {
    // The shorter rotation, so that the angle is within half a turn.
    let rotation = if rotation.w < 0.0 {
        -rotation
    } else {
        rotation
    };
    let (axis, angle) = rotation.libm_to_axis_angle();
    let axis = axis.as_vec3();
    [axis.x, axis.y, axis.z, angle as f32]
}
