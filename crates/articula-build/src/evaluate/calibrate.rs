//! Calibration: the best parameter of a method under an error limit, so that methods are compared
//! at equal error.

use super::method::Method;
use super::playbacks::play;
use super::stage::{ClipEvaluator, MethodRun};
use articula_core::Libm;

/// Number of times that an interval of the sweep is halved: a step of a third becomes one of 0.03 %.
const HALVINGS: usize = 10;

/// Parameter values of a sweep, from the smallest error to the largest where that rises with the
/// parameter: 24 or 26 geometric steps; every whole number of frames up to 26; every level.
fn parameters(method: &Method) -> Vec<f32> {
    let geometric = |from: f32, to: f32, steps: usize| -> Vec<f32> {
        let ratio = (to / from).libm_powf(1.0 / (steps - 1) as f32);
        (0..steps).map(|i| from * ratio.powi(i as i32)).collect()
    };
    match method {
        Method::SkinPx(_) => geometric(2e-4, 0.4, 26),
        Method::Thesis => geometric(1e-4, 0.3, 24),
        Method::Ahn => geometric(2e-4, 0.4, 26),
        Method::PrincipalComponents => geometric(1e-3, 10.0, 26),
        Method::SkipHold | Method::SkipLerp => (1..=26).map(|n| n as f32).collect(),
        Method::Loa(levels) => (0..levels.len()).map(|i| i as f32).collect(),
    }
}

/// Runs a method at every parameter value of its sweep.
pub fn sweep(stage: &ClipEvaluator<'_>, method: &Method) -> Vec<MethodRun> {
    parameters(method)
        .into_iter()
        .map(|p| play(stage, method, p).0)
        .collect()
}

/// Returns the run with the largest gain whose p95 error at a distance is at most `limit_px`.
///
/// The sweep shows where the error crosses the limit. Every crossing is narrowed by bisection: the
/// error need not rise with the parameter, and a larger parameter may meet the limit where a smaller
/// one does not. Parameters that count frames or levels are compared as they are. Where no run meets
/// the limit, returns the one with the smallest error; `None` only for an empty sweep.
pub fn calibrate(
    stage: &ClipEvaluator<'_>,
    method: &Method,
    swept: &[MethodRun],
    distance_m: f32,
    limit_px: f32,
) -> Option<MethodRun> {
    let limit = limit_px / stage.setup.viewport.pixels_per_metre(distance_m);
    let meets = |run: &MethodRun| run.error.p95 <= limit;
    let mut meeting: Vec<MethodRun> = swept.iter().copied().filter(|run| meets(run)).collect();
    if method.has_real_parameter() {
        for pair in swept
            .windows(2)
            .filter(|pair| meets(&pair[0]) != meets(&pair[1]))
        {
            let narrowed = narrowed(pair, meets, |parameter| play(stage, method, parameter).0);
            meeting.extend(narrowed);
        }
    }
    let by_gain =
        |a: &MethodRun, b: &MethodRun| a.joint_update_gain.total_cmp(&b.joint_update_gain);
    let by_error = |a: &&MethodRun, b: &&MethodRun| a.error.p95.total_cmp(&b.error.p95);
    let best = meeting.into_iter().max_by(by_gain);
    best.or_else(|| swept.iter().min_by(by_error).copied())
}

/// The runs within an interval that meet the limit, one of whose ends does; each is nearer to the
/// other end than the one before.
fn narrowed(
    pair: &[MethodRun],
    meets: impl Fn(&MethodRun) -> bool,
    run: impl Fn(f32) -> MethodRun,
) -> Vec<MethodRun> {
    let (mut good, mut bad) = (pair[0].parameter, pair[1].parameter);
    if !meets(&pair[0]) {
        (good, bad) = (bad, good);
    }
    let mut found = Vec::new();
    for _ in 0..HALVINGS {
        // The sweep is geometric.
        let tried = run((good * bad).sqrt());
        if meets(&tried) {
            good = tried.parameter;
            found.push(tried);
        } else {
            bad = tried.parameter;
        }
    }
    found
}
