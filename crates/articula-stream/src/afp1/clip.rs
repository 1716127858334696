//! The plain form of a face animation, frame by frame.

use crate::face_frame::{FaceFrame, check_frames};
use crate::frame_rate::FrameRate;
use articula_core::Mismatch;

/// A face animation.
#[derive(Debug, Clone, PartialEq)]
pub struct Afp1Clip {
    /// Its name.
    pub name: String,
    /// If the parameters were made from blend shapes, the name of the columns by which.
    pub bridge: Option<String>,
    /// Frames per second.
    pub rate: FrameRate,
    /// The frames.
    pub frames: Vec<FaceFrame>,
}

impl Afp1Clip {
    /// Checks that the fields of FAP 1 and 2 are in their ranges.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first frame where one is not.
    pub fn check(&self) -> Result<(), Mismatch> {
        check_frames(self.frames.iter())
    }
}
