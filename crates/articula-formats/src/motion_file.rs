//! What files of motion hold (BVH, BVA, Acclaim), and what they do not say.

use crate::units::UpAxis;
use articula_core::source::Character;
use glam::Vec3;

/// What a file of motion does not say, or what to believe instead of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadOptions {
    /// Metres of one unit. Without it what the file says (BVA, and ASF where it does), else told
    /// from the figure's height.
    pub scale_to_metres: Option<f32>,
    /// The axis that points up; of BVA files, [`UpAxis::Auto`] is +Y, as the format has it.
    pub up: UpAxis,
    /// AMC: frames a second; without it what the motion says, or 120. The others say their own.
    pub rate_hz: Option<f32>,
}

/// What a file of motion holds, in metres and with +Y up.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MotionFile {
    /// Skeleton and at most one clip, called `motion`; every joint is `in_skin`.
    pub character: Character,
    /// Joint and offset of each end site (of Acclaim files the end of each last bone), in metres
    /// of the joint's space; none in BVA.
    pub end_sites: Vec<(usize, Vec3)>,
    /// Seconds from frame to frame; 0 without motion.
    pub frame_time_secs: f32,
}
