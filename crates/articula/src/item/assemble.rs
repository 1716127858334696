//! From an item to a character.

use super::decoded_mesh::decoded;
use super::files::Item;
use super::part::PartKind;
use super::shown::{Shown, ShownFigure};
use crate::clip_streams::abp2::decode;
use crate::clip_streams::{StreamKind, afp1, afp2, stream_limits};
use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, OpenOptions};
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::FaceReadOptions;
use articula_stream::mesh::Receiver;

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
    let figure = ShownFigure::read(file(figure_file)?, manifest, options)?;
    let limits = stream_limits(&options.limits);
    let of_kind = |kind: PartKind| manifest.parts.iter().filter(move |part| part.kind == kind);

    let mut shown = Shown::default();
    for name in of_kind(PartKind::Mesh).filter_map(|part| part.file.as_ref()) {
        let received = Receiver::read(file(name)?, &limits).context(name)?;
        let made = decoded(&received, &figure.character.meshes, &limits).context(name)?;
        shown.primitives.extend(made.primitives);
    }
    for part in of_kind(PartKind::Texture) {
        if let (Some(image), Some((name, _))) = (part.image, part.largest(|_| true)) {
            shown.pictures.push((image, file(name)?));
        }
    }
    for part in of_kind(PartKind::BodyMotion) {
        let Some(name) = &part.file else { continue };
        let clip = decode(file(name)?, &figure.rig, figure_file, &options.limits).context(name)?;
        shown.clips.push(clip);
    }
    for part in of_kind(PartKind::FaceMotion) {
        let Some(name) = &part.file else { continue };
        let clip = faps(file(name)?, &limits).context(name)?;
        shown.faces.push((name, clip));
    }
    figure.with(&shown, options)
}

/// The parameters of a face stream.
pub(super) fn faps(bytes: &[u8], limits: &articula_stream::StreamLimits) -> Result<FapClip> {
    let options = FaceReadOptions::default();
    match StreamKind::of(bytes) {
        Some(StreamKind::Afp1) => afp1::read(bytes, &options, limits),
        Some(StreamKind::Afp2) => afp2::read(bytes, &options, limits),
        _ => Err(Error::unsuited(
            "the file does not begin as a face stream does, with AFPF or AFP2",
        )),
    }
}
