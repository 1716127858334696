//! Rooms, microphones and mouths that the synthesisers do not have.

use super::super::random::Random;
use super::corpus::Clip;
use articula_speech::training::Segment;
use articula_speech::{Resampler, SAMPLE_RATE_HZ};
use std::f32::consts::PI;

/// Seconds that a clip of the training has at most.
pub(super) const CLIP_SECS: f32 = 6.0;
const RATE: f32 = SAMPLE_RATE_HZ as f32;

/// The samples and shapes of a clip, changed at random, with up to half a second of silence before it.
pub(super) fn changed(clip: &Clip, random: &mut Random) -> (Vec<f32>, Vec<Segment>) {
    let mut samples = clip.sound.samples.clone();
    samples.truncate((CLIP_SECS * RATE) as usize);
    let lead = vec![0.0; (0.5 * random.unit() * RATE) as usize];
    let lead_secs = lead.len() as f32 / RATE;
    samples.splice(0..0, lead);
    let mut stretch = 1.0;
    if random.unit() < 0.75 {
        stretch = 1.0 / (0.8 + 0.42 * random.unit());
        samples = stretched(&samples, stretch);
    }
    let shifted = |secs: f32| (secs + lead_secs) * stretch;
    let segments = clip.segments.iter().map(|segment| Segment {
        start_secs: shifted(segment.start_secs),
        end_secs: shifted(segment.end_secs),
        ..*segment
    });
    let segments = segments.collect();
    let level = root_mean_square(&samples).max(1e-5);
    if random.unit() < 0.7 {
        samples = filtered(&samples, &equaliser(random));
    }
    if random.unit() < 0.35 {
        samples = in_a_room(&samples, random);
    }
    if random.unit() < 0.25 {
        let cut_hz = 3_300.0 + 3_200.0 * random.unit();
        samples = filtered(&samples, &low_pass(cut_hz));
    }
    if random.unit() < 0.75 {
        add_noise(&mut samples, level, random);
    }
    if random.unit() < 0.15 {
        let drive = 0.2 + 0.6 * random.unit();
        samples
            .iter_mut()
            .for_each(|s| *s = (*s / level * drive).tanh() * level);
    }
    let gain = 10f32.powf((-48.0 + 36.0 * random.unit()) / 20.0) / level;
    samples.iter_mut().for_each(|s| *s *= gain);
    (samples, segments)
}

fn root_mean_square(samples: &[f32]) -> f32 {
    (samples.iter().map(|s| s * s).sum::<f32>() / samples.len().max(1) as f32).sqrt()
}

/// The same, longer by a factor and lower by it: another tempo and another length of the throat.
fn stretched(samples: &[f32], factor: f32) -> Vec<f32> {
    let mut resampler = Resampler::new((RATE / factor) as u32);
    let mut out = resampler.push(samples);
    out.extend(resampler.finish());
    out
}

/// A random smooth response with a deviation of 4.5 dB, as 64 taps.
fn equaliser(random: &mut Random) -> Vec<f32> {
    let knots: [f32; 6] = std::array::from_fn(|_| 4.5 * random.normal());
    let gain = |bin: usize| {
        let at = bin as f32 / 32.0 * 5.0;
        let (low, share) = ((at as usize).min(4), at - (at as usize).min(4) as f32);
        10f32.powf((knots[low] + share * (knots[low + 1] - knots[low])) / 20.0)
    };
    // The response of even phase, by the cosines of its bins, under a raised cosine.
    let tap = |tap: usize| {
        let n = tap as f32 - 32.0;
        let wave = |bin: usize| gain(bin) * (PI * bin as f32 * n / 32.0).cos();
        let inner: f32 = (1..32).map(wave).sum();
        let sum = wave(0) + wave(32) + 2.0 * inner;
        sum / 64.0 * (0.5 + 0.5 * (PI * n / 32.0).cos())
    };
    (0..64).map(tap).collect()
}

/// A sinc under a raised cosine, of 63 taps.
fn low_pass(cut_hz: f32) -> Vec<f32> {
    let cut = 2.0 * cut_hz / RATE;
    let tap = |tap: usize| {
        let n = tap as f32 - 31.0;
        let sinc = if n == 0.0 {
            cut
        } else {
            (PI * cut * n).sin() / (PI * n)
        };
        sinc * (0.5 + 0.5 * (PI * n / 32.0).cos())
    };
    (0..63).map(tap).collect()
}

/// The sum of shifted copies, in step with the sound that came in.
fn filtered(samples: &[f32], taps: &[f32]) -> Vec<f32> {
    let middle = taps.len() / 2;
    let mut out = vec![0.0; samples.len()];
    for (tap, weight) in taps.iter().enumerate() {
        add_shifted(&mut out, samples, tap as isize - middle as isize, *weight);
    }
    out
}

fn add_shifted(out: &mut [f32], samples: &[f32], shift: isize, weight: f32) {
    let skip = shift.unsigned_abs().min(out.len());
    let (out, samples) = if shift < 0 {
        (&mut out[..], &samples[skip..])
    } else {
        (&mut out[skip..], samples)
    };
    for (out, sample) in out.iter_mut().zip(samples) {
        *out += weight * sample;
    }
}

/// Echoes that die away over 80 to 450 ms, one every half millisecond at a random time and of a random
/// sign: a room costs as little as it may.
fn in_a_room(samples: &[f32], random: &mut Random) -> Vec<f32> {
    let secs = 0.08 + 0.37 * random.unit();
    let share = 0.05 + 0.45 * random.unit();
    let spacing = 8.0;
    let count = (secs * RATE / spacing) as usize;
    let echoes: Vec<(usize, f32)> = (0..count)
        .map(|index| {
            let at = (index as f32 + random.unit()) * spacing;
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            (at as usize + 1, sign * (-6.9 * at / (secs * RATE)).exp())
        })
        .collect();
    let energy: f32 = echoes.iter().map(|(_, weight)| weight * weight).sum();
    let mut out = samples.to_vec();
    for (at, weight) in echoes {
        add_shifted(
            &mut out,
            samples,
            at as isize,
            share * weight / energy.sqrt(),
        );
    }
    out
}

/// Noise of a random colour, 5 to 40 dB below the voice, that swells.
fn add_noise(samples: &mut [f32], level: f32, random: &mut Random) {
    let colour = 0.97 * random.unit();
    let mut last = 0.0;
    let noise: Vec<f32> = samples
        .iter()
        .map(|_| {
            last = random.normal() + colour * last;
            last
        })
        .collect();
    let below = 10f32.powf(-(5.0 + 35.0 * random.unit()) / 20.0);
    let gain = level * below / root_mean_square(&noise).max(1e-6);
    let (hertz, phase) = (0.5 + 7.5 * random.unit(), 6.0 * random.unit());
    for (index, (sample, noise)) in samples.iter_mut().zip(noise).enumerate() {
        let swell = 1.0 + 0.5 * (index as f32 / RATE * hertz + phase).sin();
        *sample += gain * swell * noise;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_speech::{Sound, Viseme};

    #[test]
    fn filters_keep_the_time_of_a_click() {
        let mut click = vec![0.0; 400];
        click[200] = 1.0;
        for taps in [low_pass(4_000.0), equaliser(&mut Random(3))] {
            let out = filtered(&click, &taps);
            let loudest = (0..400).max_by(|a, b| out[*a].abs().total_cmp(&out[*b].abs()));
            assert_eq!(loudest, Some(200));
        }
    }

    #[test]
    fn shapes_stay_with_their_sound() {
        // A tone of a tenth of a second in silence.
        let tone = |n: usize| {
            if (8_000..9_600).contains(&n) {
                (n as f32 * 0.4).sin() * 0.3
            } else {
                0.0
            }
        };
        let samples: Vec<f32> = (0..16_000).map(tone).collect();
        let clip = Clip {
            sound: Sound::new(&samples, SAMPLE_RATE_HZ),
            segments: vec![Segment {
                start_secs: 0.5,
                end_secs: 0.6,
                viseme: Viseme::Aa,
            }],
            phones: Vec::new(),
        };
        for seed in 0..20 {
            let (samples, segments) = changed(&clip, &mut Random(seed));
            let at = |secs: f32| ((secs * RATE) as usize).min(samples.len());
            let inside =
                root_mean_square(&samples[at(segments[0].start_secs)..at(segments[0].end_secs)]);
            let before = root_mean_square(&samples[..at(segments[0].start_secs - 0.01)]);
            assert!(inside > 2.0 * before, "seed {seed}: {inside} {before}");
        }
    }
}
