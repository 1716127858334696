//! The reference human as a file that was opened.

use super::{CharacterFile, OpenOptions, open};
use crate::error::{Error, Result};
use articula_formats::Resolver;
use articula_formats::gltf::Document;
use articula_human::{HumanOptions, human};

/// Makes the reference human: a clothed figure with a face, hands and some clips, for where no
/// character is at hand.
///
/// # Errors
/// None that the caller could mend.
pub fn reference_human() -> Result<CharacterFile> {
    let made = human(&HumanOptions::default());
    let character = made.map_err(|e| Error::Unsuited(e.to_string()))?;
    let glb = Document::from_character(&character)?.write_glb()?;
    let nothing: &mut Resolver<'_> = &mut |_: &str| Err("nothing lies beside it".into());
    open(&glb, "reference human", &OpenOptions::default(), nothing)
}
