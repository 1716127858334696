//! Facial animation parameters as AFP-2, and back.
//!
//! Form: `docs/formats/afp2.md`.

use super::face_clip::{face_clip, fap_clip};
use crate::error::Result;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::abp2::EncodedMotion;
use articula_stream::afp2::Afp2Options;
#[cfg(feature = "item")]
use articula_stream::afp2::FaceReceiver;
use articula_stream::{FaceReadOptions, StreamLimits};

/// Encodes a FAP clip as an AFP-2 stream; numbers of frames that are missing hold the frame before.
///
/// Where the outer lips move and the inner ones never do, the inner lips get their motion, since
/// they lead at coarser levels.
///
/// # Errors
/// An [`Error`](crate::Error) if the rate, the number of frames or a value cannot be written, or an
/// option is out of range.
pub fn write(clip: &FapClip, options: &Afp2Options) -> Result<EncodedMotion> {
    Ok(articula_stream::afp2::write(
        &face_clip(clip, "AFP-2")?,
        options,
    )?)
}

/// Decodes an AFP-2 stream, or a prefix of one, as a FAP clip. Its masks have the parameters that the
/// stream has, and those that copy them and move.
///
/// # Errors
/// An [`Error`](crate::Error) that names the position in the stream.
pub fn read(bytes: &[u8], options: &FaceReadOptions, limits: &StreamLimits) -> Result<FapClip> {
    let read = articula_stream::afp2::read(bytes, options, limits)?;
    Ok(fap_clip(read))
}

/// What a receiver has, as a FAP clip.
#[cfg(feature = "item")]
pub(crate) fn received(receiver: &FaceReceiver) -> Result<FapClip> {
    Ok(fap_clip(receiver.decoded()?))
}
