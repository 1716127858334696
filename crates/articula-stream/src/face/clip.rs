//! The plain form of a face animation, and how a stream becomes one.

use super::frame::{FaceFrame, check_frames};
use crate::frame_rate::FrameRate;
use articula_core::Mismatch;
use articula_core::fap_table::FAP_COUNT;

/// Seconds of the fade after a change of level.
const FADE_SECS: f32 = 0.2;

/// A face animation.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceClip {
    /// Its name.
    pub name: String,
    /// If the parameters were made from blend shapes, the name of the columns by which.
    pub bridge: Option<String>,
    /// Frames per second.
    pub rate: FrameRate,
    /// The frames.
    pub frames: Vec<FaceFrame>,
}

impl FaceClip {
    /// Checks that the fields of FAP 1 and 2 are in their ranges.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first frame where one is not.
    pub fn check(&self) -> Result<(), Mismatch> {
        check_frames(self.frames.iter())
    }
}

/// How a face stream that may have been cut is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceReadOptions {
    /// Seconds in which a parameter goes to its new value where the level of its region changes; 0
    /// for none.
    pub fade_secs: f32,
}

/// A fade of 0.2 s.
impl Default for FaceReadOptions {
    fn default() -> Self {
        Self {
            fade_secs: FADE_SECS,
        }
    }
}

impl FaceReadOptions {
    /// Frames of a fade.
    pub(crate) fn fade_frames(&self, rate: FrameRate) -> usize {
        let frames = (f64::from(self.fade_secs) * rate.hz()).round();
        frames.clamp(0.0, f64::from(u16::MAX)) as usize
    }
}

/// A decoded face stream.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedFace {
    /// The clip, with all parameters.
    pub clip: FaceClip,
    /// Parameters that at least one access unit has; index 0 is FAP 1.
    pub coded: [bool; FAP_COUNT],
}
