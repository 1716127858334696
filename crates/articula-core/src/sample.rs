//! Sampling of clips at any time, in any direction and at any speed.
//!
//! With a uniform frame rate every access costs the same, so no cursor is needed.

use crate::clip::{Clip, Track};
use crate::joint_set::JointSet;
use crate::math::nlerp;
use crate::pose::LocalPose;
use glam::Vec3;

/// Handling of times outside the clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The clip repeats; its last frame coincides with its first.
    #[default]
    Loop,
    /// The first or the last frame is held.
    Clamp,
}

/// A time as two neighbouring frame indices and the interpolation factor between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePosition {
    /// Index of the frame at or before the time.
    pub before: usize,
    /// Index of the frame after it, or the same index at the end of the clip.
    pub after: usize,
    /// Interpolation factor from `before` (0) to `after` (1).
    pub blend: f32,
}

/// Relative rounding error of a frame number after a division and a multiplication in f64.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Returns the frames of a clip around a time, and the interpolation factor between them.
///
/// In a looping clip negative times count backwards from its end. A time that is not finite counts
/// as 0. Times are f64, so that a clock may run for days; a time that equals that of a frame except
/// for rounding is that frame, so `i / rate_hz` seconds always gives exactly frame `i`.
pub fn frame_position(clip: &Clip, time_secs: f64, wrap: Wrap) -> FramePosition {
    position_within(clip, time_secs, ROUNDING, wrap)
}

/// The frames around a time that was computed in f32; a time that equals that of a frame except for
/// rounding in f32 is that frame.
pub(crate) fn frame_position_f32(clip: &Clip, time_secs: f32, wrap: Wrap) -> FramePosition {
    let rounding = 2.0 * f64::from(f32::EPSILON);
    position_within(clip, f64::from(time_secs), rounding, wrap)
}

fn position_within(clip: &Clip, time_secs: f64, rounding: f64, wrap: Wrap) -> FramePosition {
    let last = clip.frames() - 1;
    let time = if time_secs.is_finite() {
        time_secs
    } else {
        0.0
    };
    let at = time * f64::from(clip.rate_hz());
    let frame = at.round();
    let at = if (at - frame).abs() <= rounding * frame.abs() {
        frame
    } else {
        at
    };
    let at = match wrap {
        Wrap::Loop if last > 0 => at.rem_euclid(last as f64),
        _ => at.clamp(0.0, last as f64),
    };
    let before = (at as usize).min(last);
    FramePosition {
        before,
        after: (before + 1).min(last),
        blend: (at - before as f64) as f32,
    }
}

/// Writes the local transforms of the `active` joints at a time; other joints are not changed.
///
/// Rotations are interpolated by normalised linear interpolation; clips of faster sources are
/// resampled densely enough when they are built. Joints without a track are not changed either, so
/// start from the rig's rest pose.
///
/// O(tracks); does not allocate.
///
/// # Panics
/// If `out` belongs to another rig than the clip.
pub fn sample(clip: &Clip, time_secs: f64, wrap: Wrap, active: &JointSet, out: &mut LocalPose) {
    assert_eq!(
        out.rotations.len(),
        clip.joints(),
        "the pose must belong to this rig"
    );
    sample_at(clip, frame_position(clip, time_secs, wrap), active, out);
}

/// [`sample`] at a position between frames.
pub(crate) fn sample_at(clip: &Clip, at: FramePosition, active: &JointSet, out: &mut LocalPose) {
    for track in &clip.tracks().rotations {
        if active.contains(usize::from(track.target)) {
            out.rotations[usize::from(track.target)] = read(track, at, nlerp);
        }
    }
    let lerp = |a: Vec3, b: Vec3, t: f32| a + (b - a) * t;
    for track in &clip.tracks().translations {
        if active.contains(usize::from(track.target)) {
            out.translations[usize::from(track.target)] = read(track, at, lerp);
        }
    }
    for track in &clip.tracks().scales {
        if active.contains(usize::from(track.target)) {
            out.scales[usize::from(track.target)] = read(track, at, lerp);
        }
    }
}

/// Writes the morph target weights at a time; slots without a track or beyond `out` are not
/// changed. Does not allocate.
pub fn sample_morphs(clip: &Clip, time_secs: f64, wrap: Wrap, out: &mut [f32]) {
    sample_morphs_at(clip, frame_position(clip, time_secs, wrap), out);
}

/// [`sample_morphs`] at a position between frames.
pub(crate) fn sample_morphs_at(clip: &Clip, at: FramePosition, out: &mut [f32]) {
    for track in &clip.tracks().morphs {
        if let Some(weight) = out.get_mut(usize::from(track.target)) {
            *weight = read(track, at, |a, b, t| a + (b - a) * t);
        }
    }
}

fn read<T: Copy>(track: &Track<T>, at: FramePosition, blend: impl Fn(T, T, f32) -> T) -> T {
    if track.values.len() == 1 {
        return track.values[0];
    }
    let before = track.values[at.before];
    // An exact frame is returned bit for bit, so that stored keys are reproduced.
    if track.step || at.blend == 0.0 {
        return before;
    }
    blend(before, track.values[at.after], at.blend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::Tracks;
    use crate::math::angle_between;
    use glam::Quat;
    use proptest::prelude::*;

    fn quarter_turn() -> Clip {
        let values = (0..=10)
            .map(|i| Quat::from_rotation_y(i as f32 * 0.1))
            .collect();
        let tracks = Tracks {
            rotations: vec![Track {
                target: 0,
                step: false,
                values,
            }],
            translations: vec![Track {
                target: 0,
                step: true,
                values: (0..=10).map(|i| Vec3::X * i as f32).collect(),
            }],
            ..Tracks::default()
        };
        Clip::new("turn", 10.0, 11, 1, tracks).unwrap()
    }

    fn pose_at(time: f64, wrap: Wrap) -> LocalPose {
        let mut out = LocalPose::from_iter([crate::math::Transform::IDENTITY]);
        sample(&quarter_turn(), time, wrap, &JointSet::first(1), &mut out);
        out
    }

    #[test]
    fn between_frames_by_hand() {
        let pose = pose_at(0.25, Wrap::Clamp);
        assert!(angle_between(pose.rotations[0], Quat::from_rotation_y(0.25)) < 1e-4);
        assert_eq!(pose.translations[0], Vec3::X * 2.0, "a step track holds");
    }

    #[test]
    fn ends_clamp_or_wrap() {
        let first = quarter_turn().tracks().rotations[0].values[0];
        let last = quarter_turn().tracks().rotations[0].values[10];
        assert_eq!(pose_at(-5.0, Wrap::Clamp).rotations[0], first);
        assert_eq!(pose_at(99.0, Wrap::Clamp).rotations[0], last);
        assert_eq!(pose_at(1.0, Wrap::Clamp).rotations[0], last);
        assert_eq!(pose_at(1.0, Wrap::Loop).rotations[0], first);
        assert_eq!(pose_at(f64::NAN, Wrap::Loop).rotations[0], first);
        let backwards = pose_at(-0.25, Wrap::Loop).rotations[0];
        assert!(angle_between(backwards, Quat::from_rotation_y(0.75)) < 1e-4);
    }

    #[test]
    fn passive_joints_are_not_touched() {
        let mut out = LocalPose::from_iter([crate::math::Transform::IDENTITY]);
        sample(&quarter_turn(), 0.5, Wrap::Loop, &JointSet::EMPTY, &mut out);
        assert_eq!(out.rotations[0], Quat::IDENTITY);
        assert_eq!(out.translations[0], Vec3::ZERO);
    }

    proptest! {
        #[test]
        fn the_time_of_a_frame_is_that_frame(rate in 0.5f32..500.0, frame in 0usize..100_000) {
            let clip = Clip::new("c", rate, 100_001, 1, Tracks::default()).unwrap();
            let secs = frame as f64 / f64::from(clip.rate_hz());
            for wrap in [Wrap::Loop, Wrap::Clamp] {
                let at = frame_position(&clip, secs, wrap);
                prop_assert_eq!((at.before, at.blend), (frame, 0.0));
            }
        }

        #[test]
        fn looping_repeats_and_stays_unit(time in -50.0f64..50.0) {
            let a = pose_at(time, Wrap::Loop).rotations[0];
            let b = pose_at(time + 7.0, Wrap::Loop).rotations[0];
            prop_assert!((a.length() - 1.0).abs() < 1e-5);
            // The pose jumps where the loop closes; elsewhere the two agree.
            let phase = time.rem_euclid(1.0);
            prop_assume!(phase > 1e-6 && phase < 1.0 - 1e-6);
            prop_assert!(angle_between(a, b) < 1e-4);
        }
    }
}
