//! Calibration: the best parameter of a method under an error limit, so that methods are compared
//! at equal error.

use super::method::Method;
use super::playbacks::play;
use super::stage::{ClipEvaluator, MethodRun};

/// Parameter values of a sweep, in order of increasing error: 24 or 26 geometric steps, as in the
/// published numbers; every whole number of frames up to 26; every level.
fn parameters(method: &Method) -> Vec<f32> {
    let geometric = |from: f32, to: f32, steps: usize| -> Vec<f32> {
        let ratio = (to / from).powf(1.0 / (steps - 1) as f32);
        (0..steps).map(|i| from * ratio.powi(i as i32)).collect()
    };
    match method {
        Method::SkinPx(_) => geometric(2e-4, 0.4, 26),
        Method::Thesis => geometric(1e-4, 0.3, 24),
        Method::Ahn => geometric(2e-4, 0.4, 26),
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

/// Returns the swept run with the largest gain whose p95 error at a distance is at most `limit_px`.
/// Where no run meets it, returns the one with the smallest error; `None` only for an empty sweep.
pub fn calibrate(
    stage: &ClipEvaluator<'_>,
    swept: &[MethodRun],
    distance_m: f32,
    limit_px: f32,
) -> Option<MethodRun> {
    let limit = limit_px / stage.setup.viewport.pixels_per_metre(distance_m);
    let by_gain =
        |a: &&MethodRun, b: &&MethodRun| a.joint_update_gain.total_cmp(&b.joint_update_gain);
    let by_error = |a: &&MethodRun, b: &&MethodRun| a.error.p95.total_cmp(&b.error.p95);
    let meeting = swept
        .iter()
        .filter(|t| t.error.p95 <= limit)
        .max_by(by_gain);
    meeting.or_else(|| swept.iter().min_by(by_error)).copied()
}
