//! How many parameters a face shows.

use super::controls::FaceControls;
use articula_core::fap_table::{FAP_COUNT, LOW_FAP_COUNT, LOW_FAPS};
use articula_core::source::Character;

/// Number of the 68 parameters that the morph targets or expressions of a character show, the viseme and
/// the expression (FAP 1 and 2) among them if anything is shown.
pub(crate) fn driven_faps(character: &Character) -> usize {
    let Some(controls) = FaceControls::of(character) else {
        return 0;
    };
    let low = LOW_FAPS.filter(|fap| controls.bridge().moves(*fap)).count();
    low + usize::from(low > 0) * (FAP_COUNT - LOW_FAP_COUNT)
}
