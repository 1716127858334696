//! BAP files: the standard humanoid in motion.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_formats::mpeg4::bap;

/// Reads a BAP file; its parameters are kept, so that they can be written back as they are.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let options = input.options;
    let read = bap::read(input.bytes, options.absent, &options.limits)?;
    let character = bap::character(&read.value);
    let mut opened = input.opened(character, read.warnings, None);
    opened.parameters = Some(read.value);
    Ok(opened)
}
