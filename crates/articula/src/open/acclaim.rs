//! Acclaim files: a skeleton (`.asf`), or a motion (`.amc`) with its skeleton.

use super::{CharacterFile, Input};
use crate::error::{Error, Result};
use articula_formats::{ReadOptions, acclaim};

/// Reads a skeleton without motion.
pub(super) fn open_skeleton(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    read(input, input.bytes, None)
}

/// Reads a motion and its skeleton.
pub(super) fn open_motion(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let Some(skeleton) = &input.options.skeleton else {
        let what = "the motion needs its skeleton; give the .asf file that belongs to it";
        return Err(Error::Skeleton(what.into()));
    };
    read(input, skeleton, Some(input.bytes))
}

fn read(input: &Input<'_, '_>, asf: &[u8], amc: Option<&[u8]>) -> Result<CharacterFile> {
    let options = ReadOptions {
        scale_to_metres: input.options.unit_metres,
        up: input.options.up,
        rate_hz: input.options.amc_rate_hz,
    };
    let read = acclaim::read(asf, amc, &options, &input.options.limits)?;
    let mut opened = input.opened(read.value.character, read.warnings, None);
    opened.end_sites = read.value.end_sites;
    Ok(opened)
}
