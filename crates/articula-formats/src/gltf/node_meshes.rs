//! Meshes of nodes: the primitives of a node's mesh, and its skin.
//!
//! Source: glTF 2.0, 3.7.

use super::place::Place;
use super::primitive;
use super::reader::Reader;
use super::skeleton::Skeletal;
use super::skin::NodeSkin;
use super::texcoord::Texcoords;
use crate::error::ReadError;
use articula_core::source::{Primitive, RawMesh, Skin};
use glam::Affine3A;

/// The meshes and the nodes that show them.
#[derive(Debug, Default)]
pub(super) struct NodeMeshes {
    pub(super) meshes: Vec<RawMesh>,
    pub(super) node_of_mesh: Vec<usize>,
}

/// Data shared by all meshes that are read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) skeletal: &'a Skeletal,
    pub(super) skins: &'a [NodeSkin],
    /// Texture coordinates that each material uses.
    pub(super) texcoords: &'a [Texcoords],
}

/// Reads the mesh of a node and its primitives.
pub(super) fn read_parts<'a>(
    reader: &mut Reader<'a>,
    node: &Place<'a>,
    given: &Given<'_>,
) -> Result<(Place<'a>, Vec<Primitive>), ReadError> {
    let place = reader.root.entry_of("meshes", node, "mesh")?;
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

/// Returns the skin as joints; without one, the node itself is the only joint.
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
    let lost = || ReadError::malformed(at.as_str(), "a joint of the skin is not a node");
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
    let shares = primitive::sharing(&places);
    for (place, shares) in places.into_iter().zip(shares) {
        reader.charge(&place, 0)?;
        let Some(mut primitive) = primitive::read(reader, &place, joint_count, texcoords)? else {
            continue;
        };
        let morphs = out
            .first()
            .map_or(primitive.morphs.len(), |p| p.morphs.len());
        if primitive.morphs.len() != morphs {
            let found = primitive.morphs.len();
            let what = format!("{found} morph targets, but the previous primitive has {morphs}");
            return Err(place.malformed(what));
        }
        if shares {
            primitive::keep_used_vertices(&mut primitive);
        }
        out.push(primitive);
    }
    Ok(out)
}
