//! Powers of mel bands in a window of sound.

use crate::SAMPLE_RATE_HZ;
use articula_core::Libm;
use std::f64::consts::PI;

/// Samples of a window: 25 ms.
pub(crate) const WINDOW: usize = 400;
/// Share of a sample that is taken off the next one, so that treble weighs as bass does.
pub(crate) const PRE_EMPHASIS: f32 = 0.97;
/// Number of bands.
pub const BANDS: usize = 26;
/// Samples of a transform; those beyond the window are 0.
const TRANSFORM: usize = 512;
/// Frequencies that the bands span.
const RANGE_HZ: [f64; 2] = [60.0, 7_600.0];
/// Added to a power before its logarithm is taken.
pub(crate) const FLOOR: f32 = 1e-8;
/// Deviation of the white noise that is taken to lie under every recording, as under those of the
/// training: without it the silence of a file sounds like no silence of a room.
const NOISE: f64 = 1e-4;

/// The window and the bands.
#[derive(Debug, Clone)]
pub(crate) struct Bands {
    window: Vec<f32>,
    /// First frequency of each band and the weights from there on.
    triangles: Vec<(usize, Vec<f32>)>,
    /// Power of the noise in each band.
    noise: Vec<f32>,
}

impl Bands {
    pub(crate) fn new() -> Self {
        let window = (0..WINDOW).map(|i| {
            let half = (PI * (i as f64 + 0.5) / WINDOW as f64).libm_sin();
            (half * half) as f32
        });
        let window: Vec<f32> = window.collect();
        let [low, high] = RANGE_HZ.map(mel);
        let step = (high - low) / (BANDS + 1) as f64;
        let corner = |i: usize| hertz(low + step * i as f64);
        let triangles =
            (0..BANDS).map(|band| triangle(corner(band), corner(band + 1), corner(band + 2)));
        let triangles: Vec<(usize, Vec<f32>)> = triangles.collect();
        let energy: f64 = window.iter().map(|w| f64::from(w * w)).sum();
        let power = energy * NOISE * NOISE / TRANSFORM as f64;
        let noise = triangles.iter().map(|(first, weights)| {
            let gains = (*first..).map(emphasis).zip(weights);
            (power * gains.map(|(gain, w)| gain * f64::from(*w)).sum::<f64>()) as f32
        });
        Self {
            noise: noise.collect(),
            window,
            triangles,
        }
    }

    /// Natural logarithms of the powers of a window of [`WINDOW`] samples.
    pub(crate) fn log_powers(&self, samples: &[f32]) -> [f32; BANDS] {
        let mut buffer = [0.0; TRANSFORM];
        for ((to, sample), weight) in buffer.iter_mut().zip(samples).zip(&self.window) {
            *to = sample * weight;
        }
        let spectrum = microfft::real::rfft_512(&mut buffer);
        // The first value holds the two real ones, of 0 Hz and of 8 kHz, which no band has.
        let powers = spectrum.map(|value| value.norm_sqr() / TRANSFORM as f32);
        let mut logs = [0.0; BANDS];
        let bands = self.triangles.iter().zip(&self.noise);
        for (log, ((first, weights), noise)) in logs.iter_mut().zip(bands) {
            let power: f32 = weights
                .iter()
                .zip(&powers[*first..])
                .map(|(w, p)| w * p)
                .sum();
            *log = (power + noise + FLOOR).libm_ln();
        }
        logs
    }
}

/// What the emphasis of treble does to the power at a frequency.
fn emphasis(bin: usize) -> f64 {
    let share = f64::from(PRE_EMPHASIS);
    1.0 + share * share - 2.0 * share * (2.0 * PI * bin as f64 / TRANSFORM as f64).libm_cos()
}

/// The band that rises from `low` to `middle` and falls to `high`, in hertz.
fn triangle(low: f64, middle: f64, high: f64) -> (usize, Vec<f32>) {
    let frequency = |bin: usize| bin as f64 * f64::from(SAMPLE_RATE_HZ) / TRANSFORM as f64;
    let weight = |bin: usize| {
        let f = frequency(bin);
        ((f - low) / (middle - low)).min((high - f) / (high - middle))
    };
    let inside = (1..TRANSFORM / 2).filter(|bin| weight(*bin) > 0.0);
    let inside: Vec<usize> = inside.collect();
    let first = inside.first().copied().unwrap_or(0);
    (
        first,
        inside.iter().map(|bin| weight(*bin) as f32).collect(),
    )
}

/// O'Shaughnessy's mel scale.
fn mel(hertz: f64) -> f64 {
    2_595.0 * (1.0 + hertz / 700.0).libm_log10()
}

fn hertz(mel: f64) -> f64 {
    700.0 * (10f64.libm_powf(mel / 2_595.0) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_is_loudest_in_the_band_that_holds_it() {
        let bands = Bands::new();
        for tone_hz in [200.0, 1_000.0, 3_000.0, 6_500.0] {
            let sample =
                |n: usize| (2.0 * PI * tone_hz * n as f64 / f64::from(SAMPLE_RATE_HZ)).sin() as f32;
            let samples: Vec<f32> = (0..WINDOW).map(sample).collect();
            let logs = bands.log_powers(&samples);
            let loudest = (0..BANDS)
                .max_by(|a, b| logs[*a].total_cmp(&logs[*b]))
                .unwrap();
            let [low, high] = RANGE_HZ.map(mel);
            let step = (high - low) / (BANDS + 1) as f64;
            let middle = low + step * (loudest + 1) as f64;
            // A triangle reaches one step to either side of its middle.
            assert!(
                (mel(tone_hz) - middle).abs() <= step,
                "{tone_hz} Hz in band {loudest}"
            );
        }
    }

    #[test]
    fn power_follows_the_square_of_the_sample() {
        let bands = Bands::new();
        // Noise: a power near the floor would not follow.
        let noise =
            |n: usize| (n as u32).wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32 - 0.5;
        let samples: Vec<f32> = (0..WINDOW).map(noise).collect();
        let louder: Vec<f32> = samples.iter().map(|s| 4.0 * s).collect();
        let (soft, loud) = (bands.log_powers(&samples), bands.log_powers(&louder));
        for (soft, loud) in soft.iter().zip(loud) {
            assert!((loud - soft - 16f32.ln()).abs() < 1e-3);
        }
    }
}
