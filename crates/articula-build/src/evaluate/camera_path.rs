//! Playback of a clip along a path of a perspective camera, under a controller of the core.
//!
//! Source: `docs/methods/motion-lod.md` 4.5 and 12. The frames are those of a live playback: depths
//! are those of the pose shown before, moved as the root moves.

use super::skin_sample::SkinSample;
use super::stage::ClipEvaluator;
use super::statistics::FrameErrors;
use crate::motion_error::bounds::joint_bounds;
use crate::motion_error::contacts::attention;
use articula_core::crowd::ClipState;
use articula_core::joint_state::JointState;
use articula_core::playback::{
    FigureModel, FigurePlayer, FigureViews, FullDetail, MotionController, StoredKeys,
    TableController, Threshold,
};
use articula_core::{
    Camera, DriftController, DriftOptions, JointErrorBounds, JointSet, LocalPose, ModelPose,
    Viewport, Wrap, frame_position, local_to_model, percentile, sample,
};
use glam::{Vec3, Vec3A};

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
    /// State of each joint: in transition, passive if it shows what it showed before, else active.
    pub states: Vec<JointState>,
    /// Pose that was shown.
    pub shown: LocalPose,
    /// 95th percentile over the sampled vertices of the distance between shown and true
    /// projections, pixels.
    pub error_px: f32,
    /// Maximum over all vertices, pixels.
    pub worst_vertex_px: f32,
    /// Maximum over the joints of `lever * angle * pixels per metre`, the quantity that the
    /// controller bounds, pixels; for the view-dependent controller the part that the camera sees.
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
    /// Maximum over all vertices and frames, pixels.
    pub worst_vertex_px: f32,
    /// Percentiles over frames of [`PathFrame::error_px`].
    pub error_px: FrameErrors,
}

/// A controller before a moving camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathMethod {
    /// The drift controller.
    Drift(DriftOptions),
    /// The drift controller with the error as seen by the camera.
    DriftInView(DriftOptions),
    /// The stored key table at the nearest stored tolerance; the tolerance in pixels.
    Tables(f32),
    /// The thesis' metric, its threshold renewed at each look-up.
    Thesis(Threshold),
    /// A fixed level of articulation.
    Loa(JointSet),
}

impl PathMethod {
    /// Tolerated displacement in pixels, if the method has one.
    pub fn tolerance_px(&self) -> Option<f32> {
        match self {
            Self::Drift(options) | Self::DriftInView(options) => Some(options.epsilon_px),
            Self::Tables(epsilon_px) => Some(*epsilon_px),
            Self::Thesis(_) | Self::Loa(_) => None,
        }
    }

    /// Maximum error of a joint in pixels, if the method bounds it.
    pub fn bound_px(&self) -> Option<f32> {
        match self {
            Self::Drift(options) | Self::DriftInView(options) => Some(options.bound_px()),
            Self::Tables(epsilon_px) => Some(*epsilon_px),
            Self::Thesis(_) | Self::Loa(_) => None,
        }
    }

    /// The method with another tolerance in pixels; methods without one are unchanged.
    #[must_use]
    pub fn with_tolerance_px(self, epsilon_px: f32) -> Self {
        let of = |options| DriftOptions {
            epsilon_px,
            ..options
        };
        match self {
            Self::Drift(options) => Self::Drift(of(options)),
            Self::DriftInView(options) => Self::DriftInView(of(options)),
            Self::Tables(_) => Self::Tables(epsilon_px),
            other => other,
        }
    }
}

/// Plays a looping clip along a camera path at a display rate in hertz. Returns `None` if the path
/// has no key.
pub fn play_camera_path(
    stage: &ClipEvaluator<'_>,
    path: &[CameraKey],
    display_hz: f64,
    method: &PathMethod,
) -> Option<PathRun> {
    let levers_metres: Vec<f32> = stage.levers.iter().map(|l| l.rest_metres).collect();
    let bounds = joint_bounds(
        stage.asset,
        &stage.clip,
        &levers_metres,
        stage.options.chain,
    );
    let shot = Shot {
        path,
        display_hz,
        in_view: matches!(method, PathMethod::DriftInView(_)),
    };
    let all = stage.asset.rig.all();
    let shares = bounds.iter().map(|b| b.share).collect();
    let rest = stage.asset.rig.rest_pose();
    let drift =
        |bounds: Vec<JointErrorBounds>, options| DriftController::new(rest, bounds, options);
    match method {
        PathMethod::Drift(options) => stage.along(&shot, &mut drift(bounds, *options), &all),
        PathMethod::DriftInView(options) => {
            let moments = stage.levers.iter().map(|l| l.second_moment).collect();
            let mut drift = drift(bounds, *options).with_second_moments(moments);
            stage.along(&shot, &mut drift, &all)
        }
        PathMethod::Tables(epsilon_px) => {
            let keys = StoredKeys::new(&stage.clip, stage.key_table().clone()).ok();
            let mut tables = TableController::new(vec![keys], shares, *epsilon_px);
            stage.along(&shot, &mut tables, &all)
        }
        PathMethod::Thesis(threshold) => {
            let mut thesis = stage.thesis(*threshold);
            stage.along(&shot, &mut thesis, &stage.moving)
        }
        PathMethod::Loa(set) => {
            let mut full = FullDetail::default();
            let mut loa = stage.articulated(set, &mut full);
            stage.moved(&shot, &mut loa, &stage.loose(set))
        }
    }
}

/// A camera path, its display rate, and whether errors of joints are those that the camera sees.
struct Shot<'p> {
    path: &'p [CameraKey],
    display_hz: f64,
    in_view: bool,
}

impl ClipEvaluator<'_> {
    /// Plays a controller within the articulation of the options.
    fn along(
        &self,
        shot: &Shot<'_>,
        control: &mut dyn MotionController,
        controlled: &JointSet,
    ) -> Option<PathRun> {
        match &self.options.articulation {
            Some(set) => {
                let mut bounded = self.articulated(set, control);
                self.moved(shot, &mut bounded, &controlled.union(&self.loose(set)))
            }
            None => self.moved(shot, control, controlled),
        }
    }

    /// Plays a controller of some joints; all others follow the clip.
    fn moved(
        &self,
        shot: &Shot<'_>,
        control: &mut dyn MotionController,
        controlled: &JointSet,
    ) -> Option<PathRun> {
        let Shot {
            path, display_hz, ..
        } = *shot;
        let (first, last) = (path.first()?, path.last()?);
        let (rig, clip) = (&self.asset.rig, &self.clip);
        let model =
            FigureModel::new(rig.clone(), [clip.clone()]).expect("the clip must belong to the rig");
        let start = ClipState::new(&model, 0);
        let mut player = FigurePlayer::new(model, &[]);
        player.play(start);
        player.set_pinned(rig.all().difference(controlled));
        let mut truth = rig.rest_pose().clone();
        let mut joints = ModelPose::new(rig.len());
        let count = ((last.secs - first.secs).max(0.0) * display_hz).floor() as usize;
        let whole = SkinSample::whole(self.asset);
        let mut frames: Vec<PathFrame> = Vec::with_capacity(count + 1);
        for i in 0..=count {
            let secs = i as f64 / display_hz;
            let camera = camera_at(path, first.secs + secs, self.setup.viewport)?;
            if self.options.protect_contacts {
                let at = frame_position(clip, secs, Wrap::Loop).before;
                attention(self.asset, &self.contacts, at, &mut player.attention);
            }
            player.advance_to(secs, looped(clip.duration_secs(), secs));
            let report = *player.control(control, FigureViews::Cameras(&[camera]));
            player.hierarchy();
            let shown = player.pose().clone();
            sample(clip, secs, Wrap::Loop, &rig.all(), &mut truth);
            local_to_model(rig, &truth, &mut joints);
            let line_of_sight = camera.eye - joints.position(rig.root());
            let joint_errors = self.moving.iter().map(|j| {
                let (held, wanted) = (shown.rotations[j], truth.rotations[j]);
                let lever = &self.levers[j];
                let in_joint = player.joint(j).matrix3.transpose() * Vec3A::from(line_of_sight);
                let view = Vec3::from(in_joint)
                    .try_normalize()
                    .filter(|_| shot.in_view);
                let metres = match view {
                    Some(view) => lever.projected_error(held, wanted, view),
                    None => lever.held_error(held, wanted),
                };
                let depth = camera.view(joints.position(j)).z.abs();
                metres * camera.viewport.pixels_per_metre(depth)
            });
            let poses = (
                &shown,
                &truth,
                f64::from(looped(clip.duration_secs(), secs)),
            );
            let mut errors_px = self.projected_errors(self.sample(), &camera, poses);
            let whole_px = self.projected_errors(&whole, &camera, poses);
            frames.push(PathFrame {
                secs,
                camera,
                distance_m: camera.eye.distance(joints.position(rig.root())),
                sampled: report.sampled,
                updated: changed(self, frames.last().map(|f| &f.shown), &shown),
                states: (0..rig.len())
                    .map(|j| match j {
                        j if report.in_transition.contains(j) => JointState::ToActive,
                        j if report.held.contains(j) => JointState::Passive,
                        _ => JointState::Active,
                    })
                    .collect(),
                joint_error_px: joint_errors.fold(0.0, f32::max),
                error_px: percentile(&mut errors_px, 0.95),
                worst_vertex_px: whole_px.into_iter().fold(0.0, f32::max),
                shown,
            });
        }
        Some(summary(self, frames))
    }
}

/// A time within a looping clip.
fn looped(duration_secs: f32, secs: f64) -> f32 {
    let duration = f64::from(duration_secs);
    if duration > 0.0 {
        secs.rem_euclid(duration) as f32
    } else {
        0.0
    }
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
    let worst = frames.iter().map(|f| f.worst_vertex_px);
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
        worst_vertex_px: worst.fold(0.0, f32::max),
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
    /// Distances between the projections of two poses of a skin, pixels. Vertices at or behind the
    /// camera are excluded.
    fn projected_errors(
        &self,
        skin: &SkinSample<'_>,
        camera: &Camera,
        (shown, truth, secs): (&LocalPose, &LocalPose, f64),
    ) -> Vec<f32> {
        let shown = self.posed(skin, shown, secs);
        let truth = self.posed(skin, truth, secs);
        let pairs = shown.iter().zip(&truth);
        let distances = pairs.filter_map(|(s, t)| {
            let ((s, sz), (t, tz)) = (camera.project(*s), camera.project(*t));
            (sz > NEAR_METRES && tz > NEAR_METRES).then(|| s.distance(t))
        });
        distances.collect()
    }
}
