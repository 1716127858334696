//! A clip with a moving camera, under a controller of the live playback.
//!
//! Source: `docs/methods/motion-lod.md` part 4.5. The camera is in full perspective.

use super::rows::{ErrorPx, MethodRow};
use crate::error::{Error, Result};
use articula_build::evaluate::{
    CameraKey, ClipEvaluator, PathFrame, PathMethod, PathRun, play_camera_path,
};
use articula_core::{JointSet, Rig};
use serde::Serialize;

/// Range of tolerances searched by a calibration in pixels, and number of bisections.
const SEARCHED_PX: (f32, f32) = (0.02, 64.0);
const HALVINGS: usize = 12;

/// A camera path and the playback options.
#[derive(Debug, Clone)]
pub struct CameraPath {
    /// Key frames of the camera; [`read_camera_path`](crate::read_camera_path) reads them.
    pub keys: Vec<CameraKey>,
    /// Frame rate of the display, in hertz.
    pub display_hz: f64,
    /// The controller and its options.
    pub method: PathMethod,
    /// Name of the fixed level in reports, if the method is one.
    pub level: Option<String>,
}

/// Result of playing a clip along a camera path.
#[derive(Debug)]
pub struct PlayedPath {
    /// Results of every frame.
    pub run: PathRun,
    /// The run as one row, at its median distance.
    pub row: MethodRow,
    /// Values specific to a path.
    pub summary: PathSummary,
}

/// Summary of a run along a camera path.
#[derive(Debug, Serialize)]
pub struct PathSummary {
    /// Number of display frames.
    pub frames: usize,
    /// Frame rate of the display, in hertz.
    pub display_hz: f64,
    /// Tolerance of the controller in pixels; null for methods without one.
    pub tolerance_px: Option<f32>,
    /// Upper bound of the error of one joint in pixels; null for methods without one.
    pub bound_px: Option<f32>,
    /// Maximum error of one joint that occurred, in pixels.
    pub joint_error_px_max: f32,
    /// Minimum distance of the camera to the root, in metres.
    pub distance_m_min: f32,
    /// Maximum distance of the camera to the root, in metres.
    pub distance_m_max: f32,
}

impl CameraPath {
    /// Plays the path; with `limit_px`, at the greatest tolerance whose 95th percentile error is at
    /// most this many pixels.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the path has no key frame.
    pub fn play(&self, stage: &ClipEvaluator<'_>, limit_px: Option<f32>) -> Result<PlayedPath> {
        let play = |method: PathMethod| {
            let run = play_camera_path(stage, &self.keys, self.display_hz, &method);
            let run = run.ok_or_else(|| {
                Error::unsuited("the camera path has no key frame; give at least one")
            })?;
            Ok((run, method))
        };
        let (run, method) = match limit_px {
            Some(limit) if self.method.tolerance_px().is_some() => {
                calibrated(|px| play(self.method.with_tolerance_px(px)), limit)?
            }
            _ => play(self.method)?,
        };
        Ok(self.played(stage, run, &method, limit_px))
    }

    fn played(
        &self,
        stage: &ClipEvaluator<'_>,
        run: PathRun,
        method: &PathMethod,
        limit_px: Option<f32>,
    ) -> PlayedPath {
        let mut distances: Vec<f32> = run.frames.iter().map(|f| f.distance_m).collect();
        distances.sort_by(f32::total_cmp);
        let at = |i: usize| distances.get(i).copied().unwrap_or(0.0);
        let frames = run.frames.len().saturating_sub(1).max(1) as f32;
        let mean = |count: &dyn Fn(&PathFrame) -> usize| {
            run.frames.iter().skip(1).map(count).sum::<usize>() as f32 / frames
        };
        let rig = &stage.asset.rig;
        let (name, variant) = match method {
            PathMethod::Drift(_) => ("skin-px", Some("drift")),
            PathMethod::DriftInView(_) => ("skin-px", Some("drift-view")),
            PathMethod::Tables(_) => ("skin-px", Some("tables")),
            PathMethod::Thesis(_) => ("thesis", None),
            PathMethod::Loa(_) => ("loa", None),
        };
        let parameter = match method {
            PathMethod::Thesis(threshold) => threshold.thr_init,
            other => other.tolerance_px().unwrap_or(0.0),
        };
        let joint_errors = run.frames.iter().map(|f| f.joint_error_px);
        PlayedPath {
            row: MethodRow {
                method: name,
                variant,
                distance_m: at(distances.len() / 2),
                joint_update_gain: run.joint_update_gain,
                evaluations_saved: run.evaluations_saved,
                parameter,
                level: self.level.clone(),
                error_px: ErrorPx::new(run.error_px, run.worst_vertex_px),
                hands_px: None,
                face_px: None,
                feet_px: None,
                joints_sampled: mean(&|f| f.sampled.intersection(&stage.moving).len()),
                fk_joints: mean(&|f| at_or_below(rig, &f.updated)),
                foot_slide_mm: None,
                meets_target: limit_px.map(|l| run.error_px.p95 <= l),
            },
            summary: PathSummary {
                frames: run.frames.len(),
                display_hz: self.display_hz,
                tolerance_px: method.tolerance_px(),
                bound_px: method.bound_px(),
                joint_error_px_max: joint_errors.fold(0.0, f32::max),
                distance_m_min: at(0),
                distance_m_max: at(distances.len().saturating_sub(1)),
            },
            run,
        }
    }
}

fn calibrated(
    play: impl Fn(f32) -> Result<(PathRun, PathMethod)>,
    limit_px: f32,
) -> Result<(PathRun, PathMethod)> {
    let (mut low, mut high) = SEARCHED_PX;
    let mut best = play(low)?;
    for _ in 0..HALVINGS {
        let px = (low * high).sqrt();
        let tried = play(px)?;
        if tried.0.error_px.p95 <= limit_px {
            low = px;
            best = tried;
        } else {
            high = px;
        }
    }
    Ok(best)
}

fn at_or_below(rig: &Rig, updated: &JointSet) -> usize {
    let mut dirty = *updated;
    for joint in 0..rig.len() {
        if rig.parent(joint).is_some_and(|p| dirty.contains(p)) {
            dirty.insert(joint);
        }
    }
    dirty.len()
}
