//! The error of motions at the skin: all vertices, frame by frame, against the packaged clip.

use crate::error::Result;
use crate::work::Executor;
use articula_build::Asset;
use articula_core::{Clip, PosedMesh, SkinnedMesh, Wrap, sample_morphs};

/// Most frames that are measured; of a longer clip, every n-th.
const MOST_FRAMES: usize = 600;
/// Frames of one job.
const FRAMES: usize = 16;

/// Error of a motion.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct MotionError {
    /// Greatest distance of a vertex from its place, metres.
    pub(super) max_metres: f64,
    /// Mean distance over vertices and frames.
    pub(super) mean_metres: f64,
}

/// Measures clips against another one, at the times of its frames. Returns the errors, and the number
/// of frames that were measured. There is one job for every few frames.
///
/// O(frames x clips x vertices).
pub(super) fn measured(
    asset: &Asset,
    truth: &Clip,
    clips: &[Clip],
    work: &Executor<'_>,
) -> Result<(Vec<MotionError>, usize)> {
    let every = truth.frames().div_ceil(MOST_FRAMES).max(1);
    // The last frame counts too.
    let last = truth.frames().saturating_sub(1);
    let mut frames: Vec<usize> = (0..truth.frames()).step_by(every).collect();
    if frames.last() != Some(&last) {
        frames.push(last);
    }
    let jobs = frames.chunks(FRAMES).map(<[usize]>::to_vec).collect();
    let sums = work.map("measuring motions", jobs, |frames: Vec<usize>| {
        Ok(of_frames(asset, truth, clips, &frames))
    })?;
    let count = (frames.len() * asset.mesh.len()).max(1) as f64;
    let total = |i: usize| {
        let of_clip = sums.iter().map(|sums| sums[i]);
        MotionError {
            max_metres: of_clip.clone().map(|e| e.max_metres).fold(0.0, f64::max),
            mean_metres: of_clip.map(|e| e.mean_metres).sum::<f64>() / count,
        }
    };
    Ok(((0..clips.len()).map(total).collect(), frames.len()))
}

/// Greatest distances, and sums of distances, in some frames.
fn of_frames(asset: &Asset, truth: &Clip, clips: &[Clip], frames: &[usize]) -> Vec<MotionError> {
    let (rig, mesh) = (&asset.rig, &asset.mesh);
    let mut posed = PosedMesh::new(rig, mesh);
    let (mut right, mut shown) = (SkinnedMesh::new(mesh), SkinnedMesh::new(mesh));
    let mut show = |clip: &Clip, secs: f64, out: &mut SkinnedMesh| {
        let mut weights = mesh.morph_weights.clone();
        sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
        posed.pose_at(clip, secs, Wrap::Clamp).skin(&weights, out);
    };
    let mut errors = vec![MotionError::default(); clips.len()];
    for frame in frames {
        let secs = *frame as f64 / f64::from(truth.rate_hz());
        show(truth, secs, &mut right);
        for (clip, error) in clips.iter().zip(&mut errors) {
            show(clip, secs, &mut shown);
            for (a, b) in right.positions.iter().zip(&shown.positions) {
                let distance = f64::from(a.distance(*b));
                error.max_metres = error.max_metres.max(distance);
                error.mean_metres += distance;
            }
        }
    }
    errors
}
