//! Access patterns of a clip, as the times of every character and frame.

use super::Bench;
use articula_build::{Plaza, plaza};

/// Access patterns of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    Forward,
    Backward,
    /// Steps of half a second.
    Skipping,
    Random,
}

impl Access {
    pub(super) const ALL: [Self; 4] = [Self::Forward, Self::Backward, Self::Skipping, Self::Random];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Backward => "backward",
            Self::Skipping => "skipping",
            Self::Random => "random",
        }
    }

    /// Times within the clip of every character, frame by frame.
    pub(super) fn frames(self, bench: &Bench, count: usize, frames: usize) -> Vec<Vec<f32>> {
        let duration = bench.clip().duration_secs();
        let phases = bench.phases(count);
        let step = match self {
            Self::Forward => 1.0 / 60.0,
            Self::Backward => -1.0 / 60.0,
            Self::Skipping => 0.5,
            Self::Random => 0.0,
        };
        let frame = |f: usize| {
            let phases = match self {
                // A different seed for each frame gives the phases of another crowd.
                Self::Random => {
                    let other = plaza(count, &[1], f as u64 + 2, Plaza::Still);
                    other.members.iter().map(|m| m.play.phase).collect()
                }
                _ => phases.clone(),
            };
            let at = |phase: f32| (phase * duration + step * f as f32).rem_euclid(duration);
            phases.into_iter().map(at).collect()
        };
        (0..frames).map(frame).collect()
    }
}
