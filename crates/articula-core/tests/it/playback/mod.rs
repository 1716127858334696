//! Playback of one figure: against a plain slow version, by hand, and without allocation.

mod by_hand;
mod controllers;
mod plain;

use articula_core::playback::FigureViews;

/// A parallel view with one scale, in pixels per metre.
pub(crate) fn seen_at(pixels_per_metre: f32) -> FigureViews<'static> {
    FigureViews::Parallel {
        pixels_per_metre,
        distance_metres: 5.0,
        directions: &[],
    }
}
