//! Meshes as nodes show them: skinned, or hung rigidly on a joint.
//!
//! Source: glTF 2.0, 3.7. Differs: one mesh shown by two nodes becomes two meshes.

use super::clustered;
use super::lod::{self, Lods};
use super::place::Place;
use super::primitive;
use super::reader::Reader;
use super::skeleton::{Skeletal, node_place};
use super::skin::NodeSkin;
use super::texcoord::Texcoords;
use crate::error::ReadError;
use articula_core::source::{Mesh, Primitive, Skin};
use glam::Affine3A;
use std::collections::HashSet;

/// The meshes and the nodes that show them.
#[derive(Debug, Default)]
pub(super) struct Shown {
    pub(super) meshes: Vec<Mesh>,
    pub(super) node_of_mesh: Vec<usize>,
}

/// What meshes are read with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) skeletal: &'a Skeletal,
    pub(super) skins: &'a [NodeSkin],
    /// Texture coordinates that each material wants.
    pub(super) texcoords: &'a [Texcoords],
}

/// Reads a mesh for each node that shows one, in the order of the nodes; those of coarser
/// levels are shown by what they stand in for.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    given: &Given<'_>,
    lods: &Lods,
) -> Result<Shown, ReadError> {
    let mut shown = Shown::default();
    for n in 0..given.skeletal.joint_of_node.len() {
        let node = node_place(reader, n)?;
        if node.get("mesh").is_none() || lods.is_coarser[n] {
            continue;
        }
        if !given.skeletal.in_scene[n] {
            reader.warn(&node, "its mesh is in no scene; left out");
            continue;
        }
        let (place, primitives) = read_parts(reader, &node, given)?;
        if primitives.is_empty() {
            reader.warn(&node, "its mesh has no triangles; left out");
            continue;
        }
        let mut mesh = Mesh {
            name: mesh_name(&node, &place),
            skin: joint_skin(reader, n, skin_of(&node, given)?, given.skeletal)?,
            clustered: clustered::read_parts(reader, &place, &primitives),
            primitives,
            ..Mesh::default()
        };
        describe_morphs(reader, &node, &place, &mut mesh)?;
        shown.meshes.push(mesh);
        shown.node_of_mesh.push(n);
    }
    lod::attach(reader, given, lods, &mut shown)?;
    Ok(shown)
}

/// The mesh that a node names, and its parts.
pub(super) fn read_parts<'a>(
    reader: &mut Reader<'a>,
    node: &Place<'a>,
    given: &Given<'_>,
) -> Result<(Place<'a>, Vec<Primitive>), ReadError> {
    let index = node.require("mesh")?;
    let i = index.index_below(reader.root.count("meshes"))?;
    let missing = || index.malformed("no such mesh");
    let place = reader.root.entry("meshes", i).ok_or_else(missing)?;
    let joint_count = skin_of(node, given)?.map(|skin| skin.joints.len());
    let primitives = read_primitives(reader, &place, joint_count, given.texcoords)?;
    Ok((place, primitives))
}

pub(super) fn skin_of<'a>(
    node: &Place<'_>,
    given: &Given<'a>,
) -> Result<Option<&'a NodeSkin>, ReadError> {
    let skin = node.index("skin", given.skins.len())?;
    Ok(skin.map(|s| &given.skins[s]))
}

fn mesh_name(node: &Place<'_>, mesh: &Place<'_>) -> String {
    let name = match node.text("name") {
        "" => mesh.text("name"),
        name => name,
    };
    name.to_owned()
}

/// The skin in terms of joints; without one, the node itself is the only joint.
pub(super) fn joint_skin(
    reader: &mut Reader<'_>,
    node: usize,
    skin: Option<&NodeSkin>,
    skeletal: &Skeletal,
) -> Result<Skin, ReadError> {
    let own = [node];
    let nodes = skin.map_or(&own[..], |skin| &skin.joints);
    let inverse_bind = skin.map_or(&[Affine3A::IDENTITY][..], |skin| &skin.inverse_bind);
    let at = format!("nodes[{node}].skin");
    reader.charge(&at, nodes.len() as u64 * 16)?;
    let lost = || ReadError::malformed(at.as_str(), "a joint of the skin is no node");
    let joints = nodes
        .iter()
        .map(|&n| skeletal.joint_of_node[n].ok_or_else(lost))
        .collect::<Result<_, _>>()?;
    Ok(Skin {
        joints,
        inverse_bind: inverse_bind.to_vec(),
    })
}

fn read_primitives(
    reader: &mut Reader<'_>,
    mesh: &Place<'_>,
    joint_count: Option<usize>,
    texcoords: &[Texcoords],
) -> Result<Vec<Primitive>, ReadError> {
    let mut out: Vec<Primitive> = Vec::new();
    let places = mesh.entries("primitives")?;
    let shares = sharing(&places);
    for (place, shares) in places.into_iter().zip(shares) {
        reader.charge(place.at(), 0)?;
        let Some(mut primitive) = primitive::read(reader, &place, joint_count, texcoords)? else {
            continue;
        };
        let morphs = out
            .first()
            .map_or(primitive.morphs.len(), |p| p.morphs.len());
        if primitive.morphs.len() != morphs {
            let found = primitive.morphs.len();
            let what = format!("{found} morph targets, but {morphs} in the primitive before");
            return Err(place.malformed(what));
        }
        if shares {
            primitive::keep_used_vertices(&mut primitive);
        }
        out.push(primitive);
    }
    Ok(out)
}

/// Whether each primitive has its positions in common with another.
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

/// Accessor of a primitive's positions.
fn positions_of(primitive: &Place<'_>) -> Option<u64> {
    let positions = primitive.dig(&["attributes", "POSITION"])?;
    positions.whole().ok()
}

/// Names and rest weights of the morph targets. Names stand in the mesh's extras by custom,
/// in those of its primitives in VRM 0.x.
fn describe_morphs(
    reader: &mut Reader<'_>,
    node: &Place<'_>,
    place: &Place<'_>,
    mesh: &mut Mesh,
) -> Result<(), ReadError> {
    let count = mesh.primitives.first().map_or(0, |p| p.morphs.len());
    let of_primitive = place.entry("primitives", 0);
    let names = [Some(place.clone()), of_primitive]
        .into_iter()
        .flatten()
        .filter_map(|owner| owner.get("extras"))
        .find(|extras| extras.count("targetNames") > 0);
    let name = |i| {
        let entry = names.as_ref()?.entry("targetNames", i)?;
        entry.value().as_str().map(str::to_owned)
    };
    mesh.morph_names = (0..count).map(|i| name(i).unwrap_or_default()).collect();
    let owner = if node.get("weights").is_some() {
        node
    } else {
        place
    };
    for weight in owner.entries("weights")? {
        mesh.morph_weights.push(weight.float()?);
    }
    let found = mesh.morph_weights.len();
    if found != 0 && found != count {
        let what = format!("{found} weights for {count} morph targets; cut or filled with 0");
        reader.notes.add(owner.path("weights"), what);
    }
    mesh.morph_weights.resize(count, 0.0);
    Ok(())
}
