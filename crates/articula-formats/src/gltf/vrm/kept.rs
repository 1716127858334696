//! Counts of data that stays in the document but is not simulated.
//!
//! Source: VRM 0.x `secondaryAnimation`, `firstPerson`; VRM 1.0 `VRMC_springBone`,
//! `VRMC_node_constraint`, `lookAt`, `firstPerson`, `VRMC_materials_mtoon`; the node hints of the
//! draft KHR_character family.

use super::super::place::Place;
use articula_core::source::Expression;

/// Data of a file that is written again but has no effect here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassThrough {
    /// Name of the data, in the plural.
    pub what: &'static str,
    /// Number of items; never 0.
    pub count: usize,
}

/// Counts the data that is kept.
pub(in super::super) fn read(root: &Place<'_>, expressions: &[Expression]) -> Vec<PassThrough> {
    let at = |path: &[&str]| root.dig(path);
    let count = |path: &[&str], key: &str| at(path).map_or(0, |place| place.count(key));
    let spring = ["extensions", "VRMC_springBone"];
    let old_springs = ["extensions", "VRM", "secondaryAnimation"];
    let new = ["extensions", "VRMC_vrm"];
    let first_person = |of: &str| count(&["extensions", of, "firstPerson"], "meshAnnotations");
    let old_look = at(&["extensions", "VRM", "firstPerson", "lookAtTypeName"]);
    let look = at(&[new[0], new[1], "lookAt"]).or(old_look);
    let track = at(&["extensions", "VRMC_vrm_animation", "lookAt", "node"]);
    let nodes = |name: &str| extended(root, "nodes", name);
    let all = [
        (
            "spring bone chains",
            count(&spring, "springs") + count(&old_springs, "boneGroups"),
        ),
        (
            "spring bone colliders",
            count(&spring, "colliders") + old_colliders(root),
        ),
        ("node constraints", nodes("VRMC_node_constraint")),
        ("look-at settings", usize::from(look.is_some())),
        ("look-at tracks", usize::from(track.is_some())),
        (
            "first-person annotations",
            first_person("VRM") + first_person("VRMC_vrm"),
        ),
        (
            "expression bindings to materials and textures",
            expressions.iter().map(|e| e.unapplied).sum(),
        ),
        ("toon materials", toon_materials(root)),
        ("camera hints", nodes("KHR_node_camera_hint")),
        ("look-at targets", nodes("KHR_node_lookat_target")),
        ("visibility hints", nodes("KHR_node_visibility_hint")),
    ];
    let kept = all.map(|(what, count)| PassThrough { what, count });
    kept.into_iter().filter(|k| k.count > 0).collect()
}

/// Returns the number of entries of a top-level array that have an extension.
fn extended(root: &Place<'_>, key: &str, name: &str) -> usize {
    let entries = root.entries(key).unwrap_or_default();
    let has = |entry: &&Place<'_>| entry.dig(&["extensions", name]).is_some();
    entries.iter().filter(has).count()
}

fn old_colliders(root: &Place<'_>) -> usize {
    let springs = root.dig(&["extensions", "VRM", "secondaryAnimation"]);
    let groups = springs.map(|s| s.entries("colliderGroups").unwrap_or_default());
    let groups = groups.unwrap_or_default();
    groups.iter().map(|group| group.count("colliders")).sum()
}

/// Returns the number of toon materials. VRM 0.x lists its materials a second time, in the same
/// order.
fn toon_materials(root: &Place<'_>) -> usize {
    let old = root.dig(&["extensions", "VRM"]);
    let old = old.map(|vrm| vrm.entries("materialProperties").unwrap_or_default());
    let is_toon = |m: &&Place<'_>| m.text("shader") == "VRM/MToon";
    let old = old.unwrap_or_default().iter().filter(is_toon).count();
    old.max(extended(root, "materials", "VRMC_materials_mtoon"))
}
