//! From an item to a character.

use super::decoded_mesh::decoded;
use super::figure;
use super::files::Item;
use super::part::{ItemPart, PartKind};
use crate::clip_streams::abp2::{decode, raw_clip};
use crate::clip_streams::{StreamKind, afp1, afp2, stream_limits};
use crate::error::{Context, Error, Result};
use crate::face::fit_face;
use crate::open::{CharacterFile, OpenOptions, open};
use articula_core::Rig;
use articula_core::source::{Primitive, RawClip};
use articula_formats::gltf::MeshGeometry;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::FaceReadOptions;
use std::collections::BTreeMap;

/// Assembles the character of an item, whole or cut: the meshes at the finest level that is there,
/// textures at their largest size, all motions of the body as clips, and all motions of the face as
/// clips of this face.
///
/// What the item lacks stays as the figure has it: a mesh without triangles, a picture of one pixel.
///
/// # Errors
/// An [`Error`] that names the file in the item: malformed bytes, a stream of another character, or
/// more than the limits allow.
pub fn assemble(item: &Item, options: &OpenOptions) -> Result<CharacterFile> {
    let manifest = &item.manifest;
    let file = |name: &str| {
        let missing = || Error::unsuited("the item lacks this file");
        item.file(name).ok_or_else(missing).context(name)
    };
    let figure_file = &manifest.figure.file;
    let glb = file(figure_file)?;
    let (character, mut gltf) = figure::read(glb, &options.limits).context(figure_file)?;
    let limits = stream_limits(&options.limits);
    let of_kind = |kind: PartKind| manifest.parts.iter().filter(move |part| part.kind == kind);

    let mut primitives: BTreeMap<(usize, usize), Primitive> = BTreeMap::new();
    for name in of_kind(PartKind::Mesh).filter_map(|part| part.file.as_ref()) {
        let made = decoded(file(name)?, &character.meshes, &limits).context(name)?;
        primitives.extend(made.primitives);
    }
    let parts = |m: usize| -> Vec<&Primitive> {
        let own = character.meshes[m].primitives.iter().enumerate();
        // A coarse level may have nothing of a primitive: it stays as it is in the figure.
        let shown = |p| {
            primitives
                .get(&(m, p))
                .filter(|made| !made.triangles.is_empty())
        };
        own.map(|(p, own)| shown(p).unwrap_or(own)).collect()
    };
    let meshes = (0..character.meshes.len()).filter(|m| {
        let first = primitives.range((*m, 0)..).next();
        first.is_some_and(|((mesh, _), _)| mesh == m)
    });
    let geometry: Vec<MeshGeometry<'_>> = meshes
        .map(|m| MeshGeometry {
            node: gltf.node_of_mesh[m],
            parts: parts(m),
        })
        .collect();
    gltf.document.set_geometry(&geometry).context(figure_file)?;

    let mut pictures = Vec::new();
    for part in of_kind(PartKind::Texture) {
        // The largest comes last.
        if let (Some(image), Some(name)) = (part.image, largest(part)) {
            pictures.push((image, file(name)?));
        }
    }
    gltf.document.set_pictures(&pictures).context("textures")?;

    let rig = Rig::new(
        &character.skeleton,
        articulation(&character, &manifest.name, glb, options)?,
    )?;
    let mut clips: Vec<RawClip> = Vec::new();
    for part in of_kind(PartKind::BodyMotion) {
        let Some(name) = &part.file else { continue };
        let clip = decode(file(name)?, &rig, figure_file, &options.limits).context(name)?;
        clips.push(raw_clip(&clip, &character.meshes));
    }
    gltf.document
        .replace_clips(&clips, &gltf.node_of_joint, &gltf.node_of_mesh)
        .context(figure_file)?;
    let glb = gltf.document.write_glb().context(figure_file)?;
    let mut nothing = |_: &str| Err("a figure holds all its data".to_owned());
    let mut opened = open(
        &glb,
        &format!("{}.glb", manifest.name),
        options,
        &mut nothing,
    )?;
    let mut fitted = Vec::new();
    for part in of_kind(PartKind::FaceMotion) {
        let Some(name) = &part.file else { continue };
        let clip = faps(file(name)?, &limits).context(name)?;
        fitted.push(fit_face(&clip, name, &opened).context(name)?.fitted);
    }
    if !fitted.is_empty() {
        opened.put_clips(fitted, true);
    }
    Ok(opened)
}

/// Articulation of the figure, as stored or recognised by its joints.
fn articulation(
    character: &articula_core::source::Character,
    name: &str,
    glb: &[u8],
    options: &OpenOptions,
) -> Result<articula_core::Articulation> {
    if let Some(stored) = &character.articulation {
        return Ok(stored.clone());
    }
    let mut nothing = |_: &str| Err("a figure holds all its data".to_owned());
    let opened = open(glb, &format!("{name}.glb"), options, &mut nothing)?;
    Ok(opened.articulation())
}

/// The largest file of a texture.
fn largest(part: &ItemPart) -> Option<&String> {
    let sizes = part.layers.iter().filter(|layer| layer.file.is_some());
    let largest = sizes.max_by_key(|layer| layer.size_px.map(|[w, h]| u64::from(w) * u64::from(h)));
    largest.and_then(|layer| layer.file.as_ref())
}

/// The parameters of a face stream.
fn faps(bytes: &[u8], limits: &articula_stream::StreamLimits) -> Result<FapClip> {
    let options = FaceReadOptions::default();
    match StreamKind::of(bytes) {
        Some(StreamKind::Afp1) => afp1::read(bytes, &options, limits),
        Some(StreamKind::Afp2) => afp2::read(bytes, &options, limits),
        _ => Err(Error::unsuited(
            "the file does not begin as a face stream does, with AFPF or AFP2",
        )),
    }
}
