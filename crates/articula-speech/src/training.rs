//! What a program that trains a network needs of the recogniser: the features that it hears, and the
//! shapes that phones stand for.

use crate::normaliser::Normaliser;
use crate::windows::Windows;

pub use crate::bands::BANDS;
pub use crate::coarticulation::{Segment, segments};
pub use crate::network::{Layer, Network};
pub use crate::normaliser::FEATURES;

/// Natural logarithms of the powers of the bands of a recording at 16 kHz, a frame each hundredth of a
/// second.
pub fn log_bands(samples: &[f32]) -> Vec<[f32; BANDS]> {
    let (mut windows, mut frames) = (Windows::new(), Vec::new());
    windows.push(samples, |logs| frames.push(logs));
    windows.finish(|logs| frames.push(logs));
    frames
}

/// The numbers that a network sees of these, where `mean` is that of its training
/// ([`Network::mean`]).
pub fn features(log_bands: &[[f32; BANDS]], mean: [f32; BANDS]) -> Vec<[f32; FEATURES]> {
    let mut normaliser = Normaliser::new(mean);
    log_bands
        .iter()
        .map(|logs| normaliser.next(logs).features)
        .collect()
}
