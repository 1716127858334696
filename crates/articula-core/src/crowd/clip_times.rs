//! Clips as a playback state sees them: durations, events and root motion.

use super::events::ClipEvent;
use super::root_path::RootTrajectory;
use crate::clip_set::ClipSet;

/// Durations of a list of clips, with their events and root motion if they have any.
pub trait ClipTimes {
    /// Number of clips.
    fn clip_count(&self) -> usize;

    /// Duration of a clip in seconds, the time of its last frame; 0 for a single pose.
    ///
    /// # Panics
    /// If there is no such clip.
    fn clip_secs(&self, clip: usize) -> f32;

    /// Events of a clip in the order of their times.
    fn clip_events(&self, _clip: usize) -> &[ClipEvent] {
        &[]
    }

    /// Root motion of a clip.
    fn clip_path(&self, _clip: usize) -> Option<&RootTrajectory> {
        None
    }
}

impl ClipTimes for ClipSet {
    fn clip_count(&self) -> usize {
        self.clips()
    }

    fn clip_secs(&self, clip: usize) -> f32 {
        self.duration_secs(clip)
    }
}
