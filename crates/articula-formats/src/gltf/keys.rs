//! Other keys for the channels of a document's animations, with all else kept.

use super::append::{entries_mut, index, object, push, set};
use super::clips::{Arrays, Nodes, element_width, interpolation, path};
use super::document::Document;
use crate::written::WriteError;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use serde_json::{Value, json};
use std::collections::HashMap;

impl Document {
    /// Replaces the keys of the animations by those of clips, where clip `i` is `animations[i]`, and
    /// removes channels that the clip does not have any more. Channels that drive anything but a joint
    /// or the morph targets of a mesh, such as those of expressions, cameras and materials, stay as they
    /// are, and so do names, extras and extensions.
    ///
    /// Returns for each animation and each of its samplers the channel of the clip that it holds.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if there is another number of clips than animations, or a channel drives
    /// a joint or mesh without node, or has another number of values than its keys need; the document
    /// is then unchanged.
    pub fn replace_keys(
        &mut self,
        clips: &[RawClip],
        node_of_joint: &[usize],
        node_of_mesh: &[usize],
    ) -> Result<Vec<Vec<Option<usize>>>, WriteError> {
        let count = self.count("animations");
        if clips.len() != count {
            let what = format!("{} clips for {count} animations", clips.len());
            return Err(WriteError::mismatch("clips", what));
        }
        let nodes = Nodes {
            of_joint: node_of_joint,
            of_mesh: node_of_mesh,
            of_expression: &[],
            is_turned: self.turned_nodes(),
            count: self.count("nodes"),
        };
        let is_stored = |c: &Channel| c.property != Property::Expression;
        let channels = clips.iter().flat_map(|clip| &clip.channels);
        for (i, channel) in channels.enumerate().filter(|(_, c)| is_stored(c)) {
            nodes.check(i, channel)?;
        }
        let mut held = Vec::with_capacity(clips.len());
        for (a, clip) in clips.iter().enumerate() {
            held.push(self.replace_keys_of(a, clip, &nodes));
        }
        Ok(held)
    }

    fn replace_keys_of(
        &mut self,
        a: usize,
        clip: &RawClip,
        nodes: &Nodes<'_>,
    ) -> Vec<Option<usize>> {
        let mut arrays = Arrays::new(self);
        let mut of_target: HashMap<(usize, &str), usize> = HashMap::new();
        for (c, channel) in clip.channels.iter().enumerate() {
            if channel.property != Property::Expression && !channel.times_secs.is_empty() {
                let node = nodes.node(channel).unwrap_or(usize::MAX);
                of_target.insert((node, path(channel.property)), c);
            }
        }
        let animation = entries_mut(&mut self.json, "animations")[a].clone();
        let list = |key: &str| animation.get(key).and_then(Value::as_array);
        let samplers = list("samplers").map_or(&[][..], Vec::as_slice);
        let mut written = json!({ "channels": [], "samplers": [] });
        let mut held = Vec::new();
        for old in list("channels").into_iter().flatten() {
            let sampler = index(old, "sampler").and_then(|s| samplers.get(s));
            let Some(mut sampler) = sampler.cloned() else {
                continue;
            };
            if is_read(old, nodes) {
                let target = target(old).and_then(|t| of_target.remove(&t));
                let Some(c) = target else {
                    continue;
                };
                let channel = nodes.as_stored(&clip.channels[c]);
                let input = arrays.add(self, &channel.times_secs, 1);
                let output = arrays.add(self, &channel.values, element_width(channel.property));
                set(&mut sampler, "input", input);
                set(&mut sampler, "output", output);
                // Linear is what a sampler does that says nothing.
                object(&mut sampler).shift_remove("interpolation");
                if channel.interpolation != Interpolation::Linear {
                    set(
                        &mut sampler,
                        "interpolation",
                        interpolation(channel.interpolation),
                    );
                }
                held.push(Some(c));
            } else {
                held.push(None);
            }
            let mut channel = old.clone();
            set(
                &mut channel,
                "sampler",
                push(&mut written, "samplers", sampler),
            );
            push(&mut written, "channels", channel);
        }
        self.add_buffer_view(&arrays.bytes);
        let animation = &mut entries_mut(&mut self.json, "animations")[a];
        for key in ["channels", "samplers"] {
            set(animation, key, written[key].take());
        }
        held
    }
}

/// Node and path of a channel without a pointer.
fn target(channel: &Value) -> Option<(usize, &str)> {
    let target = channel.get("target")?;
    Some((index(target, "node")?, target.get("path")?.as_str()?))
}

/// Whether a channel drives a joint, or all morph targets of a mesh.
fn is_read(channel: &Value, nodes: &Nodes<'_>) -> bool {
    target(channel).is_some_and(|(node, path)| match path {
        "weights" => nodes.of_mesh.contains(&node),
        "translation" | "rotation" | "scale" => nodes.of_joint.contains(&node),
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotation(times_secs: &[f32]) -> Channel {
        Channel {
            target: 0,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: times_secs.to_vec(),
            values: [0.0, 0.0, 0.0, 1.0].repeat(times_secs.len()),
        }
    }

    #[test]
    fn keys_change_and_what_is_not_a_joint_stays() {
        let pointer = json!({"sampler": 1, "target": {"path": "pointer", "extensions":
            {"KHR_animation_pointer": {"pointer": "/materials/0/alphaCutoff"}}}});
        let json = json!({
            "nodes": [{}, {}],
            "accessors": [{"count": 2}, {"count": 2}],
            "animations": [{"name": "a", "extras": 3, "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "rotation"}, "extras": 1},
                pointer,
                {"sampler": 1, "target": {"node": 0, "path": "scale"}},
                {"sampler": 1, "target": {"node": 1, "path": "scale"}},
            ], "samplers": [{"input": 0, "output": 1, "extras": 2}, {"input": 0, "output": 1}]}],
        });
        let mut document = Document {
            json,
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        let clip = RawClip {
            name: "a".into(),
            duration_secs: 1.0,
            channels: vec![rotation(&[0.0, 1.0])],
        };
        let none = document.replace_keys(&[], &[0], &[]);
        assert!(none.is_err());
        let held = document.replace_keys(&[clip], &[0], &[]).unwrap();
        assert_eq!(held, [[Some(0), None, None]]);
        let animation = &document.json["animations"][0];
        assert_eq!(animation["extras"], 3);
        assert_eq!(animation["channels"][0]["extras"], 1);
        assert_eq!(animation["channels"][1]["sampler"], 1);
        assert_eq!(animation["channels"][2]["target"]["node"], 1);
        assert_eq!(animation["samplers"][0]["input"], 2);
        assert_eq!(animation["samplers"][0]["extras"], 2);
        assert_eq!(animation["samplers"][1], json!({"input": 0, "output": 1}));
    }
}
