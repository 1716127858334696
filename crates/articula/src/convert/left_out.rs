//! A written file, and what its format cannot hold.

use crate::open::{CharacterFile, Format};

/// The bytes of a file, and what they do not hold.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedFile {
    /// The file.
    pub bytes: Vec<u8>,
    /// The file that must lie beside it: the skeleton of a motion, or the motion of a skeleton.
    pub beside: Option<(Format, Vec<u8>)>,
    /// What the format cannot hold.
    pub left_out: Vec<LossyPart>,
}

/// Something that the format of a written file cannot hold.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LossyPart {
    /// So many meshes.
    Meshes(usize),
    /// So many end sites of joints.
    EndSites(usize),
    /// So many clips behind the first.
    Clips(usize),
    /// Turns for which BAP has no parameter.
    Turns {
        /// How many joints turn so.
        joints: usize,
        /// H-Anim name of the joint with the greatest angle.
        most: String,
        /// That angle.
        max_radians: f32,
    },
    /// So many parameters of a FAP file that its masks name, but that never move.
    StillParameters(usize),
    /// What the writer of the format says of a part of the character.
    Note(String),
}

/// The meshes, which a format of joints cannot hold.
pub(super) fn meshes(opened: &CharacterFile) -> Option<LossyPart> {
    counted(opened.character.meshes.len(), LossyPart::Meshes)
}

pub(super) fn counted(count: usize, left_out: fn(usize) -> LossyPart) -> Option<LossyPart> {
    (count > 0).then(|| left_out(count))
}
