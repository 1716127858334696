//! Meshes of nodes: skinned, or rigidly attached to a joint.
//!
//! Source: glTF 2.0, 3.7. A mesh used by two nodes becomes two meshes.

use super::clustered;
use super::lod::{self, Lods};
use super::node_meshes::{Given, NodeMeshes, joint_skin, read_parts, skin_of};
use super::place::Place;
use super::reader::Reader;
use super::skeleton::node_place;
use crate::error::ReadError;
use articula_core::source::RawMesh;

/// Reads a mesh for each node that shows one, in the order of the nodes; coarser levels belong to
/// the mesh that they replace.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    given: &Given<'_>,
    lods: &Lods,
) -> Result<NodeMeshes, ReadError> {
    let mut shown = NodeMeshes::default();
    for n in 0..given.skeletal.joint_of_node.len() {
        let node = node_place(reader, n)?;
        if node.get("mesh").is_none() || lods.is_coarser[n] {
            continue;
        }
        if !given.skeletal.in_scene[n] {
            reader.warn(&node, "the node is in no scene; its mesh is left out");
            continue;
        }
        let (place, primitives) = read_parts(reader, &node, given)?;
        if primitives.is_empty() {
            reader.warn(&node, "the mesh has no triangles; left out");
            continue;
        }
        let mut mesh = RawMesh {
            name: mesh_name(&node, &place),
            skin: joint_skin(reader, n, skin_of(&node, given)?, given.skeletal)?,
            clustered: clustered::read_parts(reader, &place, &primitives),
            primitives,
            ..RawMesh::default()
        };
        describe_morphs(reader, &node, &place, &mut mesh)?;
        shown.meshes.push(mesh);
        shown.node_of_mesh.push(n);
    }
    lod::attach(reader, given, lods, &mut shown)?;
    Ok(shown)
}

fn mesh_name(node: &Place<'_>, mesh: &Place<'_>) -> String {
    let name = match node.text("name") {
        "" => mesh.text("name"),
        name => name,
    };
    name.to_owned()
}

/// Reads names and rest weights of the morph targets. By convention, names are in the mesh's
/// extras, in VRM 0.x in those of its primitives.
fn describe_morphs(
    reader: &mut Reader<'_>,
    node: &Place<'_>,
    place: &Place<'_>,
    mesh: &mut RawMesh,
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
        let what = format!("{found} weights for {count} morph targets; truncated or filled with 0");
        reader.notes.add(owner.path("weights"), what);
    }
    mesh.morph_weights.resize(count, 0.0);
    Ok(())
}
