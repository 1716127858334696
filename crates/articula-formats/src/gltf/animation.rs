//! Animations as clips of keyed channels.
//!
//! Source: glTF 2.0, 3.11 and appendix C.

use super::node;
use super::node_meshes::NodeMeshes;
use super::place::Place;
use super::pointer::{self, Pointed};
use super::reader::Reader;
use super::single_weights::{SingleWeights, combined};
use super::skeleton::Skeletal;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::source::{Channel, Interpolation, JUMP_SECS, Property, RawClip};
use glam::Quat;
use std::collections::HashSet;

/// Reads all animations in order.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    skeletal: &Skeletal,
    shown: &NodeMeshes,
) -> Result<Vec<RawClip>, ReadError> {
    let animations = reader.root.entries("animations")?;
    let mut clips = Vec::with_capacity(animations.len());
    for (i, animation) in animations.iter().enumerate() {
        let name = match animation.text("name") {
            "" => format!("animation_{i}"),
            name => name.to_owned(),
        };
        let channels = read_channels(reader, animation, skeletal, shown)?;
        let last = channels.iter().filter_map(|c| c.times_secs.last());
        clips.push(RawClip {
            name,
            duration_secs: last.copied().fold(0.0, f32::max),
            channels,
        });
    }
    Ok(clips)
}

/// Target of a channel, and the number of floats per key.
#[derive(Debug, Clone, Copy)]
struct Target {
    target: usize,
    property: Property,
    width: usize,
    /// The only morph target that the channel drives; `None` if it drives all, or no weights.
    morph: Option<usize>,
}

impl Target {
    /// All weights of a shown mesh.
    fn weights(mesh: usize, shown: &NodeMeshes) -> Self {
        Self {
            target: mesh,
            property: Property::Weights,
            width: shown.meshes[mesh].morph_weights.len(),
            morph: None,
        }
    }

    /// Returns one of the weights, if there are that many.
    fn single(self, morph: usize) -> Option<Self> {
        (morph < self.width).then_some(Self {
            width: 1,
            morph: Some(morph),
            ..self
        })
    }
}

/// The targets of the channels that were read.
#[derive(Debug, Default)]
struct Driven {
    whole: HashSet<(usize, Property)>,
    /// Mesh and morph target.
    single: HashSet<(usize, usize)>,
    /// Meshes of which a channel drives a single weight.
    in_parts: HashSet<usize>,
}

impl Driven {
    /// Adds a target; returns whether no other channel drives it, or a part of it.
    fn insert(&mut self, target: Target) -> bool {
        let whole = (target.target, target.property);
        match target.morph {
            Some(morph) => {
                let is_free =
                    !self.whole.contains(&whole) && self.single.insert((target.target, morph));
                if is_free {
                    self.in_parts.insert(target.target);
                }
                is_free
            }
            None => {
                let in_parts =
                    target.property == Property::Weights && self.in_parts.contains(&target.target);
                !in_parts && self.whole.insert(whole)
            }
        }
    }
}

fn read_channels<'a>(
    reader: &mut Reader<'a>,
    animation: &Place<'a>,
    skeletal: &Skeletal,
    shown: &NodeMeshes,
) -> Result<Vec<Channel>, ReadError> {
    let mut channels = Vec::new();
    let mut driven = Driven::default();
    let mut singles = SingleWeights::new();
    for place in animation.entries("channels")? {
        for target in read_targets(reader, &place, skeletal, shown)? {
            if !driven.insert(target) {
                reader.warn(&place, "a second channel for the same property; left out");
                continue;
            }
            let sampler = animation.entry_of("samplers", &place, "sampler")?;
            let Some(channel) = read_sampler(reader, &sampler, target)? else {
                continue;
            };
            match target.morph {
                None => channels.push(channel),
                Some(morph) => {
                    let of_mesh = singles.entry(target.target).or_default();
                    of_mesh.insert(morph, channel);
                }
            }
        }
    }
    for (mesh, of_weight) in singles {
        let rest = &shown.meshes[mesh].morph_weights;
        channels.extend(combined(reader, animation, (mesh, rest), of_weight)?);
    }
    Ok(channels)
}

/// Reads the targets of a channel as joints and meshes; empty, with a warning, if it drives
/// neither.
fn read_targets(
    reader: &mut Reader<'_>,
    channel: &Place<'_>,
    skeletal: &Skeletal,
    shown: &NodeMeshes,
) -> Result<Vec<Target>, ReadError> {
    let target = channel.require("target")?;
    let nodes = skeletal.joint_of_node.len();
    let Some(pointer) = pointer::text(&target) else {
        let path = target.text("path");
        let Some(node) = target.index("node", nodes)? else {
            let what = format!(
                "a channel without a target node (path \"{}\") left out",
                cut(path)
            );
            reader.warn(&target, what);
            return Ok(Vec::new());
        };
        let found = read_target(reader, &target, (node, path), skeletal, shown)?;
        return Ok(found.into_iter().collect());
    };
    let found = match pointer::parse(pointer) {
        Some(Pointed::Node(node, path)) if node < nodes => {
            let found = read_target(reader, &target, (node, path), skeletal, shown)?;
            return Ok(found.into_iter().collect());
        }
        Some(Pointed::MeshWeights(mesh)) => mesh_targets(reader, mesh, shown),
        Some(Pointed::MeshWeight(mesh, morph)) => {
            let meshes = mesh_targets(reader, mesh, shown).into_iter();
            meshes.filter_map(|all| all.single(morph)).collect()
        }
        Some(Pointed::NodeWeight(node, morph)) => {
            let mesh = shown.node_of_mesh.binary_search(&node).ok();
            let all = mesh.map(|mesh| Target::weights(mesh, shown));
            all.and_then(|all| all.single(morph)).into_iter().collect()
        }
        _ => Vec::new(),
    };
    if found.is_empty() {
        let what = format!("a channel for \"{}\" left out", cut(pointer));
        reader.warn(&target, what);
    }
    Ok(found)
}

/// Returns the shown meshes that use the weights of a mesh of the document.
fn mesh_targets(reader: &Reader<'_>, mesh: usize, shown: &NodeMeshes) -> Vec<Target> {
    let takes_weights = |n: usize| {
        let node = reader.root.entry("nodes", n)?;
        let own = node.get("mesh")?.whole().ok()? == mesh as u64;
        (own && node.get("weights").is_none()).then_some(())
    };
    let each = shown.node_of_mesh.iter().enumerate();
    each.filter(|(_, n)| takes_weights(**n).is_some())
        .map(|(mesh, _)| Target::weights(mesh, shown))
        .filter(|target| target.width > 0)
        .collect()
}

/// Returns the target of a node's property; `None`, with a warning, if it is unsupported.
fn read_target(
    reader: &mut Reader<'_>,
    target: &Place<'_>,
    (node, path): (usize, &str),
    skeletal: &Skeletal,
    shown: &NodeMeshes,
) -> Result<Option<Target>, ReadError> {
    let expression = skeletal.expression_of_node.get(&node);
    if let (Some(&target), "translation") = (expression, path) {
        // Only the x component is used; the array still has three floats per key.
        return Ok(Some(Target {
            target,
            property: Property::Expression,
            width: 3,
            morph: None,
        }));
    }
    let (property, width) = match path {
        "translation" => (Property::Translation, 3),
        "rotation" => (Property::Rotation, 4),
        "scale" => (Property::Scale, 3),
        "weights" => return Ok(weights_target(reader, target, node, shown)),
        other => {
            let what = format!("a channel with path \"{}\" left out", cut(other));
            reader.warn(target, what);
            return Ok(None);
        }
    };
    Ok(skeletal.joint_of_node[node].map(|joint| Target {
        target: joint,
        property,
        width,
        morph: None,
    }))
}

fn weights_target(
    reader: &mut Reader<'_>,
    target: &Place<'_>,
    node: usize,
    shown: &NodeMeshes,
) -> Option<Target> {
    // Meshes are in the order of their nodes.
    let mesh = shown.node_of_mesh.binary_search(&node).ok();
    let all = mesh.map(|mesh| Target::weights(mesh, shown));
    let all = all.filter(|all| all.width > 0);
    if all.is_none() {
        reader.warn(target, "weights of a node without morph targets left out");
    }
    all
}

fn read_sampler(
    reader: &mut Reader<'_>,
    sampler: &Place<'_>,
    target: Target,
) -> Result<Option<Channel>, ReadError> {
    let interpolation = match sampler.text("interpolation") {
        "" | "LINEAR" => Interpolation::Linear,
        "STEP" => Interpolation::Step,
        "CUBICSPLINE" => Interpolation::CubicSpline,
        other => {
            let what = format!("unknown interpolation \"{}\"", cut(other));
            return Err(sampler.malformed(what));
        }
    };
    let parts = if interpolation == Interpolation::CubicSpline {
        3
    } else {
        1
    };
    let times_secs = read_times(reader, &sampler.require("input")?)?;
    let floats = target.width * parts;
    let values = read_values(
        reader,
        &sampler.require("output")?,
        target,
        times_secs.len() * floats,
    )?;
    let mut channel = Channel {
        target: target.target,
        property: target.property,
        interpolation,
        times_secs,
        values,
    };
    drop_unordered_keys(reader, sampler, floats, &mut channel);
    if target.property == Property::Expression {
        let keys = channel.values.as_chunks::<3>().0;
        channel.values = keys.iter().map(|key| key[0]).collect();
    }
    if target.property == Property::Rotation {
        mend_rotations(reader, sampler, parts, &mut channel.values);
    }
    Ok((!channel.times_secs.is_empty()).then_some(channel))
}

fn read_times(reader: &mut Reader<'_>, index: &Place<'_>) -> Result<Vec<f32>, ReadError> {
    let accessor = reader.accessor(index)?;
    accessor.expect_type(&["SCALAR"])?;
    let keys = accessor.count as u64;
    Limits::check(index, "keys of a channel", keys, reader.limits.frames)?;
    if keys == 0 {
        reader.warn(index, "a channel without keys left out");
    }
    reader.floats(&accessor)
}

fn read_values(
    reader: &mut Reader<'_>,
    index: &Place<'_>,
    target: Target,
    floats: usize,
) -> Result<Vec<f32>, ReadError> {
    let accessor = reader.accessor(index)?;
    let (kind, width) = match target.property {
        Property::Translation | Property::Scale | Property::Expression => ("VEC3", 3),
        Property::Rotation => ("VEC4", 4),
        Property::Weights => ("SCALAR", 1),
    };
    accessor.expect_type(&[kind])?;
    accessor.expect_count(floats / width, "values belong to the key times")?;
    reader.floats(&accessor)
}

/// Drops keys whose time is before that of a previous key, with their values. Of several keys at one
/// time the first and the last are kept, as a jump.
fn drop_unordered_keys(
    reader: &mut Reader<'_>,
    sampler: &Place<'_>,
    floats: usize,
    channel: &mut Channel,
) {
    if channel.times_secs.is_sorted_by(|a, b| a < b) {
        return;
    }
    let keys = channel
        .times_secs
        .iter()
        .zip(channel.values.chunks_exact(floats));
    let mut times: Vec<f32> = Vec::with_capacity(channel.times_secs.len());
    let mut values: Vec<&[f32]> = Vec::with_capacity(channel.times_secs.len());
    let (mut dropped, mut jumps) = (0, 0);
    // Whether the last kept key is the second one at its time.
    let mut jumped = false;
    for (&time, value) in keys {
        let last = times.last().copied().unwrap_or(f32::NEG_INFINITY);
        if time > last {
            times.push(time);
            values.push(value);
            jumped = false;
        } else if time == last {
            let is_new = !jumped && values.last() != Some(&value);
            let before = times.len().checked_sub(2).map(|i| times[i]);
            if let Some(earlier) = before_jump(before, time).filter(|_| is_new) {
                times.pop();
                times.extend([earlier, time]);
                (jumped, jumps) = (true, jumps + 1);
            } else {
                values.pop();
                dropped += 1;
            }
            values.push(value);
        } else {
            dropped += 1;
        }
    }
    channel.values = values.concat();
    channel.times_secs = times;
    if dropped > 0 {
        let what = format!("{dropped} keys do not rise in time; left out");
        reader.notes.add(sampler.path("input"), what);
    }
    if jumps > 0 {
        let what = format!("{jumps} times have two keys; each is read as a jump");
        reader.notes.add(sampler.path("input"), what);
    }
}

/// The time of the first of two keys at one time, so that times rise; `None` if there is none after
/// the key before, or the jump is at the start, where its first value has no duration.
fn before_jump(before: Option<f32>, time: f32) -> Option<f32> {
    let earlier = (time - JUMP_SECS).min(time.next_down());
    let between = before.map_or(0.0, |b| 0.5 * (b + time));
    let earlier = earlier.max(between);
    (earlier < time && before.is_none_or(|b| b < earlier)).then_some(earlier)
}

/// Normalises key rotations; tangents of cubic splines stay as they are.
fn mend_rotations(reader: &mut Reader<'_>, sampler: &Place<'_>, parts: usize, values: &mut [f32]) {
    let mut zeros = 0;
    let mut off = 0;
    let quaternions = values.as_chunks_mut::<4>().0;
    for key in quaternions.chunks_exact_mut(parts) {
        let value = &mut key[parts / 2];
        let rotation = Quat::from_array(*value);
        let unit = node::unit(rotation);
        zeros += usize::from(unit.is_none());
        off += usize::from(unit.is_some() && (rotation.length() - 1.0).abs() > 1e-3);
        *value = unit.unwrap_or(Quat::IDENTITY).to_array();
    }
    if zeros > 0 {
        let what = format!("{zeros} quaternions of length 0 are read as identity");
        reader.notes.add(sampler.path("output"), what);
    }
    if off > 0 {
        let what = format!("{off} quaternions are not of unit length; normalised");
        reader.notes.add(sampler.path("output"), what);
    }
}

fn cut(text: &str) -> String {
    text.chars().take(40).collect()
}
