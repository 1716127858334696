//! Removal of unreferenced arrays and bytes.
//!
//! Only data of the old animations, meshes or compressed views is ever dropped, and only if nothing
//! else refers to it. For animations and meshes, an extension that is not known to leave accessors
//! and buffer views alone prevents any removal.

use super::append::{entries_mut, index, object, set};
use super::compression::take_extension;
use super::document::Document;
use super::extension::{ARTICULATION, CLUSTERED_MESH, FACE, PREPARED};
use super::texture_source::is_named_for_textures;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Extensions that refer to neither accessors nor buffer views, or whose references are known.
const HARMLESS: &[&str] = &[
    ARTICULATION,
    CLUSTERED_MESH,
    FACE,
    PREPARED,
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "MSFT_lod",
    "VRM",
];
const HARMLESS_FAMILIES: &[&str] = &[
    "KHR_avatar",
    "KHR_character",
    "KHR_materials_",
    "KHR_node_",
    "KHR_xmp",
    "VRMC_",
];

impl Document {
    /// Removes and returns all animations, with the data that only they used.
    pub(super) fn take_animations(&mut self) -> Vec<Value> {
        let old = object(&mut self.json).shift_remove("animations");
        let Some(Value::Array(old)) = old else {
            return Vec::new();
        };
        if has_unknown_extension(&self.json) || old.iter().any(has_unknown_extension) {
            return old;
        }
        let mut accessors = BTreeSet::new();
        let mut views = BTreeSet::new();
        for animation in &old {
            accessors.extend(sampler_accessors(animation));
            views.extend(table_views(animation));
        }
        self.drop_arrays(accessors, views);
        old
    }

    /// Removes all animations, with the data that only they used.
    pub fn remove_animations(&mut self) {
        self.take_animations();
    }

    /// Drops those of the given accessors that are no longer referenced, with the data that only
    /// they used.
    pub(super) fn drop_unnamed(&mut self, accessors: BTreeSet<usize>) {
        if !has_unknown_extension(&self.json) {
            self.drop_arrays(accessors, BTreeSet::new());
        }
    }

    /// Drops accessors that nothing refers to any more, but not what they describe; returns the new index
    /// of those that stay.
    pub(super) fn drop_copies(&mut self, copies: BTreeSet<usize>) -> impl Fn(usize) -> usize {
        remove(&mut self.json, "accessors", &copies);
        let new = renumbered(&copies);
        each_accessor_reference(&mut self.json, &mut |i| new(i));
        new
    }

    /// Removes the motion tables of all animations. They hold for one order of vertices and one
    /// set of joints and clips, so whoever changes these removes them.
    pub fn remove_motion_tables(&mut self) {
        let mut views = BTreeSet::new();
        for animation in entries_mut(&mut self.json, "animations") {
            views.extend(table_views(animation));
            if let Some(own) = extension(animation, ARTICULATION) {
                object(own).shift_remove("tables");
                if object(own).is_empty() {
                    take_extension(animation, ARTICULATION);
                }
            }
        }
        self.drop_arrays(BTreeSet::new(), views);
    }

    pub(super) fn drop_arrays(
        &mut self,
        mut accessors: BTreeSet<usize>,
        mut views: BTreeSet<usize>,
    ) {
        each_accessor_reference(&mut self.json, &mut |i| {
            accessors.remove(&i);
            i
        });
        self.drop_accessors(&accessors, &mut views);
        each_view_reference(&mut self.json, &mut |i| {
            views.remove(&i);
            i
        });
        self.drop_views(&views);
    }

    /// Drops those of the given buffer views that are no longer referenced.
    pub(super) fn drop_unused_views(&mut self, views: BTreeSet<usize>) {
        if !has_unknown_extension(&self.json) {
            self.drop_arrays(BTreeSet::new(), views);
        }
    }

    fn drop_accessors(&mut self, dropped: &BTreeSet<usize>, views: &mut BTreeSet<usize>) {
        let mut gone = json!({ "accessors": remove(&mut self.json, "accessors", dropped) });
        each_view_reference(&mut gone, &mut |i| {
            views.insert(i);
            i
        });
        let new = renumbered(dropped);
        each_accessor_reference(&mut self.json, &mut |i| new(i));
    }

    fn drop_views(&mut self, dropped: &BTreeSet<usize>) {
        let gone = remove(&mut self.json, "bufferViews", dropped);
        let new = renumbered(dropped);
        each_view_reference(&mut self.json, &mut |i| new(i));
        self.drop_ranges(&gone);
    }

    /// Removes the byte ranges that the given values name like views, except those that a view
    /// still uses.
    pub(super) fn drop_ranges(&mut self, gone: &[Value]) {
        let kept = ranges(entries_mut(&mut self.json, "bufferViews"));
        let mut all_cuts = BTreeMap::new();
        for (b, gone) in ranges(gone) {
            let Some(buffer) = self.buffers.get_mut(b) else {
                continue;
            };
            let kept = kept.get(&b).map_or(&[][..], Vec::as_slice);
            let cuts = cuts(&gone, kept, buffer.len());
            if !cuts.is_empty() {
                *buffer = without(buffer, &cuts);
                all_cuts.insert(b, cuts);
            }
        }
        for view in entries_mut(&mut self.json, "bufferViews") {
            if let Some(cuts) = index(view, "buffer").and_then(|b| all_cuts.get(&b)) {
                let offset = index(view, "byteOffset").unwrap_or(0);
                set(view, "byteOffset", moved(cuts, offset));
            }
        }
        let buffers = entries_mut(&mut self.json, "buffers").iter_mut();
        for (b, buffer) in buffers
            .enumerate()
            .filter(|(b, _)| all_cuts.contains_key(b))
        {
            set(buffer, "byteLength", self.buffers[b].len());
        }
    }

    /// Drops the buffers that no view uses.
    pub(super) fn drop_unused_buffers(&mut self) {
        let views = entries_mut(&mut self.json, "bufferViews").iter();
        let used: BTreeSet<usize> = views.filter_map(|view| index(view, "buffer")).collect();
        let unused: BTreeSet<usize> = (0..self.buffers.len())
            .filter(|b| !used.contains(b))
            .collect();
        remove(&mut self.json, "buffers", &unused);
        let mut i = 0;
        self.buffers.retain(|_| {
            i += 1;
            used.contains(&(i - 1))
        });
        let new = renumbered(&unused);
        for view in entries_mut(&mut self.json, "bufferViews") {
            change(view, "buffer", &mut |b| new(b));
        }
    }
}

pub(super) fn has_unknown_extension(value: &Value) -> bool {
    let is_unknown = |name: &String| {
        !HARMLESS.contains(&name.as_str())
            && !HARMLESS_FAMILIES.iter().any(|f| name.starts_with(f))
            && !is_named_for_textures(name)
    };
    match value {
        Value::Array(list) => list.iter().any(has_unknown_extension),
        Value::Object(members) => members.iter().any(|(key, value)| {
            let names = value.as_object().filter(|_| key == "extensions");
            names.is_some_and(|names| names.keys().any(is_unknown)) || has_unknown_extension(value)
        }),
        _ => false,
    }
}

pub(super) fn sampler_accessors(animation: &Value) -> Vec<usize> {
    let samplers = animation.get("samplers").and_then(Value::as_array);
    samplers
        .into_iter()
        .flatten()
        .flat_map(|s| [index(s, "input"), index(s, "output")])
        .flatten()
        .collect()
}

fn table_views(animation: &Value) -> Vec<usize> {
    let tables = animation
        .get("extensions")
        .and_then(|e| e.get(ARTICULATION)?.get("tables")?.as_object());
    let names = tables.into_iter().flat_map(|tables| tables.keys());
    names
        .filter_map(|name| index(&animation["extensions"][ARTICULATION]["tables"], name))
        .collect()
}

/// Calls `visit` with every accessor index, and replaces it by the result.
pub(super) fn each_accessor_reference(json: &mut Value, visit: &mut dyn FnMut(usize) -> usize) {
    for mesh in entries_mut(json, "meshes") {
        for primitive in entries_mut(mesh, "primitives") {
            change(primitive, "indices", visit);
            change_all(primitive.get_mut("attributes"), visit);
            for target in entries_mut(primitive, "targets") {
                change_all(Some(target), visit);
            }
            if let Some(levels) = extension(primitive, CLUSTERED_MESH) {
                change(levels, "indices", visit);
            }
        }
    }
    for animation in entries_mut(json, "animations") {
        for sampler in entries_mut(animation, "samplers") {
            change(sampler, "input", visit);
            change(sampler, "output", visit);
        }
    }
    for skin in entries_mut(json, "skins") {
        change(skin, "inverseBindMatrices", visit);
    }
}

/// Calls `visit` with every buffer view index, and replaces it by the result.
pub(super) fn each_view_reference(json: &mut Value, visit: &mut dyn FnMut(usize) -> usize) {
    for accessor in entries_mut(json, "accessors") {
        change(accessor, "bufferView", visit);
        for part in ["indices", "values"] {
            if let Some(part) = accessor.get_mut("sparse").and_then(|s| s.get_mut(part)) {
                change(part, "bufferView", visit);
            }
        }
    }
    for image in entries_mut(json, "images") {
        change(image, "bufferView", visit);
    }
    for animation in entries_mut(json, "animations") {
        let tables = extension(animation, ARTICULATION).and_then(|e| e.get_mut("tables"));
        change_all(tables, visit);
    }
    let parts = extension(json, PREPARED).and_then(|e| e.get_mut("parts")?.as_object_mut());
    for part in parts.into_iter().flat_map(|parts| parts.values_mut()) {
        change(part, "bufferView", visit);
    }
}

fn extension<'a>(owner: &'a mut Value, name: &str) -> Option<&'a mut Value> {
    owner.get_mut("extensions")?.get_mut(name)
}

fn change(owner: &mut Value, key: &str, visit: &mut dyn FnMut(usize) -> usize) {
    if let Some(i) = index(owner, key) {
        set(owner, key, visit(i));
    }
}

fn change_all(owner: Option<&mut Value>, visit: &mut dyn FnMut(usize) -> usize) {
    let Some(owner) = owner.filter(|owner| owner.is_object()) else {
        return;
    };
    let keys: Vec<String> = object(owner).keys().cloned().collect();
    for key in keys {
        change(owner, &key, visit);
    }
}

/// Removes entries of a top-level array, and the array if it becomes empty; returns them.
pub(super) fn remove(json: &mut Value, key: &str, dropped: &BTreeSet<usize>) -> Vec<Value> {
    let Some(Value::Array(list)) = json.get_mut(key).map(Value::take) else {
        return Vec::new();
    };
    let (gone, kept): (Vec<_>, Vec<_>) = list
        .into_iter()
        .enumerate()
        .partition(|(i, _)| dropped.contains(i));
    let values = |list: Vec<(usize, Value)>| list.into_iter().map(|(_, v)| v).collect();
    let kept: Vec<Value> = values(kept);
    if kept.is_empty() {
        object(json).shift_remove(key);
    } else {
        set(json, key, kept);
    }
    values(gone)
}

pub(super) fn renumbered(dropped: &BTreeSet<usize>) -> impl Fn(usize) -> usize + use<> {
    let dropped: Vec<usize> = dropped.iter().copied().collect();
    move |i| i - dropped.partition_point(|&d| d < i)
}

/// A range of bytes of one buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Range {
    start: usize,
    end: usize,
}

/// A range to be removed, and the number of bytes removed up to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cut {
    start: usize,
    end: usize,
    total: usize,
}

/// Returns the ranges of views by buffer, sorted and merged.
fn ranges(views: &[Value]) -> BTreeMap<usize, Vec<Range>> {
    let mut all: BTreeMap<usize, Vec<Range>> = BTreeMap::new();
    for view in views {
        let Some(buffer) = index(view, "buffer") else {
            continue;
        };
        let start = index(view, "byteOffset").unwrap_or(0);
        let length = index(view, "byteLength").unwrap_or(0);
        let end = start.saturating_add(length);
        all.entry(buffer).or_default().push(Range { start, end });
    }
    for list in all.values_mut() {
        list.sort_by_key(|r| r.start);
        list.dedup_by(|range, last| {
            let touches = range.start <= last.end;
            if touches {
                last.end = last.end.max(range.end);
            }
            touches
        });
    }
    all
}

/// Returns the parts of `gone` that no kept range covers, with lengths that are multiples of 4, so
/// that the data after them stays aligned: padding after a part is removed with it.
fn cuts(gone: &[Range], kept: &[Range], length: usize) -> Vec<Cut> {
    let mut cuts: Vec<Cut> = Vec::new();
    let mut push = |start: usize, end: usize, limit: usize| {
        let last = cuts.last();
        let start = start.max(last.map_or(0, |c| c.end));
        let end = end.min(length);
        let bytes = end.saturating_sub(start);
        let padded = start + bytes.next_multiple_of(4);
        let end = match () {
            () if end == length => end,
            () if padded <= limit.min(length) => padded,
            () => start + bytes / 4 * 4,
        };
        if end > start {
            let total = last.map_or(0, |c| c.total) + end - start;
            cuts.push(Cut { start, end, total });
        }
    };
    let mut next = 0;
    for range in gone {
        while next < kept.len() && kept[next].end <= range.start {
            next += 1;
        }
        let mut start = range.start;
        for keep in kept[next..].iter().take_while(|k| k.start < range.end) {
            push(start, keep.start.min(range.end), keep.start);
            start = start.max(keep.end);
        }
        let limit = kept[next..].iter().find(|k| k.start >= range.end);
        push(start, range.end, limit.map_or(length, |k| k.start));
    }
    cuts
}

fn without(bytes: &[u8], cuts: &[Cut]) -> Vec<u8> {
    let mut kept = Vec::with_capacity(bytes.len());
    let mut from = 0;
    for cut in cuts {
        kept.extend_from_slice(&bytes[from..cut.start]);
        from = cut.end;
    }
    kept.extend_from_slice(&bytes[from..]);
    kept
}

/// Returns the new offset after the removals before it.
fn moved(cuts: &[Cut], offset: usize) -> usize {
    let before = cuts.partition_point(|cut| cut.end <= offset);
    offset - before.checked_sub(1).map_or(0, |last| cuts[last].total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_spare_what_is_kept_and_keep_alignment() {
        let range = |start, end| Range { start, end };
        let gone = [range(0, 10), range(20, 40)];
        let kept = [range(8, 12), range(26, 30)];
        let cuts = cuts(&gone, &kept, 38);
        let places: Vec<_> = cuts.iter().map(|c| (c.start, c.end, c.total)).collect();
        assert_eq!(places, [(0, 8, 8), (20, 24, 12), (30, 38, 20)]);
        assert_eq!(moved(&cuts, 8), 0);
        assert_eq!(moved(&cuts, 26), 14);
        assert_eq!(moved(&cuts, 38), 18);
    }

    #[test]
    fn unknown_extensions_are_found_at_any_depth() {
        let known = json!({"extensions": {"VRMC_vrm": {}, "ARTICULA_face": {}}, "materials": [
            {"extensions": {"KHR_materials_unlit": {}}}]});
        assert!(!has_unknown_extension(&known));
        let unknown = json!({"meshes": [{"extensions": {"EXT_new": {"bufferView": 3}}}]});
        assert!(has_unknown_extension(&unknown));
    }
}
