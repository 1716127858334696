//! The level of each region of a face, from the parameters that are there.
//!
//! Form: `docs/formats/afp1.md`, part 4.

use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion};
use articula_core::fap_table::FAP_COUNT;

/// Numbers of a parameter's level and region in a stream, by its own number: the coarsest level that
/// keeps it, 0 (very low) to 3 (high), and the index of the region in [`FaceRegion::ALL`].
pub(crate) fn labels(fap: usize) -> Option<[u8; 2]> {
    let (region, level) = (FaceRegion::of(fap)?, coarsest(fap)?);
    Some([FaceLevel::VeryLow as u8 - level as u8, region as u8])
}

/// The coarsest level of each region that keeps all its parameters that are there (index 0 is FAP
/// 1).
pub(crate) fn levels_of(is_there: &[bool; FAP_COUNT]) -> FaceLevels {
    let mut levels = FaceLevels::all(FaceLevel::VeryLow);
    for fap in (1..=FAP_COUNT).filter(|fap| is_there[fap - 1]) {
        if let (Some(region), Some(level)) = (FaceRegion::of(fap), coarsest(fap)) {
            // Levels are ordered from the finest.
            levels = levels.with(region, levels.level(region).min(level));
        }
    }
    levels
}

/// The coarsest level that keeps a parameter, by its number.
fn coarsest(fap: usize) -> Option<FaceLevel> {
    let mut levels = FaceLevel::ALL.into_iter().rev();
    levels.find(|level| FaceLevels::all(*level).roles().keeps(fap))
}
