//! Memory as a bound: options that take much are left out until the choice among the others fits.
//!
//! Bytes and time bind in most contexts, memory in few, so it is no third price. What is left out is that
//! of the part whose loss costs the least error; the result fits, and is not proved to be the best.

use super::Choice;
use crate::decide::part::Part;

/// The choice by `choose` among options that fit the memory together; `None` if none was found.
pub(super) fn within(
    parts: &[Part],
    allowed: &[Vec<usize>],
    most: u64,
    choose: &dyn Fn(&[Vec<usize>]) -> Option<Choice>,
) -> Option<Choice> {
    let mut choice = choose(allowed)?;
    if choice.memory_bytes <= most {
        return Some(choice);
    }
    let bound_px = choice.bound_px;
    let memory = |part: usize, option: usize| parts[part].options[option].memory_bytes;
    let mut allowed = fitting_alone(parts, allowed, most)?;
    choice = choose(&allowed)?;
    while choice.memory_bytes > most {
        let excess = choice.memory_bytes - most;
        let less = |part: usize| {
            let now = memory(part, choice.options[part]);
            // As much as is too much, or where a part has no such option, some.
            let at_most = |limit: u64| {
                let options = allowed[part].iter().copied();
                options.filter(|o| memory(part, *o) <= limit).collect()
            };
            let all: Vec<usize> = now.checked_sub(excess).map(at_most).unwrap_or_default();
            let some: Vec<usize> = now.checked_sub(1).map(at_most).unwrap_or_default();
            let left = if all.is_empty() { some } else { all };
            let mut next = allowed.clone();
            next[part] = left;
            let found = (!next[part].is_empty()).then(|| choose(&next))??;
            Some((next, found))
        };
        let by = |(_, a): &(_, Choice), (_, b): &(_, Choice)| {
            let over = |c: &Choice| c.memory_bytes.saturating_sub(most);
            let is_less = over(a) < choice.memory_bytes - most;
            let other = over(b) < choice.memory_bytes - most;
            // What is not seen does not count.
            let by_error = match (a.is_enough, b.is_enough) {
                (true, true) => a.bytes.cmp(&b.bytes),
                (a_is, b_is) => b_is.cmp(&a_is).then(a.error_px.total_cmp(&b.error_px)),
            };
            other
                .cmp(&is_less)
                .then(by_error)
                .then(over(a).cmp(&over(b)))
        };
        let tried = (0..parts.len()).filter_map(less);
        (allowed, choice) = tried.min_by(by)?;
    }
    choice.bound_px = bound_px.min(choice.error_px);
    Some(choice)
}

/// The options that fit beside those of all other parts that take the least; `None` if a part has none.
fn fitting_alone(parts: &[Part], allowed: &[Vec<usize>], most: u64) -> Option<Vec<Vec<usize>>> {
    let memory = |part: &Part, option: &usize| part.options[*option].memory_bytes;
    let least = |(part, allowed): (&Part, &Vec<usize>)| {
        let of = allowed.iter().map(|option| memory(part, option));
        of.min().unwrap_or(0)
    };
    let least: Vec<u64> = parts.iter().zip(allowed).map(least).collect();
    let spare = most.checked_sub(least.iter().sum())?;
    let fitting = |((part, allowed), least): ((&Part, &Vec<usize>), &u64)| {
        let fits = |option: &&usize| memory(part, option) <= least + spare;
        allowed.iter().filter(fits).copied().collect()
    };
    Some(parts.iter().zip(allowed).zip(&least).map(fitting).collect())
}
