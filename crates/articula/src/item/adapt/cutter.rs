//! How streams are cut: by their unit trees, or by their descriptions and a program that transforms
//! these.

use super::selected::selection;
use crate::clip_streams::unit_tree;
use crate::error::{Context as _, Error, Result};
use crate::item::part::ItemPart;
use articula_stream::description::{GbsdOptions, Holes, gbsd_to_bin, write_gbsd};
use articula_stream::{DescriptionLimits, IndexedCut, StreamLimits, read_index, write_index};

/// Transforms a description (gBSD) by the stylesheet of the item with these parameters; returns the
/// new description, or what went wrong.
pub type Transform<'a> = dyn FnMut(&str, &[(&'static str, String)]) -> Result<String, String> + 'a;

/// Cuts the stream of a part by its description.
pub(super) fn by_description(
    part: &ItemPart,
    kept: &[bool],
    (stream, index): (&[u8], &[u8]),
    transform: &mut Transform<'_>,
) -> Result<IndexedCut> {
    let options = GbsdOptions {
        bitstream: part.file.clone(),
    };
    let unit = read_index(index).context("unit index")?;
    unit.check_values(stream).context("unit index")?;
    let description = write_gbsd(&unit, &options)?;
    let parameters = selection(part, kept)?.parameters();
    let adapted = transform(&description, &parameters).map_err(Error::unsuited)?;
    let limits = DescriptionLimits::default();
    let bytes = gbsd_to_bin(adapted.as_bytes(), stream, Holes::Skip, &limits)?;
    let unit = unit_tree(&bytes, &StreamLimits::default())?;
    Ok(IndexedCut {
        index: write_index(&unit),
        bytes,
    })
}
