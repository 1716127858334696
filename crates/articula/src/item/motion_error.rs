//! The error of motions at the skin: all vertices, frame by frame, against the packaged clip. Without
//! a mesh, all joints.

use crate::error::Result;
use crate::work::Executor;
use articula_build::Asset;
use articula_core::{
    Clip, GroupedSkin, Matrix3x4, MorphedShape, PosedMesh, SkinnedMesh, StaleBlocks, Wrap, palette,
    sample_morphs,
};
use glam::{Affine3A, Vec3};

/// Most frames that are measured; of a longer clip, every n-th.
pub(super) const MOST_FRAMES: usize = 600;
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

/// The frames of a clip that are measured: about `most`, evenly spread.
pub(super) fn measured_frames(clip: &Clip, most: usize) -> Vec<usize> {
    let every = clip.frames().div_ceil(most).max(1);
    // The last frame counts too.
    let last = clip.frames().saturating_sub(1);
    let mut frames: Vec<usize> = (0..clip.frames()).step_by(every).collect();
    if frames.last() != Some(&last) {
        frames.push(last);
    }
    frames
}

/// Measures clips against another one, at the times of some of its frames. There is one job for every few
/// frames. Equal clips, such as those of layers without bytes, are measured once.
///
/// O(frames x different clips x vertices).
pub(super) fn measured(
    asset: &Asset,
    (truth, frames): (&Clip, &[usize]),
    clips: &[Clip],
    work: &Executor<'_>,
) -> Result<Vec<MotionError>> {
    let (different, places) = different(clips);
    let jobs = frames.chunks(FRAMES).map(<[usize]>::to_vec).collect();
    let skin = GroupedSkin::new(&asset.mesh);
    let sums = work.map("measuring motions", jobs, |frames: Vec<usize>| {
        Ok(of_frames(
            Poser::new(asset, &skin),
            truth,
            &different,
            &frames,
        ))
    })?;
    let points = match asset.mesh.is_empty() {
        true => asset.rig.len(),
        false => asset.mesh.len(),
    };
    let count = (frames.len() * points).max(1) as f64;
    let total = |i: usize| {
        let of_clip = sums.iter().map(|sums| sums[i]);
        MotionError {
            max_metres: of_clip.clone().map(|e| e.max_metres).fold(0.0, f64::max),
            mean_metres: of_clip.map(|e| e.mean_metres).sum::<f64>() / count,
        }
    };
    Ok(places.into_iter().map(total).collect())
}

/// Different clips, and the place among them of each given one.
fn different(clips: &[Clip]) -> (Vec<&Clip>, Vec<usize>) {
    let mut different: Vec<&Clip> = Vec::with_capacity(clips.len());
    let mut places = Vec::with_capacity(clips.len());
    for clip in clips {
        let known = different.iter().position(|known| *known == clip);
        places.push(known.unwrap_or(different.len()));
        if known.is_none() {
            different.push(clip);
        }
    }
    (different, places)
}

/// Greatest distances, and sums of distances, in some frames.
fn of_frames(
    mut poser: Poser<'_>,
    truth: &Clip,
    clips: &[&Clip],
    frames: &[usize],
) -> Vec<MotionError> {
    let mut right = Vec::new();
    let mut errors = vec![MotionError::default(); clips.len()];
    for frame in frames {
        let secs = *frame as f64 / f64::from(truth.rate_hz());
        right.clear();
        right.extend_from_slice(poser.points(truth, secs));
        for (clip, error) in clips.iter().zip(&mut errors) {
            for (a, b) in right.iter().zip(poser.points(clip, secs)) {
                let distance = f64::from(a.distance(*b));
                error.max_metres = error.max_metres.max(distance);
                error.mean_metres += distance;
            }
        }
    }
    errors
}

/// Places the points of a character in clips.
struct Poser<'a> {
    asset: &'a Asset,
    posed: PosedMesh<'a>,
    skin: &'a GroupedSkin,
    shape: MorphedShape,
    stale: StaleBlocks,
    weights: Vec<f32>,
    palette: Vec<Affine3A>,
    rows: Vec<Matrix3x4>,
    skinned: SkinnedMesh,
    joints: Vec<Vec3>,
}

impl<'a> Poser<'a> {
    fn new(asset: &'a Asset, skin: &'a GroupedSkin) -> Self {
        let bindings = asset.mesh.bindings.len();
        Self {
            asset,
            posed: PosedMesh::new(&asset.rig, &asset.mesh),
            shape: skin.rest().clone(),
            stale: skin.stale(),
            skin,
            weights: Vec::new(),
            palette: vec![Affine3A::IDENTITY; bindings],
            rows: vec![Matrix3x4::default(); bindings],
            skinned: SkinnedMesh::new(&asset.mesh),
            joints: Vec::new(),
        }
    }

    /// All vertices at a time of a clip, or all joints without a mesh.
    fn points(&mut self, clip: &Clip, secs: f64) -> &[Vec3] {
        let (rig, mesh) = (&self.asset.rig, &self.asset.mesh);
        self.posed.pose_at(clip, secs, Wrap::Clamp);
        let model = &self.posed.model;
        if mesh.is_empty() {
            self.joints.clear();
            (self.joints).extend((0..rig.len()).map(|joint| model.position(joint)));
            return &self.joints;
        }
        self.weights.clone_from(&mesh.morph_weights);
        sample_morphs(clip, secs, Wrap::Clamp, &mut self.weights);
        (self.skin).morph(&self.weights, &mut self.shape, &mut self.stale);
        palette(mesh, model, &mut self.palette);
        GroupedSkin::rows(&self.palette, &mut self.rows);
        self.skin.skin(&self.shape, &self.rows, &mut self.skinned);
        &self.skinned.positions
    }
}
