//! Files of formats other than glTF, in a build without the feature `formats`: all are refused.

use super::{CharacterFile, Input};
use crate::error::{Error, Result};

pub(super) use self::{open as open_motion, open as open_skeleton};

/// Refuses a file.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    Err(Error::needs_formats(input.format.name()))
}
