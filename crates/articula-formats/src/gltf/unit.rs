//! Another unit of length for a whole document.

use super::append::{entries_mut, index, object, push, set, shorts};
use super::document::Document;
use super::place::Place;
use super::pointer::{self, Pointed};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

impl Document {
    /// Scales everything that the scenes show: the transforms of their root nodes, or of a new node
    /// above a root that is animated. Meshes, keys and inverse bind matrices stay as they are.
    pub fn scale_scenes(&mut self, factor: f32) {
        let animated = self.animated_nodes();
        let mut replaced = BTreeMap::new();
        for root in self.scene_roots() {
            if animated.contains(&root) {
                let above = json!({
                    "name": "unit",
                    "scale": shorts(&[factor; 3]),
                    "children": [root],
                });
                replaced.insert(root, push(&mut self.json, "nodes", above));
            } else if let Some(node) = entries_mut(&mut self.json, "nodes").get_mut(root) {
                scale_node(node, factor);
            }
        }
        for scene in entries_mut(&mut self.json, "scenes") {
            for root in entries_mut(scene, "nodes") {
                let above = root.as_u64().and_then(|i| replaced.get(&(i as usize)));
                above.into_iter().for_each(|&i| *root = i.into());
            }
        }
    }

    fn scene_roots(&self) -> BTreeSet<usize> {
        let scenes = self.json.get("scenes").and_then(Value::as_array);
        let nodes = scenes
            .into_iter()
            .flatten()
            .filter_map(|s| s.get("nodes")?.as_array());
        nodes
            .flatten()
            .filter_map(Value::as_u64)
            .map(|i| i as usize)
            .collect()
    }

    fn animated_nodes(&self) -> BTreeSet<usize> {
        let root = Place::root(&self.json);
        let mut nodes = BTreeSet::new();
        for animation in root.entries("animations").unwrap_or_default() {
            for channel in animation.entries("channels").unwrap_or_default() {
                let Some(target) = channel.get("target") else {
                    continue;
                };
                nodes.extend(index(target.value(), "node"));
                if let Some(Pointed::Node(node, _)) =
                    pointer::text(&target).and_then(pointer::parse)
                {
                    nodes.insert(node);
                }
            }
        }
        nodes
    }
}

fn scale_node(node: &mut Value, factor: f32) {
    let floats = |value: &Value| -> Option<Vec<f32>> {
        let list = value.as_array()?.iter();
        list.map(|x| x.as_f64().map(|x| x as f32)).collect()
    };
    if let Some(mut matrix) = node
        .get("matrix")
        .and_then(floats)
        .filter(|m| m.len() == 16)
    {
        // Column-major; the bottom row stays.
        for (i, x) in matrix.iter_mut().enumerate() {
            *x *= if i % 4 == 3 { 1.0 } else { factor };
        }
        set(node, "matrix", shorts(&matrix));
        return;
    }
    for (key, usual) in [("translation", 0.0), ("scale", 1.0)] {
        let own = node.get(key).and_then(floats).unwrap_or(vec![usual; 3]);
        let scaled: Vec<f32> = own.iter().map(|x| x * factor).collect();
        if scaled.iter().all(|x| *x == usual) {
            object(node).shift_remove(key);
        } else {
            set(node, key, shorts(&scaled));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(json: Value) -> Document {
        Document {
            json,
            buffers: Vec::new(),
            pictures: Vec::new(),
        }
    }

    #[test]
    fn still_roots_are_scaled_and_animated_ones_get_a_node_above() {
        let mut scaled = document(json!({
            "scenes": [{"nodes": [0, 2]}, {"nodes": [2, 3]}],
            "nodes": [
                {"translation": [0.0, 2.0, 0.0], "children": [1]},
                {"translation": [0.0, 1.0, 0.0]},
                {"translation": [1.0, 0.0, 0.0]},
                {"matrix": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3.0, 0.0, 0.0, 1.0]},
            ],
            "animations": [{"channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}]}],
        }));
        scaled.scale_scenes(0.5);
        let nodes = &scaled.json["nodes"];
        assert_eq!(nodes[0]["translation"], json!([0.0, 1.0, 0.0]));
        assert_eq!(nodes[0]["scale"], json!([0.5, 0.5, 0.5]));
        assert_eq!(nodes[1], json!({"translation": [0.0, 1.0, 0.0]}));
        assert_eq!(nodes[2], json!({"translation": [1.0, 0.0, 0.0]}));
        let matrix = [
            0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 1.5, 0.0, 0.0, 1.0,
        ];
        assert_eq!(nodes[3]["matrix"], json!(matrix));
        assert_eq!(
            nodes[4],
            json!({"name": "unit", "scale": [0.5, 0.5, 0.5], "children": [2]})
        );
        assert_eq!(
            scaled.json["scenes"],
            json!([{"nodes": [0, 4]}, {"nodes": [4, 3]}])
        );
        scaled.scale_scenes(2.0);
        assert_eq!(
            scaled.json["nodes"][0]["translation"],
            json!([0.0, 2.0, 0.0])
        );
        assert!(scaled.json["nodes"][0].get("scale").is_none());
    }
}
