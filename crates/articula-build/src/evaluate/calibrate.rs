//! The best parameter of a method under an error limit: calibrate, then compare.

use super::method::Method;
use super::stage::{Stage, Trial, play};

/// Geometric steps of a sweep, as in the published numbers.
const STEPS: usize = 26;

/// Halvings between the best step that meets the limit and the next one.
const REFINEMENTS: usize = 5;

/// Parameters that a sweep tries, from gentle to harsh.
pub fn parameters(method: &Method) -> Vec<f32> {
    let geometric = |from: f32, to: f32| -> Vec<f32> {
        let ratio = (to / from).powf(1.0 / (STEPS - 1) as f32);
        (0..STEPS).map(|i| from * ratio.powi(i as i32)).collect()
    };
    match method {
        Method::SkinPx(_) => geometric(2e-4, 0.4),
        Method::Thesis => geometric(1e-4, 1.0),
        Method::Ahn => geometric(2e-4, 1.0),
        Method::SkipHold | Method::SkipLerp => (1..=STEPS).map(|n| n as f32).collect(),
        Method::Loa(levels) => (0..levels.len()).map(|i| i as f32).collect(),
    }
}

/// Plays a method over its whole range of parameters.
pub fn sweep(stage: &Stage<'_>, method: &Method) -> Vec<Trial> {
    parameters(method)
        .into_iter()
        .map(|p| play(stage, method, p).0)
        .collect()
}

/// The trial with the greatest gain whose p95 error at a distance is at most `limit_px`. Where
/// none meets it, the one that errs least. `swept` comes from [`sweep`]; continuous parameters
/// are refined between its steps.
pub fn calibrate(
    stage: &Stage<'_>,
    method: &Method,
    swept: &[Trial],
    distance_m: f32,
    limit_px: f32,
) -> Option<Trial> {
    let limit = limit_px / stage.setup.viewport.pixels_per_metre(distance_m);
    let meets = |t: &Trial| t.error.p95 <= limit;
    let by_gain = |a: &&Trial, b: &&Trial| a.joint_update_gain.total_cmp(&b.joint_update_gain);
    let Some(best) = swept.iter().filter(|t| meets(t)).max_by(by_gain) else {
        return swept
            .iter()
            .min_by(|a, b| a.error.p95.total_cmp(&b.error.p95))
            .copied();
    };
    let mut best = *best;
    let harsher = swept.iter().find(|t| t.parameter > best.parameter);
    if let (Method::SkinPx(_) | Method::Thesis | Method::Ahn, Some(above)) = (method, harsher) {
        let (mut low, mut high) = (best.parameter, above.parameter);
        for _ in 0..REFINEMENTS {
            let trial = play(stage, method, (low * high).sqrt()).0;
            if meets(&trial) {
                low = trial.parameter;
                if trial.joint_update_gain >= best.joint_update_gain {
                    best = trial;
                }
            } else {
                high = trial.parameter;
            }
        }
    }
    Some(best)
}
