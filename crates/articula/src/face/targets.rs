//! New morph targets of a head, from displacements of its vertices.

use super::surface::HeadSurface;
use crate::error::{Error, Result};
use crate::open::CharacterFile;
use articula_build::face::normal_offsets;
use articula_core::source::{Character, MorphTarget, Primitive, Property, RawClip, RawMesh, Skin};
use glam::{Affine3A, Quat, Vec3};

/// Whether meshes that have morph targets get more of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Existing {
    /// They are refused.
    Refused,
    /// They keep their own, and the new ones follow.
    Kept,
}

/// Adds morph targets, each with the displacement of every vertex of a head in its own frame; returns
/// the number of vertices that any of them moves. `vertices` are those of the head in the meshes of the
/// character. Clips keep what they show.
///
/// # Errors
/// [`Error::Unsupported`] if a mesh that moves has morph targets and these are refused; the character
/// is then unchanged.
pub(super) fn add_targets(
    opened: &mut CharacterFile,
    (head, vertices): (&HeadSurface, &[u32]),
    shapes: &[(String, Vec<Vec3>)],
    existing: Existing,
) -> Result<usize> {
    let mut moves = vec![false; head.vertices.len()];
    for (_, offsets) in shapes {
        for (moves, offset) in moves.iter_mut().zip(offsets) {
            *moves |= *offset != Vec3::ZERO;
        }
    }
    let mut meshes = opened.character().meshes.clone();
    let places = places_of(&meshes);
    let rest = opened.character().skeleton.model_rest();
    let mut touched = vec![false; meshes.len()];
    for (vertex, _) in vertices.iter().zip(&moves).filter(|(_, m)| **m) {
        touched[places[*vertex as usize].0] = true;
    }
    let before: Vec<usize> = meshes.iter().map(|m| m.morph_names.len()).collect();
    let of_touched = || (0..before.len()).filter(|m| touched[*m]);
    if existing == Existing::Refused
        && let Some(mesh) = of_touched().find(|m| before[*m] > 0)
    {
        let what = format!(
            "face: mesh \"{}\" has morph targets that show blend shapes; these are made for faces without any",
            meshes[mesh].name
        );
        return Err(Error::unsuited(what));
    }
    for mesh in of_touched() {
        add_empty(&mut meshes[mesh], shapes.iter().map(|(name, _)| name));
    }
    let moved = vertices.iter().enumerate().filter(|(i, _)| moves[*i]);
    let moved = moved.map(|(index, vertex)| {
        let (m, primitive, v) = places[*vertex as usize];
        let skin = skin_rotation(&meshes[m].skin, &meshes[m].primitives[primitive], v, &rest);
        let turn = skin.rotation.inverse() * head.model_from_head;
        (index, (m, primitive, v), turn, skin.scale)
    });
    let moved: Vec<_> = moved.collect();
    for (shape, (_, offsets)) in shapes.iter().enumerate() {
        let normals = normal_offsets(&head.surface, offsets);
        for (index, (m, primitive, v), turn, scale) in &moved {
            let target = &mut meshes[*m].primitives[*primitive].morphs[before[*m] + shape];
            target.positions[*v] = *turn * offsets[*index] / *scale;
            target.normals[*v] = *turn * normals[*index];
        }
    }
    let added: Vec<(usize, usize)> = of_touched().map(|m| (m, before[m])).collect();
    put(opened, meshes, &added, shapes.len())?;
    Ok(moves.iter().filter(|m| **m).count())
}

/// Mesh, primitive and vertex of each vertex of a figure.
fn places_of(meshes: &[RawMesh]) -> Vec<(usize, usize, usize)> {
    let mut places = Vec::new();
    for (m, mesh) in meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            places.extend((0..primitive.positions.len()).map(|v| (m, p, v)));
        }
    }
    places
}

/// Gives a mesh further morph targets that move nothing.
fn add_empty<'a>(mesh: &mut RawMesh, names: impl Iterator<Item = &'a String>) {
    mesh.morph_names.extend(names.cloned());
    let all = mesh.morph_names.len();
    mesh.morph_weights.resize(all, 0.0);
    for primitive in &mut mesh.primitives {
        let count = primitive.positions.len();
        let target = MorphTarget {
            positions: vec![Vec3::ZERO; count],
            normals: vec![Vec3::ZERO; count],
        };
        primitive.morphs.resize(all, target);
    }
}

/// Rotation and uniform scale from mesh space to model space.
struct SkinTurn {
    rotation: Quat,
    scale: f32,
}

/// How the joints at rest place a vertex.
fn skin_rotation(skin: &Skin, primitive: &Primitive, vertex: usize, rest: &[Affine3A]) -> SkinTurn {
    let range = vertex * primitive.influences..(vertex + 1) * primitive.influences;
    let influences = primitive.joints[range.clone()]
        .iter()
        .zip(&primitive.weights[range]);
    let heaviest = influences.max_by(|a, b| a.1.total_cmp(b.1));
    let joint = heaviest.map_or(0, |(joint, _)| usize::from(*joint));
    let matrix = match (skin.joints.get(joint), skin.inverse_bind.get(joint)) {
        (Some(joint), Some(bind)) => rest[*joint] * *bind,
        _ => Affine3A::IDENTITY,
    };
    let (scale, rotation, _) = matrix.to_scale_rotation_translation();
    SkinTurn {
        rotation,
        scale: (scale.element_sum() / 3.0).max(1e-9),
    }
}

/// Stores the meshes in the character and in the document behind it. `added` are those with new morph
/// targets, and how many they had.
fn put(
    opened: &mut CharacterFile,
    meshes: Vec<RawMesh>,
    added: &[(usize, usize)],
    count: usize,
) -> Result<()> {
    let mut gltf = opened.gltf().cloned();
    if let Some(behind) = &mut gltf {
        for (mesh, _) in added {
            let (node, mesh) = (behind.node_of_mesh[*mesh], &meshes[*mesh]);
            behind.document.add_morph_targets(node, mesh)?;
        }
    }
    let mut character = Character {
        meshes,
        ..opened.character().clone()
    };
    for clip in &mut character.clips {
        for (mesh, before) in added {
            extend(clip, *mesh, *before, count);
        }
    }
    opened.set_meshes(character, gltf);
    Ok(())
}

/// Lets a clip that drives morph targets of a mesh leave the new ones at 0.
fn extend(clip: &mut RawClip, mesh: usize, before: usize, count: usize) {
    let channels = clip.channels.iter_mut();
    let of_mesh = channels.filter(|c| c.property == Property::Weights && c.target == mesh);
    for channel in of_mesh.filter(|_| before > 0) {
        // Tangents of splines are as wide as values.
        let mut values = Vec::with_capacity(channel.values.len() / before * (before + count));
        for weights in channel.values.chunks(before) {
            values.extend_from_slice(weights);
            values.extend(std::iter::repeat_n(0.0, count));
        }
        channel.values = values;
    }
}
