//! The extension `ARTICULA_articulation`: H-Anim articulation of joints, and tables of motions.
//!
//! Each skin lists H-Anim name, level and region in the order of its joints; a node that is a joint
//! without being in a skin has them itself; each animation may
//! name buffer views by table name, and have other members that are opaque here. The page is
//! `docs/formats/ARTICULA_articulation.md`; the schema is next to it.

use super::append::{entries_mut, index, object, set};
use super::document::Document;
use super::extension::ARTICULATION;
use super::place::Place;
use super::reader::Reader;
use super::skeleton::Skeletal;
use crate::error::ReadError;
use crate::written::WriteError;
use articula_core::loa::MAX_LEVEL;
use articula_core::{Articulation, JointArticulation, Region};
use serde_json::{Value, json};

impl Document {
    /// Writes H-Anim name, level and region of every joint onto the document's skins.
    ///
    /// `node_of_joint` maps the articulation's joints to nodes, as [`read`](super::read) returns
    /// it. Joints in no skin are described on their nodes.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the lists differ in length, or a skin has a joint that is not in
    /// them.
    pub fn set_articulation(
        &mut self,
        articulation: &Articulation,
        node_of_joint: &[usize],
    ) -> Result<(), WriteError> {
        if articulation.joints.len() != node_of_joint.len() {
            let (found, wanted) = (node_of_joint.len(), articulation.joints.len());
            let what = format!("{found} nodes for {wanted} joints");
            return Err(WriteError::mismatch("node_of_joint", what));
        }
        let mut of_node = vec![None; self.count("nodes")];
        for (joint, &node) in articulation.joints.iter().zip(node_of_joint) {
            if let Some(slot) = of_node.get_mut(node) {
                *slot = Some(joint);
            }
        }
        let mut written = Vec::new();
        for (s, skin) in entries_mut(&mut self.json, "skins").iter().enumerate() {
            let joints = skin_joints(skin, &of_node).ok_or_else(|| {
                let what = "a joint of the skin is not among the given joints";
                WriteError::mismatch(format!("skins[{s}]"), what)
            })?;
            written.push(json!({"profile": articulation.profile, "joints": joints}));
        }
        self.describe_nodes(&of_node);
        for (skin, value) in entries_mut(&mut self.json, "skins").iter_mut().zip(written) {
            extend(skin, value);
        }
        self.use_extension(ARTICULATION);
        Ok(())
    }

    /// Describes the joints that are in no skin on their nodes, and no others.
    fn describe_nodes(&mut self, of_node: &[Option<&JointArticulation>]) {
        let mut is_in_skin = vec![false; of_node.len()];
        for skin in entries_mut(&mut self.json, "skins") {
            let joints = skin.get("joints").and_then(Value::as_array);
            for node in joints.into_iter().flatten().filter_map(super::place::whole) {
                if let Some(slot) = is_in_skin.get_mut(node as usize) {
                    *slot = true;
                }
            }
        }
        let nodes = entries_mut(&mut self.json, "nodes").iter_mut();
        for ((node, joint), is_in_skin) in nodes.zip(of_node).zip(is_in_skin) {
            match joint.filter(|_| !is_in_skin) {
                Some(joint) => extend(node, described(joint)),
                None => {
                    let extensions = node.get_mut("extensions").and_then(Value::as_object_mut);
                    if let Some(extensions) = extensions
                        && extensions.shift_remove(ARTICULATION).is_some()
                        && extensions.is_empty()
                    {
                        object(node).shift_remove("extensions");
                    }
                }
            }
        }
    }

    /// Stores a binary table with an animation under a name such as `motionError`.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the animation does not exist.
    pub fn set_motion_table(
        &mut self,
        animation: usize,
        name: &str,
        bytes: &[u8],
    ) -> Result<(), WriteError> {
        self.animation_mut(animation)?;
        if self.overwrite_table(animation, name, bytes) {
            return Ok(());
        }
        let view = self.add_buffer_view(bytes);
        let slot = motion_extension(self.animation_mut(animation)?);
        let tables = object(slot).entry("tables").or_insert_with(|| json!({}));
        set(tables, name, view);
        self.use_extension(ARTICULATION);
        Ok(())
    }

    /// Overwrites the bytes of a table of that name if they fit, so that rebuilding an asset does
    /// not enlarge it. The buffer view of a table is not shared.
    fn overwrite_table(&mut self, animation: usize, name: &str, bytes: &[u8]) -> bool {
        let tables = self.motion_member(animation, "tables");
        let Some(view) = tables.and_then(|tables| index(tables, name)) else {
            return false;
        };
        let Some(view) = entries_mut(&mut self.json, "bufferViews").get_mut(view) else {
            return false;
        };
        let start = index(view, "byteOffset").unwrap_or(0);
        let room = index(view, "byteLength").unwrap_or(0);
        let buffer = index(view, "buffer").and_then(|b| self.buffers.get_mut(b));
        let Some(place) = buffer.and_then(|b| b.get_mut(start..start.checked_add(room)?)) else {
            return false;
        };
        let Some(place) = place.get_mut(..bytes.len()).filter(|_| !bytes.is_empty()) else {
            return false;
        };
        place.copy_from_slice(bytes);
        set(view, "byteLength", bytes.len());
        true
    }

    /// Returns the bytes of an animation's table with this name.
    pub fn motion_table(&self, animation: usize, name: &str) -> Option<&[u8]> {
        let tables = self.motion_member(animation, "tables")?;
        self.view_bytes(index(tables, name)?)
    }

    /// Returns the bytes of a buffer view; `None` if they do not lie within a buffer.
    pub(super) fn view_bytes(&self, view: usize) -> Option<&[u8]> {
        let view = self.json.get("bufferViews")?.as_array()?.get(view)?;
        let bytes = self.buffers.get(index(view, "buffer")?)?;
        let start = index(view, "byteOffset").unwrap_or(0);
        let length = index(view, "byteLength")?;
        bytes.get(start..start.checked_add(length)?)
    }

    /// Returns a JSON member of an animation's extension.
    fn motion_member(&self, animation: usize, name: &str) -> Option<&Value> {
        let animations = self.json.get("animations")?.as_array()?;
        let extensions = animations.get(animation)?.get("extensions")?;
        extensions.get(ARTICULATION)?.get(name)
    }

    fn animation_mut(&mut self, animation: usize) -> Result<&mut Value, WriteError> {
        let animations = entries_mut(&mut self.json, "animations");
        let count = animations.len();
        animations.get_mut(animation).ok_or_else(|| {
            let what = format!("index {animation} is out of range: there are {count}");
            WriteError::mismatch("animation", what)
        })
    }
}

fn skin_joints(skin: &Value, of_node: &[Option<&JointArticulation>]) -> Option<Vec<Value>> {
    let nodes = skin.get("joints")?.as_array()?;
    let joint = |node: &Value| {
        let node = usize::try_from(super::place::whole(node)?).ok()?;
        let joint = of_node.get(node).copied().flatten()?;
        Some(described(joint))
    };
    nodes.iter().map(joint).collect()
}

fn described(joint: &JointArticulation) -> Value {
    json!({
        "hanim": joint.hanim,
        "level": joint.level,
        "region": joint.region.to_string(),
    })
}

fn extend(owner: &mut Value, value: Value) {
    let extensions = object(owner)
        .entry("extensions")
        .or_insert_with(|| json!({}));
    set(extensions, ARTICULATION, value);
}

fn motion_extension(animation: &mut Value) -> &mut Value {
    let extensions = object(animation)
        .entry("extensions")
        .or_insert_with(|| json!({}));
    object(extensions)
        .entry(ARTICULATION)
        .or_insert_with(|| json!({}))
}

/// Reads the extension from all skins and nodes; `None` if none has it. A broken one is a warning, since the
/// character can be mapped again.
pub(super) fn read(
    reader: &mut Reader<'_>,
    skeletal: &Skeletal,
) -> Result<Option<Articulation>, ReadError> {
    let mut found = vec![None; skeletal.node_of_joint.len()];
    let mut profile = None;
    for skin in reader.root.entries("skins")? {
        let Some(extension) = skin.dig(&["extensions", ARTICULATION]) else {
            continue;
        };
        match read_skin(&skin, &extension) {
            Ok(joints) => {
                profile.get_or_insert_with(|| extension.text("profile").to_owned());
                for (node, joint) in joints {
                    if let Some(j) = skeletal.joint_of_node.get(node).copied().flatten() {
                        found[j].get_or_insert(joint);
                    }
                }
            }
            Err(error) => reader.warn(&extension, format!("{error}; left out")),
        }
    }
    for (n, node) in reader.root.entries("nodes")?.iter().enumerate() {
        let Some(extension) = node.dig(&["extensions", ARTICULATION]) else {
            continue;
        };
        match read_joint(&extension) {
            Ok(joint) => {
                profile.get_or_insert_default();
                if let Some(j) = skeletal.joint_of_node.get(n).copied().flatten() {
                    found[j].get_or_insert(joint);
                }
            }
            Err(error) => reader.warn(&extension, format!("{error}; left out")),
        }
    }
    Ok(profile.map(|profile| Articulation {
        profile,
        joints: inherited(found, skeletal),
    }))
}

/// Reads node and articulation of each joint of a skin.
fn read_skin(
    skin: &Place<'_>,
    extension: &Place<'_>,
) -> Result<Vec<(usize, JointArticulation)>, ReadError> {
    let nodes = skin.entries("joints")?;
    let joints = extension.entries("joints")?;
    if nodes.len() != joints.len() {
        let what = format!("{} entries for {} joints", joints.len(), nodes.len());
        return Err(extension.malformed(what));
    }
    let pairs = nodes.iter().zip(&joints);
    pairs
        .map(|(node, joint)| Ok((node.index_below(usize::MAX)?, read_joint(joint)?)))
        .collect()
}

fn read_joint(place: &Place<'_>) -> Result<JointArticulation, ReadError> {
    let level = place.require("level")?;
    let level = level.index_below(usize::from(MAX_LEVEL) + 1)? as u8;
    let name = place.text("region");
    let region = name
        .parse::<Region>()
        .map_err(|_| place.malformed("unknown region"))?;
    let hanim = place.get("hanim").and_then(|h| h.value().as_str());
    Ok(JointArticulation {
        hanim: hanim.map(str::to_owned),
        level,
        region,
    })
}

/// Gives joints in no skin the level and region of their nearest described ancestor. Above all of
/// them is the root, which every level includes.
fn inherited(found: Vec<Option<JointArticulation>>, skeletal: &Skeletal) -> Vec<JointArticulation> {
    let mut joints: Vec<JointArticulation> = Vec::with_capacity(found.len());
    for (joint, own) in skeletal.skeleton.joints.iter().zip(found) {
        let above = joint.parent.map(|parent| &joints[parent]);
        let inherited = || JointArticulation {
            hanim: None,
            level: above.map_or(0, |a| a.level),
            region: above.map_or(Region::Pelvis, |a| a.region),
        };
        let joint = own.unwrap_or_else(inherited);
        joints.push(joint);
    }
    joints
}
