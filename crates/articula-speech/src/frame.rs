//! A frame of visemes.

use articula_core::viseme::{VISEME_COUNT, Viseme};

/// The mouth shapes of a hundredth of a second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisemeFrame {
    /// Share of each viseme, by its number; the sum is 1.
    pub weights: [f32; VISEME_COUNT],
    /// Level below the loudest of the last seconds, in decibels: 0 at most.
    pub level_db: f32,
}

impl VisemeFrame {
    /// The viseme with the greatest share.
    pub fn strongest(&self) -> Viseme {
        let greatest = |a: &&Viseme, b: &&Viseme| {
            self.weights[a.number()].total_cmp(&self.weights[b.number()])
        };
        Viseme::ALL
            .iter()
            .max_by(greatest)
            .copied()
            .unwrap_or(Viseme::Silence)
    }
}
