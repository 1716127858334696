//! FBX characters and motions.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_formats::{ReadOptions, fbx};
use std::path::Path;

/// Name that Mixamo gives to the clip of every file.
const MIXAMO: &str = "mixamo.com";

/// Reads an FBX file and the pictures that it refers to. A clip that says only where it is from gets the name of
/// its file.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let options = ReadOptions {
        scale_to_metres: input.options.unit_metres,
        ..ReadOptions::default()
    };
    let stem = Path::new(input.name).file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy();
    let limits = &input.options.limits;
    let mut read = fbx::read(input.bytes, &stem, &options, limits, input.beside)?;
    let clips = &mut read.value.character.clips;
    if let [clip] = &mut clips[..]
        && clip.name.contains(MIXAMO)
        && !stem.is_empty()
    {
        clip.name = stem.into_owned();
    }
    Ok(input.opened(read.value.character, read.warnings, None))
}
