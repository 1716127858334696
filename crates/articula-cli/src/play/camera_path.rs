//! A clip before a moving camera, under the controller that runs in a frame.
//!
//! Source: `spec/motion-lod.md` 4.5. The camera is a true one; where it stands is read from a
//! JSON file of key frames: `[{"t": 0, "eye": [0, 1.6, 25], "target": [0, 1, 0]}, …]`, seconds
//! and metres in the character's own space.

use super::Scene;
use super::rows::{ErrorPx, Row};
use crate::files;
use anyhow::Context;
use articula_build::evaluate::{CameraKey, PathFrame, PathRun, Stage, play_camera_path};
use articula_core::joint_state::JointState;
use articula_core::{DriftOptions, JointSet, Rig};
use articula_formats::Limits;
use articula_report::{JointMark, Plot, PlotOptions, Series, line_plot};
use serde::Serialize;
use std::path::Path;

/// Tolerances between which a calibration searches, pixels, and its halvings.
const SEARCHED_PX: (f32, f32) = (0.02, 64.0);
const HALVINGS: usize = 12;

/// A path and how it is played.
#[derive(Debug, Clone)]
pub(crate) struct CameraPath {
    pub(crate) keys: Vec<CameraKey>,
    pub(crate) display_hz: f64,
    pub(crate) options: DriftOptions,
}

/// Reads the key frames of a path.
pub(crate) fn read(path: &Path, display_hz: f64) -> anyhow::Result<Vec<CameraKey>> {
    let bytes = files::read(path, Limits::default().bytes)?;
    articula::read_camera_path(&bytes, display_hz).with_context(|| files::shown(path))
}

/// What a run along a path found.
#[derive(Debug, Serialize)]
pub(crate) struct PathReport {
    pub(crate) frames: usize,
    pub(crate) display_hz: f64,
    pub(crate) tolerance_px: f32,
    /// What the error of one joint never exceeds.
    pub(crate) bound_px: f32,
    /// The greatest error of one joint that was met.
    pub(crate) joint_error_px_max: f32,
    pub(crate) distance_m_min: f32,
    pub(crate) distance_m_max: f32,
}

/// Plays the path; with a limit at the greatest tolerance whose p95 error meets it.
pub(crate) fn run(
    stage: &Stage<'_>,
    path: &CameraPath,
    limit_px: Option<f32>,
) -> anyhow::Result<(PathRun, DriftOptions)> {
    let play = |epsilon_px: f32| {
        let options = DriftOptions {
            epsilon_px,
            ..path.options
        };
        let run = play_camera_path(stage, &path.keys, path.display_hz, options);
        run.map(|r| (r, options))
            .context("the path has no key frame")
    };
    let Some(limit) = limit_px else {
        return play(path.options.epsilon_px);
    };
    let (mut low, mut high) = SEARCHED_PX;
    let mut best = play(low)?;
    for _ in 0..HALVINGS {
        let tried = play((low * high).sqrt())?;
        if tried.0.error_px.p95 <= limit {
            low = tried.1.epsilon_px;
            best = tried;
        } else {
            high = tried.1.epsilon_px;
        }
    }
    Ok(best)
}

/// The run as one row (at its median distance), and what belongs to a path alone.
pub(crate) fn report(
    stage: &Stage<'_>,
    path: &CameraPath,
    run: &PathRun,
    options: &DriftOptions,
    limit_px: Option<f32>,
) -> (Row, PathReport) {
    let mut distances: Vec<f32> = run.frames.iter().map(|f| f.distance_m).collect();
    distances.sort_by(f32::total_cmp);
    let at = |i: usize| distances.get(i).copied().unwrap_or(0.0);
    let frames = run.frames.len().saturating_sub(1).max(1) as f32;
    let mean = |count: &dyn Fn(&PathFrame) -> usize| {
        run.frames.iter().skip(1).map(count).sum::<usize>() as f32 / frames
    };
    let rig = &stage.asset.rig;
    let row = Row {
        method: "skin-px",
        variant: Some("drift"),
        distance_m: at(distances.len() / 2),
        joint_update_gain: run.joint_update_gain,
        evaluations_saved: run.evaluations_saved,
        parameter: options.epsilon_px,
        level: None,
        error_px: ErrorPx {
            p50: run.error_px.p50,
            p95: run.error_px.p95,
            max: run.error_px.max,
        },
        joints_sampled: mean(&|f| f.sampled.intersection(&stage.moving).len()),
        fk_joints: mean(&|f| at_or_below(rig, &f.updated)),
        foot_slide_mm: None,
        meets_target: limit_px.map(|l| run.error_px.p95 <= l),
    };
    let joint_errors = run.frames.iter().map(|f| f.joint_error_px);
    let path = PathReport {
        frames: run.frames.len(),
        display_hz: path.display_hz,
        tolerance_px: options.epsilon_px,
        bound_px: options.bound_px(),
        joint_error_px_max: joint_errors.fold(0.0, f32::max),
        distance_m_min: at(0),
        distance_m_max: at(distances.len().saturating_sub(1)),
    };
    (row, path)
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

/// Marks of the joints at a frame.
pub(crate) fn marks(scene: &Scene<'_>, frame: &PathFrame) -> Vec<JointMark> {
    let root = scene.figure.asset.rig.root();
    let mark = |(joint, state): (usize, &JointState)| match state {
        JointState::ToActive | JointState::ToPassive => JointMark::InTransition,
        JointState::Passive if joint != root && !frame.updated.contains(joint) => {
            JointMark::Passive
        }
        _ => JointMark::Active,
    };
    frame.states.iter().enumerate().map(mark).collect()
}

/// Distance, joints updated and error over the time of a path.
pub(crate) fn plots(run: &PathRun, bound_px: f32, heading: &str) -> Vec<Plot> {
    let plot = |name, y: &str, target: Option<(f64, String)>, of: &dyn Fn(&PathFrame) -> f64| {
        let options = PlotOptions {
            title: format!("{y}, {heading}"),
            x_label: "time (s)".into(),
            y_label: y.into(),
            target,
            ..PlotOptions::default()
        };
        let series = Series {
            points: run.frames.iter().skip(1).map(|f| (f.secs, of(f))).collect(),
            ..Series::default()
        };
        Plot {
            name,
            svg: line_plot(&options, &[series]),
        }
    };
    let bound = (
        f64::from(bound_px),
        format!("bound of a joint {bound_px} px"),
    );
    vec![
        plot(
            "path-distance.svg",
            "Distance to the root (m)",
            None,
            &|f| f64::from(f.distance_m),
        ),
        plot("path-updates.svg", "Joints updated", None, &|f| {
            f.updated.len() as f64
        }),
        plot(
            "path-joint-error.svg",
            "Greatest joint error (px)",
            Some(bound),
            &|f| f64::from(f.joint_error_px),
        ),
        plot(
            "path-error.svg",
            "Error of the skin (px, p95 over vertices)",
            None,
            &|f| f64::from(f.error_px),
        ),
    ]
}
