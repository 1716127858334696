//! The plain form of a face animation: numbered frames of all parameters.

use crate::face::FaceFrame;
use crate::frame_rate::FrameRate;
use articula_core::fap_table::FAP_COUNT;

/// Time of a frame, in whole seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeCode {
    /// Hours, 0 to 23.
    pub hours: u8,
    /// Minutes, 0 to 59.
    pub minutes: u8,
    /// Seconds, 0 to 59.
    pub seconds: u8,
}

impl TimeCode {
    pub(super) fn is_valid(self) -> bool {
        self.hours < 24 && self.minutes < 60 && self.seconds < 60
    }
}

/// A frame that is coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FbaFrame {
    /// Its number; rising from 0. Until the next number, the frame is shown.
    pub number: u32,
    /// Values of all parameters; those that are not coded are neutral, or hold.
    pub face: FaceFrame,
}

/// A face animation.
#[derive(Debug, Clone, PartialEq)]
pub struct FbaClip {
    /// Frames per second.
    pub rate: FrameRate,
    /// Time of the first frame.
    pub time_code: Option<TimeCode>,
    /// Parameters that are coded in at least one frame; index 0 is FAP 1.
    pub coded: [bool; FAP_COUNT],
    /// The frames.
    pub frames: Vec<FbaFrame>,
}
