//! The plain form of the joint choice: all combinations of options.

use super::{Choice, ChoiceRequest, check, summed};
use crate::decide::part::Part;
use articula_core::Mismatch;

/// Tries all combinations and returns the one that [`choose`](super::choose) looks for; the oracle of
/// its tests. Time is exponential in the parts: at most `most` combinations are tried.
///
/// # Errors
/// As for [`choose`](super::choose), or if there are more combinations than `most`.
pub fn choose_exhaustively(
    parts: &[Part],
    request: &ChoiceRequest,
    most: u64,
) -> Result<Option<Choice>, Mismatch> {
    check(parts, request)?;
    let counts = parts.iter().map(|p| p.options.len() as u64);
    let all = counts.fold(1, u64::saturating_mul);
    if all > most {
        let what = format!("{all} combinations, expected at most {most}");
        return Err(Mismatch::new("parts", what));
    }
    let mut best: Option<Choice> = None;
    let mut options = vec![0; parts.len()];
    loop {
        let choice = summed(parts, &options, request, 0.0, false);
        let fits = choice.fits(&request.budget);
        if fits
            && best
                .as_ref()
                .is_none_or(|old| is_better(&choice, old, request))
        {
            best = Some(choice);
        }
        // Counts up, the last part first.
        let Some(next) = (0..parts.len()).rfind(|p| options[*p] + 1 < parts[*p].options.len())
        else {
            break;
        };
        options[next] += 1;
        options[next + 1..].fill(0);
    }
    if let Some(best) = &mut best {
        best.bound_px = best.error_px;
        best.is_enough = best.error_px <= request.enough_px;
    }
    Ok(best)
}

fn is_better(new: &Choice, old: &Choice, request: &ChoiceRequest) -> bool {
    let enough = |c: &Choice| c.error_px <= request.enough_px;
    match (enough(new), enough(old)) {
        (true, true) => new.bytes < old.bytes,
        (false, false) => new.error_px < old.error_px,
        (new, _) => new,
    }
}
