//! FAP files from clips of facial animation parameters.

use super::left_out::{EncodedFile, LossyPart, counted};
use articula_core::fap_table::FAP_COUNT;
use articula_formats::mpeg4::fap::{self, FapClip};

/// Writes a FAP file; its masks select the parameters that the clip codes.
pub(super) fn written(clip: &FapClip) -> EncodedFile {
    EncodedFile::new(fap::write(clip), still(clip))
}

/// Parameters that the masks select but that never change.
fn still(clip: &FapClip) -> Option<LossyPart> {
    let moving = clip.moving();
    let still = (0..FAP_COUNT).filter(|fap| clip.coded[*fap] && !moving[*fap]);
    counted(still.count(), LossyPart::StillParameters)
}
