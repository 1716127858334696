//! Replacement of a document's animations by clips.

use super::append::{exact, float_bytes, object, push, set};
use super::document::Document;
use super::extension::ARTICULATION;
use super::facing::{faces_back, parents, turned_back};
use super::khr_character::named;
use super::vrm::expression_nodes;
use crate::written::WriteError;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::HashMap;

impl Document {
    /// Replaces `animations` by clips.
    ///
    /// Channel targets are joints and meshes of the character that was read from this document:
    /// `node_of_joint` and `node_of_mesh` are those of its [`GltfFile`](super::GltfFile). Arrays
    /// and bytes that only the old animations used are dropped, unless the document has extensions
    /// that might refer to them. A clip keeps the extras and unknown extensions of the old
    /// animation of the same name; motion tables describe old keys and are removed. Expressions are
    /// written where the document has nodes for them, which only VRM animations have. Other
    /// channels that drive expressions, channels without keys, and clips without channels, which
    /// glTF cannot represent, are left out. Expressions of KHR_character follow their animation, or
    /// are removed with it. A VRM 0.x character that was turned when it was read is turned back.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if a channel drives a joint or mesh without node, or has another
    /// number of values than its keys need; the document is then unchanged.
    pub fn replace_clips(
        &mut self,
        clips: &[RawClip],
        node_of_joint: &[usize],
        node_of_mesh: &[usize],
    ) -> Result<(), WriteError> {
        let nodes = Nodes {
            of_joint: node_of_joint,
            of_mesh: node_of_mesh,
            of_expression: &expression_nodes(&self.json),
            is_turned: self.turned_nodes(),
            count: self.count("nodes"),
        };
        for (i, channel) in clips.iter().flat_map(|clip| &clip.channels).enumerate() {
            if channel.property != Property::Expression || nodes.node(channel).is_some() {
                nodes.check(i, channel)?;
            }
        }
        let known = named(self.json.get("animations").and_then(Value::as_array));
        self.remove_prepared_motion();
        let mut old = self.take_animations();
        for clip in clips {
            let fits = |c: &&Channel| !c.times_secs.is_empty() && nodes.node(c).is_some();
            let channels = clip.channels.iter().filter(fits);
            let channels: Vec<_> = channels.map(|c| nodes.as_stored(c)).collect();
            if channels.is_empty() {
                continue;
            }
            let mut animation = self.animation(clip, &channels, &nodes);
            if let Some(same) = old.iter().position(|o| o["name"] == clip.name.as_str()) {
                keep_unknown(old.swap_remove(same), &mut animation);
            }
            push(&mut self.json, "animations", animation);
        }
        self.follow_animations(&known);
        Ok(())
    }

    /// Returns an animation whose channels refer to nodes of the document.
    pub(super) fn animation_of_nodes(&mut self, clip: &RawClip) -> Value {
        let every: Vec<usize> = (0..self.count("nodes")).collect();
        let nodes = Nodes {
            of_joint: &every,
            of_mesh: &[],
            of_expression: &[],
            is_turned: Vec::new(),
            count: every.len(),
        };
        let channels: Vec<_> = clip.channels.iter().map(Cow::Borrowed).collect();
        self.animation(clip, &channels, &nodes)
    }

    /// Returns for each node whether it was turned when it was read; only in VRM 0.x.
    pub(super) fn turned_nodes(&self) -> Vec<bool> {
        if !faces_back(&self.json) {
            return Vec::new();
        }
        parents(&self.json).iter().map(Option::is_none).collect()
    }

    fn animation(
        &mut self,
        clip: &RawClip,
        channels: &[Cow<'_, Channel>],
        nodes: &Nodes<'_>,
    ) -> Value {
        let mut arrays = Arrays::new(self);
        let mut samplers = Vec::new();
        let mut targets = Vec::new();
        for channel in channels {
            let input = arrays.add(self, &channel.times_secs, 1);
            let output = arrays.add(self, &channel.values, element_width(channel.property));
            targets.push(json!({
                "sampler": samplers.len(),
                "target": {"node": nodes.node(channel), "path": path(channel.property)},
            }));
            samplers.push(json!({
                "input": input,
                "interpolation": interpolation(channel.interpolation),
                "output": output,
            }));
        }
        self.add_buffer_view(&arrays.bytes);
        json!({"name": clip.name, "channels": targets, "samplers": samplers})
    }
}

/// Mapping from channel targets to nodes.
pub(super) struct Nodes<'a> {
    pub(super) of_joint: &'a [usize],
    pub(super) of_mesh: &'a [usize],
    pub(super) of_expression: &'a [Option<usize>],
    pub(super) is_turned: Vec<bool>,
    pub(super) count: usize,
}

impl Nodes<'_> {
    pub(super) fn node(&self, channel: &Channel) -> Option<usize> {
        let node = match channel.property {
            Property::Weights => self.of_mesh.get(channel.target).copied(),
            Property::Expression => self.of_expression.get(channel.target).copied().flatten(),
            _ => self.of_joint.get(channel.target).copied(),
        };
        node.filter(|&n| n < self.count)
    }

    /// Returns the channel with the keys to be stored.
    pub(super) fn as_stored<'c>(&self, channel: &'c Channel) -> Cow<'c, Channel> {
        let is_turned = |node: usize| self.is_turned.get(node) == Some(&true);
        match channel.property {
            // The value of an expression is the x translation of its node.
            Property::Expression => {
                let mut stored = channel.clone();
                stored.values = channel.values.iter().flat_map(|x| [*x, 0.0, 0.0]).collect();
                Cow::Owned(stored)
            }
            Property::Translation | Property::Rotation
                if self.node(channel).is_some_and(is_turned) =>
            {
                Cow::Owned(turned_back(channel))
            }
            _ => Cow::Borrowed(channel),
        }
    }

    pub(super) fn check(&self, i: usize, channel: &Channel) -> Result<(), WriteError> {
        let at = || format!("channel {i}");
        if self.node(channel).is_none() {
            let what = format!("target {} has no node", channel.target);
            return Err(WriteError::mismatch(at(), what));
        }
        let parts = match channel.interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        let width = match channel.property {
            Property::Expression => 1,
            property => element_width(property),
        };
        let unit = channel.times_secs.len() * parts * width;
        let found = channel.values.len();
        let fits = match channel.property {
            Property::Weights => unit == 0 || found > 0 && found.is_multiple_of(unit),
            _ => found == unit,
        };
        if !fits {
            let what = format!("{found} floats for {} keys", channel.times_secs.len());
            return Err(WriteError::mismatch(at(), what));
        }
        Ok(())
    }
}

/// The arrays of one animation, in one buffer view; equal ones are stored once.
pub(super) struct Arrays {
    view: usize,
    pub(super) bytes: Vec<u8>,
    known: HashMap<(usize, Vec<u8>), usize>,
}

impl Arrays {
    /// Arrays of the view that is added next to a document.
    pub(super) fn new(document: &Document) -> Self {
        Self {
            view: document.count("bufferViews"),
            bytes: Vec::new(),
            known: HashMap::new(),
        }
    }

    pub(super) fn add(&mut self, document: &mut Document, numbers: &[f32], width: usize) -> usize {
        let bytes = float_bytes(numbers);
        let key = (width, bytes);
        if let Some(accessor) = self.known.get(&key) {
            return *accessor;
        }
        let mut accessor = json!({
            "bufferView": self.view,
            "byteOffset": self.bytes.len(),
            "componentType": 5126,
            "count": numbers.len() / width,
            "type": (element_type(width)),
        });
        if width == 1 {
            let least = numbers.iter().copied().fold(f32::INFINITY, f32::min);
            let greatest = numbers.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            set(&mut accessor, "min", exact(&[least]));
            set(&mut accessor, "max", exact(&[greatest]));
        }
        self.bytes.extend_from_slice(&key.1);
        let index = document.add_accessor(accessor);
        self.known.insert(key, index);
        index
    }
}

/// Returns the number of floats per element of the output accessor.
pub(super) fn element_width(property: Property) -> usize {
    match property {
        Property::Translation | Property::Scale | Property::Expression => 3,
        Property::Rotation => 4,
        Property::Weights => 1,
    }
}

fn element_type(width: usize) -> &'static str {
    match width {
        3 => "VEC3",
        4 => "VEC4",
        _ => "SCALAR",
    }
}

pub(super) fn path(property: Property) -> &'static str {
    match property {
        Property::Translation | Property::Expression => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        Property::Weights => "weights",
    }
}

pub(super) fn interpolation(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Linear => "LINEAR",
        Interpolation::Step => "STEP",
        Interpolation::CubicSpline => "CUBICSPLINE",
    }
}

/// Copies members of an old animation other than channels and samplers.
fn keep_unknown(mut old: Value, animation: &mut Value) {
    let members = std::mem::take(object(&mut old));
    for (key, mut value) in members {
        if key == "extensions" {
            object(&mut value).shift_remove(ARTICULATION);
            if object(&mut value).is_empty() {
                continue;
            }
        }
        if animation.get(&key).is_none() {
            set(animation, &key, value);
        }
    }
}
