//! Matrices of animated nodes, written as translation, rotation and scale.
//!
//! Source: glTF 2.0, 5.25.7: a node that an animation moves must not have a matrix.

use super::append::{entries_mut, object};
use super::fresh::write_transform;
use super::node::transform_of;
use super::place::Place;
use super::skeleton::animated_nodes;
use glam::Mat4;
use serde_json::Value;

/// Replaces the matrix of every node whose translation, rotation or scale a channel moves. One that
/// is sheared becomes the transform that it is read as, of which the reader warns.
pub(super) fn split_animated(json: &mut Value) {
    let nodes = json.get("nodes").and_then(Value::as_array);
    let has_matrix = |node: &Value| node.get("matrix").is_some();
    let Some(nodes) = nodes.filter(|nodes| nodes.iter().any(has_matrix)) else {
        return;
    };
    let moves = animated_nodes(&Place::root(json), nodes.len()).unwrap_or_default();
    for (node, _) in entries_mut(json, "nodes")
        .iter_mut()
        .zip(moves)
        .filter(|(_, moves)| *moves)
    {
        let Ok(Some(columns)) = Place::root(node).floats::<16>("matrix") else {
            continue;
        };
        let (transform, _) = transform_of(Mat4::from_cols_array(&columns));
        object(node).shift_remove("matrix");
        write_transform(node, transform);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_moving_node_has_no_matrix_and_a_still_one_keeps_it() {
        // A quarter turn about Z, twice as large, at (1, 2, 3).
        let matrix = json!([0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]);
        let target = |node: usize, path: &str| json!({"target": {"node": node, "path": path}});
        let pointed = json!({"target": {"path": "pointer", "extensions": {
            "KHR_animation_pointer": {"pointer": "/nodes/3/scale"}}}});
        let node = json!({"matrix": matrix});
        let mut document = json!({
            "nodes": [node, node, node, node],
            "animations": [{"channels": [target(0, "rotation"), target(1, "weights"), pointed]}],
        });
        split_animated(&mut document);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        for moved in [0, 3] {
            let node = &document["nodes"][moved];
            assert_eq!(node.get("matrix"), None);
            assert_eq!(node["translation"], json!([1.0, 2.0, 3.0]));
            assert_eq!(node["scale"], json!([2.0, 2.0, 2.0]));
            for (found, right) in (0..4).zip([0.0, 0.0, half, half]) {
                let found = node["rotation"][found].as_f64().unwrap() as f32;
                assert!((found - right).abs() < 1e-6, "{found} for {right}");
            }
        }
        for still in [1, 2] {
            assert_eq!(document["nodes"][still]["matrix"], matrix);
        }
    }
}
