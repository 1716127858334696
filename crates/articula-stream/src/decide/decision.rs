//! A whole decision, with its reasons: joint choice, preferences, and the fall to another
//! representation.
//!
//! Source: thesis 3.2.

use super::choice::{Budget, Choice, ChoiceRequest, choose_among, summed};
use super::part::{Part, PartKind};
use super::preference::Preference;
use super::ratio::DeviceBenchmark;
use super::representation::{Representation, choose_representation, supports};

/// What a decision is about.
#[derive(Debug, Clone, Copy)]
pub struct DecisionRequest<'a> {
    /// Parts of the character in 3D.
    pub parts: &'a [Part],
    /// Features that a client needs to show them.
    pub parts_need: &'a [String],
    /// Budget, window, size on the screen.
    pub choice: ChoiceRequest,
    /// Limits and wishes; of wishes that exclude each other, the earlier holds.
    pub preferences: &'a [Preference],
    /// Other representations of the character.
    pub representations: &'a [Representation],
    /// Features that the client supports.
    pub capabilities: &'a [String],
    /// Kind of representation that the user wants, such as `vector`; `None` for 3D where possible.
    pub modality: Option<&'a str>,
    /// The device, if benchmarks of it are known: it bears a share of the time per frame of the costliest
    /// options, whatever the unit of these times.
    pub device: Option<DeviceBenchmark>,
}

/// What keeps a decision from a smaller error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The bytes within the window.
    Bytes,
    /// The time per frame.
    FrameTime,
    /// The time per frame that the device bears by its benchmarks.
    Device,
    /// The memory.
    Memory,
    /// A smaller error is not seen.
    View,
    /// The part has no emphasis.
    Emphasis,
    /// A limit or a wish.
    Preference(Preference),
    /// The client lacks a feature.
    Capability,
}

/// What is sent and shown.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// These options of the parts.
    Parts(Choice),
    /// The representation of this index.
    Representation(usize),
    /// Nothing fits.
    Nothing,
}

/// What a part got.
#[derive(Debug, Clone, PartialEq)]
pub struct PartDecision {
    /// Name of the part.
    pub name: String,
    /// Kind of the part.
    pub kind: PartKind,
    /// Index of the option.
    pub option: usize,
    /// Name of the option.
    pub option_name: String,
    /// Its bytes within the window.
    pub bytes: u64,
    /// Its time per frame, nanoseconds.
    pub frame_ns: u64,
    /// Its error, pixels, without the weight of the part.
    pub error_px: f64,
    /// The upgrade that gains most for its cost; `None` at the least error.
    pub next: Option<NextStep>,
}

/// An upgrade that was not taken.
#[derive(Debug, Clone, PartialEq)]
pub struct NextStep {
    /// Index of the option.
    pub option: usize,
    /// Name of the option.
    pub option_name: String,
    /// Its bytes beyond the present ones; negative if it has fewer.
    pub more_bytes: i64,
    /// Its nanoseconds beyond the present ones.
    pub more_frame_ns: i64,
    /// Its drop of the error, pixels.
    pub gain_px: f64,
    /// What forbids it, by itself. If nothing does, it would have to replace an upgrade of another
    /// part that gains more.
    pub bounds: Vec<Bound>,
}

/// A decision and its reasons; [`Display`](std::fmt::Display) says them in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// What was asked: budget, window, size on the screen.
    pub request: ChoiceRequest,
    /// Share of the time per frame of the costliest options that the device bears (`R_A` of the thesis),
    /// if that is what the time per frame is bounded by.
    pub device_ratio: Option<f64>,
    /// What is sent and shown.
    pub outcome: Outcome,
    /// Kind of encoding: `3d`, that of the representation, or empty if nothing fits.
    pub modality: String,
    /// Sum of the errors of the parts, pixels, without weights, or the error of the representation;
    /// infinite if nothing fits.
    pub error_px: f64,
    /// Bytes within the window.
    pub bytes: u64,
    /// What keeps the error from being smaller; empty at the least error. It names all that forbids the
    /// next step of a part.
    pub bounds: Vec<Bound>,
    /// Where the parts are not chosen: the fewest bytes within the window that they need in the time per
    /// frame and the limits; `None` if no number of bytes is enough. Where memory binds, a number that is
    /// enough.
    pub least_bytes: Option<u64>,
    /// What each part got; empty for another representation.
    pub parts: Vec<PartDecision>,
    /// The preferences that are not met: limits that no option of a part meets, and wishes that gave
    /// way.
    pub unmet: Vec<Preference>,
}

/// The decision within the budget: limits narrow the options of the parts, then wishes as far as the rest
/// fits, then [`choose`](super::choose) takes the best. If the client cannot show 3D, or the cheapest
/// options exceed the budget, the best of the other representations is taken.
pub(super) fn decided(request: &DecisionRequest<'_>) -> Decision {
    let (allowed, choice, unmet) = choose_parts(request);
    let bytes = request.choice.budget.bytes;
    let of_kind = |modality| {
        let forms = request.representations;
        choose_representation(forms, bytes, request.capabilities, modality)
    };
    let wanted = request.modality.filter(|m| *m != THREE_D);
    if let Some(form) = wanted.and_then(|m| of_kind(Some(m))) {
        return flat(request, form, Vec::new(), unmet);
    }
    let shows_parts = supports(request.capabilities, request.parts_need);
    if shows_parts
        && !request.parts.is_empty()
        && let Some(choice) = choice
    {
        return three_d(request, &allowed, choice, unmet);
    }
    let bounds = if shows_parts {
        too_little(request)
    } else {
        vec![Bound::Capability]
    };
    let least_bytes = least_bytes(request, &allowed).filter(|_| shows_parts);
    match of_kind(None) {
        Some(form) => Decision {
            least_bytes,
            ..flat(request, form, bounds, unmet)
        },
        None => Decision {
            least_bytes,
            request: request.choice,
            device_ratio: None,
            outcome: Outcome::Nothing,
            modality: String::new(),
            error_px: f64::INFINITY,
            bytes: 0,
            bounds,
            parts: Vec::new(),
            unmet,
        },
    }
}

const THREE_D: &str = "3d";

/// Options within limits and wishes, the choice among them, and the preferences that gave way.
fn choose_parts(
    request: &DecisionRequest<'_>,
) -> (Vec<Vec<usize>>, Option<Choice>, Vec<Preference>) {
    let parts = request.parts;
    let all = |part: &Part| (0..part.options.len()).collect();
    let mut allowed: Vec<Vec<usize>> = parts.iter().map(all).collect();
    let mut unmet = Vec::new();
    let preferences = request.preferences.iter().enumerate();
    for (index, limit) in preferences.clone().filter(|p| !p.1.is_wish) {
        match limit.narrow(parts, &allowed) {
            Some(left) => allowed = left,
            None => unmet.push((index, limit)),
        }
    }
    let mut choice = choose_among(parts, &allowed, &request.choice);
    for (index, wish) in preferences.filter(|p| p.1.is_wish) {
        let left = wish.narrow(parts, &allowed);
        let chosen = left.and_then(|left| {
            let choice = choose_among(parts, &left, &request.choice)?;
            Some((left, choice))
        });
        match chosen {
            Some((left, with_wish)) => (allowed, choice) = (left, Some(with_wish)),
            None => unmet.push((index, wish)),
        }
    }
    unmet.sort_unstable_by_key(|unmet| unmet.0);
    let unmet = unmet.into_iter().map(|unmet| *unmet.1).collect();
    (allowed, choice, unmet)
}

fn flat(
    request: &DecisionRequest<'_>,
    form: usize,
    bounds: Vec<Bound>,
    unmet: Vec<Preference>,
) -> Decision {
    let of = &request.representations[form];
    Decision {
        request: request.choice,
        device_ratio: None,
        outcome: Outcome::Representation(form),
        modality: of.modality.clone(),
        error_px: of.error_px,
        bytes: of.bytes,
        bounds,
        least_bytes: None,
        parts: Vec::new(),
        unmet,
    }
}

/// The fewest bytes of the parts within time, memory and limits.
fn least_bytes(request: &DecisionRequest<'_>, allowed: &[Vec<usize>]) -> Option<u64> {
    let any_error = ChoiceRequest {
        enough_px: f64::INFINITY,
        ..lifted(&request.choice, Bound::Bytes)
    };
    choose_among(request.parts, allowed, &any_error).map(|choice| choice.bytes)
}

/// Which budget the cheapest options exceed.
fn too_little(request: &DecisionRequest<'_>) -> Vec<Bound> {
    let without = |bound| {
        let all = |part: &Part| (0..part.options.len()).collect();
        let allowed: Vec<Vec<usize>> = request.parts.iter().map(all).collect();
        choose_among(request.parts, &allowed, &lifted(&request.choice, bound)).is_some()
    };
    let bounds: Vec<Bound> = BUDGETS.into_iter().filter(|b| without(*b)).collect();
    match bounds.is_empty() {
        true => BUDGETS.to_vec(),
        false => bounds,
    }
}

/// What a budget has.
const BUDGETS: [Bound; 3] = [Bound::Bytes, Bound::FrameTime, Bound::Memory];

/// The request without one of its bounds.
fn lifted(request: &ChoiceRequest, bound: Bound) -> ChoiceRequest {
    let mut wide = *request;
    match bound {
        Bound::Bytes => wide.budget.bytes = Budget::UNBOUNDED,
        Bound::FrameTime => wide.budget.frame_ns = Budget::UNBOUNDED,
        Bound::Memory => wide.budget.memory_bytes = Budget::UNBOUNDED,
        Bound::Device
        | Bound::View
        | Bound::Emphasis
        | Bound::Preference(_)
        | Bound::Capability => {
            wide.enough_px = 0.0;
        }
    }
    wide
}

fn three_d(
    request: &DecisionRequest<'_>,
    allowed: &[Vec<usize>],
    choice: Choice,
    unmet: Vec<Preference>,
) -> Decision {
    let parts: Vec<PartDecision> = (0..request.parts.len())
        .map(|i| part_decision(request, allowed, &choice, i))
        .collect();
    Decision {
        request: request.choice,
        device_ratio: None,
        modality: THREE_D.to_owned(),
        error_px: parts.iter().map(|p| p.error_px).sum(),
        bytes: choice.bytes,
        bounds: bounds(request, allowed, &choice, &parts),
        least_bytes: None,
        parts,
        outcome: Outcome::Parts(choice),
        unmet,
    }
}

/// What would have to be lifted for a smaller error, or forbids the next step of a part.
fn bounds(
    request: &DecisionRequest<'_>,
    allowed: &[Vec<usize>],
    choice: &Choice,
    parts: &[PartDecision],
) -> Vec<Bound> {
    let mut bounds = match choice.is_enough {
        // Each step that is left is not seen.
        true => Vec::new(),
        false => lifting(request, allowed, choice),
    };
    let next = parts.iter().filter_map(|part| part.next.as_ref());
    for bound in next.flat_map(|next| &next.bounds) {
        if !bounds.contains(bound) {
            bounds.push(*bound);
        }
    }
    bounds
}

/// What would have to be lifted for a smaller error.
fn lifting(request: &DecisionRequest<'_>, allowed: &[Vec<usize>], choice: &Choice) -> Vec<Bound> {
    let smaller = |with: &ChoiceRequest, allowed: &[Vec<usize>]| {
        let found = choose_among(request.parts, allowed, with);
        found.is_some_and(|c| c.error_px < choice.error_px * (1.0 - 1e-6))
    };
    let mut bounds: Vec<Bound> = BUDGETS
        .into_iter()
        .filter(|b| smaller(&lifted(&request.choice, *b), allowed))
        .collect();
    let ample = BUDGETS
        .into_iter()
        .fold(request.choice, |r, b| lifted(&r, b));
    if bounds.is_empty() && smaller(&ample, allowed) {
        bounds.extend(BUDGETS);
    }
    // A preference binds if one of its parts could take an option of smaller error without it.
    for preference in request.preferences {
        let better = |(i, part): (usize, &Part)| {
            let k = request.choice.pixels_per_metre;
            let now = part.options[choice.options[i]].pixels(k);
            let mut options = part.options.iter();
            let holds = preference.rule.allows(&part.options[choice.options[i]]);
            part.kind == preference.part
                && holds
                && options.any(|o| !preference.rule.allows(o) && o.pixels(k) < now)
        };
        if request.parts.iter().enumerate().any(better) {
            bounds.push(Bound::Preference(*preference));
        }
    }
    bounds
}

fn part_decision(
    request: &DecisionRequest<'_>,
    allowed: &[Vec<usize>],
    choice: &Choice,
    index: usize,
) -> PartDecision {
    let part = &request.parts[index];
    let of = &request.choice;
    let now = choice.options[index];
    let bytes = |i: usize| part.options[i].bytes(of.window_secs, part.held_bytes);
    let px = |i: usize| part.options[i].pixels(of.pixels_per_metre);
    let ns = |i: usize| part.options[i].frame_ns;
    // Gain per share of both budgets; what costs nothing comes first.
    let rate = |i: usize| {
        let share = |more: u64, whole: u64| more as f64 / whole.max(1) as f64;
        let more = share(bytes(i).saturating_sub(bytes(now)), of.budget.bytes);
        (px(now) - px(i)) / (more + share(ns(i).saturating_sub(ns(now)), of.budget.frame_ns))
    };
    let finer = (0..part.options.len()).filter(|i| px(*i) < px(now));
    let next = finer.max_by(|a, b| rate(*a).total_cmp(&rate(*b)).then(b.cmp(a)));
    let next = next.map(|i| NextStep {
        option: i,
        option_name: part.options[i].name.clone(),
        more_bytes: bytes(i) as i64 - bytes(now) as i64,
        more_frame_ns: ns(i) as i64 - ns(now) as i64,
        gain_px: px(now) - px(i),
        bounds: forbidding(request, &allowed[index], choice, (index, i)),
    });
    PartDecision {
        name: part.name.clone(),
        kind: part.kind,
        option: now,
        option_name: part.options[now].name.clone(),
        bytes: bytes(now),
        frame_ns: ns(now),
        error_px: px(now),
        next,
    }
}

/// What forbids an option of a part beside the choice of all others.
fn forbidding(
    request: &DecisionRequest<'_>,
    allowed: &[usize],
    choice: &Choice,
    (index, option): (usize, usize),
) -> Vec<Bound> {
    let part = &request.parts[index];
    let mut bounds = Vec::new();
    if choice.is_enough {
        bounds.push(Bound::View);
    } else if part.weight == 0.0 {
        bounds.push(Bound::Emphasis);
    } else {
        let mut with = choice.options.clone();
        with[index] = option;
        let sums = summed(request.parts, &with, &request.choice, 0.0, false);
        let budget = &request.choice.budget;
        let exceeds = |bound: &Bound| match bound {
            Bound::Bytes => sums.bytes > budget.bytes,
            Bound::FrameTime => sums.frame_ns > budget.frame_ns,
            _ => sums.memory_bytes > budget.memory_bytes,
        };
        bounds.extend(BUDGETS.into_iter().filter(exceeds));
    }
    if !allowed.contains(&option) {
        let refuses =
            |p: &&Preference| p.part == part.kind && !p.rule.allows(&part.options[option]);
        let refusing = request.preferences.iter().filter(refuses);
        bounds.extend(refusing.map(|p| Bound::Preference(*p)));
    }
    bounds
}
