//! Facial animation parameters as AFP-1, and back.
//!
//! Form: `docs/formats/afp1.md`.

use super::face_frame::{fap_frame, frame_rate, plain};
use crate::error::{Error, Result};
use crate::face::with_inner_lips;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::afp1::{Afp1Clip, Afp1Options, Afp1ReadOptions};
use articula_stream::{FaceFrame, StreamLimits};

/// Maximum number of frames.
const MAX_FRAMES: u32 = 1 << 20;

/// Returns a FAP clip in the form of AFP-1: a frame for each number from the first to the last,
/// numbers that are missing hold the frame before.
///
/// Where the outer lips move and the inner ones never do, the inner lips get their motion, since
/// they lead at coarser levels.
///
/// # Errors
/// An [`Error`] if the rate or the number of frames cannot be written.
pub fn from_faps(clip: &FapClip) -> Result<Afp1Clip> {
    let rate = frame_rate(clip, "AFP-1")?;
    let clip = with_inner_lips(clip);
    let ends = clip.frames.first().zip(clip.frames.last());
    let span = ends.map_or(0, |(first, last)| last.number.saturating_sub(first.number));
    if span >= MAX_FRAMES {
        return Err(Error::unsuited(format!(
            "frames: their numbers span {span}, AFP-1 holds at most {MAX_FRAMES}"
        )));
    }
    let mut frames: Vec<FaceFrame> = Vec::new();
    let mut next = ends.map_or(0, |(first, _)| first.number);
    for frame in &clip.frames {
        let held = frames.last().copied();
        while next < frame.number {
            frames.extend(held);
            next += 1;
        }
        frames.push(plain(frame));
        next += 1;
    }
    Ok(Afp1Clip {
        name: clip.name.clone(),
        bridge: clip.bridge.clone(),
        rate,
        frames,
    })
}

/// Encodes a FAP clip as an AFP-1 file.
///
/// # Errors
/// As [`from_faps`], and if a value is too great for the step.
pub fn write(clip: &FapClip, options: &Afp1Options) -> Result<Vec<u8>> {
    Ok(articula_stream::afp1::write(&from_faps(clip)?, options)?)
}

/// Decodes an AFP-1 file as a FAP clip. Its masks have the parameters that the file has, and those
/// that copy them and move.
///
/// # Errors
/// An [`Error`] that names the position in the file.
pub fn read(bytes: &[u8], options: &Afp1ReadOptions, limits: &StreamLimits) -> Result<FapClip> {
    let read = articula_stream::afp1::read(bytes, options, limits)?;
    let frames = read.clip.frames.iter().zip(0..);
    let mut clip = FapClip {
        name: read.clip.name,
        rate_hz: read.clip.rate.hz() as f32,
        coded: read.coded,
        frames: frames
            .map(|(frame, number)| fap_frame(frame, number))
            .collect(),
        bridge: read.clip.bridge,
    };
    let moving = clip.moving();
    for (coded, moves) in clip.coded.iter_mut().zip(moving) {
        *coded |= moves;
    }
    Ok(clip)
}
