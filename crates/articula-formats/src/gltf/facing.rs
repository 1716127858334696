//! Facing of VRM 0.x characters: -Z in the file, +Z as read, like all others.
//!
//! Source: VRM 0.x, "VRM rules". The half turn about the vertical axis is applied to rest and keys
//! of the root joints, whose components it only swaps and negates, so turning back restores every
//! number. The facing is detected from the legs at rest, so that a file that was already turned is
//! left alone.

use super::append::index;
use super::place::Place;
use articula_core::Transform;
use articula_core::source::{Channel, Character, Property};
use glam::{Affine3A, Mat4, Quat, Vec3};
use serde_json::Value;

/// Returns whether the character of a document is turned when it is read, and back when clips are
/// written.
pub(super) fn faces_back(json: &Value) -> bool {
    let root = Place::root(json);
    let Some(old) = root.dig(&["extensions", "VRM"]) else {
        return false;
    };
    if root.dig(&["extensions", "VRMC_vrm"]).is_some() {
        return false;
    }
    let bones = old
        .get("humanoid")
        .map_or(Vec::new(), |h| h.entries("humanBones").unwrap_or_default());
    let node = |name: &str| {
        let bone = bones.iter().find(|bone| bone.text("bone") == name)?;
        index(bone.value(), "node")
    };
    let parents = parents(json);
    let x = |name: &str| Some(rest_in_model(json, &parents, node(name)?)?.translation.x);
    let across = |left, right| Some(x(left)? - x(right)?);
    let across =
        across("leftUpperLeg", "rightUpperLeg").or_else(|| across("leftUpperArm", "rightUpperArm"));
    // A character that faces +Z has its left at +X. Without limbs the format's rule applies.
    across.is_none_or(|dx| dx < 0.0)
}

/// Returns the parent of each node.
pub(super) fn parents(json: &Value) -> Vec<Option<usize>> {
    let nodes = json.get("nodes").and_then(Value::as_array);
    let nodes = nodes.map_or(&[][..], Vec::as_slice);
    let mut parents = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        let children = node.get("children").and_then(Value::as_array);
        for child in children.into_iter().flatten() {
            let child = super::place::whole(child).and_then(|c| usize::try_from(c).ok());
            if let Some(slot) = child.and_then(|c| parents.get_mut(c)) {
                *slot = Some(parent);
            }
        }
    }
    parents
}

/// Returns the model-from-node matrix at rest; `None` if the node does not exist or is its own
/// ancestor.
fn rest_in_model(json: &Value, parents: &[Option<usize>], node: usize) -> Option<Affine3A> {
    let nodes = json.get("nodes")?.as_array()?;
    let mut model = Affine3A::IDENTITY;
    let mut at = Some(node);
    for _ in 0..=nodes.len() {
        let Some(n) = at else {
            return Some(model);
        };
        model = rest(nodes.get(n)?) * model;
        at = *parents.get(n)?;
    }
    None
}

/// Returns the parent-from-node matrix at rest.
pub(super) fn rest(node: &Value) -> Affine3A {
    let place = Place::root(node);
    if let Ok(Some(columns)) = place.floats::<16>("matrix") {
        return Affine3A::from_mat4(Mat4::from_cols_array(&columns));
    }
    let floats3 = |key: &str, absent| {
        place
            .floats::<3>(key)
            .ok()
            .flatten()
            .map_or(absent, Vec3::from_array)
    };
    let rotation = place.floats::<4>("rotation").ok().flatten();
    Transform {
        translation: floats3("translation", Vec3::ZERO),
        rotation: rotation.map_or(Quat::IDENTITY, Quat::from_array),
        scale: floats3("scale", Vec3::ONE),
    }
    .to_affine()
}

/// Turns a character by half a circle about the vertical axis.
pub(super) fn turn(character: &mut Character) {
    let joints = &mut character.skeleton.joints;
    let is_root: Vec<bool> = joints.iter().map(|j| j.parent.is_none()).collect();
    for joint in joints.iter_mut().filter(|j| j.parent.is_none()) {
        turn_transform(&mut joint.rest);
    }
    for expression in &mut character.expressions {
        for binding in expression.joints.iter_mut().filter(|b| is_root[b.joint]) {
            turn_transform(&mut binding.full);
        }
    }
    for channel in character.clips.iter_mut().flat_map(|c| &mut c.channels) {
        if channel.property.is_of_joint() && is_root[channel.target] {
            turn_keys(channel);
        }
    }
}

/// Returns the keys of a root node's channel as they are stored in the file.
pub(super) fn turned_back(channel: &Channel) -> Channel {
    let mut channel = channel.clone();
    // Another half turn restores positions, and rotations up to a factor of -1.
    turn_keys(&mut channel);
    if channel.property == Property::Rotation {
        channel.values.iter_mut().for_each(|x| *x = 0.0 - *x);
    }
    channel
}

fn turn_transform(transform: &mut Transform) {
    transform.translation = Vec3::from_array(turned_place(transform.translation.to_array()));
    transform.rotation = Quat::from_array(turned_rotation(transform.rotation.to_array()));
}

/// Tangents of splines turn like values.
fn turn_keys(channel: &mut Channel) {
    match channel.property {
        Property::Translation => {
            for key in channel.values.as_chunks_mut::<3>().0 {
                *key = turned_place(*key);
            }
        }
        Property::Rotation => {
            for key in channel.values.as_chunks_mut::<4>().0 {
                *key = turned_rotation(*key);
            }
        }
        Property::Scale | Property::Weights | Property::Expression => {}
    }
}

/// Subtracts from 0, so that no zero becomes negative.
fn turned_place([x, y, z]: [f32; 3]) -> [f32; 3] {
    [0.0 - x, y, 0.0 - z]
}

/// Returns the quaternion product of a half turn about y, `(0, 1, 0, 0)`, and another.
fn turned_rotation([x, y, z, w]: [f32; 4]) -> [f32; 4] {
    [z, w, 0.0 - x, 0.0 - y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::Interpolation;
    use serde_json::json;

    #[test]
    fn the_turn_is_the_product_with_a_half_turn() {
        let q = Quat::from_xyzw(0.1, -0.3, 0.5, 0.8).normalize();
        let half = Quat::from_xyzw(0.0, 1.0, 0.0, 0.0);
        let turned = Quat::from_array(turned_rotation(q.to_array()));
        assert!((turned - half * q).length() < 1e-7);
        let p = Vec3::new(1.0, 2.0, 3.0);
        assert!((Vec3::from_array(turned_place(p.to_array())) - half * p).length() < 1e-6);
    }

    #[test]
    fn turned_back_gives_every_number() {
        for (property, values) in [
            (
                Property::Translation,
                vec![0.1f32, -0.0, 7e-9, 0.0, 1.0, 2.0],
            ),
            (
                Property::Rotation,
                vec![0.1f32, 0.7, -0.3, 0.0, 0.0, 0.0, 0.0, 1.0],
            ),
            (Property::Scale, vec![1.0f32, 2.0, 3.0, 1.0, 1.0, 1.0]),
        ] {
            let channel = Channel {
                target: 0,
                property,
                interpolation: Interpolation::Linear,
                times_secs: vec![0.0, 1.0],
                values,
            };
            let mut turned = channel.clone();
            turn_keys(&mut turned);
            assert_eq!(turned_back(&turned), channel);
        }
    }

    #[test]
    fn legs_tell_which_way() {
        let file = |extension: &str, left: f32| {
            json!({
                "nodes": [{"children": [1, 2], "translation": [5, 0, 0]},
                    {"translation": [left, 1, 0]}, {"translation": [-left, 1, 0]}],
                "extensions": {extension: {"humanoid": {"humanBones": [
                    {"bone": "leftUpperLeg", "node": 1}, {"bone": "rightUpperLeg", "node": 2}]}}},
            })
        };
        assert!(faces_back(&file("VRM", -0.1)));
        assert!(!faces_back(&file("VRM", 0.1)), "somebody turned it already");
        assert!(!faces_back(&file("VRMC_vrm", -0.1)), "VRM 1.0 faces +Z");
        let mut turned = file("VRM", -0.1);
        turned["nodes"][0]["rotation"] = json!([0, 1, 0, 0]);
        assert!(!faces_back(&turned));
        assert!(faces_back(&json!({"extensions": {"VRM": {}}})));
        let round = json!({"nodes": [{"children": [1]}, {"children": [0]}], "extensions": {"VRM":
            {"humanoid": {"humanBones": [{"bone": "leftUpperLeg", "node": 0}]}}}});
        assert!(faces_back(&round));
    }
}
