//! Poses of all clips at evenly spread frames, for the joint order and the errors.

use crate::character::Asset;
use articula_core::{Clip, LocalPose, ModelPose, Wrap, local_to_model, sample};

/// Returns frames of a clip spread evenly from the first to the last: all of them if there are at
/// most `count`, the middle one if `count` is 0 or 1.
pub(crate) fn spread_frames(frames: usize, count: usize) -> Vec<usize> {
    let last = frames - 1;
    match count.min(frames) {
        0 | 1 => vec![last / 2],
        n => (0..n).map(|i| (i * last + (n - 1) / 2) / (n - 1)).collect(),
    }
}

/// Returns the number of frames to sample in each clip, about `total` in all: the same for every
/// clip, with what short clips do not use shared among the longer ones; at least 1.
pub(crate) fn share_frames(clips: &[Clip], total: usize) -> Vec<usize> {
    let mut by_length: Vec<usize> = (0..clips.len()).collect();
    by_length.sort_by_key(|&c| clips[c].frames());
    let mut counts = vec![0; clips.len()];
    let mut left = total;
    for (done, &c) in by_length.iter().enumerate() {
        let share = (left / (clips.len() - done)).max(1);
        counts[c] = clips[c].frames().min(share);
        left = left.saturating_sub(counts[c]);
    }
    counts
}

/// Local pose at a frame: rest where the clip has no track.
pub(super) fn pose_of(asset: &Asset, clip: &Clip, frame: usize) -> LocalPose {
    pose_at(asset, clip, frame as f64 / f64::from(clip.rate_hz()))
}

/// Local pose at a time in seconds.
pub(super) fn pose_at(asset: &Asset, clip: &Clip, secs: f64) -> LocalPose {
    let mut pose = asset.rig.rest_pose().clone();
    sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
    pose
}

/// Model-space matrices of a pose.
pub(super) fn model_of(asset: &Asset, pose: &LocalPose) -> ModelPose {
    let mut model = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, pose, &mut model);
    model
}

/// Model-space matrices of a clip's poses at some frames.
pub(crate) fn models_of(asset: &Asset, clip: &Clip, frames: &[usize]) -> Vec<ModelPose> {
    let frames = frames.iter();
    frames
        .map(|frame| model_of(asset, &pose_of(asset, clip, *frame)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Tracks;

    #[test]
    fn frames_are_spread_from_end_to_end() {
        assert_eq!(spread_frames(5, 3), [0, 2, 4]);
        assert_eq!(spread_frames(3, 9), [0, 1, 2]);
        assert_eq!(spread_frames(1, 4), [0]);
        assert_eq!(spread_frames(9, 1), [4]);
    }

    #[test]
    fn a_long_clip_takes_what_short_ones_leave() {
        let clip = |frames| Clip::new("c", 30.0, frames, 1, Tracks::default()).unwrap();
        let clips = [clip(1000), clip(1), clip(10)];
        assert_eq!(share_frames(&clips, 60), [49, 1, 10]);
        let clips_alike = [clip(1000), clip(4), clip(900)];
        assert_eq!(share_frames(&clips_alike, 64), [30, 4, 30]);
        assert_eq!(share_frames(&clips, 0), [1, 1, 1], "every clip is seen");
        assert!(share_frames(&[], 60).is_empty());
    }
}
