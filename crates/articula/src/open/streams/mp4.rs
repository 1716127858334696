//! MP4 files: the first stream of a body in them.

use super::abp;
use crate::clip_streams::mp4;
use crate::error::{Error, Result};
use crate::open::data_format::NO_JOINTS;
use crate::open::{CharacterFile, Input};

/// Reads the first stream of a body as if it were the file.
pub(in crate::open) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let limits = &input.options.limits;
    let Some(stream) = mp4::take(input.bytes, limits, |kind| !kind.is_of_face())? else {
        return Err(Error::unsuited(NO_JOINTS));
    };
    let mut inner = Input {
        bytes: &stream.bytes,
        name: input.name,
        format: input.format,
        options: input.options,
        joint_maps: input.joint_maps,
        beside: &mut *input.beside,
    };
    let opened = abp::open(&mut inner)?;
    Ok(opened.found_in(input.format, input.bytes.len(), stream.warnings()))
}
