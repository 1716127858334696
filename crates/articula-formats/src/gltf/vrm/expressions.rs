//! Expressions: names that drive morph targets, and overrides between them.
//!
//! Source: VRM 0.x `blendShapeMaster.blendShapeGroups`, VRM 1.0 `expressions`, VRM animation 1.0
//! `expressions`. Presets of VRM 0.x get their VRM 1.0 names, so that one motion drives both.

use super::super::node_meshes::NodeMeshes;
use super::super::place::{Place, whole};
use super::super::reader::Reader;
use crate::error::ReadError;
use articula_core::source::{Expression, Mask, MaskKind, MorphBinding};
use serde_json::Value;
use std::collections::{HashMap, HashSet};

/// Presets of VRM 0.x and their VRM 1.0 names.
const PRESETS: [(&str, &str); 17] = [
    ("neutral", "neutral"),
    ("a", "aa"),
    ("i", "ih"),
    ("u", "ou"),
    ("e", "ee"),
    ("o", "oh"),
    ("blink", "blink"),
    ("joy", "happy"),
    ("angry", "angry"),
    ("sorrow", "sad"),
    ("fun", "relaxed"),
    ("lookup", "lookUp"),
    ("lookdown", "lookDown"),
    ("lookleft", "lookLeft"),
    ("lookright", "lookRight"),
    ("blink_l", "blinkLeft"),
    ("blink_r", "blinkRight"),
];

/// The presets that each override of VRM 1.0 weakens.
const OVERRIDES: [(&str, &[&str]); 3] = [
    ("overrideMouth", &["aa", "ih", "ou", "ee", "oh"]),
    ("overrideBlink", &["blink", "blinkLeft", "blinkRight"]),
    (
        "overrideLookAt",
        &["lookUp", "lookDown", "lookLeft", "lookRight"],
    ),
];

/// Elements counted for one binding or mask, against the limit on decoded elements.
const COST: u64 = 8;

/// Returns the expressions of a document with their names, in the order of their indices: those of
/// the character first, then those that only a motion drives.
fn listed<'a>(root: &Place<'a>) -> Vec<(String, Place<'a>)> {
    let of = |extension: &str| {
        let expressions = root.dig(&["extensions", extension, "expressions"]);
        let part = |key: &str| expressions.as_ref().and_then(|e| e.get(key));
        let parts = [part("preset"), part("custom")].into_iter().flatten();
        let members = parts.flat_map(|p| p.members());
        let objects = members.filter(|(_, e)| e.is_object());
        objects
            .map(|(name, e)| (name.to_owned(), e))
            .collect::<Vec<_>>()
    };
    let mut all = of("VRMC_vrm");
    let old = root.dig(&["extensions", "VRM", "blendShapeMaster"]);
    if let Some(master) = old.filter(|_| all.is_empty()) {
        let groups = master.entries("blendShapeGroups").unwrap_or_default();
        all.extend(groups.into_iter().map(|group| (old_name(&group), group)));
    }
    let known: HashSet<String> = all.iter().map(|(name, _)| name.clone()).collect();
    let moved = of("VRMC_vrm_animation").into_iter();
    all.extend(moved.filter(|(name, _)| !known.contains(name)));
    all
}

fn old_name(group: &Place<'_>) -> String {
    let preset = group.text("presetName").to_ascii_lowercase();
    let known = PRESETS.iter().find(|(old, _)| *old == preset);
    known.map_or(group.text("name"), |(_, new)| new).to_owned()
}

/// Returns, in the order of the expressions, the node whose x translation is the expression's
/// value.
pub(in super::super) fn expression_nodes(json: &Value) -> Vec<Option<usize>> {
    let root = Place::root(json);
    let tracks = root.dig(&["extensions", "VRMC_vrm_animation", "expressions"]);
    let Some(tracks) = tracks else {
        return Vec::new();
    };
    let node = |name: &str| {
        let track = |part: &str| tracks.dig(&[part, name, "node"]);
        let node = track("preset").or_else(|| track("custom"))?;
        usize::try_from(whole(node.value())?).ok()
    };
    listed(&root).iter().map(|(name, _)| node(name)).collect()
}

/// Reads all expressions.
pub(in super::super) fn read(
    reader: &mut Reader<'_>,
    shown: &NodeMeshes,
) -> Result<Vec<Expression>, ReadError> {
    let listed = listed(&reader.root);
    let mut of_name: HashMap<&str, usize> = HashMap::new();
    for (i, (name, _)) in listed.iter().enumerate() {
        of_name.entry(name).or_insert(i);
    }
    let meshes = Meshes::new(reader, shown);
    let mut expressions = Vec::new();
    for (i, (name, place)) in listed.iter().enumerate() {
        reader.charge(place, 4 * COST)?;
        let mut expression = Expression {
            name: name.clone(),
            is_binary: place.is_true("isBinary"),
            masks: masks(reader, place, i, name, &of_name),
            ..Expression::default()
        };
        for (key, full) in [("morphTargetBinds", 1.0), ("binds", 100.0)] {
            for bind in place.entries(key).unwrap_or_default() {
                let found = meshes.bindings(reader, &bind, full)?;
                expression.morphs.extend(found);
            }
        }
        let others = [
            "materialColorBinds",
            "textureTransformBinds",
            "materialValues",
        ];
        expression.unapplied = others.iter().map(|key| place.count(key)).sum();
        expressions.push(expression);
    }
    Ok(expressions)
}

/// Reads the masks of an expression. An override does not affect its own kind.
fn masks(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    own: usize,
    name: &str,
    of_name: &HashMap<&str, usize>,
) -> Vec<Mask> {
    let mut masks = Vec::new();
    for (key, targets) in OVERRIDES {
        let kind = match place.text(key) {
            "" | "none" => continue,
            "block" => MaskKind::Block { above: 0.0 },
            "blend" => MaskKind::Blend,
            other => {
                let other: String = other.chars().take(40).collect();
                let what = format!("unknown override \"{other}\"; read as none");
                reader.notes.add(place.path(key), what);
                continue;
            }
        };
        if targets.contains(&name) {
            continue;
        }
        let targets = targets.iter().filter_map(|target| of_name.get(target));
        masks.extend(targets.filter(|t| **t != own).map(|target| Mask {
            target: *target,
            kind,
            amount: 1.0,
            adds: true,
        }));
    }
    masks
}

/// Mapping from nodes and glTF meshes to the meshes of the character.
struct Meshes<'a> {
    shown: &'a NodeMeshes,
    of_gltf: HashMap<u64, Vec<usize>>,
}

impl<'a> Meshes<'a> {
    fn new(reader: &Reader<'_>, shown: &'a NodeMeshes) -> Self {
        let mut of_gltf: HashMap<u64, Vec<usize>> = HashMap::new();
        for (m, node) in shown.node_of_mesh.iter().enumerate() {
            let node = reader.root.entry("nodes", *node);
            if let Some(mesh) = node.and_then(|n| n.get("mesh")?.whole().ok()) {
                of_gltf.entry(mesh).or_default().push(m);
            }
        }
        Self { shown, of_gltf }
    }

    /// Reads the morph bindings. VRM 1.0 names the node that shows a mesh; VRM 0.x names the mesh,
    /// and so all nodes that show it.
    fn bindings(
        &self,
        reader: &mut Reader<'_>,
        bind: &Place<'_>,
        full: f32,
    ) -> Result<Vec<MorphBinding>, ReadError> {
        let one;
        let meshes = match (bind.get("node"), bind.get("mesh")) {
            (Some(node), _) => {
                let node = node.whole().ok().and_then(|n| usize::try_from(n).ok());
                let mesh = node.and_then(|n| self.shown.node_of_mesh.binary_search(&n).ok());
                one = mesh.map_or(Vec::new(), |m| vec![m]);
                &one
            }
            (None, Some(mesh)) => {
                let found = mesh.whole().ok().and_then(|m| self.of_gltf.get(&m));
                one = Vec::new();
                found.unwrap_or(&one)
            }
            (None, None) => return Ok(Vec::new()),
        };
        let target = bind.get("index").and_then(|i| i.whole().ok());
        let weight = bind.get("weight").map_or(Ok(full), |w| w.float());
        let mut found = Vec::new();
        for &mesh in meshes {
            reader.charge(bind, COST)?;
            let count = self.shown.meshes[mesh].morph_weights.len();
            let target = target.and_then(|t| usize::try_from(t).ok());
            if let (Some(target), Ok(weight)) = (target.filter(|t| *t < count), &weight) {
                let weight = weight / full;
                found.push(MorphBinding {
                    mesh,
                    target,
                    weight,
                });
            }
        }
        if found.is_empty() {
            reader.warn(
                bind,
                "the target is not a morph target of a displayed mesh; left out",
            );
        }
        Ok(found)
    }
}
