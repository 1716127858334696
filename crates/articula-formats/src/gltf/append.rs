//! Appends bytes, buffer views and accessors to a document.

use super::document::Document;
use super::place::whole;
use serde_json::{Map, Value, json};

/// Usage of a buffer view, written as its `target`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Vertices,
    Indices,
    Other,
}

impl Document {
    /// Stores bytes in the first buffer and returns the index of a new buffer view of them.
    ///
    /// Extensions refer to binary tables by this index. The bytes start at a multiple of 4.
    pub(super) fn add_buffer_view(&mut self, bytes: &[u8]) -> usize {
        self.add_view(bytes, Use::Other)
    }

    pub(super) fn add_view(&mut self, bytes: &[u8], used_for: Use) -> usize {
        if self.buffers.is_empty() {
            self.buffers.push(Vec::new());
        }
        let buffer = &mut self.buffers[0];
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": 0,
            "byteOffset": buffer.len(),
            "byteLength": bytes.len(),
        });
        match used_for {
            Use::Vertices => set(&mut view, "target", 34962),
            Use::Indices => set(&mut view, "target", 34963),
            Use::Other => {}
        }
        buffer.extend_from_slice(bytes);
        let length = buffer.len();
        self.note_length(length);
        push(&mut self.json, "bufferViews", view)
    }

    pub(super) fn add_accessor(&mut self, accessor: Value) -> usize {
        push(&mut self.json, "accessors", accessor)
    }

    /// Writes the length of the first buffer into the JSON.
    fn note_length(&mut self, length: usize) {
        let buffers = object(&mut self.json)
            .entry("buffers")
            .or_insert_with(|| json!([]));
        match buffers.as_array_mut() {
            Some(list) if !list.is_empty() => set(&mut list[0], "byteLength", length),
            _ => *buffers = json!([{ "byteLength": length }]),
        }
    }

    /// Adds a name to `extensionsUsed` unless it is present.
    pub(super) fn use_extension(&mut self, name: &str) {
        let used = self.json.get("extensionsUsed").and_then(Value::as_array);
        if !used.is_some_and(|used| used.iter().any(|u| u == name)) {
            push(&mut self.json, "extensionsUsed", json!(name));
        }
    }

    /// Adds a name to `extensionsRequired` unless it is present.
    pub(super) fn require_extension(&mut self, name: &str) {
        let required = self
            .json
            .get("extensionsRequired")
            .and_then(Value::as_array);
        if !required.is_some_and(|required| required.iter().any(|r| r == name)) {
            push(&mut self.json, "extensionsRequired", json!(name));
        }
    }

    /// Sets an extension of the document itself.
    pub(super) fn extend(&mut self, name: &str, value: Value) {
        let extensions = object(&mut self.json)
            .entry("extensions")
            .or_insert_with(|| json!({}));
        set(extensions, name, value);
        self.use_extension(name);
    }

    /// Removes an extension of the document itself; returns whether it had it.
    pub(super) fn remove_extension(&mut self, name: &str) -> bool {
        let extensions = self.json.get_mut("extensions");
        let Some(extensions) = extensions.and_then(Value::as_object_mut) else {
            return false;
        };
        if extensions.shift_remove(name).is_none() {
            return false;
        }
        if extensions.is_empty() {
            object(&mut self.json).shift_remove("extensions");
        }
        self.disuse_extension(name);
        true
    }

    /// Removes a name from `extensionsUsed` and `extensionsRequired`.
    pub(super) fn disuse_extension(&mut self, name: &str) {
        for list in ["extensionsUsed", "extensionsRequired"] {
            let Some(names) = self.json.get_mut(list).and_then(Value::as_array_mut) else {
                continue;
            };
            names.retain(|n| n != name);
            if names.is_empty() {
                object(&mut self.json).shift_remove(list);
            }
        }
    }

    /// The type of the elements of an accessor, such as `VEC3`.
    pub(super) fn element_type(&self, accessor: usize) -> String {
        let accessor = self
            .json
            .get("accessors")
            .and_then(|list| list.get(accessor));
        let kind = accessor.and_then(|a| a.get("type")?.as_str());
        kind.unwrap_or("").to_owned()
    }

    /// Returns the number of entries of a top-level array.
    pub(super) fn count(&self, key: &str) -> usize {
        self.json
            .get(key)
            .and_then(Value::as_array)
            .map_or(0, Vec::len)
    }
}

/// Returns the members of a value; a value that is not an object is replaced by an empty one.
pub(super) fn object(value: &mut Value) -> &mut Map<String, Value> {
    if !value.is_object() {
        *value = json!({});
    }
    value.as_object_mut().expect("the object was just inserted")
}

pub(super) fn set(owner: &mut Value, key: &str, value: impl Into<Value>) {
    object(owner).insert(key.to_owned(), value.into());
}

/// Appends to an array member and returns the index of the new entry.
pub(super) fn push(owner: &mut Value, key: &str, entry: Value) -> usize {
    let slot = object(owner).entry(key).or_insert_with(|| json!([]));
    if !slot.is_array() {
        *slot = json!([]);
    }
    let list = slot.as_array_mut().expect("the array was just inserted");
    list.push(entry);
    list.len() - 1
}

/// The entries of an array of a value; none if there is no such array.
pub(super) fn entries<'a>(owner: &'a Value, key: &str) -> &'a [Value] {
    let list = owner.get(key).and_then(Value::as_array);
    list.map_or(&[], Vec::as_slice)
}

/// Returns the entries of an array member for in-place changes; empty if it is not an array.
pub(super) fn entries_mut<'a>(owner: &'a mut Value, key: &str) -> &'a mut [Value] {
    owner
        .get_mut(key)
        .and_then(Value::as_array_mut)
        .map_or(&mut [], Vec::as_mut_slice)
}

/// Returns an index member, if it is a valid one.
pub(super) fn index(owner: &Value, key: &str) -> Option<usize> {
    owner
        .get(key)
        .and_then(whole)
        .and_then(|i| usize::try_from(i).ok())
}

/// Converts a float to the shortest decimal that reads back as the same `f32`.
pub(super) fn short(x: f32) -> Value {
    let wide: f64 = x.to_string().parse().unwrap_or(f64::from(x));
    json!(if wide as f32 == x { wide } else { f64::from(x) })
}

/// Converts floats to their shortest decimals.
pub(super) fn shorts(numbers: &[f32]) -> Value {
    numbers.iter().copied().map(short).collect()
}

/// Converts floats with all digits, for bounds that validators compare exactly.
pub(super) fn exact(numbers: &[f32]) -> Value {
    numbers.iter().map(|x| json!(f64::from(*x))).collect()
}

/// Returns floats as the JSON numbers of fewest digits that are read as the same floats.
pub(super) fn shortest(numbers: &[f32]) -> Value {
    let shortest = |x: &f32| match x.to_string().parse::<f64>() {
        Ok(number) if number.fract() == 0.0 && number.abs() < 1e6 => json!(number as i64),
        Ok(number) => json!(number),
        Err(_) => json!(f64::from(*x)),
    };
    numbers.iter().map(shortest).collect()
}

/// Returns floats in the byte layout of a buffer.
pub(super) fn float_bytes<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> Vec<u8> {
    numbers.into_iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_start_at_multiples_of_four_and_the_length_follows() {
        let mut document = Document {
            json: json!({"buffers": [{"byteLength": 3, "name": "kept"}]}),
            buffers: vec![vec![1, 2, 3]],
            pictures: Vec::new(),
        };
        assert_eq!(document.add_buffer_view(&[9]), 0);
        assert_eq!(document.add_buffer_view(&[7, 7]), 1);
        assert_eq!(document.buffers[0], [1, 2, 3, 0, 9, 0, 0, 0, 7, 7]);
        assert_eq!(
            document.json["buffers"],
            json!([{"byteLength": 10, "name": "kept"}])
        );
        assert_eq!(document.json["bufferViews"][1]["byteOffset"], 8);
    }

    #[test]
    fn short_floats_read_back() {
        assert_eq!(short(0.1).to_string(), "0.1");
        for x in [0.1f32, -3.4e38, 1.0e-45, 16_777_217.0, 0.333_333_34] {
            assert_eq!(short(x).as_f64().unwrap() as f32, x);
        }
    }
}
