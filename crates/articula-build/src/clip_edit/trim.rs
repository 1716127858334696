//! Cutting a part out of a clip.

use super::channel;
use crate::key_times::SAME_SECS;
use articula_core::Mismatch;
use articula_core::source::{Channel, RawClip};
use std::ops::RangeInclusive;

/// Returns the part of a clip between two times, moved to start at 0. Both cuts have a key with the
/// exact value; in between nothing changes (splines of rotations: by 1e-5 rad at most). A channel
/// with one key keeps it unchanged.
///
/// # Errors
/// A [`Mismatch`] if the times are not an ascending interval of the clip, or the clip is malformed.
pub fn trim(clip: &RawClip, secs: RangeInclusive<f32>) -> Result<RawClip, Mismatch> {
    channel::check(clip)?;
    let (from, to) = (*secs.start(), *secs.end());
    let end = clip.duration_secs;
    if !(from >= 0.0 && from < to && to <= end + SAME_SECS) {
        let what = format!("{from} to {to} s is not an interval within 0 to {end} s");
        return Err(Mismatch::new(format!("clip \"{}\"", clip.name), what));
    }
    let mut out = RawClip {
        name: clip.name.clone(),
        duration_secs: to - from,
        channels: clip.channels.iter().map(|c| part(c, from, to)).collect(),
    };
    channel::keep_length(&mut out);
    Ok(out)
}

/// Returns a clip without its first frame: it begins at the earliest key after its start. Captures
/// often begin with a frame of the rest pose. A clip without two later key times is unchanged.
///
/// # Errors
/// A [`Mismatch`] if the clip is malformed.
pub fn skip_first_frame(clip: &RawClip) -> Result<RawClip, Mismatch> {
    channel::check(clip)?;
    let keys = clip.channels.iter().flat_map(|c| &c.times_secs);
    let later = keys.copied().filter(|t| *t > SAME_SECS);
    let second = later.fold(f32::INFINITY, f32::min);
    if second < clip.duration_secs - SAME_SECS {
        trim(clip, second..=clip.duration_secs)
    } else {
        Ok(clip.clone())
    }
}

fn part(whole: &Channel, from: f32, to: f32) -> Channel {
    let mut cut = whole.clone();
    if cut.times_secs.len() == 1 {
        cut.times_secs[0] = 0.0;
        return cut;
    }
    channel::put_key(&mut cut, to);
    let first = channel::put_key(&mut cut, from);
    // The keys before the cut have shifted by those that the cut has inserted.
    let last = channel::put_key(&mut cut, to);
    let floats = cut.values.len() / cut.times_secs.len();
    cut.values.truncate((last + 1) * floats);
    cut.values.drain(..first * floats);
    cut.times_secs.truncate(last + 1);
    cut.times_secs.drain(..first);
    for t in &mut cut.times_secs {
        *t -= from;
    }
    // Existing keys may differ from the cut by rounding.
    let keys = cut.times_secs.len();
    cut.times_secs[0] = 0.0;
    cut.times_secs[keys - 1] = to - from;
    cut
}

#[cfg(test)]
mod tests {
    use super::super::test_clips::{clips, greatest_difference, line};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_first_frame_is_skipped_and_nothing_else() {
        let clip = line(&[0.0, 0.1, 0.2, 0.3], &[5.0, 1.0, 2.0, 4.0]);
        let cut = skip_first_frame(&clip).unwrap();
        assert!((cut.duration_secs - 0.2).abs() < 1e-6);
        let (whole, part) = (&clip.channels[0], &cut.channels[0]);
        assert_eq!(part.times_secs.len(), 3);
        assert_eq!(part.values[..], whole.values[whole.values.len() / 4..]);
        let short = line(&[0.0, 0.1], &[5.0, 1.0]);
        assert_eq!(
            skip_first_frame(&short).unwrap(),
            short,
            "one frame would be left"
        );
    }

    #[test]
    fn a_line_is_cut_by_hand() {
        // 0 to 4 over 2 s, key at the middle: from 0.5 to 1.5 s it runs from 1 to 3.
        let clip = line(&[0.0, 1.0, 2.0], &[0.0, 2.0, 4.0]);
        let cut = trim(&clip, 0.5..=1.5).unwrap();
        assert_eq!(cut.duration_secs, 1.0);
        assert_eq!(cut.channels[0].times_secs, [0.0, 0.5, 1.0]);
        let x: Vec<f32> = cut.channels[0].values.chunks(3).map(|v| v[0]).collect();
        assert_eq!(x, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn keys_at_the_cuts_are_not_doubled() {
        let clip = line(&[0.0, 1.0, 2.0], &[0.0, 2.0, 4.0]);
        let whole = trim(&clip, 0.0..=2.0).unwrap();
        assert_eq!(whole, clip);
        let half = trim(&clip, 0.0..=1.0).unwrap();
        assert_eq!(half.channels[0].times_secs, [0.0, 1.0]);
    }

    #[test]
    fn what_is_no_part_is_refused() {
        let clip = line(&[0.0, 2.0], &[0.0, 4.0]);
        for bad in [1.0..=1.0, 1.5..=0.5, -0.1..=1.0, 0.0..=2.1, f32::NAN..=1.0] {
            assert!(trim(&clip, bad.clone()).is_err(), "{bad:?}");
        }
        let mut broken = clip.clone();
        broken.channels[0].values.pop();
        assert!(trim(&broken, 0.0..=1.0).is_err());
    }

    #[test]
    fn a_still_clip_keeps_its_length() {
        let mut clip = line(&[0.0], &[3.0]);
        clip.duration_secs = 5.0;
        let cut = trim(&clip, 1.0..=3.0).unwrap();
        assert_eq!(
            (cut.duration_secs, cut.channels[0].times_secs.last()),
            (2.0, Some(&2.0))
        );
    }

    proptest! {
        #[test]
        fn two_parts_are_the_whole(clip in clips(), at in 0.05f32..0.95) {
            let end = clip.duration_secs;
            let cut = at * end;
            let first = trim(&clip, 0.0..=cut).unwrap();
            let second = trim(&clip, cut..=end).unwrap();
            prop_assert!((first.duration_secs + second.duration_secs - end).abs() < 1e-5);
            let before = |t: f32| t.min(cut);
            prop_assert!(greatest_difference(&clip, &first, before, |t| t, cut) < 1e-4);
            let after = end - cut;
            prop_assert!(greatest_difference(&clip, &second, |t| t + cut, |t| t, after) < 1e-4);
        }
    }
}
