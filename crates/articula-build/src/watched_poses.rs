//! Poses of a character in which its surface is measured.

use crate::moment::Moment;
use crate::split_mix::SplitMix;
use crate::vertex_error::PosedVertices;
use glam::Vec3;

/// Greatest number of points of all poses together, and numbers of poses.
const POINTS: usize = 6_000_000;
const FEWEST: usize = 16;
const MOST: usize = 400;
/// Greatest number of poses of one clip.
const MOST_OF_CLIP: usize = 150;

/// Returns the vertices of a character in poses in which its surface is measured: at rest, at times of all
/// clips, one at random in each of equal parts, and with each morph target alone at the greatest weight
/// that a clip gives it, at least 1. At most 400 poses, fewer of a large mesh but one of each of 400 clips;
/// of more morph targets than half of them, those that move a vertex farthest.
pub fn watched_poses(posed: &mut PosedVertices<'_>, seed: u64) -> Vec<Vec<Vec3>> {
    let moments = moments(posed, seed).into_iter();
    moments
        .map(|moment| posed.in_moment(moment).to_vec())
        .collect()
}

/// The moments of [`watched_poses`].
pub(crate) fn moments(posed: &PosedVertices<'_>, seed: u64) -> Vec<Moment> {
    let count = (POINTS / posed.count().max(1)).clamp(FEWEST, MOST);
    let mut morphs = posed.greatest_morph_weights();
    morphs.truncate(count / 2);
    let mut moments = vec![Moment::Rest];
    let of_morph = |(slot, weight)| Moment::Morph { slot, weight };
    moments.extend(morphs.into_iter().map(of_morph));
    let clips = posed.clips();
    let left = count.saturating_sub(moments.len()).max(clips.len());
    let of_clip = (left / clips.len().max(1)).clamp(1, MOST_OF_CLIP);
    let mut random = SplitMix(seed);
    for (index, clip) in clips.iter().enumerate().take(MOST) {
        for i in 0..of_clip {
            let part = (i as f32 + random.unit()) / of_clip as f32;
            let secs = part * clip.duration_secs;
            moments.push(Moment::Clip { index, secs });
        }
    }
    moments
}
