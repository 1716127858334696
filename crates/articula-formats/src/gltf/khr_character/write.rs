//! Writing of character, skeleton mapping and reference pose into a document.
//!
//! Source: the schemas `KHR_character`, `KHR_character_skeleton_mapping` (role to node index) and
//! `KHR_character_reference_pose`; the guideline `vrmHumanoid`, which leaves eyes and jaw to
//! expressions.

use super::super::append::{entries_mut, index, object, push, set, shorts};
use super::super::document::Document;
use super::super::facing::{faces_back, parents, rest};
use super::super::place::{Place, whole};
use super::{CHARACTER, REFERENCE_POSE, SKELETON_MAPPING};
use crate::joint_map::is_vrm_bone;
use crate::written::WriteError;
use articula_core::Transform;
use articula_core::source::{Channel, Credits, Interpolation, Property, RawClip};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// Bones that the rig `vrmHumanoid` does not have.
const NO_ROLES: [&str; 3] = ["leftEye", "rightEye", "jaw"];

impl Document {
    /// Writes the draft extensions KHR_character, KHR_character_skeleton_mapping (to `vrmHumanoid`)
    /// and, as a new animation, KHR_character_reference_pose; and the credits as KHR_xmp_json_ld.
    ///
    /// `bones` are nodes and human bones of VRM, of either version; the reference pose is their
    /// rest pose, and `kind` names it (`TPose`, `APose`, `IPose`). If the scene has several root
    /// nodes, or a VRM 0.x character faces -Z, a new root node is added above them; it turns the
    /// latter to +Z. Call this last: clips must not be replaced afterwards. A document that has a
    /// reference pose keeps it.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if a bone's node does not exist, or `bones` has no `hips`; the
    /// document is then unchanged.
    pub fn set_khr_character(
        &mut self,
        bones: &[(usize, String)],
        kind: &str,
        credits: Option<&Credits>,
    ) -> Result<(), WriteError> {
        let count = self.count("nodes");
        let is_old = bones.iter().any(|(_, b)| b.ends_with("ThumbIntermediate"));
        let mut roles: Vec<(usize, String)> = Vec::new();
        for (node, bone) in bones {
            if *node >= count {
                let what = format!("node {node} is out of range: the file has {count} nodes");
                return Err(WriteError::mismatch(format!("bone \"{bone}\""), what));
            }
            let role = if is_old { new_name(bone) } else { bone.clone() };
            let has_role = is_vrm_bone(&role) && !NO_ROLES.contains(&role.as_str());
            if has_role && roles.iter().all(|(_, known)| *known != role) {
                roles.push((*node, role));
            }
        }
        if roles.iter().all(|(_, role)| role != "hips") {
            let what = "no bone is \"hips\"; the extension needs a human character";
            return Err(WriteError::mismatch("bones", what));
        }
        let root = self.common_root();
        self.extend(CHARACTER, json!({"rootNode": root}));
        let named = roles.iter().map(|(node, role)| (role.clone(), json!(node)));
        let rig: Map<String, Value> = named.collect();
        let rigs = json!({"skeletalRigMappings": {"vrmHumanoid": rig}});
        self.extend(SKELETON_MAPPING, rigs);
        if !self.has_reference_pose() {
            self.add_reference_pose(&roles, kind);
        }
        if let Some(credits) = credits {
            self.set_credits(credits);
        }
        Ok(())
    }

    /// Returns the node above all others of the scene; a new one if there is none, or the character
    /// has to be turned. Nodes outside of the scene stay unchanged.
    fn common_root(&mut self) -> usize {
        let turns = faces_back(&self.json);
        let roots = self.shown_roots();
        if let ([root], false) = (&roots[..], turns) {
            return *root;
        }
        let mut node = json!({"name": "character", "children": roots});
        if turns {
            set(&mut node, "rotation", json!([0.0, 1.0, 0.0, 0.0]));
        }
        let new = push(&mut self.json, "nodes", node);
        if self.count("scenes") == 0 {
            set(&mut self.json, "scenes", json!([{"nodes": [new]}]));
            set(&mut self.json, "scene", 0);
            return new;
        }
        for scene in entries_mut(&mut self.json, "scenes") {
            let Some(Value::Array(nodes)) = scene.get_mut("nodes") else {
                continue;
            };
            let count = nodes.len();
            nodes.retain(|node| {
                whole(node).is_none_or(|n| roots.binary_search(&(n as usize)).is_err())
            });
            if nodes.len() < count {
                nodes.insert(0, json!(new));
            }
        }
        new
    }

    /// Returns the nodes without parent that the document's scene shows; all of them without a
    /// scene.
    fn shown_roots(&self) -> Vec<usize> {
        let parents = parents(&self.json);
        let is_root = |n: &usize| parents.get(*n) == Some(&None);
        let scene = index(&self.json, "scene").unwrap_or(0);
        let scenes = self.json.get("scenes").and_then(Value::as_array);
        let nodes = scenes.and_then(|s| s.get(scene)?.get("nodes")?.as_array());
        let nodes = nodes.into_iter().flatten().filter_map(whole);
        let mut shown: BTreeSet<usize> = nodes.map(|n| n as usize).filter(is_root).collect();
        if shown.is_empty() {
            shown.extend((0..parents.len()).filter(is_root));
        }
        shown.into_iter().collect()
    }

    fn has_reference_pose(&self) -> bool {
        let root = Place::root(&self.json);
        !super::reference_poses(&root).is_empty()
    }

    /// Adds an animation with one key per bone: its rotation, and the translation of the hips.
    fn add_reference_pose(&mut self, roles: &[(usize, String)], kind: &str) {
        let mut channels = Vec::new();
        for (node, role) in roles {
            // A node with a matrix cannot be animated; one whose matrix is not a transform has no
            // pose.
            let Some(rest) = self.split_matrix(*node) else {
                continue;
            };
            let mut key = |property, values: &[f32]| {
                channels.push(Channel {
                    target: *node,
                    property,
                    interpolation: Interpolation::Step,
                    times_secs: vec![0.0],
                    values: values.to_vec(),
                });
            };
            key(Property::Rotation, &rest.rotation.to_array());
            if role == "hips" {
                key(Property::Translation, &rest.translation.to_array());
            }
        }
        let mut pose = self.animation_of_nodes(&RawClip {
            name: kind.to_owned(),
            duration_secs: 0.0,
            channels,
        });
        let is_pose = json!({REFERENCE_POSE: {"poseType": kind}});
        set(&mut pose, "extensions", is_pose);
        push(&mut self.json, "animations", pose);
        self.use_extension(REFERENCE_POSE);
    }

    /// Returns the rest transform of a node, and stores it as translation, rotation and scale from
    /// now on.
    fn split_matrix(&mut self, node: usize) -> Option<Transform> {
        let node = &mut self.json["nodes"][node];
        let split = Transform::from_matrix(rest(node).into())?;
        if object(node).shift_remove("matrix").is_some() {
            set(node, "translation", shorts(&split.translation.to_array()));
            set(node, "rotation", shorts(&split.rotation.to_array()));
            set(node, "scale", shorts(&split.scale.to_array()));
            return Some(split);
        }
        // Existing values are kept exactly.
        let place = Place::root(node);
        let rotation = place.floats::<4>("rotation").ok().flatten();
        Some(Transform {
            rotation: rotation.map_or(split.rotation, glam::Quat::from_array),
            ..split
        })
    }

    /// Updates the expressions of KHR_character_expression after animations were replaced; `old`
    /// are name and channel count of the previous ones. An expression is removed if its animation
    /// is missing or has another number of channels.
    pub(in super::super) fn follow_animations(&mut self, old: &[(String, usize)]) {
        let animations = self.json.get("animations").and_then(Value::as_array);
        let new: Vec<(String, usize)> = super::named(animations);
        let moved = |entry: &Value| -> Option<usize> {
            let at = index(entry, "animation")?;
            let animation = old.get(at)?;
            // Of animations with equal names, the first corresponds to the first.
            let before = old[..at].iter().filter(|a| *a == animation).count();
            let same = new.iter().enumerate().filter(|(_, a)| *a == animation);
            same.map(|(i, _)| i).nth(before)
        };
        let Some(expression) = self
            .json
            .get_mut("extensions")
            .and_then(|extensions| extensions.get_mut(super::EXPRESSION))
        else {
            return;
        };
        let Some(Value::Array(entries)) = expression.get_mut("expressions") else {
            return;
        };
        entries.retain_mut(|entry| {
            let moved = moved(entry);
            if let Some(animation) = moved {
                set(entry, "animation", animation);
            }
            moved.is_some()
        });
        if entries.is_empty() {
            object(&mut self.json["extensions"]).shift_remove(super::EXPRESSION);
        }
    }
}

/// Returns the VRM 1.0 name of a VRM 0.x bone: they differ in the thumb.
fn new_name(bone: &str) -> String {
    if let Some(side) = bone.strip_suffix("ThumbProximal") {
        return format!("{side}ThumbMetacarpal");
    }
    if let Some(side) = bone.strip_suffix("ThumbIntermediate") {
        return format!("{side}ThumbProximal");
    }
    bone.to_owned()
}
