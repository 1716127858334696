//! Features that do not depend on gain and channel, from the past alone.

use crate::bands::{BANDS, FLOOR};
use articula_core::Libm;

/// Numbers of a frame: the bands and the level.
pub const FEATURES: usize = BANDS + 1;
/// Least level of the peak, in nepers of power.
const LEAST_PEAK: f32 = -12.0;
/// How far the peak falls in a frame: 1.7 dB in a second.
const FALL: f32 = 0.004;
/// Level below the peak above which a frame counts as speech: 22 dB.
const SPEECH: f32 = -5.0;
/// Frames that the stored mean of the channel counts for, and the most that a mean is of.
const FRAMES: [f32; 2] = [100.0, 300.0];
/// Decibels in a neper of power.
const DECIBELS: f32 = 4.342_945;

/// A frame without its gain and channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Normalised {
    pub(crate) features: [f32; FEATURES],
    /// Level below the running peak, in decibels: 0 at most.
    pub(crate) level_db: f32,
}

/// The running peak of the level and the mean of the bands in speech.
#[derive(Debug, Clone)]
pub(crate) struct Normaliser {
    peak: f32,
    mean: [f32; BANDS],
    frames: f32,
}

impl Normaliser {
    /// Begins with the mean of the recordings that a network was trained with.
    pub(crate) fn new(mean: [f32; BANDS]) -> Self {
        Self {
            peak: LEAST_PEAK,
            mean,
            frames: FRAMES[0],
        }
    }

    pub(crate) fn next(&mut self, logs: &[f32; BANDS]) -> Normalised {
        let mean_power = logs.iter().map(|log| log.libm_exp()).sum::<f32>() / BANDS as f32;
        let level = (mean_power + FLOOR).libm_ln();
        self.peak = (self.peak - FALL).max(level).max(LEAST_PEAK);
        let below = level - self.peak;
        if below > SPEECH {
            self.frames = (self.frames + 1.0).min(FRAMES[1]);
            for (mean, log) in self.mean.iter_mut().zip(logs) {
                *mean += (log - self.peak - *mean) / self.frames;
            }
        }
        let mut features = [0.0; FEATURES];
        for ((feature, log), mean) in features.iter_mut().zip(logs).zip(&self.mean) {
            *feature = ((log - self.peak - mean) * 0.5).clamp(-4.0, 4.0);
        }
        features[BANDS] = (0.4 * below + 1.0).clamp(-4.0, 2.0);
        Normalised {
            features,
            level_db: DECIBELS * below,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn gain_changes_nothing(
            frames in prop::collection::vec(prop::array::uniform26(-4.0f32..4.0), 1..60),
            gain in 0.0f32..3.0,
        ) {
            let mut plain = Normaliser::new([0.0; BANDS]);
            let mut louder = plain.clone();
            for logs in &frames {
                let loud = logs.map(|log| log + gain);
                let (a, b) = (plain.next(logs), louder.next(&loud));
                for (a, b) in a.features.iter().zip(b.features) {
                    prop_assert!((a - b).abs() < 1e-3, "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn the_peak_falls_and_the_level_is_told_below_it() {
        let mut normaliser = Normaliser::new([0.0; BANDS]);
        assert_eq!(normaliser.next(&[0.0; BANDS]).level_db, 0.0);
        // Ten decibels less, a frame later: the peak has fallen by 0.004 nepers.
        let soft = normaliser.next(&[-10.0 / DECIBELS; BANDS]);
        assert!((soft.level_db - (-10.0 + FALL * DECIBELS)).abs() < 1e-3);
    }
}
