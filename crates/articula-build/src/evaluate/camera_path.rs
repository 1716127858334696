//! Playback of a clip along a path of a perspective camera, under the drift controller.
//!
//! Source: `docs/methods/motion-lod.md` 4.5 and 12. This measures the controller that runs in a
//! frame, not a table: its bound holds while the view moves.

use super::stage::{ClipEvaluator, FrameErrors};
use crate::motion_error::bounds::joint_bounds;
use crate::motion_error::contacts::attention;
use articula_core::joint_state::JointState;
use articula_core::percentile;
use articula_core::{
    Camera, DriftController, DriftOptions, JointSet, JointViewScales, LocalPose, ModelPose,
    Viewport, Wrap, angle_between, frame_position, local_to_model, sample,
};
use glam::Vec3;

/// Minimum depth of a vertex in front of the camera for its error to be measured.
const NEAR_METRES: f32 = 0.05;

/// Camera position and target at a time; between keys both are interpolated linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraKey {
    /// Time in seconds.
    pub secs: f64,
    /// Position of the camera, metres in model space.
    pub eye: Vec3,
    /// Point that the camera faces, metres in model space.
    pub target: Vec3,
}

/// Measurements of one display frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFrame {
    /// Time in seconds.
    pub secs: f64,
    /// Camera of the frame.
    pub camera: Camera,
    /// Distance of the camera to the root, metres.
    pub distance_m: f32,
    /// Joints whose wanted rotation was sampled.
    pub sampled: JointSet,
    /// Moving joints whose shown rotation changed.
    pub updated: JointSet,
    /// State of each joint.
    pub states: Vec<JointState>,
    /// Pose that was shown.
    pub shown: LocalPose,
    /// 95th percentile over the sampled vertices of the distance between shown and true
    /// projections, pixels.
    pub error_px: f32,
    /// Maximum over the joints of `lever * angle * pixels per metre`, the quantity that the
    /// controller bounds, pixels.
    pub joint_error_px: f32,
}

/// Playback along a camera path, with statistics.
#[derive(Debug, Clone, PartialEq)]
pub struct PathRun {
    /// Display frames in order of time.
    pub frames: Vec<PathFrame>,
    /// Saved joint updates as a share of moving joints times frames after the first.
    pub joint_update_gain: f32,
    /// Share of frames after the first at which no joint changed.
    pub evaluations_saved: f32,
    /// Percentiles over frames of [`PathFrame::error_px`].
    pub error_px: FrameErrors,
}

/// Plays a looping clip along a camera path at a display rate in hertz. Returns `None` if the path
/// has no key.
pub fn play_camera_path(
    stage: &ClipEvaluator<'_>,
    path: &[CameraKey],
    display_hz: f64,
    opts: DriftOptions,
) -> Option<PathRun> {
    let (first, last) = (path.first()?, path.last()?);
    let (asset, clip) = (stage.asset, &stage.clip);
    let levers_metres: Vec<f32> = stage.levers.iter().map(|l| l.rest_metres).collect();
    let bounds = joint_bounds(asset, clip, &levers_metres, stage.options.chain);
    let mut drift = DriftController::new(asset.rig.rest_pose(), bounds, opts);
    let mut wanted = asset.rig.rest_pose().clone();
    let mut truth = wanted.clone();
    let mut model = ModelPose::new(asset.rig.len());
    let mut care = vec![1.0; asset.rig.len()];
    let mut before = f64::INFINITY;
    let count = ((last.secs - first.secs).max(0.0) * display_hz).floor() as usize;
    let mut frames: Vec<PathFrame> = Vec::with_capacity(count + 1);
    for i in 0..=count {
        let secs = i as f64 / display_hz;
        let at = frame_position(clip, secs, Wrap::Loop);
        if stage.options.protect_contacts {
            attention(asset, &stage.contacts, at.before, &mut care);
        }
        // Where the clip starts again it may jump, which exceeds any bound on its speed.
        let now = at.before as f64 + f64::from(at.blend);
        if now <= before || f64::from(clip.duration_secs()) * display_hz <= 1.0 {
            drift.invalidate();
        }
        before = now;
        let camera = camera_at(path, first.secs + secs, stage.setup.viewport)?;
        sample(clip, secs, Wrap::Loop, &asset.rig.all(), &mut truth);
        local_to_model(&asset.rig, &truth, &mut model);
        let ppm: Vec<f32> = (0..asset.rig.len())
            .map(|j| {
                camera
                    .viewport
                    .pixels_per_metre(camera.view(model.position(j)).z.abs())
            })
            .collect();
        let views = JointViewScales {
            pixels_per_metre: &ppm,
            attention: &care,
        };
        let due = drift.due(secs, views);
        sample(clip, secs, Wrap::Loop, &due, &mut wanted);
        let shown = drift.step(secs, views, &due, &wanted).clone();
        let joint_errors = stage.moving.iter().map(|j| {
            let angle = angle_between(shown.rotations[j], truth.rotations[j]);
            stage.levers[j].rest_metres * angle * ppm[j]
        });
        frames.push(PathFrame {
            secs,
            camera,
            distance_m: camera.eye.distance(model.position(asset.rig.root())),
            sampled: due,
            updated: changed(stage, frames.last().map(|f| &f.shown), &shown),
            states: (0..asset.rig.len())
                .map(|j| drift.states().state(j))
                .collect(),
            joint_error_px: joint_errors.fold(0.0, f32::max),
            error_px: stage.projected_error(&camera, &shown, &truth),
            shown,
        });
    }
    Some(summary(stage, frames))
}

fn changed(stage: &ClipEvaluator<'_>, before: Option<&LocalPose>, shown: &LocalPose) -> JointSet {
    let Some(before) = before else {
        return JointSet::EMPTY;
    };
    let moved = stage
        .moving
        .iter()
        .filter(|j| before.rotations[*j] != shown.rotations[*j]);
    moved.collect()
}

fn summary(stage: &ClipEvaluator<'_>, frames: Vec<PathFrame>) -> PathRun {
    let after = frames.len().saturating_sub(1).max(1) as f32;
    let updates: usize = frames.iter().map(|f| f.updated.len()).sum();
    let free = frames
        .iter()
        .skip(1)
        .filter(|f| f.updated.is_empty())
        .count();
    let mut errors: Vec<f32> = frames.iter().map(|f| f.error_px).collect();
    let mut at = |fraction| percentile(&mut errors, fraction);
    let error_px = FrameErrors {
        p50: at(0.5),
        p95: at(0.95),
        max: at(1.0),
    };
    PathRun {
        joint_update_gain: 1.0 - updates as f32 / (stage.moving.len().max(1) as f32 * after),
        evaluations_saved: free as f32 / after,
        error_px,
        frames,
    }
}

/// The camera at a time: interpolated linearly between keys, constant outside them. `None` without
/// a key.
pub(crate) fn camera_at(path: &[CameraKey], secs: f64, viewport: Viewport) -> Option<Camera> {
    let after = path.partition_point(|k| k.secs <= secs);
    let before = path.get(after.saturating_sub(1))?;
    let next = path.get(after).unwrap_or(before);
    let span = next.secs - before.secs;
    let u = if span > 0.0 {
        ((secs - before.secs) / span).clamp(0.0, 1.0) as f32
    } else {
        0.0
    };
    Some(Camera::looking_at(
        before.eye.lerp(next.eye, u),
        before.target.lerp(next.target, u),
        viewport,
    ))
}

impl ClipEvaluator<'_> {
    /// 95th percentile over the sampled vertices of the distance between the projections of two
    /// poses, pixels. Vertices at or behind the camera are excluded.
    fn projected_error(&self, camera: &Camera, shown: &LocalPose, truth: &LocalPose) -> f32 {
        let shown = self.points().posed(self.asset, shown);
        let truth = self.points().posed(self.asset, truth);
        let mut distances: Vec<f32> = shown
            .iter()
            .zip(&truth)
            .filter_map(|(s, t)| {
                let ((s, sz), (t, tz)) = (camera.project(*s), camera.project(*t));
                (sz > NEAR_METRES && tz > NEAR_METRES).then(|| s.distance(t))
            })
            .collect();
        percentile(&mut distances, 0.95)
    }
}
