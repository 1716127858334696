//! Facial animation parameters as AFP-1, and back.
//!
//! Form: `docs/formats/afp1.md`.

use super::face_clip::{face_clip, fap_clip};
use crate::error::Result;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::afp1::Afp1Options;
use articula_stream::{FaceReadOptions, StreamLimits};

/// Encodes a FAP clip as an AFP-1 file; numbers of frames that are missing hold the frame before.
///
/// Where the outer lips move and the inner ones never do, the inner lips get their motion, since
/// they lead at coarser levels.
///
/// # Errors
/// An [`Error`](crate::Error) if the rate or the number of frames cannot be written, or a value is too
/// great for the step.
pub fn write(clip: &FapClip, options: &Afp1Options) -> Result<Vec<u8>> {
    Ok(articula_stream::afp1::write(
        &face_clip(clip, "AFP-1")?,
        options,
    )?)
}

/// Decodes an AFP-1 file as a FAP clip. Its masks have the parameters that the file has, and those
/// that copy them and move.
///
/// # Errors
/// An [`Error`](crate::Error) that names the position in the file.
pub fn read(bytes: &[u8], options: &FaceReadOptions, limits: &StreamLimits) -> Result<FapClip> {
    let read = articula_stream::afp1::read(bytes, options, limits)?;
    Ok(fap_clip(read))
}
