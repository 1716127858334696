//! Files that hold streams, in a build without the feature `streams`: all are refused.

use super::{CharacterFile, DataFormat, Input};
use crate::error::{Error, Result};
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::{Limits, Warning};

pub(super) use self::{open as open_mp4, open as open_text};

/// Refuses the stream of a motion of a body, in any of its formats.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    Err(Error::needs_streams(input.format.name()))
}

/// Refuses the stream of a face.
pub(super) fn open_face(
    _bytes: &[u8],
    _name: &str,
    format: DataFormat,
    _limits: &Limits,
) -> Result<(FapClip, Vec<Warning>)> {
    Err(Error::needs_streams(format.name()))
}
