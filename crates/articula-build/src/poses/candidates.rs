//! The poses to choose from.

use super::bends::Bends;
use super::shape::{Sample, Shape};
use super::skin_pose::{PoseOrigin, SkinPose};
use crate::character::Asset;
use crate::joint_lods::{share_frames, spread_frames};
use articula_core::Morph;

/// Maximum number of frames, over all clips.
const MAX_FRAMES: usize = 600;

/// Number of random bends for a character whose clips do not move it.
const BENDS: usize = 64;

/// Minimum displacement of a morph target relative to the largest one; smaller ones are ignored.
const SMALL_MORPH: f32 = 0.1;

/// A pose with its shape.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) pose: SkinPose,
    pub(super) shape: Shape,
    /// Index of its group: the clip, or the kind of pose.
    pub(super) group: usize,
}

/// A list of candidate poses in groups.
#[derive(Debug, Clone, Default)]
pub(super) struct Candidates {
    pub(super) list: Vec<Candidate>,
    groups: usize,
}

impl Candidates {
    /// Frames of all clips; each clip is a group.
    pub(super) fn of_clips(asset: &Asset, sample: &Sample) -> Self {
        let mut all = Self::default();
        let counts = share_frames(&asset.clips, MAX_FRAMES);
        for (clip, count) in counts.into_iter().enumerate() {
            for frame in spread_frames(asset.clips[clip].frames(), count) {
                all.push(asset, sample, SkinPose::of_clip(asset, clip, frame));
            }
            all.groups += 1;
        }
        all
    }

    /// Seeded random bends, one group.
    pub(super) fn of_bends(asset: &Asset, sample: &Sample, seed: u64) -> Self {
        let mut all = Self::default();
        let mut bends = Bends::new(asset, seed);
        for _ in 0..BENDS {
            let pose = bends.next(asset);
            all.push(asset, sample, pose);
        }
        all.groups = 1;
        all
    }

    /// Each large morph target at weight 1, one group; none if a clip drives morph targets.
    pub(super) fn of_morphs(asset: &Asset, sample: &Sample) -> Self {
        let mut all = Self::default();
        if asset.clips.iter().any(|c| !c.tracks().morphs.is_empty()) {
            return all;
        }
        let mut sizes = vec![0.0f32; asset.mesh.morph_weights.len()];
        for morph in &asset.mesh.morphs {
            let size = &mut sizes[usize::from(morph.slot)];
            *size = size.max(farthest(morph));
        }
        let largest = sizes.iter().fold(0.0, |a: f32, b| a.max(*b));
        for (slot, size) in sizes.iter().enumerate() {
            if largest > 0.0 && *size >= SMALL_MORPH * largest {
                let mut pose = SkinPose::rest(asset);
                pose.origin = PoseOrigin::Morph { slot: slot as u16 };
                pose.morphs[slot] = 1.0;
                all.push(asset, sample, pose);
            }
        }
        all.groups = 1;
        all
    }

    /// Whether two candidates may differ by at least `min_metres`; false only if none do.
    pub(super) fn differ(&self, min_metres: f32) -> bool {
        let Some(first) = self.list.first() else {
            return false;
        };
        let apart = |c: &Candidate| first.shape.separation_metres(&c.shape);
        // Half of the largest distance is at most the distance from some candidate to the first.
        self.list.iter().any(|c| apart(c) >= 0.5 * min_metres)
    }

    /// Appends other candidates with groups of their own.
    pub(super) fn and(mut self, others: Self) -> Self {
        let first = self.groups;
        let moved = others.list.into_iter().map(|c| Candidate {
            group: first + c.group,
            ..c
        });
        self.list.extend(moved);
        self.groups += others.groups;
        self
    }

    /// Number of groups.
    pub(super) fn groups(&self) -> usize {
        self.groups
    }

    /// Adds a pose to the current group, unless it is not finite.
    fn push(&mut self, asset: &Asset, sample: &Sample, pose: SkinPose) {
        if let Some(shape) = sample.shape(asset, &pose) {
            let group = self.groups;
            self.list.push(Candidate { pose, shape, group });
        }
    }
}

/// Maximum displacement of a vertex by a morph target.
fn farthest(morph: &Morph) -> f32 {
    let lengths = morph.positions.iter().map(|p| p.length());
    lengths.filter(|l| l.is_finite()).fold(0.0, f32::max)
}
