//! Facial animation parameters as MPEG-4's binary stream (FBA), and back.
//!
//! Form: `docs/formats/fba.md`. A stream holds neither the name of the clip nor that of the columns
//! by which blend shapes became parameters.

use super::face_frame::{fap_frame, frame_rate, plain};
use crate::error::Result;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use articula_stream::StreamLimits;
use articula_stream::fba::{FbaClip, FbaFrame, FbaOptions};

/// Encodes a FAP clip as an FBA stream, with the parameters of its masks.
///
/// # Errors
/// An [`Error`](crate::Error) if the rate or a value cannot be written, or the clip has no frame.
pub fn write(clip: &FapClip, options: &FbaOptions) -> Result<Vec<u8>> {
    let frame = |frame: &FapFrame| FbaFrame {
        number: frame.number,
        face: plain(frame),
    };
    let clip = FbaClip {
        rate: frame_rate(clip, "FBA")?,
        time_code: None,
        coded: clip.coded,
        frames: clip.frames.iter().map(frame).collect(),
    };
    Ok(articula_stream::fba::write(&clip, options)?)
}

/// Decodes an FBA stream as a FAP clip; `name` becomes that of the clip.
///
/// # Errors
/// An [`Error`](crate::Error) that names the position in the stream.
pub fn read(bytes: &[u8], name: &str, limits: &StreamLimits) -> Result<FapClip> {
    let clip = articula_stream::fba::read(bytes, limits)?.clip;
    let frames = clip.frames.iter();
    Ok(FapClip {
        name: name.to_owned(),
        rate_hz: clip.rate.hz() as f32,
        coded: clip.coded,
        frames: frames.map(|f| fap_frame(&f.face, f.number)).collect(),
        bridge: None,
    })
}
