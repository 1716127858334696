//! Heads of the data without their morph targets.

use crate::real;
use articula::{CharacterFile, fs};

/// A character without its morph targets and clips; `None` where the data lacks it.
pub(crate) fn bare(name: &str) -> Option<CharacterFile> {
    let mut head = fs::open(real::file(name)?).unwrap();
    head.edit_character(|character| {
        character.clips.clear();
        for mesh in &mut character.meshes {
            mesh.morph_names.clear();
            mesh.morph_weights.clear();
            mesh.primitives.iter_mut().for_each(|p| p.morphs.clear());
        }
    });
    Some(head)
}
