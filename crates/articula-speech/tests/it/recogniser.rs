//! Sound in blocks, and sound that is none.

use articula_speech::{LOOK_AHEAD_SECS, Recogniser, SAMPLE_RATE_HZ, VisemeFrame};
use proptest::prelude::*;

/// Samples of a frame.
const HOP: usize = 160;

/// A buzz whose pitch glides, with pauses: every part of the recogniser has something to do.
fn buzz(count: usize) -> Vec<f32> {
    let sample = |n: usize| {
        let secs = n as f32 / SAMPLE_RATE_HZ as f32;
        let voiced = (secs * 3.0).fract() < 0.7;
        let phase = (secs * (110.0 + 40.0 * secs)).fract();
        if voiced {
            0.3 * (1.0 - 2.0 * phase)
        } else {
            0.0
        }
    };
    (0..count).map(sample).collect()
}

fn whole(samples: &[f32]) -> Vec<VisemeFrame> {
    let mut recogniser = Recogniser::new();
    let mut frames = recogniser.push(samples);
    frames.extend(recogniser.finish());
    frames
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn blocks_of_any_size_give_the_same_frames(
        count in 0usize..20_000, block in 1usize..3_000,
    ) {
        let samples = buzz(count);
        let mut recogniser = Recogniser::new();
        let mut frames = Vec::new();
        for block in samples.chunks(block) {
            frames.extend(recogniser.push(block));
        }
        frames.extend(recogniser.finish());
        prop_assert_eq!(frames.len(), count / HOP);
        prop_assert!(frames == whole(&samples));
    }
}

#[test]
fn a_frame_comes_as_soon_as_is_promised() {
    let samples = buzz(16_000);
    let mut recogniser = Recogniser::new();
    let first = samples
        .chunks(1)
        .position(|s| !recogniser.push(s).is_empty())
        .unwrap()
        + 1;
    // The middle of the first frame is 80 samples into the sound.
    let promised = 80.0 + LOOK_AHEAD_SECS * SAMPLE_RATE_HZ as f32;
    assert_eq!(first as f32, promised);
}

#[test]
fn weights_are_shares_and_anything_may_come_in() {
    let mut samples = buzz(8_000);
    samples[3_000] = f32::NAN;
    samples[3_001] = f32::INFINITY;
    samples[3_002] = 1e30;
    for frame in whole(&samples) {
        let sum: f32 = frame.weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-5);
        assert!(frame.weights.iter().all(|w| (0.0..=1.0).contains(w)));
        assert!(frame.level_db <= 0.0);
    }
}
