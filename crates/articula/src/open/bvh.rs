//! BVH files.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_formats::{ReadOptions, bvh};

/// Reads a BVH file; unit and up axis are taken from the options or estimated.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let options = ReadOptions {
        scale_to_metres: input.options.unit_metres,
        up: input.options.up,
        ..ReadOptions::default()
    };
    let read = bvh::read(input.bytes, &options, &input.options.limits)?;
    let mut opened = input.opened(read.value.character, read.warnings, None);
    opened.end_sites = read.value.end_sites;
    Ok(opened)
}
