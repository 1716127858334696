//! One primitive: attributes, triangles, morph targets.
//!
//! Source: glTF 2.0, 3.7.2; integer attributes as KHR_mesh_quantization allows them.

use super::influences;
use super::place::Place;
use super::reader::Reader;
use super::texcoord::Texcoords;
use crate::error::ReadError;
use articula_core::source::{MorphTarget, Primitive};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashSet;

/// Reads one primitive; `None`, with a warning, if it has no triangles.
///
/// `joint_count` is the number of joints of the skin, if it is skinned.
pub(super) fn read(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    joint_count: Option<usize>,
    wanted: &[Texcoords],
) -> Result<Option<Primitive>, ReadError> {
    let mode = place.whole_or("mode", 4)?;
    let Some(attributes) = place.get("attributes") else {
        return Err(place.malformed("\"attributes\" is missing"));
    };
    if !matches!(mode, 4..=6) {
        reader.warn(place, format!("points or lines (mode {mode}) are left out"));
        return Ok(None);
    }
    let positions = vec3s(reader, &attributes, "POSITION", None)?;
    let count = positions.len();
    if count == 0 {
        reader.warn(place, "the primitive has no positions; left out");
        return Ok(None);
    }
    let triangles = triangles(reader, place, mode, count)?;
    if triangles.is_empty() {
        reader.warn(place, "the primitive has no triangles; left out");
        return Ok(None);
    }
    let material = place.index("material", wanted.len())?;
    let wanted = material.map(|m| wanted[m]).unwrap_or_default();
    let (influences, joints, weights) = influences::read(reader, &attributes, count, joint_count)?;
    Ok(Some(Primitive {
        normals: normals(reader, &attributes, count)?,
        texcoords: texcoords(reader, &attributes, wanted, count)?,
        colors: colors(reader, &attributes, count)?,
        influences,
        joints,
        weights,
        morphs: morphs(reader, place, count)?,
        triangles,
        material,
        positions,
    }))
}

/// Number of vertices, and triangles.
type Outline = (usize, Vec<[u32; 3]>);

/// Returns vertex count and triangles as [`read`] does, without attributes; `None` if it leaves the
/// primitive out.
pub(super) fn outline(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
) -> Result<Option<Outline>, ReadError> {
    let mode = place.whole_or("mode", 4)?;
    let positions = place.dig(&["attributes", "POSITION"]);
    let Some(positions) = positions.filter(|_| matches!(mode, 4..=6)) else {
        return Ok(None);
    };
    let count = reader.accessor(&positions)?.count;
    if count == 0 {
        return Ok(None);
    }
    let triangles = triangles(reader, place, mode, count)?;
    Ok((!triangles.is_empty()).then_some((count, triangles)))
}

/// Reads an attribute of three floats; empty if absent.
fn vec3s(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    name: &str,
    count: Option<usize>,
) -> Result<Vec<Vec3>, ReadError> {
    let Some(index) = attributes.get(name) else {
        return Ok(Vec::new());
    };
    let accessor = reader.accessor(&index)?;
    accessor.expect_type(&["VEC3"])?;
    if let Some(count) = count {
        accessor.expect_count(count, "vertices")?;
    }
    let numbers = reader.floats(&accessor)?;
    let triples = numbers.as_chunks::<3>().0;
    Ok(triples.iter().copied().map(Vec3::from_array).collect())
}

/// Reads normals, normalised where storage or export made them inexact.
fn normals(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    count: usize,
) -> Result<Vec<Vec3>, ReadError> {
    let mut normals = vec3s(reader, attributes, "NORMAL", Some(count))?;
    let mut zeros = 0;
    for normal in &mut normals {
        if (normal.length_squared() - 1.0).abs() <= 1e-3 {
            continue;
        }
        let unit = normal.try_normalize();
        zeros += usize::from(unit.is_none());
        *normal = unit.unwrap_or(Vec3::Y);
    }
    if zeros > 0 {
        let what = format!("{zeros} of {count} normals have length 0; read as +Y");
        reader.notes.add(attributes.path("NORMAL"), what);
    }
    Ok(normals)
}

fn texcoords(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    wanted: Texcoords,
    count: usize,
) -> Result<Vec<Vec2>, ReadError> {
    let Some(index) = attributes.get(&format!("TEXCOORD_{}", wanted.set)) else {
        return Ok(Vec::new());
    };
    let accessor = reader.accessor(&index)?;
    accessor.expect_type(&["VEC2"])?;
    accessor.expect_count(count, "vertices")?;
    let numbers = reader.floats(&accessor)?;
    let pairs = numbers.as_chunks::<2>().0.iter();
    let mut texcoords: Vec<Vec2> = pairs.copied().map(Vec2::from_array).collect();
    if let Err(what) = wanted.apply(&mut texcoords) {
        reader.warn(&index, format!("{what}; texture coordinates left out"));
        texcoords.clear();
    }
    Ok(texcoords)
}

fn colors(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    count: usize,
) -> Result<Vec<Vec4>, ReadError> {
    let Some(index) = attributes.get("COLOR_0") else {
        return Ok(Vec::new());
    };
    let accessor = reader.accessor(&index)?;
    accessor.expect_type(&["VEC3", "VEC4"])?;
    accessor.expect_count(count, "vertices")?;
    let is_opaque = accessor.place().text("type") == "VEC3";
    let numbers = reader.floats(&accessor)?;
    if is_opaque {
        let triples = numbers.as_chunks::<3>().0.iter();
        return Ok(triples.map(|&[r, g, b]| Vec4::new(r, g, b, 1.0)).collect());
    }
    let quads = numbers.as_chunks::<4>().0.iter();
    Ok(quads.copied().map(Vec4::from_array).collect())
}

fn morphs(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    count: usize,
) -> Result<Vec<MorphTarget>, ReadError> {
    let mut morphs = Vec::new();
    for target in place.entries("targets")? {
        let mut positions = vec3s(reader, &target, "POSITION", Some(count))?;
        if positions.is_empty() {
            reader.charge(&target, count as u64 * 3)?;
            positions = vec![Vec3::ZERO; count];
        }
        morphs.push(MorphTarget {
            positions,
            normals: vec3s(reader, &target, "NORMAL", Some(count))?,
        });
    }
    Ok(morphs)
}

/// Reads the triangles of a list (mode 4), strip (5) or fan (6), indexed or not.
fn triangles(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    mode: u64,
    count: usize,
) -> Result<Vec<[u32; 3]>, ReadError> {
    let corners = match place.get("indices") {
        Some(index) => {
            let accessor = reader.accessor(&index)?;
            accessor.expect_type(&["SCALAR"])?;
            reader.integers(&accessor)?
        }
        None => {
            reader.charge(place, count as u64)?;
            let last = u32::try_from(count).map_err(|_| place.malformed("too many vertices"))?;
            (0..last).collect()
        }
    };
    if let Some(i) = corners.iter().position(|&c| c as usize >= count) {
        let what = format!(
            "index {i}: vertex {} is out of range, there are {count}",
            corners[i]
        );
        return Err(ReadError::malformed(place.path("indices"), what));
    }
    let is_whole = if mode == 4 {
        corners.len() % 3 == 0
    } else {
        corners.len() >= 3
    };
    if !is_whole {
        let what = format!(
            "{} indices are not a multiple of 3; the rest is left out",
            corners.len()
        );
        reader.notes.add(place.path("indices"), what);
    }
    if mode != 4 {
        reader.charge(place, corners.len() as u64 * 3)?;
    }
    Ok(assemble(mode, &corners))
}

/// Assembles triangles. Source: glTF 2.0, 3.7.2.1, the formulas for p_i.
fn assemble(mode: u64, corners: &[u32]) -> Vec<[u32; 3]> {
    let windows = || corners.windows(3).enumerate();
    match mode {
        5 => windows()
            .map(|(i, w)| [w[0], w[1 + i % 2], w[2 - i % 2]])
            .collect(),
        6 => windows().map(|(_, w)| [w[1], w[2], corners[0]]).collect(),
        _ => corners.as_chunks::<3>().0.to_vec(),
    }
}

/// Keeps the vertices that triangles use, in their order.
///
/// For primitives that share one vertex array: otherwise each would store, and every frame would
/// skin, the vertices of all.
pub(super) fn keep_used_vertices(primitive: &mut Primitive) {
    let mut is_used = vec![false; primitive.positions.len()];
    for corner in primitive.triangles.iter().flatten() {
        is_used[*corner as usize] = true;
    }
    let mut new = Vec::with_capacity(is_used.len());
    let mut count = 0u32;
    for used in &is_used {
        new.push(count);
        count += u32::from(*used);
    }
    for corner in primitive.triangles.iter_mut().flatten() {
        *corner = new[*corner as usize];
    }
    let n = primitive.influences;
    retain(&mut primitive.positions, &is_used, 1);
    retain(&mut primitive.normals, &is_used, 1);
    retain(&mut primitive.texcoords, &is_used, 1);
    retain(&mut primitive.colors, &is_used, 1);
    retain(&mut primitive.joints, &is_used, n);
    retain(&mut primitive.weights, &is_used, n);
    for morph in &mut primitive.morphs {
        retain(&mut morph.positions, &is_used, 1);
        retain(&mut morph.normals, &is_used, 1);
    }
}

/// Keeps the entries of used vertices, `each` entries per vertex.
fn retain<T>(list: &mut Vec<T>, is_used: &[bool], each: usize) {
    let mut i = 0;
    list.retain(|_| {
        i += 1;
        is_used[(i - 1) / each]
    });
}

/// Returns for each primitive whether it shares its positions with another.
pub(super) fn sharing(primitives: &[Place<'_>]) -> Vec<bool> {
    let mut seen = HashSet::new();
    let mut shared = HashSet::new();
    for positions in primitives.iter().map(positions_of) {
        if !seen.insert(positions) {
            shared.insert(positions);
        }
    }
    let is_shared = |place| shared.contains(&positions_of(place));
    primitives.iter().map(is_shared).collect()
}

/// Returns the accessor of a primitive's positions.
fn positions_of(primitive: &Place<'_>) -> Option<u64> {
    let positions = primitive.dig(&["attributes", "POSITION"])?;
    positions.whole().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_by_hand() {
        assert_eq!(assemble(5, &[0, 1, 2, 3]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(assemble(6, &[7, 1, 2, 3]), [[1, 2, 7], [2, 3, 7]]);
        assert_eq!(assemble(4, &[0, 1, 2, 3]), [[0, 1, 2]]);
        assert!(assemble(5, &[0, 1]).is_empty());
    }

    #[test]
    fn unused_vertices_go_with_all_they_have() {
        let mut primitive = Primitive {
            positions: (0..5).map(|i| Vec3::splat(i as f32)).collect(),
            influences: 2,
            joints: (0..10).collect(),
            weights: vec![0.5; 10],
            triangles: vec![[4, 1, 3]],
            ..Primitive::default()
        };
        keep_used_vertices(&mut primitive);
        assert_eq!(primitive.positions, [1.0, 3.0, 4.0].map(Vec3::splat));
        assert_eq!(primitive.joints, [2, 3, 6, 7, 8, 9]);
        assert_eq!(primitive.triangles, [[2, 0, 1]]);
        assert!(primitive.normals.is_empty());
    }
}
