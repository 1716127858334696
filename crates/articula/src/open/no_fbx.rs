//! FBX files, in a build without the feature `fbx`: all are refused.

use super::{CharacterFile, Input};
use crate::error::{Error, Result};

/// Refuses a file.
pub(super) fn open(_: &mut Input<'_, '_>) -> Result<CharacterFile> {
    Err(Error::needs_fbx())
}
