//! Leaving morph targets out of a document.

use super::append::{entries_mut, index, object, set};
use super::document::Document;
use serde_json::Value;
use std::collections::BTreeSet;

impl Document {
    /// Keeps the morph targets whose names `keeps` takes; those without a name have the empty one. Rest
    /// weights, names and the bindings of VRM expressions follow, and arrays that nothing uses any more are
    /// dropped. Animations of weights stay as they are: [`Self::replace_clips`] writes them anew.
    pub fn keep_morph_targets(&mut self, keeps: impl Fn(&str) -> bool) {
        let meshes = entries_mut(&mut self.json, "meshes").iter();
        let kept: Vec<Vec<bool>> = meshes.map(|mesh| kept_of(mesh, &keeps)).collect();
        if kept.iter().flatten().all(|kept| *kept) {
            return;
        }
        let mut dropped = BTreeSet::new();
        for (mesh, kept) in entries_mut(&mut self.json, "meshes").iter_mut().zip(&kept) {
            retain(mesh, "weights", kept);
            retain_names(mesh, kept);
            for primitive in entries_mut(mesh, "primitives") {
                let targets = entries_mut(primitive, "targets").iter().zip(kept);
                let gone = targets
                    .filter(|(_, kept)| !**kept)
                    .map(|(target, _)| target);
                let arrays = gone.filter_map(Value::as_object).flat_map(|t| t.values());
                let arrays = arrays.filter_map(Value::as_u64);
                dropped.extend(arrays.filter_map(|array| usize::try_from(array).ok()));
                retain(primitive, "targets", kept);
                retain_names(primitive, kept);
            }
        }
        let mut mesh_of_node = Vec::new();
        for node in entries_mut(&mut self.json, "nodes") {
            let mesh = index(node, "mesh");
            if let Some(kept) = mesh.and_then(|mesh| kept.get(mesh)) {
                retain(node, "weights", kept);
            }
            mesh_of_node.push(mesh);
        }
        let new_index = |mesh: usize, target: usize| {
            let kept = kept.get(mesh)?;
            let before = kept.get(..target)?.iter().filter(|kept| **kept).count();
            kept.get(target)?.then_some(before)
        };
        self.renumber_bindings(&mesh_of_node, &new_index);
        self.drop_unnamed(dropped);
        self.remove_prepared();
    }

    /// Gives the bindings of VRM expressions the new indices of their targets, and removes those of targets
    /// that have none.
    fn renumber_bindings(
        &mut self,
        mesh_of_node: &[Option<usize>],
        new_index: &dyn Fn(usize, usize) -> Option<usize>,
    ) {
        let Some(extensions) = self.json.get_mut("extensions") else {
            return;
        };
        let renumber = |owner: &mut Value, key: &str| {
            let Some(Value::Array(bindings)) = owner.get_mut(key) else {
                return;
            };
            bindings.retain_mut(|binding| {
                let node = index(binding, "node").and_then(|node| *mesh_of_node.get(node)?);
                let mesh = node.or_else(|| index(binding, "mesh"));
                let new = mesh.zip(index(binding, "index"));
                let new = new.and_then(|(mesh, target)| new_index(mesh, target));
                if let Some(new) = new {
                    set(binding, "index", new);
                }
                new.is_some()
            });
        };
        if let Some(expressions) = extensions.pointer_mut("/VRMC_vrm/expressions") {
            for part in ["preset", "custom"] {
                let members = expressions.get_mut(part).and_then(Value::as_object_mut);
                for (_, expression) in members.into_iter().flatten() {
                    renumber(expression, "morphTargetBinds");
                }
            }
        }
        if let Some(master) = extensions.pointer_mut("/VRM/blendShapeMaster") {
            for group in entries_mut(master, "blendShapeGroups") {
                renumber(group, "binds");
            }
        }
    }
}

/// Which targets of a mesh stay. By convention, names are in its extras, in VRM 0.x in those of its
/// primitives.
fn kept_of(mesh: &Value, keeps: &dyn Fn(&str) -> bool) -> Vec<bool> {
    let primitives = mesh.get("primitives").and_then(Value::as_array);
    let primitives: Vec<&Value> = primitives.into_iter().flatten().collect();
    let targets = |p: &&Value| {
        p.get("targets")
            .and_then(Value::as_array)
            .map_or(0, Vec::len)
    };
    let count = primitives.iter().map(targets).max().unwrap_or(0);
    let owners = [Some(mesh), primitives.first().copied()];
    let mut names = owners.into_iter().flatten();
    let names = names.find_map(|owner| owner.pointer("/extras/targetNames")?.as_array());
    let name = |i: usize| names.and_then(|names| names.get(i)?.as_str());
    (0..count)
        .map(|i| keeps(name(i).unwrap_or_default()))
        .collect()
}

/// Keeps entries of an array member, and the member if one is left.
fn retain(owner: &mut Value, key: &str, kept: &[bool]) {
    let Some(Value::Array(entries)) = owner.get_mut(key) else {
        return;
    };
    let mut kept = kept.iter();
    entries.retain(|_| *kept.next().unwrap_or(&true));
    if entries.is_empty() {
        object(owner).shift_remove(key);
    }
}

fn retain_names(owner: &mut Value, kept: &[bool]) {
    let Some(extras) = owner.get_mut("extras").filter(|e| e.is_object()) else {
        return;
    };
    retain(extras, "targetNames", kept);
    if object(extras).is_empty() {
        object(owner).shift_remove("extras");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A mesh with the targets a, b and c, each of one array, shown by node 1.
    fn document() -> Document {
        let accessor = |view: usize| json!({"bufferView": view, "componentType": 5126, "count": 1, "type": "VEC3"});
        let view = |i: usize| json!({"buffer": 0, "byteOffset": 12 * i, "byteLength": 12});
        let bind =
            |key: &str, of: usize, target: usize| json!({key: of, "index": target, "weight": 1});
        Document {
            json: json!({
                "nodes": [{}, {"mesh": 0, "weights": [0.1, 0.2, 0.3]}],
                "meshes": [{
                    "weights": [0.0, 0.5, 1.0],
                    "extras": {"targetNames": ["a", "b", "c"], "own": 1},
                    "primitives": [{"attributes": {"POSITION": 0},
                        "targets": [{"POSITION": 1}, {"POSITION": 2}, {"POSITION": 3}]}],
                }],
                "accessors": [accessor(0), accessor(1), accessor(2), accessor(3)],
                "bufferViews": [view(0), view(1), view(2), view(3)],
                "buffers": [{"byteLength": 48}],
                "extensions": {
                    "VRMC_vrm": {"expressions": {"preset": {"aa": {"morphTargetBinds": [
                        bind("node", 1, 0), bind("node", 1, 2)]}}}},
                    "VRM": {"blendShapeMaster": {"blendShapeGroups": [{"binds": [
                        bind("mesh", 0, 1), bind("mesh", 0, 2)]}]}},
                },
            }),
            buffers: vec![(0..48).collect()],
            pictures: Vec::new(),
        }
    }

    #[test]
    fn what_names_a_target_follows_those_that_stay() {
        let mut made = document();
        made.keep_morph_targets(|name| name == "c");
        let json = &made.json;
        let mesh = &json["meshes"][0];
        assert_eq!(mesh["weights"], json!([1.0]));
        assert_eq!(mesh["extras"], json!({"targetNames": ["c"], "own": 1}));
        assert_eq!(mesh["primitives"][0]["targets"], json!([{"POSITION": 1}]));
        assert_eq!(json["nodes"][1]["weights"], json!([0.3]));
        let binds = &json["extensions"]["VRMC_vrm"]["expressions"]["preset"]["aa"];
        let left = json!([{"node": 1, "index": 0, "weight": 1}]);
        assert_eq!(binds["morphTargetBinds"], left);
        let groups = &json["extensions"]["VRM"]["blendShapeMaster"]["blendShapeGroups"];
        assert_eq!(
            groups[0]["binds"],
            json!([{"mesh": 0, "index": 0, "weight": 1}])
        );
        // Of four arrays that of the mesh and that of the target are left.
        let bytes: Vec<u8> = (0..12).chain(36..48).collect();
        assert_eq!(made.buffers, [bytes]);
        assert_eq!(json["accessors"].as_array().map(Vec::len), Some(2));
    }

    #[test]
    fn without_targets_nothing_of_them_is_left_and_with_all_nothing_changes() {
        let mut none = document();
        none.keep_morph_targets(|_| false);
        let mesh = &none.json["meshes"][0];
        assert_eq!(mesh["extras"], json!({"own": 1}));
        assert!(mesh.get("weights").is_none() && mesh["primitives"][0].get("targets").is_none());
        assert!(none.json["nodes"][1].get("weights").is_none());
        let mut all = document();
        all.keep_morph_targets(|name| !name.is_empty());
        assert_eq!(all, document());
    }
}
