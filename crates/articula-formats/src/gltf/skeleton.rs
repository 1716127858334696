//! Selection of the nodes that become joints, and their properties.

use super::node::{self, Tree};
use super::place::Place;
use super::pointer::{self, Pointed};
use super::reader::Reader;
use super::skin::NodeSkin;
use crate::error::ReadError;
use articula_core::source::{Joint, Skeleton};
use std::collections::HashMap;

/// The nodes of a document that a human extension names.
#[derive(Debug, Default)]
pub(super) struct HumanNodes {
    /// Node and human bone, in the order of the file.
    pub(super) bones: Vec<(usize, String)>,
    /// Expression index of each node whose x translation is an expression's value.
    pub(super) expressions: HashMap<usize, usize>,
}

/// The skeleton, and the mapping between its joints and the nodes.
#[derive(Debug)]
pub(super) struct Skeletal {
    pub(super) skeleton: Skeleton,
    pub(super) node_of_joint: Vec<usize>,
    /// Joint of each node that was kept.
    pub(super) joint_of_node: Vec<Option<usize>>,
    /// Whether a scene shows each node.
    pub(super) in_scene: Vec<bool>,
    /// Expression index of each node whose x translation is an expression's value.
    pub(super) expression_of_node: HashMap<usize, usize>,
}

/// Selects the nodes that become joints and builds the skeleton.
pub(super) fn read(
    reader: &mut Reader<'_>,
    tree: &Tree,
    skins: &[NodeSkin],
    human: &HumanNodes,
) -> Result<Skeletal, ReadError> {
    let mut in_skin = vec![false; tree.len()];
    for joint in skins.iter().flat_map(|skin| &skin.joints) {
        in_skin[*joint] = true;
    }
    for (node, _) in &human.bones {
        in_skin[*node] = true;
    }
    // A node that only carries the value of an expression is not a joint.
    let mut expression_of_node = human.expressions.clone();
    expression_of_node.retain(|node, _| !in_skin[*node]);
    let kept = kept_nodes(reader, tree, &in_skin, &expression_of_node)?;
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
        expression_of_node,
    })
}

pub(super) fn node_place<'a>(reader: &Reader<'a>, n: usize) -> Result<Place<'a>, ReadError> {
    let missing = || ReadError::malformed("nodes", format!("node {n} does not exist"));
    reader.root.entry("nodes", n).ok_or_else(missing)
}

fn kept_nodes(
    reader: &Reader<'_>,
    tree: &Tree,
    in_skin: &[bool],
    expression_of_node: &HashMap<usize, usize>,
) -> Result<Vec<bool>, ReadError> {
    let mut kept = animated_nodes(&reader.root, tree.len())?;
    expression_of_node.keys().for_each(|n| kept[*n] = false);
    let count = |is: &dyn Fn(usize) -> bool| (0..tree.len()).filter(|n| is(*n)).count();
    let (skinned, beside) = (count(&|n| in_skin[n]), count(&|n| kept[n] && !in_skin[n]));
    if skinned > 0 && beside > skinned {
        // The skins are over a part of the figure; hands and feet rarely have keys.
        for &n in &tree.order {
            let is_below = tree.parents[n].is_some_and(|parent| kept[parent]);
            kept[n] |= is_below && !expression_of_node.contains_key(&n);
        }
    }
    for (n, node) in reader.root.entries("nodes")?.iter().enumerate() {
        let is_rigid = node.get("mesh").is_some() && node.get("skin").is_none();
        kept[n] |= in_skin[n] || is_rigid && tree.in_scene[n];
    }
    // Children come after their parents in the order, so one backward pass reaches the roots.
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

/// Returns for each node whether a channel moves it (weights do not count).
pub(super) fn animated_nodes(root: &Place<'_>, nodes: usize) -> Result<Vec<bool>, ReadError> {
    let mut animated = vec![false; nodes];
    for animation in root.entries("animations")? {
        for channel in animation.entries("channels")? {
            let Some(target) = channel.get("target") else {
                continue;
            };
            let named = target.index("node", nodes)?;
            let pointed = pointer::text(&target).and_then(pointer::parse);
            let (node, path) = match pointed {
                Some(Pointed::Node(node, path)) if node < nodes => (Some(node), path),
                _ => (named, target.text("path")),
            };
            let moves = matches!(path, "translation" | "rotation" | "scale");
            if let (Some(node), true) = (node, moves) {
                animated[node] = true;
            }
        }
    }
    Ok(animated)
}
