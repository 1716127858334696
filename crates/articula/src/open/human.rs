//! The built-in reference human as an opened file.

use super::{CharacterFile, OpenOptions, open};
use crate::error::{Error, Result};
use articula_formats::Resolver;
use articula_formats::gltf::Document;
use articula_human::{HumanOptions, human};

/// Creates the built-in reference human: a clothed figure with a face, hair, hands and some clips, for
/// use without a character file.
///
/// # Errors
/// None that a caller could avoid.
pub fn reference_human() -> Result<CharacterFile> {
    opened(&HumanOptions::default())
}

/// Creates the built-in mannequin: the plain figure of 12,000 triangles that measurements are made on,
/// without a face that moves.
///
/// # Errors
/// None that a caller could avoid.
pub fn reference_mannequin() -> Result<CharacterFile> {
    opened(&HumanOptions::mannequin(12_000))
}

fn opened(options: &HumanOptions) -> Result<CharacterFile> {
    let made = human(options);
    let character = made.map_err(|e| Error::Unsupported(e.to_string()))?;
    let glb = Document::from_character(&character)?.write_glb()?;
    let nothing: &mut Resolver<'_> =
        &mut |_: &str| Err("the reference human has no other files".into());
    open(&glb, "reference human", &OpenOptions::default(), nothing)
}
