//! The figure of an item: the character without geometry, clips and large pictures.

use super::part::PIXEL;
use crate::error::Result;
use crate::open::GltfSource;
use articula_core::Articulation;
use articula_core::source::{
    Channel, Character, Image, Interpolation, Primitive, Property, RawClip, RawMesh, Skeleton,
};
use articula_flat::{Averaging, Picture, PictureError};
use articula_formats::Limits;
use articula_formats::gltf::{self, MeshGeometry, placeholder};
use glam::{Vec2, Vec3, Vec4};

/// Name of the clip that keeps joints which only clips move.
pub(super) const REST: &str = "rest";

/// A figure, and what it lost.
pub(super) struct StrippedFigure {
    /// The GLB.
    pub(super) glb: Vec<u8>,
    /// For each picture of the character, whether a single pixel stands for it.
    pub(super) is_replaced: Vec<bool>,
    /// Whether each picture holds colours.
    pub(super) holds_colors: Vec<bool>,
    /// Descriptions of what is left out.
    pub(super) left_out: Vec<String>,
}

/// Makes the figure of a character with its document.
///
/// Each primitive becomes one triangle without an area, each picture that can be decoded one pixel
/// of its mean colour. Joints that only clips move are kept by a clip of one key at rest.
pub(super) fn stripped(
    character: &Character,
    meshes: &[RawMesh],
    mut gltf: GltfSource,
    articulation: &Articulation,
) -> Result<StrippedFigure> {
    let document = &mut gltf.document;
    document.remove_motion_tables();
    let clips: Vec<RawClip> = rest_clip(character).into_iter().collect();
    document.replace_clips(&clips, &gltf.node_of_joint, &gltf.node_of_mesh)?;
    let empty: Vec<Vec<_>> = meshes.iter().map(|mesh| stand_ins(mesh, meshes)).collect();
    let geometry: Vec<MeshGeometry<'_>> = empty
        .iter()
        .zip(&gltf.node_of_mesh)
        .map(|(parts, node)| MeshGeometry {
            node: *node,
            parts: parts.iter().collect(),
        })
        .collect();
    document.set_geometry(&geometry)?;
    let holds_colors = document.pictures_of_colors();
    let mut left_out = document.set_plain_textures();
    let mut pixels = Vec::with_capacity(character.images.len());
    for (i, image) in character.images.iter().enumerate() {
        let averaging = averaging(holds_colors.get(i) != Some(&false));
        let pixel = pixel_of(image, averaging);
        if let Err(what) = &pixel {
            left_out.push(format!("picture {i}: not reduced: {what}"));
        }
        pixels.push(pixel.ok());
    }
    let pictures: Vec<(usize, &[u8])> = pixels
        .iter()
        .enumerate()
        .filter_map(|(i, pixel)| Some((i, pixel.as_deref()?)))
        .collect();
    document.set_pictures(&pictures)?;
    document.set_articulation(articulation, &gltf.node_of_joint)?;
    document.compact();
    Ok(StrippedFigure {
        glb: document.write_glb()?,
        is_replaced: pixels.iter().map(Option::is_some).collect(),
        holds_colors,
        left_out,
    })
}

/// What stands for the primitives of a mesh: all that it can be as for any other one, since equal arrays
/// are stored once. Meshes of one skin share the vertex, which is that of the first of them.
fn stand_ins(mesh: &RawMesh, meshes: &[RawMesh]) -> Vec<Primitive> {
    let of_skin = meshes.iter().filter(|other| other.skin == mesh.skin);
    let first = of_skin.flat_map(|other| &other.primitives).next();
    let first = first.map(placeholder).unwrap_or_default();
    let stand_in = |of: &Primitive| {
        let mut made = placeholder(of);
        made.positions.clone_from(&first.positions);
        (made.joints, made.weights) = (first.joints.clone(), first.weights.clone());
        made.influences = first.influences;
        made.normals.fill(Vec3::Z);
        made.texcoords.fill(Vec2::ZERO);
        made.colors.fill(Vec4::ONE);
        made
    };
    mesh.primitives.iter().map(stand_in).collect()
}

/// How a picture is averaged.
pub(super) fn averaging(holds_colors: bool) -> Averaging {
    if holds_colors {
        Averaging::Light
    } else {
        Averaging::Numbers
    }
}

fn pixel_of(image: &Image, averaging: Averaging) -> Result<Vec<u8>, PictureError> {
    pixel(&Picture::decode(&image.bytes)?, averaging)
}

/// The pixel that stands for a picture.
pub(super) fn pixel(picture: &Picture, averaging: Averaging) -> Result<Vec<u8>, PictureError> {
    let [width, height] = PIXEL;
    picture.resized((width, height), averaging)?.to_small_png()
}

/// A clip of one key for each joint that a reader takes for one because clips move it.
fn rest_clip(character: &Character) -> Option<RawClip> {
    let Skeleton { joints } = &character.skeleton;
    let mut is_moved = vec![false; joints.len()];
    let channels = character.clips.iter().flat_map(|clip| &clip.channels);
    for channel in channels.filter(|c| c.property.is_of_joint()) {
        if let Some(is_moved) = is_moved.get_mut(channel.target) {
            *is_moved = true;
        }
    }
    let channels = joints.iter().zip(is_moved).enumerate();
    let channels = channels.filter(|(_, (joint, is_moved))| *is_moved && !joint.in_skin);
    let channels = channels.map(|(target, (joint, _))| Channel {
        target,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0],
        values: joint.rest.rotation.to_array().to_vec(),
    });
    let channels: Vec<Channel> = channels.collect();
    (!channels.is_empty()).then(|| RawClip {
        name: REST.to_owned(),
        duration_secs: 0.0,
        channels,
    })
}

/// Reads what a figure shows: its joints and the nodes of its meshes.
pub(super) fn read(glb: &[u8], limits: &Limits) -> Result<(Character, GltfSource)> {
    let mut nothing = |_: &str| Err("a figure holds all its data".to_owned());
    let file = gltf::read(glb, limits, &mut nothing)?.value;
    Ok(GltfSource::split(file))
}
