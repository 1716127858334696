//! Choices that spend less thought: one part is cut, or all by the same share.
//!
//! The joint choice is never worse than these; tests and the example `adaptation` count how much
//! better it is.

use super::{Choice, ChoiceRequest, check, summed};
use crate::decide::part::Part;
use articula_core::Mismatch;

/// All parts at their least error, only one is cut; `None` if that does not meet the budget.
///
/// # Errors
/// As for [`choose`](super::choose), or if there is no such part.
pub fn cut_one(
    parts: &[Part],
    request: &ChoiceRequest,
    which: usize,
) -> Result<Option<Choice>, Mismatch> {
    check(parts, request)?;
    let Some(cut) = parts.get(which) else {
        let what = format!("{which}, there are {} parts", parts.len());
        return Err(Mismatch::new("which", what));
    };
    let mut options: Vec<usize> = parts.iter().map(|part| finest(part, request)).collect();
    let mut best: Option<Choice> = None;
    for option in 0..cut.options.len() {
        options[which] = option;
        let choice = summed(parts, &options, request, 0.0, false);
        let fits = choice.fits(&request.budget);
        let better = |old: &Choice| choice.error_px < old.error_px;
        if fits && best.as_ref().is_none_or(better) {
            best = Some(choice);
        }
    }
    Ok(best)
}

/// Each part gets the share of its finest option's bytes and time that the budget is of their sums,
/// and takes its least error within it; `None` if some part has no option within its share.
///
/// # Errors
/// As for [`choose`](super::choose).
pub fn cut_equally(parts: &[Part], request: &ChoiceRequest) -> Result<Option<Choice>, Mismatch> {
    check(parts, request)?;
    let full: Vec<usize> = parts.iter().map(|part| finest(part, request)).collect();
    let full = summed(parts, &full, request, 0.0, false);
    let share = |allowed: u64, whole: u64| {
        let share = if whole == 0 {
            1.0
        } else {
            allowed as f64 / whole as f64
        };
        share.min(1.0)
    };
    let shares = [
        share(request.budget.bytes, full.bytes),
        share(request.budget.frame_ns, full.frame_ns),
    ];
    let mut options = Vec::with_capacity(parts.len());
    for part in parts {
        let bytes = |i: usize| part.options[i].bytes(request.window_secs, part.held_bytes) as f64;
        let ns = |i: usize| part.options[i].frame_ns as f64;
        let most = finest(part, request);
        let fits =
            |i: &usize| bytes(*i) <= shares[0] * bytes(most) && ns(*i) <= shares[1] * ns(most);
        let error = |i: &usize| part.options[*i].pixels(request.pixels_per_metre);
        let within = (0..part.options.len()).filter(fits);
        match within.min_by(|a, b| error(a).total_cmp(&error(b))) {
            Some(option) => options.push(option),
            None => return Ok(None),
        }
    }
    let choice = summed(parts, &options, request, 0.0, false);
    Ok(Some(choice).filter(|choice| choice.fits(&request.budget)))
}

/// The option of least error, of equal ones the one of fewest bytes.
fn finest(part: &Part, request: &ChoiceRequest) -> usize {
    let key = |i: &usize| {
        let option = &part.options[*i];
        let bytes = option.bytes(request.window_secs, part.held_bytes);
        (option.pixels(request.pixels_per_metre), bytes)
    };
    let by = |a: &usize, b: &usize| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
    };
    (0..part.options.len()).min_by(by).unwrap_or(0)
}
