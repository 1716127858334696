//! Documents about an item after MPEG-21: its declaration, the descriptions of its streams, its table
//! of decisions and the stylesheet.
//!
//! They follow from the item and are made when they are asked for. Forms: `docs/formats/did.md`,
//! `gbsd.md`, `aqos.md`.

use super::adapt::{AdaptOptions, aqos, parameters};
use super::files::Item;
use super::part::ItemPart;
use crate::error::{Context as _, Error, Result};
use articula_stream::description::{
    BsdLink, Context, Did, DidComponent, DidDescriptor, DidItem, DidResource, GbsdOptions,
    stylesheet, write_gbsd,
};

/// Name of the declaration.
pub const DID: &str = "did.xml";
/// Name of the table of decisions.
pub const AQOS: &str = "aqos.xml";
/// Name of the stylesheet.
pub const STYLESHEET: &str = "adapt.xslt";
/// Extension of descriptions of streams.
const GBSD_EXTENSION: &str = "gbsd.xml";

/// Returns the description (gBSD) of a stream of an item.
///
/// # Errors
/// An [`Error`] that names the file, and lists the streams if there is none of this name.
pub fn gbsd(item: &Item, file: &str) -> Result<String> {
    let streams = || {
        item.manifest
            .parts
            .iter()
            .filter(|part| part.file.is_some())
    };
    let found = streams().find(|part| part.file.as_deref() == Some(file));
    let Some(part) = found else {
        let known: Vec<&str> = streams().filter_map(|part| part.file.as_deref()).collect();
        let what = format!(
            "\"{file}\" is no stream of the item, which has {}",
            known.join(", ")
        );
        return Err(Error::argument(what));
    };
    let options = GbsdOptions {
        bitstream: Some(file.to_owned()),
    };
    let unit = item.unit_tree(part).context(file)?;
    Ok(write_gbsd(&unit, &options)?)
}

/// Returns the declaration (DID) of an item: a resource for each file, and for each stream what
/// adapts it.
///
/// # Errors
/// An [`Error`] that names a file whose name no declaration can hold.
pub fn declaration(item: &Item) -> Result<String> {
    let manifest = &item.manifest;
    let mut made = DidItem {
        id: None,
        items: vec![resource(
            &manifest.figure.file,
            "model/gltf-binary",
            Vec::new(),
        )?],
        ..DidItem::default()
    };
    for part in &manifest.parts {
        made.items.extend(of_part(part)?);
    }
    for form in &manifest.flat {
        made.items
            .push(resource(&form.file, "image/svg+xml", Vec::new())?);
    }
    for file in &manifest.whole {
        made.items
            .push(resource(&file.file, &file.mime, Vec::new())?);
    }
    Ok(Did { items: vec![made] }.write()?)
}

/// Returns all documents about an item with their names: declaration, table for a context that says
/// nothing, stylesheet, and the description of each stream.
///
/// # Errors
/// As [`gbsd`], [`declaration`] and [`aqos`].
pub fn documents(item: &Item) -> Result<Vec<(String, Vec<u8>)>> {
    let table = aqos(item, &Context::default(), &AdaptOptions::default())?;
    let mut made = vec![
        (DID.to_owned(), declaration(item)?.into_bytes()),
        (AQOS.to_owned(), table.write().into_bytes()),
        (STYLESHEET.to_owned(), stylesheet().into_bytes()),
    ];
    for file in item.manifest.parts.iter().filter_map(|p| p.file.as_deref()) {
        made.push((description_of(file), gbsd(item, file)?.into_bytes()));
    }
    Ok(made)
}

/// Name of the description of a stream.
fn description_of(file: &str) -> String {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    format!("{stem}.{GBSD_EXTENSION}")
}

fn resource(file: &str, mime: &str, descriptors: Vec<DidDescriptor>) -> Result<DidItem> {
    let reference = file.parse().context(file)?;
    let resource = DidResource {
        mime_type: mime.to_owned(),
        reference: Some(reference),
        text: String::new(),
    };
    Ok(DidItem {
        components: vec![DidComponent {
            descriptors,
            resources: vec![resource],
        }],
        ..DidItem::default()
    })
}

/// The stream of a part with its link, or the sizes of a texture.
fn of_part(part: &ItemPart) -> Result<Vec<DidItem>> {
    let Some(file) = &part.file else {
        let sizes = part.layers.iter().filter_map(|layer| layer.file.as_deref());
        let mime = |file: &str| match file.rsplit_once('.') {
            Some((_, "jpg")) => "image/jpeg",
            Some((_, "webp")) => "image/webp",
            _ => "image/png",
        };
        return sizes
            .map(|file| resource(file, mime(file), Vec::new()))
            .collect();
    };
    let link = BsdLink {
        steering: Some(AQOS.parse()?),
        description: description_of(file).parse().context(file)?,
        transformation: Some(STYLESHEET.parse()?),
        parameters: parameters(),
    };
    let link = vec![DidDescriptor::BsdLink(link)];
    Ok(vec![resource(file, "application/octet-stream", link)?])
}
