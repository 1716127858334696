//! BAP files: the standard humanoid in motion.

use super::{Loaded, Source};
use articula_formats::mpeg4::bap;

/// Reads a BAP file; its parameters are kept, so that they can be written back as they are.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let read = bap::read(source.bytes, source.args.absent(), &source.limits)?;
    let character = bap::character(&read.value);
    let mut loaded = source.loaded(character, read.warnings, None);
    loaded.parameters = Some(read.value);
    Ok(loaded)
}
