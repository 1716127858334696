//! Recordings as samples of one channel at 16 kHz.

use crate::{Resampler, SAMPLE_RATE_HZ};
use hound::{SampleFormat, WavReader};
use std::io::Cursor;

/// Longest recording that is read.
const MAX_SECS: u32 = 3_600;
/// Sampling rates that are read.
const RATES_HZ: std::ops::RangeInclusive<u32> = 4_000..=384_000;

/// A recording of one channel at [`SAMPLE_RATE_HZ`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sound {
    /// Samples, between -1 and 1.
    pub samples: Vec<f32>,
}

/// Error of [`Sound::from_wav`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SoundError {
    /// The bytes are not a whole WAV file of PCM or floats.
    #[error("not a WAV file of PCM or float samples: {0}; convert it with `ffmpeg -i IN OUT.wav`")]
    Malformed(String),
    /// The sampling rate is not one of sound.
    #[error("{0} samples a second; 4,000 to 384,000 are read")]
    Rate(u32),
    /// The recording is longer than an hour.
    #[error("the recording takes {0} s; 3,600 are read at most: cut it into parts")]
    Long(u32),
}

impl Sound {
    /// Samples of one channel at another rate, at least 1 a second.
    pub fn new(samples: &[f32], rate_hz: u32) -> Self {
        let mut resampler = Resampler::new(rate_hz);
        let mut made = resampler.push(samples);
        made.extend(resampler.finish());
        Self { samples: made }
    }

    /// Reads a WAV file: PCM of 8 to 32 bits or floats, of any rate; channels are mixed.
    ///
    /// # Errors
    /// A [`SoundError`].
    pub fn from_wav(bytes: &[u8]) -> Result<Self, SoundError> {
        let malformed = |fault: hound::Error| SoundError::Malformed(fault.to_string());
        let mut reader = WavReader::new(Cursor::new(bytes)).map_err(malformed)?;
        let spec = reader.spec();
        if !RATES_HZ.contains(&spec.sample_rate) {
            return Err(SoundError::Rate(spec.sample_rate));
        }
        let secs = reader.duration() / spec.sample_rate;
        if secs > MAX_SECS {
            return Err(SoundError::Long(secs));
        }
        let samples: Result<Vec<f32>, _> = match spec.sample_format {
            SampleFormat::Float => reader.samples::<f32>().collect(),
            SampleFormat::Int => {
                let scale = 1.0 / (1u64 << spec.bits_per_sample.clamp(1, 32)) as f32 * 2.0;
                let samples = reader.samples::<i32>();
                samples.map(|s| s.map(|s| s as f32 * scale)).collect()
            }
        };
        let samples = samples.map_err(malformed)?;
        let channels = usize::from(spec.channels.max(1));
        let mixed = samples
            .chunks_exact(channels)
            .map(|frame| frame.iter().sum::<f32>() / channels as f32);
        let mixed: Vec<f32> = mixed.collect();
        Ok(Self::new(&mixed, spec.sample_rate))
    }

    /// Duration in seconds.
    pub fn duration_secs(&self) -> f32 {
        self.samples.len() as f32 / SAMPLE_RATE_HZ as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::{WavSpec, WavWriter};
    use proptest::prelude::*;

    /// A file of two channels, of which the right one has half of the left one.
    fn wav(bits: u16, format: SampleFormat, rate_hz: u32) -> Vec<u8> {
        let spec = WavSpec {
            channels: 2,
            sample_rate: rate_hz,
            bits_per_sample: bits,
            sample_format: format,
        };
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        for n in 0..rate_hz / 10 {
            for gain in [0.5, 0.25] {
                let sample = gain * (n as f32 * 2_000.0 / rate_hz as f32).sin();
                match format {
                    SampleFormat::Float => writer.write_sample(sample).unwrap(),
                    SampleFormat::Int => {
                        let full = (1i64 << (bits - 1)) as f32;
                        writer.write_sample((sample * full) as i32).unwrap();
                    }
                }
            }
        }
        writer.finalize().unwrap();
        bytes.into_inner()
    }

    #[test]
    fn every_width_and_rate_gives_the_same_sound() {
        let expected = Sound::from_wav(&wav(32, SampleFormat::Float, 16_000)).unwrap();
        assert_eq!(expected.samples.len(), 1_600);
        assert!((expected.samples[100] - 0.375 * (12.5f32).sin()).abs() < 1e-4);
        for (bits, format, rate_hz, within) in [
            (8, SampleFormat::Int, 16_000, 0.012),
            (16, SampleFormat::Int, 16_000, 1e-4),
            (24, SampleFormat::Int, 16_000, 1e-4),
            (16, SampleFormat::Int, 44_100, 1e-2),
        ] {
            let sound = Sound::from_wav(&wav(bits, format, rate_hz)).unwrap();
            for n in 100..1_400 {
                let off = (sound.samples[n] - expected.samples[n]).abs();
                assert!(
                    off < within,
                    "{bits} bits at {rate_hz} Hz: sample {n} is off by {off}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_sound_is_refused_in_a_line() {
        let mut slow = wav(16, SampleFormat::Int, 16_000);
        // Samples and bytes a second.
        slow[24..28].copy_from_slice(&10u32.to_le_bytes());
        slow[28..32].copy_from_slice(&40u32.to_le_bytes());
        assert_eq!(Sound::from_wav(&slow), Err(SoundError::Rate(10)));
        let error = Sound::from_wav(b"ID3").unwrap_err().to_string();
        assert!(error.contains("ffmpeg") && !error.contains('\n'), "{error}");
    }

    proptest! {
        #[test]
        fn damaged_files_give_a_sound_or_an_error(
            changes in prop::collection::vec((0usize..200, any::<u8>()), 1..8), cut in 0usize..400,
        ) {
            let mut bytes = wav(16, SampleFormat::Int, 8_000);
            for (at, value) in changes {
                bytes[at] = value;
            }
            bytes.truncate(bytes.len() - cut);
            if let Ok(sound) = Sound::from_wav(&bytes) {
                prop_assert!(sound.duration_secs() <= 3_601.0);
            }
        }
    }
}
