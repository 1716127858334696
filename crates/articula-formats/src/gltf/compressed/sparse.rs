//! Offsets by morph targets that are mostly zero as sparse accessors.
//!
//! Bitstream v0 stores the kind of each 16 bytes even where all are zero, 3 bytes for 16 vertices. So an array
//! with few offsets is shorter as the places of those and their values, and more so without compression. Bitstream
//! v1 has blocks of zeros for next to nothing.

use super::super::accessor::Component;
use super::super::append::{entries_mut, object, set};
use super::Compression;
use super::array::{Array, Part};
use super::element::Elements;
use super::role::Role;
use serde_json::{Value, json};

/// Bytes of a vertex without an offset in a dense array, and of one with an offset in a sparse array, as far as they
/// decide which is shorter.
struct Bytes {
    dense: f64,
    place: f64,
}

/// In bitstream v0, as measured on faces.
const OF_V0: Bytes = Bytes {
    dense: 3.0 / 16.0,
    place: 0.45,
};
/// Of floats without compression.
const PLAIN: Bytes = Bytes {
    dense: 12.0,
    place: 16.0,
};
/// Bytes of JSON of a sparse array.
const JSON: f64 = 150.0;

/// Splits arrays of offsets that are shorter so.
pub(super) fn with_sparse(
    json: &mut Value,
    arrays: Vec<Array>,
    compression: Compression,
) -> Vec<Array> {
    let bytes = match compression {
        Compression::Ext => &OF_V0,
        Compression::Khr => return arrays,
        Compression::Quantized | Compression::None => &PLAIN,
    };
    let mut out = Vec::with_capacity(arrays.len());
    for array in arrays {
        match sparse(&array, bytes) {
            Some(parts) => {
                let accessor = &mut entries_mut(json, "accessors")[array.accessor];
                describe(accessor, &array.elements, &parts);
                out.extend(parts);
            }
            None => out.push(array),
        }
    }
    out
}

/// The places and values of an array of mostly zeros.
fn sparse(array: &Array, bytes: &Bytes) -> Option<[Array; 2]> {
    let elements = &array.elements;
    let is_float = elements.component == Component::F32 && elements.stride == 12;
    let is_offset = matches!(array.role, Role::Offsets { .. } | Role::NormalOffsets);
    if !is_offset || !is_float || !elements.is_compressible {
        return None;
    }
    // The upper byte of each of three numbers is an exponent.
    let is_zero = |element: &[u8]| {
        let numbers = element.as_chunks::<4>().0;
        numbers.iter().all(|number| number[..3] == [0; 3])
    };
    let each = elements.bytes.chunks_exact(elements.stride);
    let moved = each.enumerate().filter(|(_, element)| !is_zero(element));
    let (places, values): (Vec<u32>, Vec<&[u8]>) = moved.map(|(i, e)| (i as u32, e)).unzip();
    let saved = bytes.dense * elements.count as f64 - bytes.place * places.len() as f64;
    // The format wants at least one element.
    if places.is_empty() || saved < JSON {
        return None;
    }
    let bytes: Vec<u8> = places.iter().flat_map(|i| i.to_le_bytes()).collect();
    let of = |part, elements| Array {
        part,
        elements,
        ..*array
    };
    let indices = Elements::padded(&bytes, 4, Component::U32, false);
    let values = Elements {
        count: values.len(),
        bytes: values.concat(),
        is_bounded: false,
        ..elements.clone()
    };
    Some([of(Part::Indices, indices), of(Part::Values, values)])
}

/// The accessor of an array, without the views of its parts.
fn describe(accessor: &mut Value, elements: &Elements, parts: &[Array; 2]) {
    for member in ["bufferView", "byteOffset", "normalized", "min", "max"] {
        object(accessor).shift_remove(member);
    }
    set(accessor, "componentType", elements.component.code());
    if elements.is_bounded {
        elements.set_bounds(accessor);
    }
    let indices = json!({ "componentType": Component::U32.code() });
    let count = parts[0].elements.count;
    set(
        accessor,
        "sparse",
        json!({ "count": count, "indices": indices, "values": {} }),
    );
}

#[cfg(test)]
mod tests {
    use super::super::{ArrayPrecision, Compression, WeightPrecision};
    use crate::gltf::{Document, read};
    use crate::limits::Limits;
    use articula_core::Transform;
    use articula_core::source::{
        Character, Joint, MorphTarget, Primitive, RawMesh, Skeleton, Skin,
    };
    use glam::{Affine3A, Vec3};

    const STEP: f32 = 1.5 / 32767.0;

    /// A strip of 1501 vertices with a morph target that moves every hundredth.
    fn character() -> Character {
        let positions: Vec<Vec3> = (0..1501u16)
            .map(|i| Vec3::new(1e-3 * f32::from(i), f32::from(i % 2), 0.0))
            .collect();
        let offset = |i: usize| match i % 100 {
            50 => Vec3::new(0.01, -0.2, 1e-3 * i as f32 / 3.0),
            _ => Vec3::ZERO,
        };
        let primitive = Primitive {
            influences: 1,
            joints: vec![0; positions.len()],
            weights: vec![1.0; positions.len()],
            triangles: (0..1499).map(|i| [i, i + 1, i + 2]).collect(),
            morphs: vec![MorphTarget {
                positions: (0..positions.len()).map(offset).collect(),
                normals: Vec::new(),
            }],
            positions,
            ..Primitive::default()
        };
        let joint = Joint {
            name: "root".into(),
            parent: None,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        Character {
            skeleton: Skeleton {
                joints: vec![joint],
            },
            meshes: vec![RawMesh {
                name: "strip".into(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![primitive],
                morph_names: vec!["up".into()],
                morph_weights: vec![0.0],
                ..RawMesh::default()
            }],
            ..Character::default()
        }
    }

    #[test]
    fn few_offsets_are_sparse_or_shorts_and_move_vertices_to_their_places() {
        let character = character();
        let document = Document::from_character(&character).unwrap();
        let precision = ArrayPrecision {
            positions: vec![STEP],
            samplers: Vec::new(),
            texcoords: 0.1,
            weights: WeightPrecision::Byte,
        };
        let far = 0.5 * 3.0f32.sqrt() * STEP + 1e-6;
        for compression in [
            Compression::Ext,
            Compression::Khr,
            Compression::Quantized,
            Compression::None,
        ] {
            let glb = document.write_compressed(compression, &precision).unwrap();
            let file = read(&glb, &Limits::default(), &mut |_| Err("none".into())).unwrap();
            let json = &file.value.document.json;
            let target = &json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"];
            let accessor = &json["accessors"][target.as_u64().unwrap() as usize];
            match compression {
                Compression::Khr => assert_eq!(accessor["componentType"], 5122),
                _ => assert_eq!(accessor["sparse"]["count"], 15),
            }
            let [wanted, found] = [&character, &file.value.character]
                .map(|character| &character.meshes[0].primitives[0]);
            for v in 0..wanted.positions.len() {
                let [rest, moved] = [0.0, 1.0].map(|weight| {
                    let at = |p: &Primitive| p.positions[v] + weight * p.morphs[0].positions[v];
                    at(wanted).distance(at(found))
                });
                assert!(
                    rest <= far && moved <= far,
                    "{compression:?} {v}: {rest} {moved}"
                );
            }
        }
    }
}
