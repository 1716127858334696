//! Gain and error of methods over distance. The field names are a promise to scripts.

use super::Scene;
use super::methods::Chosen;
use crate::console::Console;
use articula_build::evaluate::{self, Stage, Trial, calibrate, play, sweep};
use rayon::prelude::*;
use serde::Serialize;

/// How the one parameter of a method is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tuning {
    /// What the method would take at each distance.
    Usual,
    /// This value at every distance.
    Fixed(f32),
    /// The greatest gain whose p95 error is at most so many pixels.
    Calibrated(f32),
}

/// One method at one distance.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    pub(crate) method: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) variant: Option<&'static str>,
    pub(crate) distance_m: f32,
    pub(crate) joint_update_gain: f32,
    pub(crate) evaluations_saved: f32,
    pub(crate) parameter: f32,
    /// The level of articulation that `parameter` counts to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) level: Option<String>,
    pub(crate) error_px: ErrorPx,
    pub(crate) joints_sampled: f32,
    pub(crate) fk_joints: f32,
    /// Mean way that standing feet slide because of what is held; null along a camera path.
    pub(crate) foot_slide_mm: Option<f32>,
    /// Whether the error meets the target of a calibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) meets_target: Option<bool>,
}

/// Statistics of the error over frames, of the 95th percentile over the skin.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct ErrorPx {
    pub(crate) p50: f32,
    pub(crate) p95: f32,
    pub(crate) max: f32,
}

/// The rows of one method.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    pub(crate) chosen: Chosen,
    pub(crate) rows: Vec<Row>,
}

/// Plays all methods at all distances, in parallel.
pub(crate) fn of(
    scene: &Scene<'_>,
    methods: &[Chosen],
    distances_m: &[f32],
    tuning: Tuning,
    console: &Console,
) -> Vec<Table> {
    let bar = console.progress("playing methods", methods.len() * distances_m.len());
    let table = |chosen: &Chosen| {
        let stage = scene.stage();
        let swept = match tuning {
            Tuning::Calibrated(_) => sweep(&stage, &chosen.method),
            _ => Vec::new(),
        };
        let row = |distance: &f32| {
            let row = at(&stage, chosen, &swept, *distance, tuning);
            bar.inc(1);
            row
        };
        Table {
            chosen: chosen.clone(),
            rows: distances_m.iter().map(row).collect(),
        }
    };
    let tables = methods.par_iter().map(table).collect();
    bar.finish_and_clear();
    tables
}

fn at(stage: &Stage<'_>, chosen: &Chosen, swept: &[Trial], distance_m: f32, tuning: Tuning) -> Row {
    let usual = || stage.usual_parameter(&chosen.method, distance_m);
    let trial = match tuning {
        Tuning::Usual => play(stage, &chosen.method, usual()).0,
        Tuning::Fixed(parameter) => play(stage, &chosen.method, parameter).0,
        // A method without any parameter to sweep is played as it is.
        Tuning::Calibrated(limit) => calibrate(stage, swept, distance_m, limit)
            .unwrap_or_else(|| play(stage, &chosen.method, usual()).0),
    };
    let evaluate::Row { error_px, .. } = stage.row(trial, distance_m);
    let target = match tuning {
        Tuning::Calibrated(limit) => Some(error_px.p95 <= limit * 1.0001),
        _ => None,
    };
    Row {
        method: chosen.method.name(),
        variant: chosen.variant,
        distance_m,
        joint_update_gain: trial.joint_update_gain,
        evaluations_saved: trial.evaluations_saved,
        parameter: trial.parameter,
        level: chosen.levels.get(trial.parameter as usize).cloned(),
        error_px: ErrorPx {
            p50: error_px.p50,
            p95: error_px.p95,
            max: error_px.max,
        },
        joints_sampled: trial.joints_sampled,
        fk_joints: trial.fk_joints,
        foot_slide_mm: Some(1000.0 * trial.foot_slide_metres),
        meets_target: target,
    }
}
