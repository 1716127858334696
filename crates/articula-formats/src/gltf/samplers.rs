//! Storage of the keys of animation samplers.
//!
//! Exporters write one accessor and one buffer view for every array of keys, equal or not. The JSON
//! of a character with many clips consists of little else, and parsing it takes most of the time to
//! open the file. So equal arrays become one, and the arrays of an animation share one view.

use super::append::{Use, entries_mut, index, object, set};
use super::document::Document;
use super::prune::{
    each_accessor_reference, each_view_reference, has_unknown_extension, sampler_accessors,
};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

/// An array of keys that only samplers use.
#[derive(Debug)]
struct Keys {
    accessor: usize,
    view: usize,
    /// Its bytes in a buffer.
    buffer: usize,
    bytes: Range<usize>,
}

/// Animations that use an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Users {
    Several,
    One(usize),
}

impl Document {
    /// Stores equal arrays of keys once, and those of each animation in one buffer view; arrays that
    /// several animations use share another. What anything else uses stays as it is, as does all of
    /// a document with unknown extensions, which may refer to accessors and views.
    pub fn pack_samplers(&mut self) {
        if has_unknown_extension(&self.json) {
            return;
        }
        let users = self.sampler_users();
        let keys = self.sampler_keys(&users);
        let same = self.equal_keys(&keys);
        let mut of_array: BTreeMap<usize, Users> = BTreeMap::new();
        for keys in &keys {
            let own = users[&keys.accessor];
            let joined = of_array.entry(same[&keys.accessor]).or_insert(own);
            if *joined != own {
                *joined = Users::Several;
            }
        }
        for animation in entries_mut(&mut self.json, "animations") {
            for sampler in entries_mut(animation, "samplers") {
                for key in ["input", "output"] {
                    let first = index(sampler, key).and_then(|i| same.get(&i));
                    first.into_iter().for_each(|&i| set(sampler, key, i));
                }
            }
        }
        let mut groups: BTreeMap<Users, Vec<&Keys>> = BTreeMap::new();
        for keys in &keys {
            if let Some(users) = of_array.get(&keys.accessor) {
                groups.entry(*users).or_default().push(keys);
            }
        }
        for group in groups.values() {
            self.move_to_one_view(group);
        }
        let unused = keys.iter().map(|k| k.accessor);
        let unused = unused.filter(|i| !of_array.contains_key(i)).collect();
        self.drop_arrays(unused, keys.iter().map(|k| k.view).collect());
    }

    /// Users of each accessor that only samplers refer to.
    fn sampler_users(&mut self) -> BTreeMap<usize, Users> {
        let mut references: BTreeMap<usize, usize> = BTreeMap::new();
        each_accessor_reference(&mut self.json, &mut |i| {
            *references.entry(i).or_default() += 1;
            i
        });
        let mut users = BTreeMap::new();
        for (a, animation) in entries_mut(&mut self.json, "animations").iter().enumerate() {
            for accessor in sampler_accessors(animation) {
                let known = users.entry(accessor).or_insert(Users::One(a));
                if *known != Users::One(a) {
                    *known = Users::Several;
                }
                references.entry(accessor).and_modify(|n| *n -= 1);
            }
        }
        users.retain(|accessor, _| references.get(accessor) == Some(&0));
        users
    }

    /// The given accessors, as far as they are plain arrays in views that nothing else uses.
    fn sampler_keys(&mut self, users: &BTreeMap<usize, Users>) -> Vec<Keys> {
        let mut others: BTreeMap<usize, usize> = BTreeMap::new();
        each_view_reference(&mut self.json, &mut |i| {
            *others.entry(i).or_default() += 1;
            i
        });
        let list = |key| self.json.get(key).and_then(Value::as_array);
        let (Some(accessors), Some(views)) = (list("accessors"), list("bufferViews")) else {
            return Vec::new();
        };
        let plain = |&accessor: &usize| {
            let json = accessors.get(accessor)?;
            let view = index(json, "bufferView")?;
            let place = views.get(view).filter(|v| has_only(v, &VIEW))?;
            let buffer = index(place, "buffer")?;
            let start = index(place, "byteOffset").unwrap_or(0);
            let end = start.checked_add(index(place, "byteLength")?)?;
            let first = start.checked_add(index(json, "byteOffset").unwrap_or(0))?;
            let length = byte_length(json).filter(|_| has_only(json, &ACCESSOR))?;
            let bytes = first..first.checked_add(length)?;
            let is_inside = bytes.end <= end.min(self.buffers.get(buffer)?.len());
            is_inside.then_some(Keys {
                accessor,
                view,
                buffer,
                bytes,
            })
        };
        let keys: Vec<Keys> = users.keys().filter_map(plain).collect();
        for keys in &keys {
            others.entry(keys.view).and_modify(|n| *n -= 1);
        }
        let is_alone = |keys: &Keys| others.get(&keys.view) == Some(&0);
        keys.into_iter().filter(is_alone).collect()
    }

    /// For each accessor, the first one of the same type and bytes.
    fn equal_keys(&self, keys: &[Keys]) -> BTreeMap<usize, usize> {
        let accessors = &self.json["accessors"];
        let mut first = HashMap::new();
        let each = keys.iter().map(|keys| {
            let mut kind = accessors[keys.accessor].clone();
            for place in ["bufferView", "byteOffset"] {
                object(&mut kind).shift_remove(place);
            }
            let bytes = &self.buffers[keys.buffer][keys.bytes.clone()];
            let array = (kind.to_string(), bytes);
            (keys.accessor, *first.entry(array).or_insert(keys.accessor))
        });
        each.collect()
    }

    fn move_to_one_view(&mut self, group: &[&Keys]) {
        let mut bytes = Vec::new();
        let mut starts = Vec::with_capacity(group.len());
        for keys in group {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            starts.push(bytes.len());
            bytes.extend_from_slice(&self.buffers[keys.buffer][keys.bytes.clone()]);
        }
        let view = self.add_view(&bytes, Use::Other);
        for (keys, start) in group.iter().zip(starts) {
            let accessor = &mut entries_mut(&mut self.json, "accessors")[keys.accessor];
            set(accessor, "bufferView", view);
            if start > 0 {
                set(accessor, "byteOffset", start);
            } else {
                object(accessor).shift_remove("byteOffset");
            }
        }
    }
}

/// Members of a buffer view that is a range of bytes and nothing else.
const VIEW: [&str; 3] = ["buffer", "byteOffset", "byteLength"];
/// Members of an accessor that is an array and nothing else.
const ACCESSOR: [&str; 8] = [
    "bufferView",
    "byteOffset",
    "componentType",
    "normalized",
    "count",
    "type",
    "min",
    "max",
];

fn has_only(json: &Value, members: &[&str]) -> bool {
    let own = json.as_object();
    own.is_some_and(|own| own.keys().all(|key| members.contains(&key.as_str())))
}

/// Number of bytes of a packed accessor; `None` for types that no sampler has.
fn byte_length(accessor: &Value) -> Option<usize> {
    let width = match accessor.get("type")?.as_str()? {
        "SCALAR" => 1,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => return None,
    };
    let component = match index(accessor, "componentType")? {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5126 => 4,
        _ => return None,
    };
    index(accessor, "count")?.checked_mul(width * component)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn accessor(view: usize, count: usize) -> Value {
        json!({"bufferView": view, "componentType": 5126, "count": count, "type": "SCALAR"})
    }

    fn view(start: usize, length: usize) -> Value {
        json!({"buffer": 0, "byteOffset": start, "byteLength": length})
    }

    /// Two animations. Accessors: the times of both, values of the first, values of the second that
    /// equal these, positions of a mesh, two arrays of the second, one with a name, one that a mesh
    /// uses too.
    fn document() -> Document {
        let mut named = accessor(6, 1);
        named["name"] = json!("kept");
        let floats =
            |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|x| x.to_le_bytes()).collect() };
        Document {
            json: json!({
                "accessors": [accessor(0, 2), accessor(1, 2), accessor(2, 2), accessor(3, 2),
                    accessor(4, 1), accessor(5, 1), named, accessor(8, 1)],
                "bufferViews": [view(0, 8), view(8, 8), view(16, 8), view(24, 8), view(32, 4),
                    view(36, 4), view(40, 4), view(44, 4), view(48, 4)],
                "buffers": [{"byteLength": 52}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 3, "NORMAL": 7}}]}],
                "images": [{"bufferView": 7}],
                "animations": [
                    {"samplers": [{"input": 0, "output": 1}, {"input": 0, "output": 7}]},
                    {"samplers": [{"input": 0, "output": 2}, {"input": 4, "output": 5},
                        {"input": 4, "output": 6}]},
                ],
            }),
            buffers: vec![floats(&[
                0.0, 1.0, 5.0, 6.0, 5.0, 6.0, 7.0, 8.0, 0.5, 9.0, 10.0, 11.0, 12.0,
            ])],
            pictures: vec![None],
        }
    }

    fn bytes(document: &Document, accessor: &Value) -> Vec<u8> {
        let view = &document.json["bufferViews"][index(accessor, "bufferView").unwrap()];
        let start = index(view, "byteOffset").unwrap_or(0);
        let own = index(accessor, "byteOffset").unwrap_or(0);
        let length = 4 * index(accessor, "count").unwrap();
        assert!(own + length <= index(view, "byteLength").unwrap());
        document.buffers[0][start + own..start + own + length].to_vec()
    }

    /// The bytes of everything that refers to an accessor.
    fn referred(document: &Document) -> Vec<Vec<u8>> {
        let mut found = Vec::new();
        each_accessor_reference(&mut document.json.clone(), &mut |i| {
            found.push(bytes(document, &document.json["accessors"][i]));
            i
        });
        found
    }

    #[test]
    fn equal_arrays_become_one_and_those_of_an_animation_share_a_view() {
        let before = document();
        let mut after = document();
        after.pack_samplers();
        assert_eq!(referred(&after), referred(&before));
        // The values of the second animation are those of the first now.
        assert_eq!(after.count("accessors"), 7);
        let views = after.json["bufferViews"].as_array().unwrap();
        let lengths: Vec<_> = views.iter().map(|v| index(v, "byteLength")).collect();
        // Mesh, name, picture and the shared array stay; what both animations use and what the
        // second uses follow.
        assert_eq!(lengths, [8, 4, 4, 4, 16, 8].map(Some));
        assert_eq!(after.json["images"][0]["bufferView"], 2);
        assert_eq!(after.buffers[0].len(), 52 - 8);
        let once = after.clone();
        after.pack_samplers();
        assert_eq!(after, once);
    }

    #[test]
    fn arrays_that_reach_beyond_their_view_stay() {
        let mut short = document();
        short.json["bufferViews"][1]["byteLength"] = json!(4);
        short.pack_samplers();
        let output = index(&short.json["animations"][0]["samplers"][0], "output").unwrap();
        let view = index(&short.json["accessors"][output], "bufferView").unwrap();
        assert_eq!(short.json["bufferViews"][view]["byteLength"], 4);
    }

    #[test]
    fn a_document_with_an_unknown_extension_stays_as_it_is() {
        let mut unknown = document();
        unknown.json["meshes"][0]["extensions"] = json!({"EXT_new": {"bufferView": 1}});
        let mut after = unknown.clone();
        after.pack_samplers();
        assert_eq!(after, unknown);
    }
}
