//! Resamples keyed channels to a clip of uniform rate.
//!
//! The rate is that at which frames [represent the keys](crate::sampling_rate). The end of the clip
//! always falls on a frame.

use crate::sampling_rate::{
    SamplingRate, blended_rate, exact_rate, frame_time, keyed_rate, source_rate_hz,
};
use articula_core::source::evaluate::{self, ChannelSampler};
use articula_core::source::{self, Channel, Interpolation, Property};
use articula_core::{Clip, Mismatch, Track, Tracks, angle_between, same_hemisphere};
use glam::{Quat, Vec3};
use std::borrow::Cow;

/// Maximum number of floats in the tracks of a clip, or of all clips of a character: half a
/// gigabyte. Two keys of a small file can span any length.
pub(crate) const MAX_NUMBERS: usize = 1 << 27;

/// Options of resampling a clip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClipOptions {
    /// Frames per second; `None` chooses a rate whose frames follow the keys, as
    /// [`sampling_rate_hz`] does. Regular keys are multiplied where joints turn so fast that blends of
    /// frames would leave them by 0.3 degrees.
    pub rate_hz: Option<f32>,
}

/// Differences from rest below which a property gets no track; of translations, as a share of the
/// figure's extent.
const STILL_SHARE: f32 = 1e-7;
const STILL_RADIANS: f32 = 1e-6;

/// Returns the lowest rate in hertz at which frames of a clip follow its keys: at its key times, at the
/// midpoints between them and at random times within 0.1 mm of skin (in figures beyond 2 m, 1/20,000 of their
/// extent) and 0.05 degrees of each joint.
/// Where no rate up to 240 Hz does, one that comes close.
///
/// Regular keys are frames of their own rate. A jump takes a frame of at least 120 Hz. A clip that does
/// not fit the skeleton gets the [rate at which it was keyed](source_rate_hz).
pub fn sampling_rate_hz(clip: &source::RawClip, skeleton: &source::Skeleton) -> f32 {
    let fits_skeleton = |c: &Channel| {
        let width = match c.property {
            Property::Weights | Property::Expression => 1,
            _ => width(c, &[]),
        };
        let parts = match c.interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        let keys = c.times_secs.len();
        let is_there = !c.property.is_of_joint() || c.target < skeleton.joints.len();
        is_there && keys > 0 && c.values.len() >= keys * parts * width
    };
    if !clip.channels.iter().all(fits_skeleton) {
        return source_rate_hz(clip);
    }
    let numbers = 10 * skeleton.joints.len();
    let fits = |rate| steps_at(clip, clip.duration_secs, rate, numbers).is_ok();
    keyed_rate(clip, skeleton, &fits).rate_hz
}

/// Resamples a clip for `skeleton`; `morph_slots` holds the first morph slot of each mesh and
/// `morph_counts` its number of morph targets.
///
/// # Errors
/// A [`Mismatch`] if a channel names a joint or mesh that does not exist, has no key or fewer
/// values than its keys need, or drives an expression ([`bake`](crate::expression::bake) resolves
/// those), or if the clip would have more than a million frames or more floats than the memory
/// limit allows.
///
/// # Panics
/// If `morph_slots` and `morph_counts` differ in length.
pub(crate) fn resample(
    clip: &source::RawClip,
    skeleton: &source::Skeleton,
    morph_slots: &[usize],
    morph_counts: &[usize],
    opts: &ClipOptions,
) -> Result<Clip, Mismatch> {
    for (c, channel) in clip.channels.iter().enumerate() {
        check(channel, skeleton.joints.len(), morph_counts)
            .map_err(|what| Mismatch::new(format!("clip \"{}\".channels[{c}]", clip.name), what))?;
    }
    let duration = if clip.duration_secs.is_finite() {
        clip.duration_secs.max(0.0)
    } else {
        0.0
    };
    // A clip too long at the rate of its keys is rejected before it is analysed further.
    let keyed = opts.rate_hz.unwrap_or_else(|| source_rate_hz(clip));
    let numbers = clip.channels.iter().map(|c| width(c, morph_counts)).sum();
    steps_at(clip, duration, keyed, numbers)?;
    let fits = |rate| steps_at(clip, duration, rate, numbers).is_ok();
    let chosen = match opts.rate_hz {
        Some(rate_hz) => SamplingRate {
            rate_hz,
            frames_per_key: 1,
        },
        None => blended_rate(clip, skeleton, &fits),
    };
    let wanted = chosen.rate_hz;
    let extents = skeleton.local_extents();
    let steps = steps_at(clip, duration, wanted, numbers)?;
    // Scale the grid by less than half a frame so that it ends exactly with the clip.
    let rate = if steps == 0 || duration == 0.0 {
        wanted
    } else {
        exact_rate(steps, duration, wanted)
    };
    let times: Vec<f32> = (0..=steps)
        .map(|i| {
            if i == steps {
                duration
            } else {
                i as f32 / rate
            }
        })
        .collect();
    let mut tracks = Tracks::default();
    for channel in &clip.channels {
        let target = channel.target;
        let times = &shown_times(channel, &times, rate);
        if channel.property == Property::Weights {
            let (slot, count) = (morph_slots[target], morph_counts[target]);
            weight_tracks(channel, slot, count, times, &mut tracks);
        } else {
            let still = STILL_SHARE * extents[target];
            joint_track(
                channel,
                (&skeleton.joints[target], still),
                times,
                &mut tracks,
            );
        }
    }
    let built = Clip::new(&clip.name, rate, times.len(), skeleton.joints.len(), tracks)?;
    Ok(built.with_frames_per_key(chosen.frames_per_key))
}

/// The times at which frames of a channel are evaluated.
fn shown_times<'t>(channel: &Channel, times: &'t [f32], rate: f32) -> Cow<'t, [f32]> {
    if channel.jump_times().next().is_none() {
        return Cow::Borrowed(times);
    }
    let times = times.iter().map(|t| frame_time(channel, true, *t, rate));
    Cow::Owned(times.collect())
}

/// Number of frame intervals at a rate, where each frame holds `numbers` floats.
pub(crate) fn steps_at(
    clip: &source::RawClip,
    duration: f32,
    rate: f32,
    numbers: usize,
) -> Result<usize, Mismatch> {
    if !(rate.is_finite() && rate > 0.0) {
        let what = format!("must be positive and finite, found {rate}");
        return Err(Mismatch::new("rate_hz", what));
    }
    let steps = (f64::from(duration) * f64::from(rate)).round();
    let at = || format!("clip \"{}\"", clip.name);
    if steps > 1e6 {
        let what = format!("{duration} s at {rate} Hz make {steps} frames, the limit is 1000000");
        return Err(Mismatch::new(at(), what));
    }
    let numbers = (steps as usize).saturating_mul(numbers);
    if numbers > MAX_NUMBERS {
        let what =
            format!("{duration} s at {rate} Hz make {numbers} values, the limit is {MAX_NUMBERS}");
        return Err(Mismatch::new(at(), what));
    }
    Ok(steps as usize)
}

/// Checks that a channel's target exists and that it has keys and as many values as they need.
pub(crate) fn check(
    channel: &Channel,
    joints: usize,
    morph_counts: &[usize],
) -> Result<(), String> {
    let (kind, targets) = match channel.property {
        Property::Weights => ("mesh", morph_counts.len()),
        Property::Expression => {
            return Err("the channel drives an expression; bake the clip first".into());
        }
        _ => ("joint", joints),
    };
    if channel.target >= targets {
        return Err(format!(
            "{kind} {} is out of range: there are {targets}",
            channel.target
        ));
    }
    let width = width(channel, morph_counts);
    let keys = channel.times_secs.len();
    let floats = match channel.interpolation {
        Interpolation::CubicSpline => 3 * width,
        _ => width,
    };
    if keys == 0 || channel.values.len() < keys * floats {
        let found = channel.values.len();
        return Err(format!(
            "{found} values, but {keys} keys need {floats} floats each"
        ));
    }
    Ok(())
}

/// Number of floats in one value of a channel.
fn width(channel: &Channel, morph_counts: &[usize]) -> usize {
    match channel.property {
        Property::Rotation => 4,
        Property::Translation | Property::Scale => 3,
        Property::Weights => morph_counts[channel.target],
        Property::Expression => 1,
    }
}

/// Adds the track of a channel; `still` is the difference below which a translation is at rest.
fn joint_track(
    channel: &Channel,
    (joint, still): (&source::Joint, f32),
    times: &[f32],
    tracks: &mut Tracks,
) {
    let target = channel.target as u16;
    let step = channel.interpolation == Interpolation::Step;
    let vectors = |rest: Vec3, still: f32| -> Option<Track<Vec3>> {
        let mut sampler = ChannelSampler::new(channel);
        let value = |t: &f32| Vec3::from_slice(&sampler.value(*t));
        let values: Vec<Vec3> = times.iter().map(value).collect();
        let spread = |from: Vec3| values.iter().map(|v| v.distance(from)).fold(0.0, f32::max);
        if spread(rest) <= still {
            return None;
        }
        let holds = spread(values[0]) <= still;
        let values = if holds { vec![values[0]] } else { values };
        Some(Track {
            target,
            step,
            values,
        })
    };
    match channel.property {
        Property::Translation => tracks
            .translations
            .extend(vectors(joint.rest.translation, still)),
        Property::Scale => tracks.scales.extend(vectors(joint.rest.scale, STILL_SHARE)),
        Property::Rotation => tracks.rotations.extend(rotations(channel, joint, times)),
        Property::Weights | Property::Expression => {}
    }
}

fn rotations(channel: &Channel, joint: &source::Joint, times: &[f32]) -> Option<Track<Quat>> {
    let mut values: Vec<Quat> = Vec::with_capacity(times.len());
    let mut sampler = ChannelSampler::new(channel);
    for t in times {
        let q = Quat::from_array(sampler.value(*t));
        values.push(
            values
                .last()
                .map_or(q, |before| same_hemisphere(*before, q)),
        );
    }
    let spread = |from: Quat| {
        values
            .iter()
            .map(|q| angle_between(*q, from))
            .fold(0.0, f32::max)
    };
    if spread(joint.rest.rotation) <= STILL_RADIANS {
        return None;
    }
    let still = spread(values[0]) <= STILL_RADIANS;
    Some(Track {
        target: channel.target as u16,
        step: channel.interpolation == Interpolation::Step,
        values: if still { vec![values[0]] } else { values },
    })
}

fn weight_tracks(channel: &Channel, slot: usize, count: usize, times: &[f32], tracks: &mut Tracks) {
    let mut weights = vec![0.0; count];
    let mut values = vec![Vec::with_capacity(times.len()); count];
    for t in times {
        evaluate::channel(channel, *t, &mut weights);
        for (track, w) in values.iter_mut().zip(&weights) {
            track.push(*w);
        }
    }
    for (i, mut values) in values.into_iter().enumerate() {
        if values.iter().all(|v| *v == values[0]) {
            values.truncate(1);
        }
        tracks.morphs.push(Track {
            target: (slot + i) as u16,
            step: channel.interpolation == Interpolation::Step,
            values,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::{JointSet, LocalPose, Wrap, sample};
    use proptest::prelude::*;

    fn skeleton() -> source::Skeleton {
        source::Skeleton {
            joints: vec![source::Joint {
                name: "j".into(),
                parent: None,
                rest: articula_core::Transform::IDENTITY,
                in_skin: true,
            }],
        }
    }

    fn turning(times: Vec<f32>, interpolation: Interpolation) -> source::RawClip {
        let values = times
            .iter()
            .flat_map(|t| Quat::from_rotation_y(1.3 * t).to_array())
            .collect();
        source::RawClip {
            name: "turn".into(),
            duration_secs: times.last().copied().unwrap_or(0.0),
            channels: vec![Channel {
                target: 0,
                property: Property::Rotation,
                interpolation,
                times_secs: times,
                values,
            }],
        }
    }

    #[test]
    fn the_source_rate_is_found_and_keys_are_hit() {
        let clip = turning(
            (0..=40).map(|i| i as f32 / 30.0).collect(),
            Interpolation::Linear,
        );
        assert_eq!(source_rate_hz(&clip), 30.0);
        let built = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap();
        assert_eq!((built.rate_hz(), built.frames()), (30.0, 41));
        for (i, q) in built.tracks().rotations[0].values.iter().enumerate() {
            assert!(angle_between(*q, Quat::from_rotation_y(1.3 * i as f32 / 30.0)) < 1e-5);
        }
    }

    #[test]
    fn a_usual_rate_stands_for_one_with_as_many_frames_alone() {
        let rows = |count: usize, secs: f32| {
            let times = (0..count).map(|i| i as f32 * secs).collect();
            source_rate_hz(&turning(times, Interpolation::Linear))
        };
        // 653 intervals of 8.342 ms are 5.447 s, which are 653.7 intervals of 120 Hz.
        assert!((rows(654, 0.008342) - 1.0 / 0.008342).abs() < 1e-2);
        assert_eq!(rows(300, 0.008342), 120.0);
        assert_eq!(rows(3000, 0.0333333), 30.0);
    }

    #[test]
    fn a_sparse_linear_turn_is_followed_between_its_keys() {
        let clip = turning(vec![0.0, 0.9, 1.1], Interpolation::Linear);
        let built = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap();
        let mut pose = LocalPose::from_iter([articula_core::Transform::IDENTITY]);
        for i in 0..=110 {
            let t = i as f32 / 100.0;
            sample(
                &built,
                f64::from(t),
                Wrap::Clamp,
                &JointSet::first(1),
                &mut pose,
            );
            let err = angle_between(pose.rotations[0], Quat::from_rotation_y(1.3 * t));
            assert!(err < 2e-3, "{err} rad at {t} s");
        }
    }

    #[test]
    fn curves_are_followed_alike_in_figures_of_any_unit() {
        use articula_core::Transform;
        // The head of a figure of 1.7 m sways by 0.1 m along a spline with keys 0.1 s apart;
        // its numbers are metres, or units below a joint that scales them to metres.
        let frames = |unit_metres: f32| {
            let joint = |parent, y: f32, scale| source::Joint {
                name: String::new(),
                parent,
                rest: Transform {
                    translation: Vec3::Y * y,
                    scale: Vec3::splat(scale),
                    ..Transform::IDENTITY
                },
                in_skin: true,
            };
            let length = |metres: f32| metres / unit_metres;
            let skeleton = source::Skeleton {
                joints: vec![
                    joint(None, 0.0, unit_metres),
                    joint(Some(0), length(0.9), 1.0),
                    joint(Some(1), length(0.8), 1.0),
                ],
            };
            let key = |x: f32| [0.0, 0.0, 0.0, length(x), length(0.8), 0.0, 0.0, 0.0, 0.0];
            let clip = source::RawClip {
                name: "sway".into(),
                duration_secs: 0.2,
                channels: vec![Channel {
                    target: 2,
                    property: Property::Translation,
                    interpolation: Interpolation::CubicSpline,
                    times_secs: vec![0.0, 0.1, 0.2],
                    values: [key(0.0), key(0.1), key(0.0)].concat(),
                }],
            };
            let built = resample(&clip, &skeleton, &[], &[], &ClipOptions::default());
            built.unwrap().frames()
        };
        let in_metres = frames(1.0);
        assert!(in_metres > 3, "the spline leaves its chords: {in_metres}");
        for unit_metres in [1e-3, 0.01, 0.0254, 100.0] {
            assert_eq!(frames(unit_metres), in_metres, "{unit_metres}");
        }
    }

    #[test]
    fn still_channels_cost_one_value_or_none() {
        let mut clip = turning(vec![0.0, 1.0], Interpolation::Linear);
        clip.channels[0].values = [Quat::IDENTITY.to_array(); 2].concat();
        let at_rest = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap();
        assert!(at_rest.tracks().rotations.is_empty());
        clip.channels[0].values = [Quat::from_rotation_x(0.5).to_array(); 2].concat();
        let held = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap();
        assert_eq!(held.tracks().rotations[0].values.len(), 1);
    }

    #[test]
    fn refuses_targets_that_are_not_there_and_endless_clips() {
        let mut clip = turning(vec![0.0, 1.0], Interpolation::Linear);
        clip.channels[0].target = 1;
        let e = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap_err();
        assert!(e.what.contains("joint 1 is out of range"));
        clip.channels[0].target = 0;
        clip.channels[0].values.pop();
        let e = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap_err();
        assert!(e.what.contains("7 values, but 2 keys need 4 floats"));
        clip.channels[0].times_secs.clear();
        assert!(resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).is_err());
        let endless = source::RawClip {
            duration_secs: 1e9,
            ..source::RawClip::default()
        };
        clip = turning(vec![0.0, 20_000.0], Interpolation::Linear);
        clip.channels = vec![clip.channels[0].clone(); 60];
        let e = resample(&clip, &skeleton(), &[], &[], &ClipOptions::default()).unwrap_err();
        assert!(e.what.contains("values, the limit"), "{e}");
        assert!(resample(&endless, &skeleton(), &[], &[], &ClipOptions::default()).is_err());
        let empty = resample(
            &source::RawClip::default(),
            &skeleton(),
            &[],
            &[],
            &ClipOptions::default(),
        )
        .unwrap();
        assert_eq!(empty.frames(), 1);
    }

    proptest! {
        #[test]
        fn the_last_frame_is_the_end(duration in 0.01f32..20.0, rate in 5.0f32..90.0) {
            let clip = source::RawClip { duration_secs: duration, ..source::RawClip::default() };
            let opts = ClipOptions { rate_hz: Some(rate) };
            let built = resample(&clip, &skeleton(), &[], &[], &opts).unwrap();
            if built.frames() > 1 {
                prop_assert!((built.duration_secs() - duration).abs() <= 1e-4 * duration);
            }
        }
    }
}
