//! Which nodes become joints, and what they are.

use super::animation;
use super::node::{self, Tree};
use super::place::Place;
use super::reader::Reader;
use super::skin::NodeSkin;
use crate::error::ReadError;
use articula_core::source::{Joint, Skeleton};

/// Humanoid extensions that name bones by node: where, and under which member.
const HUMANOIDS: &[&[&str]] = &[
    &["extensions", "VRMC_vrm", "humanoid"],
    &["extensions", "VRM", "humanoid"],
    &["extensions", "VRMC_vrm_animation", "humanoid"],
];

/// The skeleton and the way between its joints and the nodes.
#[derive(Debug)]
pub(super) struct Skeletal {
    pub(super) skeleton: Skeleton,
    pub(super) node_of_joint: Vec<usize>,
    /// Joint of each node that was kept.
    pub(super) joint_of_node: Vec<Option<usize>>,
    /// Whether a scene shows each node.
    pub(super) in_scene: Vec<bool>,
}

/// Picks the nodes that matter and makes joints of them.
pub(super) fn read(
    reader: &mut Reader<'_>,
    tree: &Tree,
    skins: &[NodeSkin],
) -> Result<Skeletal, ReadError> {
    let mut in_skin = vec![false; tree.len()];
    for joint in skins.iter().flat_map(|skin| &skin.joints) {
        in_skin[*joint] = true;
    }
    mark_human_bones(reader, &mut in_skin);
    let kept = kept_nodes(reader, tree, &in_skin)?;
    let mut joint_of_node = vec![None; tree.len()];
    let mut node_of_joint = Vec::new();
    let mut joints = Vec::new();
    for &n in tree.order.iter().filter(|&&n| kept[n]) {
        let node = node_place(reader, n)?;
        joint_of_node[n] = Some(joints.len());
        node_of_joint.push(n);
        joints.push(Joint {
            name: node.text("name").to_owned(),
            parent: tree.parents[n].and_then(|parent| joint_of_node[parent]),
            rest: node::read_transform(reader, &node)?,
            in_skin: in_skin[n],
        });
    }
    Ok(Skeletal {
        skeleton: Skeleton { joints },
        node_of_joint,
        joint_of_node,
        in_scene: tree.in_scene.clone(),
    })
}

pub(super) fn node_place<'a>(reader: &Reader<'a>, n: usize) -> Result<Place<'a>, ReadError> {
    let missing = || ReadError::malformed("nodes", format!("there is no node {n}"));
    reader.root.entry("nodes", n).ok_or_else(missing)
}

fn kept_nodes(reader: &Reader<'_>, tree: &Tree, in_skin: &[bool]) -> Result<Vec<bool>, ReadError> {
    let mut kept = animation::animated_nodes(reader, tree.len())?;
    for (n, node) in reader.root.entries("nodes")?.iter().enumerate() {
        let is_rigid = node.get("mesh").is_some() && node.get("skin").is_none();
        kept[n] |= in_skin[n] || is_rigid && tree.in_scene[n];
    }
    // Children stand after their parents in the order, so one pass backwards reaches the top.
    for &n in tree
        .order
        .iter()
        .rev()
        .filter(|&&n| tree.parents[n].is_some())
    {
        if let (true, Some(parent)) = (kept[n], tree.parents[n]) {
            kept[parent] = true;
        }
    }
    Ok(kept)
}

/// VRM names its bones in an object (1.0, VRMA) or in a list (0.x). A broken entry is only a
/// warning, since the extension stands outside the format.
fn mark_human_bones(reader: &mut Reader<'_>, in_skin: &mut [bool]) {
    for keys in HUMANOIDS {
        let Some(bones) = reader.root.dig(keys).and_then(|h| h.get("humanBones")) else {
            continue;
        };
        let listed = reader
            .root
            .dig(keys)
            .and_then(|h| h.entries("humanBones").ok())
            .unwrap_or_default();
        let named = bones.members().into_iter().map(|(_, bone)| bone);
        for bone in listed.into_iter().chain(named) {
            match bone.index("node", in_skin.len()) {
                Ok(Some(node)) => in_skin[node] = true,
                // VRM 0.x writes -1 for a bone that is not there.
                Ok(None) => {}
                Err(_)
                    if bone
                        .get("node")
                        .is_some_and(|n| n.value().as_i64() == Some(-1)) => {}
                Err(error) => reader.warn(&bone, format!("human bone left out: {error}")),
            }
        }
    }
}
