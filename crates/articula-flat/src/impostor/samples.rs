//! The motion of some vertices, sampled over all clips.

use super::error::ImpostorError;
use crate::appearance::Appearance;
use articula_core::{
    Clip, ClipImpostors, Mesh, PosedMesh, Progress, Rig, SkinnedMesh, Wrap, sample_morphs,
};
use glam::Vec3;

/// Maximum number of vertices that are followed.
const MAX_VERTICES: usize = 700;

/// What is baked. Clips move the character on the spot; the rest pose stands for one without clips.
#[derive(Debug, Clone, Copy)]
pub struct ImpostorSource<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The clips to bake.
    pub clips: &'a [Clip],
    /// Materials and textures.
    pub appearance: &'a Appearance,
}

impl ImpostorSource<'_> {
    /// Skins the character at a time of a clip, morph targets included; in the rest pose if there is
    /// no such clip.
    pub(super) fn skinned(&self, clip: usize, secs: f32) -> SkinnedMesh {
        let mut posed = PosedMesh::new(self.rig, self.mesh);
        let mut weights = self.mesh.morph_weights.clone();
        match self.clips.get(clip) {
            Some(clip) => {
                sample_morphs(clip, f64::from(secs), Wrap::Clamp, &mut weights);
                posed.pose_at(clip, f64::from(secs), Wrap::Clamp)
            }
            None => posed.pose(self.rig.rest_pose()),
        };
        posed.skinned(&weights)
    }
}

/// Positions of the followed vertices of one clip.
#[derive(Debug, Clone)]
pub(super) struct ClipSamples {
    /// Duration, seconds.
    pub(super) duration_secs: f32,
    /// Times of the samples, evenly spaced over the clip, both ends included.
    pub(super) times_secs: Vec<f32>,
    /// Positions in model space at each time, metres.
    pub(super) points: Vec<Vec<Vec3>>,
    /// Centre of the pose at each time, metres ([`centre`]).
    pub(super) centres: Vec<Vec3>,
}

impl ClipSamples {
    /// Positions of a sample relative to its centre.
    pub(super) fn centred(&self, sample: usize) -> impl Iterator<Item = Vec3> + '_ {
        let centre = self.centres[sample];
        self.points[sample].iter().map(move |p| *p - centre)
    }
}

/// Positions of the followed vertices of all clips.
#[derive(Debug, Clone)]
pub(super) struct MotionSamples {
    /// Longest side of the boxes around the poses, metres.
    pub(super) height_m: f32,
    /// One entry for each clip, one for the rest pose without clips.
    pub(super) clips: Vec<ClipSamples>,
}

impl MotionSamples {
    pub(super) fn new(
        source: &ImpostorSource<'_>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImpostorError> {
        if source.mesh.is_empty() {
            return Err(ImpostorError::Nothing);
        }
        let every = source.mesh.len().div_ceil(MAX_VERTICES).max(1);
        let count = source.clips.len().max(1);
        let mut clips = Vec::with_capacity(count);
        let mut height_m = 0.0f32;
        for clip in 0..count {
            progress.step(clip as f32 / count as f32)?;
            let duration_secs = source.clips.get(clip).map_or(0.0, Clip::duration_secs);
            let steps = ClipImpostors::intervals(duration_secs);
            let time = |i: usize| match steps {
                0 => 0.0,
                _ => duration_secs * i as f32 / steps as f32,
            };
            let times_secs: Vec<f32> = (0..=steps).map(time).collect();
            let mut points = Vec::with_capacity(times_secs.len());
            let mut centres = Vec::with_capacity(times_secs.len());
            for secs in &times_secs {
                let skinned = source.skinned(clip, *secs);
                let known = |p: Vec3| if p.is_finite() { p } else { Vec3::ZERO };
                let places = skinned.positions.into_iter().step_by(every).map(known);
                let places: Vec<Vec3> = places.collect();
                let (low, high) = span(&places);
                height_m = height_m.max((high - low).max_element());
                centres.push(centre(&places));
                points.push(places);
            }
            clips.push(ClipSamples {
                duration_secs,
                times_secs,
                points,
                centres,
            });
        }
        if !(height_m > 0.0 && height_m.is_finite()) {
            return Err(ImpostorError::Nothing);
        }
        Ok(Self { height_m, clips })
    }
}

/// Box around points.
fn span(points: &[Vec3]) -> (Vec3, Vec3) {
    let first = points.first().copied().unwrap_or(Vec3::ZERO);
    points
        .iter()
        .fold((first, first), |(l, h), p| (l.min(*p), h.max(*p)))
}

/// Centre of a pose: the middle of the box around it in height, the mean of its vertices across, so
/// that most of them are near an upright plane through it.
fn centre(points: &[Vec3]) -> Vec3 {
    let (low, high) = span(points);
    let sum: glam::DVec3 = points.iter().map(|p| p.as_dvec3()).sum();
    let mean = (sum / points.len().max(1) as f64).as_vec3();
    Vec3::new(mean.x, 0.5 * (low.y + high.y), mean.z)
}
