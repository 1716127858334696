//! A motion of a face that was read from a file, as a clip of a character.

use super::fit::{FittedFace, fit_capture, fit_face};
use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, Data};

/// Transfers the motion of a face to the face of a character: parameters as [`fit_face`], captures as
/// [`fit_capture`]. `file` names the file of the motion.
///
/// # Errors
/// As these, and [`Error::Unsupported`] for data that move no face.
pub fn fit_motion(data: &Data, file: &str, character: &CharacterFile) -> Result<FittedFace> {
    match data {
        Data::Fap(clip) => fit_face(clip, file, character),
        Data::LiveLink(capture) => fit_capture(capture, file, character),
        Data::Epf(_) | Data::Fdp(_) => {
            let what = "the file has no motion of a face; give a .fap, .afp, .fba or .csv file";
            Err(Error::unsuited(what)).context(file)
        }
    }
}
