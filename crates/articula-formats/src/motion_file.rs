//! Options and content of motion files (BVH, BVA, Acclaim).

use crate::units::UpAxis;
use articula_core::source::Character;
use glam::Vec3;

/// Facts that a motion file omits, or that override what it states.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadOptions {
    /// Metres per file unit. `None` takes the unit from the file (BVA, and ASF where it states
    /// one), else guesses it from the height of the figure.
    pub scale_to_metres: Option<f32>,
    /// The axis that points up. For BVA files, [`UpAxis::Auto`] is +Y, as the format defines.
    pub up: UpAxis,
    /// Frames per second of AMC files. `None` takes the rate that the motion states, else 120.
    /// Other formats state their rate.
    pub rate_hz: Option<f32>,
}

/// Content of a motion file, in metres and with +Y up.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MotionFile {
    /// Skeleton and at most one clip, called `motion`; every joint is `in_skin`.
    pub character: Character,
    /// Joint and offset of each end site (for Acclaim files, the end of each leaf bone), in metres
    /// in the joint's space; empty for BVA.
    pub end_sites: Vec<(usize, Vec3)>,
    /// Seconds between frames; 0 without motion.
    pub frame_time_secs: f32,
}
