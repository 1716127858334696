//! FAP clips in the plain form of the face streams, and back.

use super::face_frame::{fap_frame, frame_rate, plain};
use crate::error::{Error, Result};
use crate::inner_lips::with_inner_lips;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::{DecodedFace, FaceClip, FaceFrame};

/// Maximum number of frames.
const MAX_FRAMES: u32 = 1 << 20;

/// Returns a FAP clip in the form of the stream of this name: a frame for each number from the first to the last,
/// numbers that are missing hold the frame before.
///
/// Where the outer lips move and the inner ones never do, the inner lips get their motion, since
/// they lead at coarser levels.
///
/// # Errors
/// An [`Error`] if the rate or the number of frames cannot be written.
pub(super) fn face_clip(clip: &FapClip, stream: &str) -> Result<FaceClip> {
    let rate = frame_rate(clip, stream)?;
    let clip = with_inner_lips(clip);
    let ends = clip.frames.first().zip(clip.frames.last());
    let span = ends.map_or(0, |(first, last)| last.number.saturating_sub(first.number));
    if span >= MAX_FRAMES {
        return Err(Error::unsuited(format!(
            "frames: their numbers span {span}, {stream} holds at most {MAX_FRAMES}"
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
    Ok(FaceClip {
        name: clip.name.clone(),
        bridge: clip.bridge.clone(),
        rate,
        frames,
    })
}

/// Returns a decoded stream as a FAP clip. Its masks have the parameters that the stream has, and
/// those that copy them and move.
pub(super) fn fap_clip(read: DecodedFace) -> FapClip {
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
    clip
}
