//! One primitive as accessors: plain floats, small integers where they fit, sparse morph targets.

use super::append::{Use, exact, float_bytes, set};
use super::document::Document;
use crate::written::WriteError;
use articula_core::source::{MorphTarget, Primitive};
use glam::Vec3;
use serde_json::{Value, json};

/// Maximum number of vertices for 16-bit indices; index 65535 would restart a strip.
const MAX_SHORT: usize = 65535;

/// Stores a primitive's arrays and returns its JSON.
pub(super) fn add_primitive(
    document: &mut Document,
    primitive: &Primitive,
    is_skinned: bool,
) -> Value {
    let count = primitive.positions.len();
    let mut attributes = json!({"POSITION": add_positions(document, &primitive.positions)});
    let mut add = |document: &mut Document, name: &str, kind: &str, bytes: Vec<u8>| {
        if !bytes.is_empty() {
            let accessor = add_vertices(document, (kind, 5126), count, &bytes);
            set(&mut attributes, name, accessor);
        }
    };
    let normals = float_bytes(primitive.normals.iter().flat_map(AsRef::<[f32; 3]>::as_ref));
    add(document, "NORMAL", "VEC3", normals);
    let texcoords = float_bytes(
        primitive
            .texcoords
            .iter()
            .flat_map(AsRef::<[f32; 2]>::as_ref),
    );
    add(document, "TEXCOORD_0", "VEC2", texcoords);
    let colors = float_bytes(primitive.colors.iter().flat_map(AsRef::<[f32; 4]>::as_ref));
    add(document, "COLOR_0", "VEC4", colors);
    if is_skinned {
        add_influences(document, primitive, &mut attributes);
    }
    let mut value = json!({
        "attributes": attributes,
        "indices": add_indices(document, &primitive.triangles, count),
    });
    if let Some(material) = primitive.material {
        set(&mut value, "material", material);
    }
    if !primitive.morphs.is_empty() {
        let targets = primitive.morphs.iter().map(|m| add_morph(document, m));
        set(&mut value, "targets", targets.collect::<Value>());
    }
    value
}

/// Returns an error if arrays do not match each other or the number of joints and morph targets.
pub(super) fn check(
    primitive: &Primitive,
    (joint_count, morph_count): (usize, usize),
    at: impl Fn() -> String,
) -> Result<(), WriteError> {
    let count = primitive.positions.len();
    let is_whole = |len: usize| len == 0 || len == count;
    let influences = primitive.influences * count;
    let morphs = &primitive.morphs;
    let fits = [
        is_whole(primitive.normals.len()),
        is_whole(primitive.texcoords.len()),
        is_whole(primitive.colors.len()),
        primitive.joints.len() == influences,
        primitive.weights.len() == influences,
        morphs.len() == morph_count,
        morphs.iter().all(|m| m.positions.len() == count),
        morphs.iter().all(|m| is_whole(m.normals.len())),
    ];
    if fits.contains(&false) {
        return Err(WriteError::mismatch(
            at(),
            "the lengths of its arrays do not match",
        ));
    }
    let mut corners = primitive.triangles.iter().flatten();
    if corners.any(|&c| c as usize >= count) {
        return Err(WriteError::mismatch(
            at(),
            "a vertex index of a triangle is out of range",
        ));
    }
    let mut joints = primitive.joints.iter();
    if joints.any(|&j| usize::from(j) >= joint_count) {
        return Err(WriteError::mismatch(
            at(),
            "a joint index of a vertex is out of range",
        ));
    }
    Ok(())
}

fn add_positions(document: &mut Document, positions: &[Vec3]) -> usize {
    let bytes = float_bytes(positions.iter().flat_map(AsRef::<[f32; 3]>::as_ref));
    let accessor = add_vertices(document, ("VEC3", 5126), positions.len(), &bytes);
    set_bounds(document, accessor, positions);
    accessor
}

fn set_bounds(document: &mut Document, accessor: usize, positions: &[Vec3]) {
    let first = positions.first().copied().unwrap_or_default();
    let (least, greatest) = positions
        .iter()
        .fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    let value = &mut document.json["accessors"][accessor];
    set(value, "min", exact(&least.to_array()));
    set(value, "max", exact(&greatest.to_array()));
}

/// Adds a vertex attribute in a separate view: accessor and component type, elements, bytes.
fn add_vertices(
    document: &mut Document,
    (kind, component): (&str, u32),
    count: usize,
    bytes: &[u8],
) -> usize {
    let view = document.add_view(bytes, Use::Vertices);
    document.add_accessor(json!({
        "bufferView": view,
        "componentType": component,
        "count": count,
        "type": kind,
    }))
}

fn add_indices(document: &mut Document, triangles: &[[u32; 3]], vertices: usize) -> usize {
    let corners = triangles.iter().flatten();
    let (component, bytes): (u32, Vec<u8>) = if vertices <= MAX_SHORT {
        (
            5123,
            corners.flat_map(|&c| (c as u16).to_le_bytes()).collect(),
        )
    } else {
        (5125, corners.flat_map(|c| c.to_le_bytes()).collect())
    };
    let view = document.add_view(&bytes, Use::Indices);
    document.add_accessor(json!({
        "bufferView": view,
        "componentType": component,
        "count": triangles.len() * 3,
        "type": "SCALAR",
    }))
}

/// Adds joints and weights in sets of four, the last one padded with zeros.
fn add_influences(document: &mut Document, primitive: &Primitive, attributes: &mut Value) {
    let count = primitive.positions.len();
    let influences = primitive.influences;
    let is_small = primitive.joints.iter().all(|&j| j < 256);
    for set_index in 0..influences.div_ceil(4) {
        let mut joints = Vec::new();
        let mut weights = Vec::new();
        for v in 0..count {
            for i in set_index * 4..set_index * 4 + 4 {
                let at = v * influences + i;
                // The format requires joint 0 where the weight is 0.
                let used = i < influences && primitive.weights[at] > 0.0;
                let joint = if used { primitive.joints[at] } else { 0 };
                if is_small {
                    joints.push(joint as u8);
                } else {
                    joints.extend(joint.to_le_bytes());
                }
                weights.push(if used { primitive.weights[at] } else { 0.0 });
            }
        }
        let component = if is_small { 5121 } else { 5123 };
        let accessor = add_vertices(document, ("VEC4", component), count, &joints);
        set(attributes, &format!("JOINTS_{set_index}"), accessor);
        let bytes = float_bytes(&weights);
        let accessor = add_vertices(document, ("VEC4", 5126), count, &bytes);
        set(attributes, &format!("WEIGHTS_{set_index}"), accessor);
    }
}

/// Adds a morph target and returns its accessors.
pub(super) fn add_morph(document: &mut Document, morph: &MorphTarget) -> Value {
    let positions = add_offsets(document, &morph.positions);
    set_bounds(document, positions, &morph.positions);
    let mut target = json!({"POSITION": positions});
    if !morph.normals.is_empty() {
        set(&mut target, "NORMAL", add_offsets(document, &morph.normals));
    }
    target
}

/// Adds offsets, sparse where that is smaller.
fn add_offsets(document: &mut Document, offsets: &[Vec3]) -> usize {
    let moved: Vec<u32> = (0u32..)
        .zip(offsets)
        .filter(|(_, o)| **o != Vec3::ZERO)
        .map(|(i, _)| i)
        .collect();
    let is_short = offsets.len() <= MAX_SHORT;
    let index_bytes = if is_short { 2 } else { 4 };
    if moved.len() * (12 + index_bytes) >= offsets.len() * 12 {
        let bytes = float_bytes(offsets.iter().flat_map(AsRef::<[f32; 3]>::as_ref));
        return add_vertices(document, ("VEC3", 5126), offsets.len(), &bytes);
    }
    let mut accessor = json!({"componentType": 5126, "count": offsets.len(), "type": "VEC3"});
    if !moved.is_empty() {
        let indices: Vec<u8> = if is_short {
            moved
                .iter()
                .flat_map(|&i| (i as u16).to_le_bytes())
                .collect()
        } else {
            moved.iter().flat_map(|i| i.to_le_bytes()).collect()
        };
        let values = moved.iter().flat_map(|&i| offsets[i as usize].to_array());
        let values: Vec<f32> = values.collect();
        let sparse = json!({
            "count": moved.len(),
            "indices": {
                "bufferView": document.add_view(&indices, Use::Other),
                "componentType": if is_short { 5123 } else { 5125 },
            },
            "values": {"bufferView": document.add_view(&float_bytes(&values), Use::Other)},
        });
        set(&mut accessor, "sparse", sparse);
    }
    document.add_accessor(accessor)
}
