//! A whole decision within what the device bears.
//!
//! Source: thesis 3.2.2.

use super::choice::check;
use super::decision::{Bound, Decision, DecisionRequest, NextStep, PartDecision, decided};
use super::part::Part;
use articula_core::Mismatch;

/// Decides what to send of a character, and to show.
///
/// The time per frame is bounded by the budget and by what the device bears (thesis 3.2.2). Limits narrow
/// the options of the parts, then wishes as far as the rest fits the budget, then
/// [`choose`](super::choose) takes the best. If the client cannot show 3D, or the cheapest options
/// exceed the budget, the best of the other representations is taken.
///
/// # Errors
/// As for [`choose`](super::choose).
pub fn decide(request: &DecisionRequest<'_>) -> Result<Decision, Mismatch> {
    check(request.parts, &request.choice)?;
    let Some((borne_ns, ratio)) = borne(request) else {
        return Ok(decided(request));
    };
    let mut within = *request;
    within.choice.budget.frame_ns = borne_ns;
    let decided = decided(&within);
    Ok(Decision {
        device_ratio: Some(ratio),
        bounds: by_device(decided.bounds),
        parts: decided.parts.into_iter().map(of_device).collect(),
        ..decided
    })
}

/// The time per frame that the device bears, and its share of that of the costliest options; `None` if
/// the budget is smaller, or nothing is known of the device or of times.
fn borne(request: &DecisionRequest<'_>) -> Option<(u64, f64)> {
    let device = request.device?;
    let costliest = |part: &Part| part.options.iter().map(|o| o.frame_ns).max();
    let full_ns: u64 = request.parts.iter().filter_map(costliest).sum();
    let borne_ns = device.frame_ns_allowed(full_ns);
    let is_bound = borne_ns < full_ns && borne_ns < request.choice.budget.frame_ns;
    is_bound.then(|| (borne_ns, device.ratio()))
}

/// The bounds of a decision whose time per frame is that of the device.
fn by_device(bounds: Vec<Bound>) -> Vec<Bound> {
    let of = |bound| match bound {
        Bound::FrameTime => Bound::Device,
        other => other,
    };
    bounds.into_iter().map(of).collect()
}

fn of_device(part: PartDecision) -> PartDecision {
    let next = part.next.map(|next| NextStep {
        bounds: by_device(next.bounds),
        ..next
    });
    PartDecision { next, ..part }
}
