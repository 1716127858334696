//! Mapping of nodes to the joints of a known rig.
//!
//! Source: `KHR_character_skeleton_mapping`. The mapping of one rig has had these forms: role to
//! node index (the schema that is written), role to `{node, name}`, role to node name, node name to
//! role, node name to a list of `{target, weight}`; and in `KHR_avatar` one rig under `target` with
//! a list of `{source, targets: [{joint, weight}]}`.

use super::super::place::Place;
use super::super::reader::Reader;
use super::super::skeleton::Skeletal;
use super::{RigMapping, SKELETON_MAPPING, extension};
use crate::joint_map::is_vrm_bone;
use std::collections::HashMap;

/// The mapping to one rig, by nodes.
struct NodeRig {
    rig: String,
    joints: Vec<(usize, String)>,
    /// Number of entries that name no node.
    lost: usize,
}

/// Returns node and VRM 1.0 human bone of the mapping with the most VRM bone names.
pub(in super::super) fn bones(root: &Place<'_>, nodes: usize) -> Vec<(usize, String)> {
    let is_human = |(_, role): &&(usize, String)| is_vrm_bone(role);
    let human = |rig: &NodeRig| rig.joints.iter().filter(is_human).count();
    let best = by_node(root, nodes).into_iter().max_by_key(human);
    let mut joints = best.map_or(Vec::new(), |rig| rig.joints);
    joints.retain(|joint| is_human(&joint));
    joints
}

/// Reads all rigs that the skeleton is mapped to.
pub(super) fn rigs(reader: &mut Reader<'_>, skeletal: &Skeletal) -> Vec<RigMapping> {
    let joint_of = &skeletal.joint_of_node;
    let mut rigs = Vec::new();
    for NodeRig { rig, joints, lost } in by_node(&reader.root, joint_of.len()) {
        if lost > 0 {
            let what = format!(
                "rig \"{}\": {lost} entries do not name a node; left out",
                cut(&rig)
            );
            reader.notes.add(SKELETON_MAPPING, what);
        }
        let joint = |(node, role): (usize, String)| Some((joint_of[node]?, role));
        let joints = joints.into_iter().filter_map(joint).collect();
        rigs.push(RigMapping { rig, joints });
    }
    rigs
}

fn by_node(root: &Place<'_>, nodes: usize) -> Vec<NodeRig> {
    let Some(mapping) = extension(root, SKELETON_MAPPING) else {
        return Vec::new();
    };
    let mut node_of_name: HashMap<&str, usize> = HashMap::new();
    let listed = root.entries("nodes").unwrap_or_default();
    for (n, node) in listed.iter().enumerate().take(nodes) {
        node_of_name.entry(node.text("name")).or_insert(n);
    }
    let named = |rig: &Place<'_>| -> Vec<Option<Entry>> {
        let members = rig.members().into_iter();
        members.map(|(key, value)| entry(key, &value)).collect()
    };
    let rigs = mapping.get("skeletalRigMappings");
    let rigs = rigs.map_or(Vec::new(), |m| m.members());
    let mut found: Vec<NodeRig> = rigs
        .iter()
        .map(|(name, rig)| resolved(name, named(rig), &node_of_name, nodes))
        .collect();
    if let Some(rig) = mapping.get("mappings") {
        let name = match mapping.text("target") {
            "" => "vrmHumanoid",
            name => name,
        };
        let mut entries = named(&rig);
        let listed = mapping.entries("mappings").unwrap_or_default();
        entries.extend(listed.iter().map(listed_entry));
        found.push(resolved(name, entries, &node_of_name, nodes));
    }
    found
}

/// One entry of a mapping, before it is known which side is the node.
enum Entry {
    ToNode { role: String, node: u64 },
    Names { key: String, value: String },
    FromName { node: String, role: String },
}

fn entry(key: &str, value: &Place<'_>) -> Option<Entry> {
    if let Ok(node) = value.whole() {
        let role = key.to_owned();
        return Some(Entry::ToNode { role, node });
    }
    if let Some(name) = value.value().as_str() {
        let (key, value) = (key.to_owned(), name.to_owned());
        return Some(Entry::Names { key, value });
    }
    if let Some(node) = value.get("node").and_then(|n| n.whole().ok()) {
        let role = key.to_owned();
        return Some(Entry::ToNode { role, node });
    }
    let role = heaviest(value.value().as_array()?, "target")?;
    let node = key.to_owned();
    Some(Entry::FromName { node, role })
}

fn listed_entry(entry: &Place<'_>) -> Option<Entry> {
    let role = heaviest(entry.get("targets")?.value().as_array()?, "joint")?;
    let node = entry.text("source").to_owned();
    Some(Entry::FromName { node, role })
}

/// Returns the weighted target with the greatest weight.
fn heaviest(targets: &[serde_json::Value], key: &str) -> Option<String> {
    let weight = |t: &serde_json::Value| t.get("weight").and_then(serde_json::Value::as_f64);
    let weight = |t: &serde_json::Value| weight(t).unwrap_or(1.0);
    // The first of equals wins, so the search runs from the end.
    let best = targets
        .iter()
        .rev()
        .max_by(|a, b| weight(a).total_cmp(&weight(b)));
    Some(best?.get(key)?.as_str()?.to_owned())
}

fn resolved(
    rig: &str,
    entries: Vec<Option<Entry>>,
    node_of_name: &HashMap<&str, usize>,
    nodes: usize,
) -> NodeRig {
    let is_node = |name: &str| usize::from(node_of_name.contains_key(name));
    let is_role = |name: &str| usize::from(is_vrm_bone(name));
    // Files from before the direction was fixed: the side with VRM bone names is the role; where
    // both or neither have them, the side that matches fewer nodes.
    let (mut keys, mut values) = ((0, 0), (0, 0));
    for entry in entries.iter().flatten() {
        if let Entry::Names { key, value } = entry {
            keys = (keys.0 + is_role(key), keys.1 + is_node(value));
            values = (values.0 + is_role(value), values.1 + is_node(key));
        }
    }
    let key_is_role = keys >= values;
    let found = |entry: Entry| {
        let (node, role) = match entry {
            Entry::ToNode { role, node } => {
                let node = usize::try_from(node).ok().filter(|n| *n < nodes)?;
                return Some((node, role));
            }
            Entry::Names { key, value } if key_is_role => (value, key),
            Entry::Names { key, value } => (key, value),
            Entry::FromName { node, role } => (node, role),
        };
        Some((*node_of_name.get(node.as_str())?, role))
    };
    let count = entries.len();
    let joints: Vec<_> = entries.into_iter().flatten().filter_map(found).collect();
    NodeRig {
        rig: rig.to_owned(),
        lost: count - joints.len(),
        joints,
    }
}

fn cut(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn of(extensions: Value) -> Vec<(usize, String)> {
        let nodes = json!([{"name": "root"}, {"name": "J_Hips"}, {"name": "J_Head"}]);
        let json = json!({"nodes": nodes, "extensions": extensions});
        bones(&Place::root(&json), 3)
    }

    fn mapping(rig: Value) -> Value {
        json!({"KHR_character_skeleton_mapping": {"skeletalRigMappings": {
            "other": {"a": 0}, "vrmHumanoid": rig}}})
    }

    #[test]
    fn every_form_says_the_same() {
        let wanted = [(1, "hips".to_owned()), (2, "head".to_owned())];
        for rig in [
            json!({"hips": 1, "head": 2, "tail": 0, "spine": 9}),
            json!({"hips": {"node": 1, "name": "x"}, "head": {"node": 2}}),
            json!({"hips": "J_Hips", "head": "J_Head", "spine": "lost"}),
            json!({"J_Hips": "hips", "J_Head": "head"}),
            json!({"J_Hips": [{"target": "hips", "weight": 1.0}],
                "J_Head": [{"target": "neck", "weight": 0.2}, {"target": "head", "weight": 0.8}]}),
        ] {
            assert_eq!(of(mapping(rig.clone())), wanted, "{rig}");
        }
        let avatar = json!([{"source": "J_Hips", "targets": [{"joint": "hips", "weight": 1.0}]},
            {"source": "J_Head", "targets": [{"joint": "head"}]}]);
        let avatar = json!({"KHR_avatar_skeleton_mapping": {"mappings": avatar}});
        assert_eq!(of(avatar), wanted);
    }

    #[test]
    fn names_that_are_roles_and_nodes_at_once() {
        let json = json!({"nodes": [{"name": "hips"}, {"name": "head"}],
            "extensions": mapping(json!({"hips": "hips", "head": "head"}))});
        let wanted = [(0, "hips".to_owned()), (1, "head".to_owned())];
        assert_eq!(bones(&Place::root(&json), 2), wanted);
    }

    #[test]
    fn what_is_no_mapping_gives_nothing() {
        for rig in [
            json!(1),
            json!([]),
            json!({"hips": [], "head": {}, "neck": null}),
        ] {
            assert_eq!(of(mapping(rig)), []);
        }
        assert_eq!(of(json!({"KHR_character_skeleton_mapping": []})), []);
    }
}
