//! Resampling of source clips: every channel keyed at one rate.

use super::channel;
use crate::clip::steps_at;
use crate::key_times::{SAME_SECS, rising};
use articula_core::Mismatch;
use articula_core::source::{Channel, Interpolation, RawClip};

/// Returns the clip with exact keys at every `1 / rate_hz` seconds and at its end; the last
/// interval is shorter where the length is no multiple. Splines become straight lines between the
/// keys, steps stay steps (their jumps move to the next key), and of other jumps both keys stay. A
/// channel with one key keeps it unchanged.
///
/// # Errors
/// A [`Mismatch`] if the rate is not positive, the clip is malformed, or it would have more than a
/// million keys per channel or more floats than the memory limit allows.
pub fn resample_keys(clip: &RawClip, rate_hz: f32) -> Result<RawClip, Mismatch> {
    channel::check(clip)?;
    let numbers = clip.channels.iter().map(channel::width).sum();
    steps_at(clip, clip.duration_secs, rate_hz, numbers)?;
    let times = times(clip.duration_secs, rate_hz);
    let mut out = RawClip {
        channels: clip.channels.iter().map(|c| keyed(c, &times)).collect(),
        ..clip.clone()
    };
    channel::keep_length(&mut out);
    Ok(out)
}

fn keyed(source: &Channel, times: &[f32]) -> Channel {
    if source.times_secs.len() == 1 {
        return Channel {
            interpolation: match source.interpolation {
                Interpolation::Step => Interpolation::Step,
                _ => Interpolation::Linear,
            },
            times_secs: vec![0.0],
            values: channel::key_value(source, 0).to_vec(),
            ..source.clone()
        };
    }
    // A key that differs from the time by rounding is copied, to the last bit.
    let value = |t: &f32| match channel::key_at(source, *t) {
        Some(key) => channel::key_value(source, key).to_vec(),
        None => channel::value(source, *t),
    };
    let interpolation = match source.interpolation {
        Interpolation::Step => Interpolation::Step,
        _ => Interpolation::Linear,
    };
    let mut times = times.to_vec();
    if interpolation == Interpolation::Linear {
        times.extend(jump_keys(source));
        times = rising(times);
    }
    Channel {
        interpolation,
        values: times.iter().flat_map(value).collect(),
        times_secs: times,
        ..source.clone()
    }
}

/// Both keys of each jump: without them it would become a ramp between frames.
fn jump_keys(source: &Channel) -> impl Iterator<Item = f32> + '_ {
    let times = &source.times_secs;
    source.jump_times().flat_map(|jump| {
        let after = times.partition_point(|t| *t < jump);
        [times[after.saturating_sub(1)], jump]
    })
}

fn times(duration_secs: f32, rate_hz: f32) -> Vec<f32> {
    let end = f64::from(duration_secs);
    let time = |i: usize| i as f64 / f64::from(rate_hz);
    // A key just before the end would only duplicate the end.
    let near = (1e-3 / f64::from(rate_hz)).max(f64::from(SAME_SECS));
    let mut times: Vec<f32> = (0..)
        .map(time)
        .take_while(|t| *t < end - near)
        .map(|t| t as f32)
        .collect();
    times.push(duration_secs);
    times
}

#[cfg(test)]
mod tests {
    use super::super::test_clips::{clips, difference, line};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_end_is_a_key_whatever_the_rate() {
        let clip = line(&[0.0, 1.0], &[0.0, 2.0]);
        let out = resample_keys(&clip, 4.0).unwrap();
        assert_eq!(out.channels[0].times_secs, [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(out.channels[0].values[3], 0.5);
        let out = resample_keys(&clip, 0.4 * 4.0).unwrap();
        assert_eq!(out.channels[0].times_secs, [0.0, 0.625, 1.0]);
        assert_eq!(out.channels[0].values[3], 1.25);
        // 2751 frames at 120 Hz end by rounding after the second to last one.
        let clip = line(&[0.0, 22.925], &[0.0, 2.0]);
        let times = resample_keys(&clip, 120.0).unwrap().channels[0]
            .times_secs
            .clone();
        assert_eq!(times.len(), 2752);
        assert!(times[2751] - times[2750] > 0.008);
    }

    #[test]
    fn endless_clips_and_no_rates_are_refused() {
        let clip = line(&[0.0, 1e30], &[0.0, 2.0]);
        assert!(resample_keys(&clip, 30.0).is_err());
        let clip = line(&[0.0, 1.0], &[0.0, 2.0]);
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(resample_keys(&clip, bad).is_err(), "{bad}");
        }
    }

    proptest! {
        #[test]
        fn twice_is_once_and_keys_are_hit(clip in clips(), rate in 5.0f32..120.0) {
            let once = resample_keys(&clip, rate).unwrap();
            prop_assert_eq!(&resample_keys(&once, rate).unwrap(), &once);
            let densest = once.channels.iter().max_by_key(|c| c.times_secs.len()).unwrap();
            for t in &densest.times_secs {
                prop_assert!(difference(&clip, &once, *t, *t) < 1e-5);
            }
        }
    }
}
