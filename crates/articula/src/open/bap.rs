//! BAP files: motion of the standard MPEG-4 body.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_formats::mpeg4::bap;

/// Reads a BAP file and keeps its parameters, so that they can be written back unchanged.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let options = input.options;
    let read = bap::read(input.bytes, options.absent, &options.limits)?;
    let character = bap::character(&read.value);
    let mut opened = input.opened(character, read.warnings, None);
    opened.parameters = Some(read.value);
    opened.scale_lengths(options.unit_metres);
    Ok(opened)
}
