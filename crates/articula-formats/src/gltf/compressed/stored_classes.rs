//! Vertices that are equal as they are stored.

use super::super::origin::{split, split_by_bytes};
use super::super::place::Place;
use super::super::reader::Reader;
use super::element::elements;
use super::role::{Role, of_attribute};
use super::{ArrayPrecision, WeightPrecision};
use crate::error::ReadError;

/// Returns for each of the first vertices of a primitive the lowest index of one whose normals, tangents, texture
/// coordinates and colours become equal by rounding, and that is equal in every other byte. `texcoords` is the step
/// of texture coordinates.
pub(in crate::gltf) fn stored_classes<'a>(
    reader: &mut Reader<'a>,
    primitive: &Place<'a>,
    count: usize,
    texcoords: f32,
) -> Result<Vec<u32>, ReadError> {
    let precision = ArrayPrecision {
        positions: Vec::new(),
        samplers: Vec::new(),
        texcoords,
        weights: WeightPrecision::Exact,
    };
    let vertices: Vec<u32> = (0..count as u32).collect();
    let mut classes = vec![0; count];
    for (name, index) in primitive.require("attributes")?.members() {
        let role = of_attribute(name, Role::Exact);
        let is_rounded = matches!(
            role,
            Role::Normals | Role::Tangents | Role::Texcoords | Role::Colors
        );
        let place = reader.root.entry("accessors", index.whole()? as usize);
        match place.filter(|_| is_rounded) {
            Some(place) => {
                let elements = elements(reader, place, role, &precision)?;
                if elements.count < count {
                    return Err(index.malformed("fewer elements than vertices"));
                }
                let stride = elements.stride;
                split(&mut classes, |v| &elements.bytes[v * stride..][..stride]);
            }
            None => split_by_bytes(reader, &index, &vertices, &mut classes)?,
        }
    }
    for target in primitive.entries("targets")? {
        for (_, index) in target.members() {
            split_by_bytes(reader, &index, &vertices, &mut classes)?;
        }
    }
    Ok(classes)
}
