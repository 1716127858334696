//! Positions of skinned meshes as 16-bit integers.
//!
//! A skinned mesh ignores the transform of its node, so what makes lengths of the integers stands in the inverse bind
//! matrices, which every reader applies. All meshes of a skin, and all skins of a mesh, have one grid.
//!
//! - `groups`: meshes and skins that have one grid
//!
//! Source: KHR_mesh_quantization.

mod groups;

use super::append::{Use, entries_mut, float_bytes, object, set};
use super::compressed::moved_multiples;
use super::document::Document;
use super::extension::{CLUSTERED_MESH, FACE, PREPARED};
use super::reader::{Notes, Reader};
use crate::error::ReadError;
use crate::limits::Limits;
use glam::{Mat4, Vec3};
use groups::{Group, groups};
use serde_json::{Value, json};
use std::collections::BTreeMap;

const EXTENSION: &str = "KHR_mesh_quantization";
/// Extensions with lengths of the mesh in its own space.
const OF_MESH_SPACE: [&str; 3] = [CLUSTERED_MESH, FACE, PREPARED];
/// Outlines of MToon are as wide as a bind matrix makes normals long.
const OF_VRM: &str = "VRM";

/// The part of a step by which the rounded numbers of a bind matrix may move a point along an axis: half of it by the
/// number of the translation, half by the other three.
const BIND_PART: f32 = 0.04;

/// A group as integers.
struct Quantized {
    /// Accessors with their integers, and whether these are offsets of a morph target.
    arrays: Vec<(usize, Integers, bool)>,
    /// Inverse bind matrices of each skin.
    matrices: Vec<(usize, Vec<f32>)>,
}

/// Integers, three to an element.
struct Integers(Vec<i32>);

impl Document {
    /// Stores positions of skinned meshes as multiples of a step of their own, for each mesh, from which half of the
    /// step along each axis is the greatest distance; offsets by morph targets are rounded with them. Returns the number of
    /// meshes that were changed.
    ///
    /// Meshes that a node shows without a skin, whose arrays are not floats or need more than 16 bits, and documents of
    /// VRM or with prepared data, stay as they are.
    ///
    /// # Errors
    /// A [`ReadError`] if the document is malformed; it is then unchanged.
    pub fn quantise_positions(&mut self, steps: &[f32]) -> Result<usize, ReadError> {
        if self.has_mesh_space() {
            return Ok(0);
        }
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let mut found = Vec::new();
        let mut meshes = 0;
        for group in groups(&reader.root)? {
            if let Some(made) = quantized(&mut reader, &group, steps)? {
                meshes += group.meshes.len();
                found.push(made);
            }
        }
        if found.is_empty() {
            return Ok(0);
        }
        for made in found {
            self.put_quantized(made);
        }
        self.use_extension(EXTENSION);
        self.require_extension(EXTENSION);
        Ok(meshes)
    }

    fn has_mesh_space(&self) -> bool {
        let used = self.json.get("extensionsUsed").and_then(Value::as_array);
        let mut names = used.into_iter().flatten().filter_map(Value::as_str);
        names.any(|name| OF_MESH_SPACE.contains(&name) || name.starts_with(OF_VRM))
    }

    fn put_quantized(&mut self, made: Quantized) {
        for (accessor, Integers(numbers), is_offset) in made.arrays {
            let (component, bytes, size) = stored(&numbers, is_offset);
            let view = self.add_elements(&bytes, size);
            let accessor = &mut entries_mut(&mut self.json, "accessors")[accessor];
            for member in ["byteOffset", "sparse"] {
                object(accessor).shift_remove(member);
            }
            set(accessor, "bufferView", view);
            set(accessor, "componentType", component);
            let axis = |axis: usize| numbers.iter().skip(axis).step_by(3);
            let least: Vec<_> = (0..3).map(|i| axis(i).min()).collect();
            let most: Vec<_> = (0..3).map(|i| axis(i).max()).collect();
            set(accessor, "min", json!(least));
            set(accessor, "max", json!(most));
        }
        for (skin, numbers) in made.matrices {
            let view = self.add_view(&float_bytes(&numbers), Use::Other);
            let accessor = self.add_accessor(json!({
                "bufferView": view,
                "componentType": 5126,
                "count": numbers.len() / 16,
                "type": "MAT4",
            }));
            let skin = &mut entries_mut(&mut self.json, "skins")[skin];
            set(skin, "inverseBindMatrices", accessor);
        }
    }
}

/// Component type, bytes and size of the elements of integers: the shortest type that holds them. Offsets of morph
/// targets have types with a sign alone.
fn stored(numbers: &[i32], is_offset: bool) -> (u32, Vec<u8>, usize) {
    let least = numbers.iter().copied().min().unwrap_or(0);
    let most = numbers.iter().copied().max().unwrap_or(0);
    let (component, size) = if least >= -127 && most <= 127 {
        (5120, 1)
    } else if least >= 0 && !is_offset {
        (5123, 2)
    } else {
        (5122, 2)
    };
    let bytes = numbers
        .iter()
        .flat_map(|n| n.to_le_bytes().into_iter().take(size));
    (component, bytes.collect(), 3 * size)
}

/// A group as integers; `None` if it stays as it is.
fn quantized(
    reader: &mut Reader<'_>,
    group: &Group,
    steps: &[f32],
) -> Result<Option<Quantized>, ReadError> {
    let own = group.meshes.iter().map(|m| steps.get(*m).copied());
    let step = own.map(|s| s.unwrap_or(0.0)).fold(f32::INFINITY, f32::min);
    if group.is_refused || group.skins.is_empty() || step <= 0.0 || !step.is_finite() {
        return Ok(None);
    }
    let mut positions = BTreeMap::new();
    for accessor in &group.positions {
        let Some(read) = points(reader, *accessor)? else {
            return Ok(None);
        };
        positions.insert(*accessor, read);
    }
    let points = || positions.values().flatten();
    let origin = points().copied().fold(Vec3::INFINITY, Vec3::min);
    let most = points().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let is_short = ((most - origin) / step).max_element() < f32::from(u16::MAX) - 1.0;
    if !is_short {
        return Ok(None);
    }
    let mut arrays = Vec::new();
    let in_steps = |p: &Vec3| ((*p - origin) / step).to_array();
    for (accessor, points) in &positions {
        let numbers = points.iter().flat_map(in_steps);
        let whole = numbers.map(|x| x.round() as i32);
        arrays.push((*accessor, Integers(whole.collect()), false));
    }
    for (offset, base) in &group.offsets {
        let Some(offsets) = self::points(reader, *offset)? else {
            return Ok(None);
        };
        let base: Vec<f32> = positions[base].iter().flat_map(in_steps).collect();
        let offsets: Vec<f32> = offsets
            .iter()
            .flat_map(|p| (*p / step).to_array())
            .collect();
        let is_short = offsets.iter().all(|x| x.abs() < f32::from(i16::MAX) - 1.0);
        if base.len() != offsets.len() || !is_short {
            return Ok(None);
        }
        arrays.push((*offset, Integers(moved_multiples(&base, &offsets)), true));
    }
    let from_steps = Mat4::from_translation(origin) * Mat4::from_scale(Vec3::splat(step));
    let extent = ((most - origin) / step).element_sum().max(1.0);
    let mut matrices = Vec::new();
    for skin in &group.skins {
        let Some(folded) = folded(reader, *skin, from_steps, extent)? else {
            return Ok(None);
        };
        matrices.push((*skin, folded));
    }
    Ok(Some(Quantized { arrays, matrices }))
}

/// The points of an accessor of floats.
fn points(reader: &mut Reader<'_>, accessor: usize) -> Result<Option<Vec<Vec3>>, ReadError> {
    let Some(place) = reader.root.entry("accessors", accessor) else {
        return Ok(None);
    };
    let accessor = reader.accessor_at(place)?;
    if !accessor.is_float() || accessor.width() != 3 || accessor.count == 0 {
        return Ok(None);
    }
    let floats = reader.floats(&accessor)?;
    let points = floats.as_chunks::<3>().0.iter();
    Ok(Some(points.map(|p| Vec3::from_array(*p)).collect()))
}

/// The inverse bind matrices of a skin, after a matrix, as exact as points with a sum of coordinates of `extent` ask.
fn folded(
    reader: &mut Reader<'_>,
    skin: usize,
    first: Mat4,
    extent: f32,
) -> Result<Option<Vec<f32>>, ReadError> {
    let Some(skin) = reader.root.entry("skins", skin) else {
        return Ok(None);
    };
    let joints = skin.entries("joints")?.len();
    let read = match skin.get("inverseBindMatrices") {
        Some(place) => {
            let accessor = reader.accessor(&place)?;
            accessor.expect_type(&["MAT4"])?;
            reader.floats(&accessor)?
        }
        None => Mat4::IDENTITY.to_cols_array().repeat(joints),
    };
    let matrices = read.as_chunks::<16>().0.iter();
    let made = matrices.flat_map(|m| rounded(Mat4::from_cols_array(m) * first, extent));
    Ok(Some(made.collect()))
}

/// A bind matrix of points in steps, in numbers of few bits, by which a point moves no more than [`BIND_PART`] of a step
/// along an axis.
fn rounded(matrix: Mat4, extent: f32) -> [f32; 16] {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let step = axes.iter().map(|axis| axis.length()).fold(0.0, f32::max);
    let multiple = |x: f32, of: f32| {
        let power = of.max(f32::MIN_POSITIVE).log2().floor().exp2();
        let rounded = (x / power).round() * power;
        if rounded.is_finite() { rounded } else { x }
    };
    let numbers = matrix.to_cols_array();
    std::array::from_fn(|i| match i {
        3 | 7 | 11 | 15 => numbers[i],
        12.. => multiple(numbers[i], BIND_PART * step),
        _ => multiple(numbers[i], BIND_PART * step / extent),
    })
}

#[cfg(test)]
mod tests {
    use super::super::append::index;
    use super::*;
    use crate::gltf::read;
    use articula_core::Transform;
    use articula_core::source::{
        Character, Joint, MorphTarget, Primitive, RawMesh, Skeleton, Skin,
    };
    use glam::{Affine3A, Quat, Vec3Swizzles};
    use proptest::prelude::*;

    #[test]
    fn offsets_have_types_with_a_sign() {
        assert_eq!(stored(&[0, 300, 40], false).0, 5123);
        assert_eq!(stored(&[0, 300, 40], true).0, 5122);
        assert_eq!(stored(&[0, 100, 40], true).0, 5120);
    }

    /// Two meshes of one skin with a bind matrix that turns, scales and moves; the first has a morph target.
    fn character(points: &[Vec3]) -> Character {
        let joint = |name: &str, parent| Joint {
            name: name.into(),
            parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let bind = Affine3A::from_scale_rotation_translation(
            Vec3::splat(2.0),
            Quat::from_rotation_y(0.7),
            Vec3::new(0.3, -4.0, 0.1),
        );
        let mesh = |name: &str, points: &[Vec3], morphs: Vec<MorphTarget>| RawMesh {
            name: name.into(),
            skin: Skin {
                joints: vec![0, 1],
                inverse_bind: vec![bind, Affine3A::IDENTITY],
            },
            morph_names: morphs.iter().map(|_| "smile".into()).collect(),
            morph_weights: vec![0.0; morphs.len()],
            primitives: vec![Primitive {
                positions: points.to_vec(),
                influences: 1,
                joints: (0..points.len()).map(|i| (i % 2) as u16).collect(),
                weights: vec![1.0; points.len()],
                triangles: vec![[0, 1, 2]],
                morphs,
                ..Primitive::default()
            }],
            ..RawMesh::default()
        };
        let smile = MorphTarget {
            positions: points.iter().map(|p| 0.1 * p.zxy()).collect(),
            ..MorphTarget::default()
        };
        Character {
            skeleton: Skeleton {
                joints: vec![joint("hips", None), joint("spine", Some(0))],
            },
            meshes: vec![
                mesh("a", points, vec![smile]),
                mesh("b", &points[..3], Vec::new()),
            ],
            ..Character::default()
        }
    }

    /// Each vertex at rest, and with its morph target, in the space of its joint.
    fn posed(character: &Character) -> Vec<Vec3> {
        let of_mesh = |mesh: &RawMesh| {
            let part = mesh.primitives[0].clone();
            let binds = mesh.skin.inverse_bind.clone();
            let place =
                move |v: usize, p: Vec3| binds[usize::from(part.joints[v])].transform_point3(p);
            let part = &mesh.primitives[0];
            let rest = part.positions.iter().enumerate().map(|(v, p)| place(v, *p));
            let mut out: Vec<Vec3> = rest.collect();
            for morph in &part.morphs {
                let moved = part.positions.iter().zip(&morph.positions).enumerate();
                out.extend(moved.map(|(v, (p, offset))| place(v, *p + *offset)));
            }
            out
        };
        character.meshes.iter().flat_map(of_mesh).collect()
    }

    fn read_back(document: &Document) -> (Character, Document) {
        let glb = document.write_glb().unwrap();
        let mut none = |_: &str| Err("none".to_owned());
        let file = read(&glb, &Limits::default(), &mut none).unwrap().value;
        (file.character, file.document)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn vertices_stay_within_half_a_step_of_each_axis(
            numbers in prop::collection::vec(prop::array::uniform3(-3.0f32..3.0), 3..40),
            step in 0.000_5f32..0.05,
        ) {
            let points: Vec<Vec3> = numbers.into_iter().map(Vec3::from_array).collect();
            let source = character(&points);
            let mut document = Document::from_character(&source).unwrap();
            let before = posed(&read_back(&document).0);
            prop_assert_eq!(document.quantise_positions(&[step, 2.0 * step]).unwrap(), 2);
            let (after, document) = read_back(&document);
            prop_assert_eq!(&document.json["extensionsRequired"], &json!([EXTENSION]));
            // The first joint makes lengths twice as long; bind matrices are rounded to a part of a step.
            let most = 2.0 * step * (0.5 * 3.0f32.sqrt() + 3.0 * BIND_PART);
            for (a, b) in before.iter().zip(posed(&after)) {
                prop_assert!(a.distance(b) <= most, "{a} {b}");
            }
            let whole = |p: &Vec3| p.fract() == Vec3::ZERO && p.min_element() >= 0.0;
            prop_assert!(after.meshes.iter().all(|m| m.primitives[0].positions.iter().all(whole)));
        }
    }

    #[test]
    fn what_has_no_bind_matrices_or_needs_more_bits_stays() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let made = || Document::from_character(&character(&points)).unwrap();
        let stays = |mut document: Document, step: f32| {
            let before = document.clone();
            assert_eq!(document.quantise_positions(&[step; 2]).unwrap(), 0);
            assert_eq!(document, before);
        };
        stays(made(), 1e-5);
        stays(made(), 0.0);
        // One of its meshes is shown by a node without the skin that both have.
        let mut bare = made();
        for node in entries_mut(&mut bare.json, "nodes") {
            if index(node, "mesh") == Some(1) {
                object(node).shift_remove("skin");
            }
        }
        let changed = bare.quantise_positions(&[0.1; 2]).unwrap();
        assert_eq!(changed, 1);
        let mut vrm = made();
        vrm.use_extension("VRMC_vrm");
        stays(vrm, 0.1);
        let mut without = made();
        object(&mut without.json).shift_remove("skins");
        for node in entries_mut(&mut without.json, "nodes") {
            object(node).shift_remove("skin");
        }
        stays(without, 0.1);
    }
}
