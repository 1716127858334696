//! Impostors of a crowd's character: pictures that are baked once, as an option for who is far away.
//!
//! Source: `docs/methods/impostors.md`. The crowd knows which pose a clip shows at which time and the
//! error; directions and pictures belong to the renderer (`docs/formats/impostor.md`). Baked by
//! `articula-flat`.

use crate::Mismatch;

/// Poses in a second of a clip's list, and intervals of it at most.
const RATE_HZ: f32 = 60.0;
const MAX_INTERVALS: usize = 599;

/// Poses of one clip as impostors.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipImpostors {
    /// Pose that is shown at each of evenly spaced times, from the start of the clip to its end; at
    /// least one. Poses of all clips are counted one after the other.
    pub poses: Vec<u32>,
    /// Error in metres of skin: across the view of any eye, the larger of the 95th percentile over
    /// vertices and half of the maximum.
    pub error_metres: f32,
}

impl ClipImpostors {
    /// Number of intervals of equal length between the poses of the list of a clip: 60 a second, at most 599.
    pub fn intervals(duration_secs: f32) -> usize {
        ((duration_secs * RATE_HZ).ceil() as usize).min(MAX_INTERVALS)
    }

    /// Takes the time in seconds from which each pose is shown, ascending; the poses follow `first_pose`.
    pub fn of_stretches(
        first_pose: u32,
        from_secs: &[f32],
        duration_secs: f32,
        error_metres: f32,
    ) -> Self {
        let intervals = Self::intervals(duration_secs);
        let pose = |i: usize| {
            let secs = duration_secs * i as f32 / intervals.max(1) as f32;
            let begun = from_secs.partition_point(|from| *from <= secs);
            first_pose + begun.saturating_sub(1) as u32
        };
        Self {
            poses: (0..=intervals).map(pose).collect(),
            error_metres,
        }
    }
}

/// Impostors of all clips.
#[derive(Debug, Clone, PartialEq)]
pub struct Impostors {
    clips: Vec<Option<ClipImpostors>>,
    /// Intervals of a clip's list in a second.
    rates: Vec<f32>,
}

impl Impostors {
    /// Takes the poses of each clip, `None` for clips without, and the clips' durations in seconds.
    ///
    /// # Errors
    /// A [`Mismatch`] if the lists differ in length, a clip has no pose, or an error is negative or
    /// not finite.
    pub fn new(
        clips: Vec<Option<ClipImpostors>>,
        durations_secs: &[f32],
    ) -> Result<Self, Mismatch> {
        if clips.len() != durations_secs.len() {
            let what = format!("{} entries for {} clips", clips.len(), durations_secs.len());
            return Err(Mismatch::new("impostors", what));
        }
        for (c, clip) in clips.iter().enumerate() {
            let Some(clip) = clip else {
                continue;
            };
            if clip.poses.is_empty() {
                let at = format!("impostors[{c}].poses");
                return Err(Mismatch::new(at, "must not be empty"));
            }
            if !(clip.error_metres.is_finite() && clip.error_metres >= 0.0) {
                let at = format!("impostors[{c}].error_metres");
                return Err(Mismatch::new(at, "must be finite and not negative"));
            }
        }
        let rate = |(clip, secs): (&Option<ClipImpostors>, &f32)| {
            let intervals = clip.as_ref().map_or(0, |c| c.poses.len() - 1);
            let rate = intervals as f32 / secs;
            if rate.is_finite() { rate } else { 0.0 }
        };
        let rates = clips.iter().zip(durations_secs).map(rate).collect();
        Ok(Self { clips, rates })
    }

    /// Number of clips.
    pub fn clips(&self) -> usize {
        self.clips.len()
    }

    /// Error of a clip in metres; `None` if it has no impostors.
    ///
    /// # Panics
    /// If there is no such clip.
    #[inline]
    pub fn error_metres(&self, clip: usize) -> Option<f32> {
        self.clips[clip].as_ref().map(|c| c.error_metres)
    }

    /// Pose that a clip shows at a time in seconds, the first one before its start and the last one
    /// after its end; `None` if it has no impostors. O(1).
    ///
    /// # Panics
    /// If there is no such clip.
    #[inline]
    pub fn pose(&self, clip: usize, time_secs: f32) -> Option<u32> {
        let poses = &self.clips[clip].as_ref()?.poses;
        // The nearest time; a conversion to an integer saturates, and NaN counts as 0.
        let at = (time_secs * self.rates[clip] + 0.5) as usize;
        Some(poses[at.min(poses.len() - 1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(poses: &[u32], error_metres: f32) -> Option<ClipImpostors> {
        Some(ClipImpostors {
            poses: poses.to_vec(),
            error_metres,
        })
    }

    #[test]
    fn the_pose_is_that_of_the_nearest_time() {
        let clips = vec![clip(&[0, 0, 1], 0.1), None, clip(&[7], 0.0)];
        let impostors = Impostors::new(clips, &[1.0, 2.0, 0.0]).unwrap();
        let at = |secs: f32| impostors.pose(0, secs).unwrap();
        let times = [-9.0, 0.0, 0.74, 0.76, 1.0, 9.0, f32::NAN, f32::INFINITY];
        assert_eq!(times.map(at), [0, 0, 0, 1, 1, 1, 0, 1]);
        assert_eq!(impostors.pose(1, 0.5), None);
        assert_eq!(impostors.pose(2, 5.0), Some(7));
        assert_eq!(
            (impostors.error_metres(0), impostors.error_metres(1)),
            (Some(0.1), None)
        );
    }

    #[test]
    fn stretches_show_each_pose_from_its_time_on() {
        let clip = ClipImpostors::of_stretches(7, &[0.0, 0.5, 0.75], 1.0, 0.1);
        assert_eq!((clip.poses.len(), clip.error_metres), (61, 0.1));
        let counts = [7, 8, 9].map(|pose| clip.poses.iter().filter(|p| **p == pose).count());
        assert_eq!(counts, [30, 15, 16]);
        assert_eq!(ClipImpostors::of_stretches(3, &[0.0], 0.0, 0.0).poses, [3]);
        let long = ClipImpostors::of_stretches(0, &[0.0], 1e9, 0.0);
        assert_eq!(long.poses.len(), MAX_INTERVALS + 1);
    }

    #[test]
    fn lists_that_do_not_fit_are_refused() {
        let at = |clips, secs: &[f32]| Impostors::new(clips, secs).err().map(|e| e.at);
        assert_eq!(at(vec![None], &[1.0, 1.0]).as_deref(), Some("impostors"));
        let empty = vec![None, clip(&[], 0.1)];
        assert_eq!(
            at(empty, &[1.0, 1.0]).as_deref(),
            Some("impostors[1].poses")
        );
        for error in [-0.1, f32::NAN, f32::INFINITY] {
            let wrong = vec![clip(&[0], error)];
            assert_eq!(
                at(wrong, &[1.0]).as_deref(),
                Some("impostors[0].error_metres")
            );
        }
    }
}
