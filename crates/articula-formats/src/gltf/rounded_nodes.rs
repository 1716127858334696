//! Transforms of nodes in few digits.

use super::append::{entries_mut, object, set, shortest};
use super::document::Document;
use super::place::Place;
use serde_json::Value;

/// Changes of the transform of a node that are not missed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeTolerance {
    /// Length in the space of the parent.
    pub translation: f32,
    /// Turn in radians.
    pub rotation: f32,
    /// Factor, less 1.
    pub scale: f32,
}

/// Decimals of the components of a quaternion, at least: its length is then within 1e-4 of 1.
const DECIMALS_OF_ROTATION: i32 = 4;
/// Decimals of a 32-bit float below 1.
const MOST_DECIMALS: i32 = 9;

impl Document {
    /// Writes the transforms of nodes with the fewest decimals that keep them within a tolerance, and leaves out those
    /// that are the identity. `None`, and nodes with a matrix, stay as they are.
    pub fn round_nodes(&mut self, tolerances: &[Option<NodeTolerance>]) {
        let nodes = entries_mut(&mut self.json, "nodes").iter_mut();
        for (node, tolerance) in nodes.zip(tolerances) {
            if let Some(tolerance) = tolerance {
                round(node, tolerance);
            }
        }
    }
}

fn round(node: &mut Value, tolerance: &NodeTolerance) {
    // Each of N components errs by half of the last decimal; a turn by twice what the quaternion does.
    let half_of_three = 0.5 * 3.0f32.sqrt();
    let translation = decimals(tolerance.translation / half_of_three, 0);
    let rotation = decimals(0.5 * tolerance.rotation, DECIMALS_OF_ROTATION);
    let scale = decimals(tolerance.scale / half_of_three, 0);
    member(node, "translation", translation, [0.0; 3]);
    member(node, "rotation", rotation, [0.0, 0.0, 0.0, 1.0]);
    member(node, "scale", scale, [1.0; 3]);
}

/// The fewest decimals of which the last is at most a step.
fn decimals(step: f32, least: i32) -> i32 {
    let needed = -step.max(f32::MIN_POSITIVE).log10();
    (needed.ceil() as i32).clamp(least, MOST_DECIMALS)
}

/// Rounds a member, unless zeros are made of what is none.
fn member<const N: usize>(node: &mut Value, name: &str, decimals: i32, identity: [f32; N]) {
    let Ok(Some(numbers)) = Place::root(node).floats::<N>(name) else {
        return;
    };
    let power = 10f64.powi(decimals);
    let rounded = numbers.map(|x| ((f64::from(x) * power).round() / power) as f32 + 0.0);
    if rounded == identity {
        object(node).shift_remove(name);
        return;
    }
    let is_lost = |(x, y): (&f32, &f32)| *x != 0.0 && *y == 0.0;
    let is_singular = name == "scale" && numbers.iter().zip(&rounded).any(is_lost);
    let kept = if is_singular { numbers } else { rounded };
    set(node, name, shortest(&kept));
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    fn tolerance(metres: f32) -> NodeTolerance {
        NodeTolerance {
            translation: metres,
            rotation: metres,
            scale: metres,
        }
    }

    fn rounded(node: Value, metres: f32) -> Value {
        let mut document = Document {
            json: json!({ "nodes": [node] }),
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        document.round_nodes(&[Some(tolerance(metres))]);
        document.json["nodes"][0].take()
    }

    #[test]
    fn digits_go_and_the_identity_with_them() {
        let node = json!({"name": "hand", "translation": [1.234_567, -0.000_04, 3.0],
            "rotation": [0.0, 0.000_01, 0.0, 1.0], "scale": [0.000_1, 1.0, 1.000_02]});
        let wanted =
            json!({"name": "hand", "translation": [1.235, 0, 3], "scale": [0.0001, 1, 1.00002]});
        assert_eq!(rounded(node, 1e-3).to_string(), wanted.to_string());
        let matrix = json!({ "matrix": vec![1.234_567; 16] });
        assert_eq!(rounded(matrix.clone(), 1e-3), matrix);
    }

    proptest! {
        #[test]
        fn transforms_stay_within_their_tolerance(
            numbers in prop::array::uniform3(-2.0f32..2.0),
            tolerance in 1e-5f32..0.1,
        ) {
            let [x, y, z] = numbers;
            let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, x, y, z);
            let node = rounded(json!({"translation": numbers, "rotation": turn.to_array()}), tolerance);
            let place = Place::root(&node);
            let moved = place.floats::<3>("translation").unwrap().unwrap_or_default();
            let squared: f32 = numbers.iter().zip(moved).map(|(a, b)| (a - b) * (a - b)).sum();
            prop_assert!(squared.sqrt() <= tolerance + 1e-6);
            let turned = place.floats::<4>("rotation").unwrap().unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let turned = glam::Quat::from_array(turned);
            prop_assert!((turned.length() - 1.0).abs() <= 1.1e-4);
            prop_assert!(turned.normalize().angle_between(turn) <= tolerance.max(2e-3));
        }
    }
}
