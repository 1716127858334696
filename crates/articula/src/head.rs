//! The joints that turn the head of a figure, and the vertices that they move.

use crate::figure::Figure;

/// A vertex belongs to the head if its weights of head joints exceed this sum.
const OF_HEAD: f32 = 0.5;
/// H-Anim joints from the neck to the skull, vertebrae included.
const NECK: [&str; 9] = [
    "vc7",
    "vc6",
    "vc5",
    "vc4",
    "vc3",
    "vc2",
    "vc1",
    "skullbase",
    "skull",
];

/// Joints that turn the head, from the lowest neck joint up; empty if unknown.
pub(crate) fn head_joints(figure: &Figure) -> Vec<usize> {
    let joints = figure.asset.rig.articulation();
    let mut found: Vec<usize> = NECK.iter().filter_map(|name| joints.find(name)).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Marks the vertices moved by the head's last joint and its descendants; all vertices without such
/// a joint.
pub(crate) fn head_vertices(figure: &Figure, joints: &[usize]) -> Vec<bool> {
    let asset = &figure.asset;
    let Some(head) = joints.last() else {
        return vec![true; asset.mesh.len()];
    };
    let weight = |v: usize| -> f32 {
        let influences = asset.mesh.influences_of(v);
        let of_head = influences.filter(|(joint, _)| asset.rig.is_at_or_below(*joint, *head));
        of_head.map(|(_, weight)| weight).sum()
    };
    (0..asset.mesh.len()).map(|v| weight(v) > OF_HEAD).collect()
}
