//! Levels as nodes of `MSFT_lod`, for engines that know that extension and not ours.
//!
//! Source: MSFT_lod, and for the shares of the screen Babylon.js and the guidelines of Windows
//! Mixed Reality: the area of a mesh's bounding sphere on the screen over the area of the screen.
//! Level nodes share skin and vertices with the finest: of each array they take a prefix.

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

/// Error of a level that may be seen, pixels.
const ERROR_PX: f32 = 1.0;
/// Width and height of the screen that levels are chosen for, pixels.
const SCREEN_PX: [u32; 2] = [1920, 1080];

/// The share of the screen that the mesh covers where the error of a level in motion, judged
/// as levels are chosen by ([`lod_error_metres`]), is what may be seen: from there down the
/// level is good enough.
///
/// With `k = ERROR_PX / error_metres` pixels a metre, the ball covers `pi (radius k)^2` of
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
    /// Shows the levels of a node's mesh, which [`Document::set_mesh_levels`] wrote, as nodes that
    /// stand in for it as it gets smaller on a screen of 1920 by 1080, where a pixel of error may
    /// be seen. `radius_metres` is that of the ball around the mesh at rest.
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
            let what = format!("{count} levels, {} in the table", levels.levels.len());
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
                // Nothing is left to show from here down.
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

    /// The levels of each primitive of a node's mesh that has some.
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

    /// The primitives that a level of a node's mesh shows.
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

    /// Puts accessors of the first vertices in the place of those of all.
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

    /// An accessor of the first elements of another, over the same bytes.
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
            // Sparse elements rise: those of the prefix come first.
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

    /// An accessor of the triangles of a level: a part of the stored list if they are one range.
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

    /// A node in no scene that shows primitives where another node stands, and what of the other's
    /// mesh has no levels, such as lines.
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
            // The transform of a skinned node means nothing.
            if fine.get("skin").is_some() && placed.contains(&key) {
                continue;
            }
            if let Some(member) = fine.get(key) {
                set(&mut value, key, member.clone());
            }
        }
        push(&mut self.json, "nodes", value)
    }

    /// Takes the levels of `MSFT_lod` from a node. Nodes that only stood in for it show nothing
    /// any longer.
    pub(super) fn clear_level_nodes(&mut self, node: usize) {
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

    /// Nodes that a scene or another node names.
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

/// An object member, made if it is not there.
fn member<'a>(owner: &'a mut Value, key: &str) -> &'a mut Value {
    object(owner).entry(key).or_insert_with(|| json!({}))
}

/// Takes a member of a member, and the latter if nothing is left in it.
fn take(owner: &mut Value, key: &str, name: &str) -> Option<Value> {
    let members = owner.get_mut(key)?.as_object_mut()?;
    let taken = members.shift_remove(name);
    if members.is_empty() {
        object(owner).shift_remove(key);
    }
    taken
}
