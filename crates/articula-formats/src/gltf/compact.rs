//! A smaller document that shows the same: equal arrays are stored once, numbers have no more digits
//! than 32-bit floats need.

use super::append::{index, short};
use super::document::Document;
use super::prune::{each_accessor_reference, has_unknown_extension};
use foldhash::{HashMap, HashMapExt};
use serde_json::{Number, Value};
use std::collections::BTreeSet;

impl Document {
    /// Stores equal arrays once, and writes numbers with the fewest digits that read back as the same
    /// 32-bit float. What readers with such floats make of the document stays the same to the bit.
    pub fn compact(&mut self) {
        self.share_arrays();
        shorten(&mut self.json);
    }

    /// Lets all references to equal accessors name the first of them.
    fn share_arrays(&mut self) {
        if has_unknown_extension(&self.json) {
            return;
        }
        let accessors = self.json.get("accessors").and_then(Value::as_array);
        let mut first = HashMap::with_capacity(accessors.map_or(0, Vec::len));
        let mut of_same = Vec::new();
        let mut copies = BTreeSet::new();
        for (i, accessor) in accessors.into_iter().flatten().enumerate() {
            let same = match self.contents(accessor) {
                Some(contents) => *first.entry(contents).or_insert(i),
                None => i,
            };
            if same != i {
                copies.insert(i);
            }
            of_same.push(same);
        }
        each_accessor_reference(&mut self.json, &mut |i| {
            of_same.get(i).copied().unwrap_or(i)
        });
        self.drop_unnamed(copies);
    }

    /// What an accessor holds: its members, those of its buffer view but the place, and the bytes.
    /// `None` if these are not all.
    fn contents(&self, accessor: &Value) -> Option<(String, String, &[u8])> {
        let views = self.json.get("bufferViews")?;
        let view = views.get(index(accessor, "bufferView")?)?;
        if accessor.get("sparse").is_some() || view.get("extensions").is_some() {
            return None;
        }
        let start = index(view, "byteOffset").unwrap_or(0);
        let end = start.checked_add(index(view, "byteLength")?)?;
        let bytes = self.buffers.get(index(view, "buffer")?)?.get(start..end)?;
        Some((
            without(accessor, "bufferView"),
            without(view, "byteOffset"),
            bytes,
        ))
    }
}

/// The members of an object but one, as text.
fn without(value: &Value, member: &str) -> String {
    let mut value = value.clone();
    if let Some(members) = value.as_object_mut() {
        members.shift_remove(member);
    }
    value.to_string()
}

/// Shortens all numbers with a fraction.
fn shorten(value: &mut Value) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(shorten),
        Value::Object(members) => members.values_mut().for_each(shorten),
        Value::Number(number) => {
            let float = Some(&*number)
                .filter(|n| n.is_f64())
                .and_then(Number::as_f64);
            if let Some(float) = float.map(|x| x as f32).filter(|x| x.is_finite()) {
                *value = short(float);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use articula_core::Transform;
    use articula_core::source::{Character, Joint, Primitive, RawMesh, Skeleton, Skin};
    use glam::{Affine3A, Vec3};
    use serde_json::json;

    #[test]
    fn equal_arrays_are_stored_once_and_read_back_equal() {
        let triangle = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y * 0.1],
            normals: vec![Vec3::Z; 3],
            influences: 1,
            joints: vec![0; 3],
            weights: vec![1.0; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let other = Primitive {
            positions: vec![Vec3::Z; 3],
            ..triangle.clone()
        };
        let mesh = |name: &str, primitives| RawMesh {
            name: name.into(),
            skin: Skin {
                joints: vec![0],
                inverse_bind: vec![Affine3A::IDENTITY],
            },
            primitives,
            ..RawMesh::default()
        };
        let joint = Joint {
            name: "root".into(),
            parent: None,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![joint],
            },
            meshes: vec![
                mesh("a", vec![triangle.clone(), other]),
                mesh("b", vec![triangle]),
            ],
            ..Character::default()
        };
        let mut document = Document::from_character(&character).unwrap();
        let read = |document: &Document| {
            let bytes = document.write_glb().unwrap();
            let mut none = |_: &str| Err("none".to_owned());
            let file = crate::gltf::read(&bytes, &Limits::default(), &mut none).unwrap();
            (file.value.character.meshes, bytes.len())
        };
        let (before, bytes_before) = read(&document);
        document.compact();
        let (after, bytes_after) = read(&document);
        assert_eq!(after, before);
        assert!(bytes_after < bytes_before);
        // Two lists of positions; one of normals, joints, weights, indices and inverse bind matrices.
        assert_eq!(document.count("accessors"), 7);
        assert_eq!(document.count("bufferViews"), 7);
    }

    #[test]
    fn numbers_read_back_as_the_same_floats() {
        let wide = [
            0.149_256_944_656_372_07,
            1.270_666_740_9e-7,
            -0.1,
            1e300,
            3.0,
        ];
        let mut value = json!({ "a": wide, "count": 7, "b": [{ "c": 0.100_000_001_490_116_12 }] });
        let before = value.clone();
        shorten(&mut value);
        assert_eq!(value["a"][0].to_string(), "0.14925694");
        assert_eq!(value["b"][0]["c"].to_string(), "0.1");
        assert_eq!(
            (&value["count"], &value["a"][3]),
            (&before["count"], &before["a"][3])
        );
        for (a, b) in before["a"]
            .as_array()
            .unwrap()
            .iter()
            .zip(value["a"].as_array().unwrap())
        {
            assert_eq!(a.as_f64().unwrap() as f32, b.as_f64().unwrap() as f32);
        }
    }
}
