//! Joints that are inserted into a document, or removed from it in favour of another one.
//!
//! Source: glTF 2.0, 3.7.3 (skins). A removed joint stays in the list of nodes as an unused entry,
//! so that references to other nodes, also of unknown extensions, stay right.

use super::append::{entries_mut, index, object, push, set};
use super::document::Document;
use super::extension::ARTICULATION;
use super::fresh::write_transform;
use super::place::whole;
use super::reader::{Notes, Reader};
use super::renumbered_skin::Slots;
use crate::error::ReadError;
use crate::limits::Limits;
use crate::written::WriteError;
use articula_core::Transform;
use glam::{Affine3A, Vec3};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// A joint to be inserted between a node and one of its children; it does not turn at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewJoint<'a> {
    /// Name of the new node.
    pub name: &'a str,
    /// Node above it.
    pub parent: usize,
    /// Node below it.
    pub child: usize,
    /// Offset from the parent at rest, in its space.
    pub offset: Vec3,
    /// Local transform of the child at rest, below the new node; `None` if it stays as it is.
    pub child_rest: Option<Transform>,
}

/// A joint to be removed.
#[derive(Debug, Clone, PartialEq)]
pub struct OldJoint {
    /// Node of the joint.
    pub node: usize,
    /// Node that takes its skin.
    pub into: usize,
    /// Transform of the joint relative to that node at rest.
    pub rest: Transform,
    /// Its children, with their local transforms at rest below its parent.
    pub children: Vec<(usize, Transform)>,
}

impl Document {
    /// Inserts a joint and returns its node. Skins of several joints that list the node above or
    /// below it list it too.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the nodes are not parent and child, or the matrices of a skin
    /// cannot be read.
    pub fn insert_joint(&mut self, joint: &NewJoint<'_>) -> Result<usize, WriteError> {
        let at = || format!("nodes[{}]", joint.parent);
        let new = self.count("nodes");
        let skins = self.skins_with(&[joint.parent, joint.child])?;
        if !self.replace_child(joint.parent, joint.child, &[new]) {
            let what = format!("node {} is not among its children", joint.child);
            return Err(WriteError::mismatch(at(), what));
        }
        let mut node = json!({"name": joint.name, "children": [joint.child]});
        write_transform(&mut node, Transform::from_translation(joint.offset));
        push(&mut self.json, "nodes", node);
        let below = match joint.child_rest {
            Some(rest) => {
                self.set_local(joint.child, rest);
                rest.to_affine()
            }
            None => self.local(joint.child),
        };
        for mut skin in skins {
            let slot = |node: usize| skin.joints.iter().position(|j| *j == node);
            let bind = if let Some(slot) = slot(joint.parent) {
                Affine3A::from_translation(-joint.offset) * skin.inverse_bind[slot]
            } else if let Some(slot) = slot(joint.child) {
                below * skin.inverse_bind[slot]
            } else {
                continue;
            };
            if skin.joints.len() > 1 {
                skin.joints.push(new);
                skin.inverse_bind.push(bind);
                self.store_skin(&skin);
            }
        }
        Ok(new)
    }

    /// Removes a joint: its children hang from its parent, and its skin follows another joint. A node
    /// that shows a mesh, a camera or something unknown stays as a plain node with another name.
    /// Animations are not changed; clips must be replaced afterwards.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the node has no parent, a skin cannot be read, or a mesh is used
    /// by two skins of which the joint is in different places; the document is then unchanged.
    pub fn remove_joint(&mut self, joint: &OldJoint) -> Result<(), WriteError> {
        let at = || format!("nodes[{}]", joint.node);
        let parents = super::facing::parents(&self.json);
        let Some(parent) = parents.get(joint.node).copied().flatten() else {
            return Err(WriteError::mismatch(at(), "the node has no parent"));
        };
        self.give_skin(joint.node, joint.into, joint.rest.to_affine())?;
        for skin in entries_mut(&mut self.json, "skins") {
            if index(skin, "skeleton") == Some(joint.node) {
                set(skin, "skeleton", parent);
            }
        }
        let mut children: Vec<usize> = joint.children.iter().map(|(c, _)| *c).collect();
        for (child, rest) in &joint.children {
            self.set_local(*child, *rest);
        }
        if self.strip(joint.node) {
            children.insert(0, joint.node);
        }
        self.replace_child(parent, joint.node, &children);
        Ok(())
    }

    /// Gives the skin of a joint to another one; the joint stays a node. Skins that list both lose it, and
    /// its weights are added to those of the other; in skins that list it alone the other takes its place.
    /// `rest` is the transform of the joint relative to the other at rest.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if a skin cannot be read, or a mesh is used by two skins of which the joint
    /// is in different places; the document is then unchanged.
    pub fn give_skin(
        &mut self,
        node: usize,
        into: usize,
        rest: Affine3A,
    ) -> Result<(), WriteError> {
        let skins = self.skins_with(&[node])?;
        let slots: BTreeMap<usize, Slots> = skins
            .iter()
            .filter_map(|skin| {
                let slot = |node: usize| skin.joints.iter().position(|j| *j == node);
                let (own, other) = (slot(node)?, slot(into)?);
                Some((skin.index, Slots { own, other }))
            })
            .collect();
        let stale = self.renumber_skinned(&slots)?;
        self.drop_unnamed(stale);
        for mut skin in skins {
            let Some(own) = skin.joints.iter().position(|j| *j == node) else {
                continue;
            };
            if slots.contains_key(&skin.index) {
                skin.joints.remove(own);
                skin.inverse_bind.remove(own);
            } else {
                skin.joints[own] = into;
                skin.inverse_bind[own] = rest * skin.inverse_bind[own];
            }
            self.store_skin(&skin);
        }
        Ok(())
    }

    /// Takes the children from a node, and all that makes it a joint; returns whether it shows
    /// anything, and so must stay in its place.
    fn strip(&mut self, node: usize) -> bool {
        let Some(node) = entries_mut(&mut self.json, "nodes").get_mut(node) else {
            return false;
        };
        let members = object(node);
        members.shift_remove("children");
        if let Some(extensions) = members.get_mut("extensions").and_then(Value::as_object_mut) {
            extensions.shift_remove(ARTICULATION);
            if extensions.is_empty() {
                members.shift_remove("extensions");
            }
        }
        let plain = [
            "name",
            "matrix",
            "translation",
            "rotation",
            "scale",
            "extras",
        ];
        if members.keys().all(|key| plain.contains(&key.as_str())) {
            members.retain(|key, _| key == "extras");
            return false;
        }
        if let Some(name) = members.get("name").and_then(Value::as_str) {
            let name = format!("{name}_merged");
            members.insert("name".to_owned(), name.into());
        }
        true
    }

    /// Puts nodes in the place of a child; returns whether it was there.
    fn replace_child(&mut self, parent: usize, child: usize, new: &[usize]) -> bool {
        let Some(node) = entries_mut(&mut self.json, "nodes").get_mut(parent) else {
            return false;
        };
        let Some(list) = node.get_mut("children").and_then(Value::as_array_mut) else {
            return false;
        };
        let is = |entry: &Value| whole(entry) == Some(child as u64);
        let Some(at) = list.iter().position(is) else {
            return false;
        };
        list.splice(at..=at, new.iter().map(|node| json!(node)));
        if list.is_empty() {
            object(node).shift_remove("children");
        }
        true
    }

    fn set_local(&mut self, node: usize, rest: Transform) {
        if let Some(node) = entries_mut(&mut self.json, "nodes").get_mut(node) {
            for key in ["matrix", "translation", "rotation", "scale"] {
                object(node).shift_remove(key);
            }
            write_transform(node, rest);
        }
    }

    fn local(&self, node: usize) -> Affine3A {
        super::facing::rest(&self.json["nodes"][node])
    }

    /// The skins that list one of these nodes.
    fn skins_with(&self, nodes: &[usize]) -> Result<Vec<StoredSkin>, WriteError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let wrong = |e: ReadError| WriteError::mismatch("skins", e.to_string());
        let skins = super::skin::read_all(&mut reader, self.count("nodes")).map_err(wrong)?;
        let stored = skins
            .into_iter()
            .enumerate()
            .map(|(index, skin)| StoredSkin {
                index,
                joints: skin.joints,
                inverse_bind: skin.inverse_bind,
            });
        let lists = |skin: &StoredSkin| skin.joints.iter().any(|j| nodes.contains(j));
        Ok(stored.filter(lists).collect())
    }

    /// Writes the joints of a skin, and their matrices as an array of its own.
    fn store_skin(&mut self, skin: &StoredSkin) {
        let accessor = self.add_inverse_bind(&skin.inverse_bind);
        let value = &mut entries_mut(&mut self.json, "skins")[skin.index];
        let old = index(value, "inverseBindMatrices");
        set(value, "joints", skin.joints.clone());
        set(value, "inverseBindMatrices", accessor);
        self.drop_unnamed(old.into_iter().collect::<BTreeSet<_>>());
    }
}

/// A skin of the document.
struct StoredSkin {
    index: usize,
    joints: Vec<usize>,
    inverse_bind: Vec<Affine3A>,
}
