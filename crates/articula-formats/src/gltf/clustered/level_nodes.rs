//! Levels as nodes of `MSFT_lod`, for engines that support that extension and not
//! `ARTICULA_clustered_mesh`.
//!
//! Source: MSFT_lod; screen coverage as in Babylon.js and the guidelines of Windows Mixed Reality:
//! the projected area of a mesh's bounding sphere divided by the area of the screen. Level nodes
//! share skin and vertices with the finest: they use a prefix of each array.

use super::read::read_part;
use crate::error::ReadError;
use crate::gltf::append::{Use, entries_mut, index, object, push, set, shorts};
use crate::gltf::document::Document;
use crate::gltf::extension::CLUSTERED_MESH;
use crate::gltf::origin::mesh_of;
use crate::gltf::place::whole;
use crate::gltf::reader::{Notes, Reader};
use crate::limits::Limits;
use crate::written::WriteError;
use articula_core::{ClusteredTriangles, LevelTable, lod_error_metres};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

const LOD: &str = "MSFT_lod";
const COVERAGE: &str = "MSFT_screencoverage";

/// Acceptable error of a level, in pixels.
const ERROR_PX: f32 = 1.0;
/// Width and height of the reference screen, in pixels.
const SCREEN_PX: [u32; 2] = [1920, 1080];

/// Returns the screen coverage of the mesh at which the error of a level in motion
/// ([`lod_error_metres`]) equals the acceptable error; the level is good enough from there down.
///
/// With `k = ERROR_PX / error_metres` pixels per metre, the sphere covers `pi (radius k)^2` of
/// `width * height` pixels.
fn coverage(radius_metres: f32, levels: &LevelTable, level: usize) -> f32 {
    let error = levels.levels.get(level).map_or(f32::INFINITY, |l| {
        lod_error_metres(l.motion.p95_metres, l.motion.max_metres)
    });
    if error <= 0.0 {
        return 1.0;
    }
    let radius_px = f64::from(radius_metres * ERROR_PX) / f64::from(error);
    let screen = SCREEN_PX.map(f64::from).iter().product::<f64>();
    let share = std::f64::consts::PI * radius_px * radius_px / screen;
    (share as f32).clamp(0.0, 1.0)
}

impl Document {
    /// Adds the levels of a node's mesh, written by [`Document::set_mesh_levels`], as nodes that
    /// replace it as it becomes smaller on a screen of 1920 by 1080 pixels with an acceptable error
    /// of one pixel. `radius_metres` is the radius of the bounding sphere of the mesh at rest.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if the mesh of the node has no levels, or not as many as the table.
    pub fn add_level_nodes(
        &mut self,
        node: usize,
        levels: &LevelTable,
        radius_metres: f32,
    ) -> Result<(), WriteError> {
        let wrong =
            |e: ReadError| WriteError::mismatch(format!("nodes[{node}].mesh"), e.to_string());
        let objects = self.stored_levels(node).map_err(wrong)?;
        let count = objects.first().map_or(0, |(_, o)| o.clusters.levels());
        if count == 0 || count != levels.levels.len() {
            let what = format!("{count} levels, the table has {}", levels.levels.len());
            return Err(WriteError::mismatch(format!("nodes[{node}].mesh"), what));
        }
        self.clear_level_nodes(node);
        let mut ids = Vec::new();
        let mut coverages = Vec::new();
        let mut least = 1.0f32;
        let mut arrays = BTreeMap::new();
        for level in 1..count {
            least = least.min(coverage(radius_metres, levels, level));
            coverages.push(least);
            let parts = self.level_primitives((node, level), &objects, &mut arrays);
            if parts.is_empty() {
                // All coarser levels are empty too.
                break;
            }
            ids.push(self.add_level_node(node, parts));
        }
        if coverages.len() == ids.len() {
            coverages.push(0.0);
        }
        if ids.is_empty() {
            return Ok(());
        }
        let stale: Vec<usize> = arrays.into_values().collect();
        self.state_bounds(&stale, &Limits::default());
        let value = &mut entries_mut(&mut self.json, "nodes")[node];
        set(member(value, "extras"), COVERAGE, shorts(&coverages));
        set(member(value, "extensions"), LOD, json!({ "ids": ids }));
        self.use_extension(LOD);
        Ok(())
    }

    /// Returns the levels of each primitive of a node's mesh that has some.
    fn stored_levels(&self, node: usize) -> Result<Vec<(usize, ClusteredTriangles)>, ReadError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mesh = mesh_of(&reader, node)?;
        let mut found = Vec::new();
        for (p, place) in mesh.entries("primitives")?.iter().enumerate() {
            if let Some(extension) = place.dig(&["extensions", CLUSTERED_MESH]) {
                let object = read_part(&mut reader, &extension)?;
                let positions = place.require("attributes")?.require("POSITION")?;
                let fits = object.check(reader.accessor(&positions)?.count);
                fits.map_err(|e| extension.malformed(e.to_string()))?;
                found.push((p, object));
            }
        }
        Ok(found)
    }

    /// Returns the primitives that a level of a node's mesh shows.
    fn level_primitives(
        &mut self,
        (node, level): (usize, usize),
        objects: &[(usize, ClusteredTriangles)],
        arrays: &mut BTreeMap<(usize, u32), usize>,
    ) -> Vec<Value> {
        let mesh = index(&self.json["nodes"][node], "mesh").unwrap_or(0);
        let mut out = Vec::new();
        for (p, object) in objects {
            if object.clusters.triangles(level) == 0 {
                continue;
            }
            let vertices = object.clusters.vertices(level);
            let mut value = self.json["meshes"][mesh]["primitives"][*p].clone();
            let own = take(&mut value, "extensions", CLUSTERED_MESH).unwrap_or_default();
            let all = index(&own, "indices").unwrap_or(0);
            self.take_prefixes(value.get_mut("attributes"), vertices, arrays);
            for target in entries_mut(&mut value, "targets") {
                self.take_prefixes(Some(target), vertices, arrays);
            }
            let indices = self.level_indices(object, level, all);
            set(&mut value, "indices", indices);
            out.push(value);
        }
        out
    }

    /// Replaces accessors of all vertices by accessors of the first ones.
    fn take_prefixes(
        &mut self,
        owner: Option<&mut Value>,
        vertices: u32,
        arrays: &mut BTreeMap<(usize, u32), usize>,
    ) {
        for (_, slot) in owner.and_then(Value::as_object_mut).into_iter().flatten() {
            let Some(all) = whole(slot).map(|i| i as usize) else {
                continue;
            };
            let known = arrays.get(&(all, vertices)).copied();
            let prefix = known.unwrap_or_else(|| self.add_prefix(all, vertices));
            arrays.insert((all, vertices), prefix);
            *slot = json!(prefix);
        }
    }

    /// Adds an accessor of the first elements of another, over the same bytes.
    fn add_prefix(&mut self, all: usize, count: u32) -> usize {
        let mut accessor = self.json["accessors"][all].clone();
        if index(&accessor, "count") == Some(count as usize) {
            return all;
        }
        set(&mut accessor, "count", count);
        if accessor.get("sparse").is_some() {
            let limits = Limits::default();
            let reader = Reader::new(self, &limits, Notes::default());
            let place = reader.root.entry("accessors", all);
            let overlay = place.and_then(|p| reader.accessor_at(p).ok());
            // Sparse indices ascend, so those of the prefix come first.
            let kept = overlay.as_ref().and_then(|a| a.overlay().ok());
            let kept = kept.map_or(0, |o| o.range(..count as usize).count());
            if kept == 0 {
                object(&mut accessor).shift_remove("sparse");
            } else {
                set(&mut accessor["sparse"], "count", kept);
            }
        }
        self.add_accessor(accessor)
    }

    /// Adds an accessor of the triangles of a level: a part of the stored list if they are one
    /// range.
    fn level_indices(&mut self, object: &ClusteredTriangles, level: usize, all: usize) -> usize {
        let mut accessor = self.json["accessors"][all].clone();
        let is_short = index(&accessor, "componentType") == Some(5123);
        let ranges: Vec<_> = object.clusters.ranges(level).collect();
        let size = if is_short { 2 } else { 4 };
        let count: u32 = ranges.iter().map(|r| r.end - r.start).sum();
        set(&mut accessor, "count", count * 3);
        if let [range] = ranges.as_slice() {
            let before = index(&accessor, "byteOffset").unwrap_or(0);
            set(
                &mut accessor,
                "byteOffset",
                before + range.start as usize * 3 * size,
            );
        } else {
            let corners = object.level(level).flatten();
            let bytes: Vec<u8> = if is_short {
                corners.flat_map(|c| (c as u16).to_le_bytes()).collect()
            } else {
                corners.flat_map(u32::to_le_bytes).collect()
            };
            let view = self.add_view(&bytes, Use::Indices);
            set(&mut accessor, "bufferView", view);
            set(&mut accessor, "byteOffset", 0);
        }
        self.add_accessor(accessor)
    }

    /// Adds a node outside of all scenes that shows primitives with the transform of another node,
    /// together with the primitives of the other's mesh that have no levels, such as lines.
    fn add_level_node(&mut self, node: usize, mut primitives: Vec<Value>) -> usize {
        let fine = self.json["nodes"][node].clone();
        let mut mesh = self.json["meshes"][index(&fine, "mesh").unwrap_or(0)].clone();
        let has_levels = |p: &Value| {
            p.get("extensions")
                .and_then(|e| e.get(CLUSTERED_MESH))
                .is_some()
        };
        let others = entries_mut(&mut mesh, "primitives").iter();
        primitives.extend(others.filter(|p| !has_levels(p)).cloned());
        set(&mut mesh, "primitives", primitives);
        let mut value = json!({"mesh": push(&mut self.json, "meshes", mesh)});
        let placed = ["matrix", "translation", "rotation", "scale"];
        for key in ["name", "skin", "weights"].into_iter().chain(placed) {
            // The transform of a skinned node has no effect.
            if fine.get("skin").is_some() && placed.contains(&key) {
                continue;
            }
            if let Some(member) = fine.get(key) {
                set(&mut value, key, member.clone());
            }
        }
        push(&mut self.json, "nodes", value)
    }

    /// Removes the `MSFT_lod` levels of a node. Nodes that were only levels of it no longer show a
    /// mesh.
    pub(in crate::gltf) fn clear_level_nodes(&mut self, node: usize) {
        let value = &mut entries_mut(&mut self.json, "nodes")[node];
        let Some(taken) = take(value, "extensions", LOD) else {
            return;
        };
        take(value, "extras", COVERAGE);
        let shown = self.shown_nodes();
        let ids = taken
            .get("ids")
            .and_then(Value::as_array)
            .into_iter()
            .flatten();
        for id in ids.filter_map(whole) {
            let id = id as usize;
            let stand_in = entries_mut(&mut self.json, "nodes").get_mut(id);
            if let Some(stand_in) = stand_in.filter(|_| !shown.contains(&id)) {
                for key in ["mesh", "skin", "weights"] {
                    object(stand_in).shift_remove(key);
                }
            }
        }
        let names = |v: &Value| v.get("extensions").and_then(|e| e.get(LOD)).is_some();
        let lists = ["nodes", "materials"].map(|key| self.json.get(key).and_then(Value::as_array));
        if !lists.into_iter().flatten().flatten().any(names) {
            self.disuse_extension(LOD);
        }
    }

    /// Returns the nodes that a scene or another node refers to.
    fn shown_nodes(&mut self) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for (list, key) in [("scenes", "nodes"), ("nodes", "children")] {
            for owner in entries_mut(&mut self.json, list) {
                let named = owner
                    .get(key)
                    .and_then(Value::as_array)
                    .into_iter()
                    .flatten();
                found.extend(named.filter_map(whole).map(|i| i as usize));
            }
        }
        found
    }
}

/// Returns an object member, created if absent.
fn member<'a>(owner: &'a mut Value, key: &str) -> &'a mut Value {
    object(owner).entry(key).or_insert_with(|| json!({}))
}

/// Removes and returns a member of a member, and removes the latter if it becomes empty.
fn take(owner: &mut Value, key: &str, name: &str) -> Option<Value> {
    let members = owner.get_mut(key)?.as_object_mut()?;
    let taken = members.shift_remove(name);
    if members.is_empty() {
        object(owner).shift_remove(key);
    }
    taken
}
