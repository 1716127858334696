//! Sound at other rates.

use articula_speech::{Resampler, SAMPLE_RATE_HZ};
use proptest::prelude::*;
use std::f64::consts::PI;

fn tone(hertz: f64, rate_hz: u32, secs: f64) -> Vec<f32> {
    let sample = |n: usize| (2.0 * PI * hertz * n as f64 / f64::from(rate_hz)).sin() as f32;
    (0..(secs * f64::from(rate_hz)) as usize)
        .map(sample)
        .collect()
}

fn resampled(samples: &[f32], rate_hz: u32) -> Vec<f32> {
    let mut resampler = Resampler::new(rate_hz);
    let mut out = resampler.push(samples);
    out.extend(resampler.finish());
    out
}

#[test]
fn tones_below_the_half_rate_stay_and_those_above_go() {
    for rate_hz in [8_000, 11_025, 22_050, 44_100, 48_000, 96_000] {
        let kept = resampled(&tone(1_000.0, rate_hz, 0.3), rate_hz);
        let expected = tone(1_000.0, SAMPLE_RATE_HZ, 0.3);
        assert!(kept.len().abs_diff(expected.len()) <= 1, "{rate_hz}");
        let inner = 800..expected.len() - 800;
        for n in inner.clone() {
            assert!((kept[n] - expected[n]).abs() < 0.01, "{rate_hz} at {n}");
        }
        if rate_hz > 32_000 {
            let gone = resampled(&tone(11_000.0, rate_hz, 0.3), rate_hz);
            let most = gone[inner].iter().fold(0.0f32, |m, s| m.max(s.abs()));
            assert!(most < 0.01, "{rate_hz}: {most}");
        }
    }
}

proptest! {
    #[test]
    fn blocks_of_any_size_give_the_same_samples(
        rate_hz in 8_000u32..50_000, count in 0usize..3_000, block in 1usize..700,
    ) {
        let samples = tone(700.0, rate_hz, count as f64 / f64::from(rate_hz));
        let mut resampler = Resampler::new(rate_hz);
        let mut out = Vec::new();
        for block in samples.chunks(block) {
            out.extend(resampler.push(block));
        }
        out.extend(resampler.finish());
        prop_assert_eq!(out, resampled(&samples, rate_hz));
    }
}
