//! One colour that changes, in place of a gradient whose line would need many keys.
//!
//! Source: `docs/methods/vector.md` 7. On a small triangle, or one that light leaves all at once, the corners have
//! nearly one colour in each frame, while the line of a gradient turns over.

use super::keyed_clip::KeyedTrack;
use super::tunnel::{Windows, fewest_keys};

/// What of the tolerance has to be left for keys, levels.
const LEAST_REACH: f64 = 1.0;

/// Colours of the corners of a triangle by frame.
#[derive(Debug, Default)]
pub(super) struct CornerColors {
    /// Middle of the corners' levels in each channel, three for each frame.
    middles: Vec<f64>,
    /// Greatest distance of a corner from it, and the tolerance, in levels; `None` where the frame is irrelevant.
    frames: Vec<Option<(f64, f64)>>,
}

impl CornerColors {
    /// Adds the next frame: the levels of its corners, and the tolerance if it is relevant.
    pub(super) fn push(&mut self, corners: [[f32; 3]; 3], tolerance: Option<f64>) {
        let mut apart: f64 = 0.0;
        for channel in 0..3 {
            let levels = corners.map(|corner| f64::from(corner[channel]));
            let low = levels.into_iter().fold(f64::MAX, f64::min);
            let high = levels.into_iter().fold(f64::MIN, f64::max);
            apart = apart.max((high - low) / 2.0);
            self.middles.push((low + high) / 2.0);
        }
        self.frames
            .push(tolerance.map(|tolerance| (apart, tolerance)));
    }

    /// Factor of the tolerance from which on one colour in each frame is within it.
    pub(super) fn least_slack(&self) -> f64 {
        let of = |(apart, tolerance): &(f64, f64)| (apart + LEAST_REACH) / tolerance;
        self.frames.iter().flatten().map(of).fold(0.0, f64::max)
    }

    /// The colour with few keys whose error is within the tolerance times `slack`, which is at least
    /// [`least_slack`](Self::least_slack).
    pub(super) fn few_keys(&self, slack: f64) -> KeyedTrack {
        let reach = |frame: &Option<(f64, f64)>| {
            frame.map_or(f64::INFINITY, |(apart, tolerance)| {
                tolerance * slack - apart
            })
        };
        let reach: Vec<f64> = self.frames.iter().map(reach).collect();
        let windows = Windows {
            targets: &self.middles,
            width: 3,
            reach: &reach,
        };
        let mut track = fewest_keys(&windows);
        track
            .values
            .iter_mut()
            .for_each(|v| *v = (*v).clamp(0, 255));
        // Keys beyond black and white were within the tolerance, what is between them may no more be.
        match windows.holds(&track) {
            true => track,
            false => KeyedTrack {
                frames: (0..self.frames.len() as u32).collect(),
                values: self.middles.iter().map(|v| v.round() as i32).collect(),
                width: 3,
            },
        }
    }

    /// Greatest distance of the corners from a colour in a frame, in levels; `None` if the frame is irrelevant.
    pub(super) fn off(&self, frame: usize, color: &KeyedTrack) -> Option<f64> {
        let (apart, _) = self.frames[frame]?;
        let middle = &self.middles[3 * frame..3 * frame + 3];
        let shown = color.at(frame as f64);
        let off = shown.iter().zip(middle).map(|(a, b)| (a - b).abs());
        Some(apart + off.fold(0.0, f64::max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn light_that_grows_needs_two_keys() {
        let mut colors = CornerColors::default();
        for f in 0..9 {
            let level = |more: f32| [10.0 * f as f32 + more, 50.0, 0.0];
            colors.push([level(0.0), level(2.0), level(4.0)], Some(8.0));
        }
        assert_eq!(colors.least_slack(), 3.0 / 8.0);
        let track = colors.few_keys(0.5);
        assert_eq!(track.frames, [0, 8]);
        assert!((0..9).all(|f| colors.off(f, &track).unwrap() <= 4.0));
        // With all of the tolerance the two are not as far apart, and never beyond black.
        assert!(colors.few_keys(1.0).values.iter().all(|v| *v >= 0));
    }

    proptest! {
        #[test]
        fn every_corner_is_within_the_tolerance(
            corners in prop::collection::vec(
                (prop::array::uniform3(prop::array::uniform3(0.0f32..255.0)), prop::bool::weighted(0.8)), 1..12),
            tolerance in 1.0f64..16.0,
        ) {
            let mut colors = CornerColors::default();
            for (corners, is_shown) in &corners {
                colors.push(*corners, is_shown.then_some(tolerance));
            }
            let slack = colors.least_slack();
            let track = colors.few_keys(slack);
            prop_assert!(track.check(corners.len() as u32).is_ok());
            for (f, (corners, is_shown)) in corners.iter().enumerate() {
                let shown = track.at(f as f64);
                let off = corners.iter().flat_map(|c| c.iter().zip(&shown).map(|(a, b)| (f64::from(*a) - b).abs()));
                let off = off.fold(0.0, f64::max);
                prop_assert!(!is_shown || off <= slack * tolerance + 1e-3, "{off} of {}", slack * tolerance);
            }
        }
    }
}
