//! An encoded file, and the data that its format cannot hold.

use crate::mesh_levels::coarser_levels;
use crate::open::{CharacterFile, Format};

/// The bytes of a file, and the data that was left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EncodedFile {
    /// Contents of the file.
    pub bytes: Vec<u8>,
    /// Format and contents of a companion file: the skeleton of a motion, or the motion of a
    /// skeleton.
    pub beside: Option<(Format, Vec<u8>)>,
    /// Data that the format cannot hold.
    pub left_out: Vec<LossyPart>,
    /// Of a motion stream (ABP-2) or a face stream (AFP-2), its tiers, finest first.
    #[cfg(feature = "streams")]
    pub tiers: Vec<crate::clip_streams::abp2::TierReport>,
}

impl EncodedFile {
    /// A file without a companion.
    pub(super) fn new(bytes: Vec<u8>, left_out: impl IntoIterator<Item = LossyPart>) -> Self {
        Self {
            bytes,
            left_out: left_out.into_iter().collect(),
            ..Self::default()
        }
    }
}

/// A kind of data that was left out because the file format cannot hold it, with its amount.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LossyPart {
    /// A number of meshes.
    Meshes(usize),
    /// A number of coarser levels of meshes.
    MeshLevels(usize),
    /// A number of end sites of joints.
    EndSites(usize),
    /// A number of clips after the first.
    Clips(usize),
    /// Rotations for which BAP has no parameter.
    Rotations {
        /// Number of affected joints.
        joints: usize,
        /// H-Anim name of the joint with the greatest angle.
        most: String,
        /// The greatest angle, in radians.
        max_radians: f32,
    },
    /// A number of FAP parameters that the masks select but that never change.
    StillParameters(usize),
    /// A number of joints whose own names were replaced by those of H-Anim, since the joint map of
    /// the file, which the format cannot hold, is not found by the names.
    JointNames(usize),
    /// A remark of the format's writer.
    Note(String),
}

/// The number of meshes, which a skeleton format cannot hold.
pub(super) fn meshes(opened: &CharacterFile) -> Option<LossyPart> {
    counted(opened.character().meshes.len(), LossyPart::Meshes)
}

/// The number of coarser levels of all meshes, for a format that holds meshes with one level each.
pub(super) fn mesh_levels(opened: &CharacterFile) -> Option<LossyPart> {
    let meshes = opened.character().meshes.iter();
    counted(meshes.map(coarser_levels).sum(), LossyPart::MeshLevels)
}

pub(super) fn counted(count: usize, left_out: fn(usize) -> LossyPart) -> Option<LossyPart> {
    (count > 0).then(|| left_out(count))
}
