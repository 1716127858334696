//! The JSON head of an AFP-1 file.

use crate::container::{self, Container};
use crate::error::StreamError;
use crate::face::FaceClip;
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use serde::{Deserialize, Serialize};

pub(super) const MAGIC: [u8; 4] = *b"AFPF";

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Head {
    version: u32,
    #[serde(default)]
    pub(super) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) bridge: Option<String>,
    frame_rate: f64,
}

/// Splits a file and checks its head.
pub(super) fn open(
    bytes: &[u8],
    limits: &StreamLimits,
) -> Result<(FrameRate, Container<Head>), StreamError> {
    let container: Container<Head> = Container::read(bytes, MAGIC, limits)?;
    container::check_version(container.head.version)?;
    let hz = container.head.frame_rate;
    let rate = FrameRate::nearest(hz);
    let bad = || StreamError::malformed("head", format!("a frame rate of {hz}"));
    Ok((rate.ok_or_else(bad)?, container))
}

/// The head of a clip.
pub(super) fn of_clip(clip: &FaceClip) -> Head {
    Head {
        version: container::VERSION,
        name: clip.name.clone(),
        bridge: clip.bridge.clone(),
        frame_rate: clip.rate.hz(),
    }
}
