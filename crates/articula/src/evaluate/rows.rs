//! Gain and error of methods over distance.

use super::{EvaluatedClip, NamedMethod};
use crate::error::Result;
use crate::work::Executor;
use articula_build::evaluate::{
    ClipEvaluator, DistanceRow, FrameErrors, Method, MethodRun, PartErrors, SkinErrors, calibrate,
    play, sweep,
};
use serde::Serialize;

/// Distances of the tables, metres (`docs/methods/motion-lod.md`).
pub const DISTANCES_M: [f32; 5] = [3.5, 5.65, 9.05, 16.0, 25.6];

/// Choice of a method's parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterChoice {
    /// The method's default at each distance.
    Usual,
    /// The same value at every distance.
    Fixed(f32),
    /// The greatest gain whose 95th percentile error is at most this many pixels.
    Calibrated(f32),
}

/// Result of one method at one distance.
#[derive(Debug, Clone, Serialize)]
pub struct MethodRow {
    /// Name of the method.
    pub method: &'static str,
    /// Variant of the method, if it has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<&'static str>,
    /// Distance of the camera to the root in metres; the median along a camera path.
    pub distance_m: f32,
    /// Fraction of joint updates saved.
    pub joint_update_gain: f32,
    /// Fraction of frames in which no joint was updated.
    pub evaluations_saved: f32,
    /// The method's parameter.
    pub parameter: f32,
    /// Name of the level of articulation that `parameter` selects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<String>,
    /// Error in pixels: percentiles over a sample of the skin, the maximum over all of it.
    pub error_px: ErrorPx,
    /// Error of all vertices of the hands; null without hands, and along a camera path.
    pub hands_px: Option<ErrorPx>,
    /// Error of all vertices of the head.
    pub face_px: Option<ErrorPx>,
    /// Error of all vertices of the feet.
    pub feet_px: Option<ErrorPx>,
    /// Mean number of joints sampled per frame.
    pub joints_sampled: f32,
    /// Mean number of joints per frame whose model matrix changed.
    pub fk_joints: f32,
    /// Mean distance that feet in contact slide because joints are held, in millimetres; null along
    /// a camera path.
    pub foot_slide_mm: Option<f32>,
    /// Whether the error meets the target of a calibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meets_target: Option<bool>,
}

/// Statistics over frames of the 95th percentile error over the skin.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ErrorPx {
    /// Median over frames.
    pub p50: f32,
    /// 95th percentile over frames.
    pub p95: f32,
    /// Maximum over frames.
    pub max: f32,
    /// Maximum over all vertices and all frames.
    pub worst_vertex: f32,
}

impl ErrorPx {
    pub(super) fn new(error: FrameErrors, worst_vertex: f32) -> Self {
        Self {
            p50: error.p50,
            p95: error.p95,
            max: error.max,
            worst_vertex,
        }
    }

    fn of_part(part: PartErrors) -> Self {
        Self::new(part.frames, part.worst_vertex)
    }
}

/// Results of one method at all distances.
#[derive(Debug, Clone)]
pub struct MethodTable {
    /// The method.
    pub method: NamedMethod,
    /// One row for each distance.
    pub rows: Vec<MethodRow>,
}

/// Evaluates a method at every distance, with its parameter chosen by `tuning`; a method without a
/// parameter to calibrate uses its default.
pub fn rows(
    stage: &ClipEvaluator<'_>,
    method: &Method,
    distances_m: &[f32],
    tuning: ParameterChoice,
) -> Vec<DistanceRow> {
    let swept = match tuning {
        ParameterChoice::Calibrated(_) => sweep(stage, method),
        _ => Vec::new(),
    };
    let mut known: Vec<(MethodRun, SkinErrors)> = Vec::new();
    let row = |distance_m: &f32| {
        let parameter = parameter(stage, method, &swept, *distance_m, tuning);
        let same = known.iter().find(|(run, _)| run.parameter == parameter);
        let measured = same.copied().unwrap_or_else(|| {
            // The search measures a sample; the whole skin is measured for its result alone.
            let (run, playbacks) = play(stage, method, parameter);
            let measured = (run, stage.skin_errors(&playbacks));
            known.push(measured);
            measured
        });
        stage.row(measured, *distance_m)
    };
    distances_m.iter().map(row).collect()
}

fn parameter(
    stage: &ClipEvaluator<'_>,
    method: &Method,
    swept: &[MethodRun],
    distance_m: f32,
    tuning: ParameterChoice,
) -> f32 {
    let usual = stage.default_parameter(method, distance_m);
    match tuning {
        ParameterChoice::Usual => usual,
        ParameterChoice::Fixed(parameter) => parameter,
        ParameterChoice::Calibrated(limit) => {
            let best = calibrate(stage, method, swept, distance_m, limit);
            best.map_or(usual, |run| run.parameter)
        }
    }
}

impl EvaluatedClip<'_> {
    /// Plays all methods at all distances. There is one job per method.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled) only.
    pub fn tables(
        &self,
        methods: &[NamedMethod],
        distances_m: &[f32],
        tuning: ParameterChoice,
        work: &Executor<'_>,
    ) -> Result<Vec<MethodTable>> {
        work.map("evaluating methods", methods.iter().collect(), |named| {
            let rows = rows(&self.stage(), &named.method, distances_m, tuning);
            Ok(MethodTable {
                method: named.clone(),
                rows: rows.iter().map(|r| named_row(named, r, tuning)).collect(),
            })
        })
    }
}

fn named_row(named: &NamedMethod, row: &DistanceRow, tuning: ParameterChoice) -> MethodRow {
    let trial = &row.trial;
    let target = match tuning {
        ParameterChoice::Calibrated(limit) => Some(row.error_px.p95 <= limit * 1.0001),
        _ => None,
    };
    MethodRow {
        method: named.method.name(),
        variant: named.variant,
        distance_m: row.distance_m,
        joint_update_gain: trial.joint_update_gain,
        evaluations_saved: trial.evaluations_saved,
        parameter: trial.parameter,
        level: named.levels.get(trial.parameter as usize).cloned(),
        error_px: ErrorPx::new(row.error_px, row.skin_px.worst_vertex),
        hands_px: row.skin_px.hands.map(ErrorPx::of_part),
        face_px: row.skin_px.face.map(ErrorPx::of_part),
        feet_px: row.skin_px.feet.map(ErrorPx::of_part),
        joints_sampled: trial.joints_sampled,
        fk_joints: trial.fk_joints,
        foot_slide_mm: Some(1000.0 * trial.foot_slide_metres),
        meets_target: target,
    }
}
