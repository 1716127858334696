//! The joint choice: one option for each part, with the least visible error that bytes and time allow.
//!
//! Source: thesis 7.2.1 (animation and representation adapted in harmony). Method, and the proof of
//! the bound: `docs/methods/adaptation.md` part 3. Steps: prices of the two budgets ([`dual`]), greedy
//! choice along hulls ([`greedy`]), changes of one or two parts ([`polish`]), branch and bound
//! ([`search`]). Memory is kept by leaving out options ([`memory`]).

mod baseline;
mod dual;
mod exhaustive;
mod greedy;
mod memory;
mod polish;
mod problem;
mod search;
#[cfg(test)]
mod tests;

pub use baseline::{cut_equally, cut_one};
pub use exhaustive::choose_exhaustively;

use super::part::{MAX_PARTS, MOST, Part};
use articula_core::Mismatch;
use problem::{Picks, Problem, Sums, keep_better};

/// What may be spent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Bytes within the window.
    pub bytes: u64,
    /// Time per frame, nanoseconds.
    pub frame_ns: u64,
    /// Bytes of memory for what is decoded.
    pub memory_bytes: u64,
}

impl Budget {
    /// Bytes or nanoseconds that no choice exceeds, where nothing bounds them.
    pub const UNBOUNDED: u64 = MOST * MAX_PARTS as u64;
}

/// What the options of parts are compared by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChoiceRequest {
    /// What may be spent.
    pub budget: Budget,
    /// Stretch of content for which the bytes are counted, seconds.
    pub window_secs: f64,
    /// Size on the screen, [`pixels_per_metre`](super::pixels_per_metre).
    pub pixels_per_metre: f64,
    /// Error that is not seen, pixels: if it can be kept, the fewest bytes that keep it are chosen.
    /// 0 makes the error as small as possible.
    pub enough_px: f64,
    /// Maximum number of items that the search for a proof visits; 0 skips it.
    pub effort: u32,
}

impl ChoiceRequest {
    /// [`effort`](Self::effort) that suffices for a proof in nearly all cases and bounds the time to a
    /// few milliseconds.
    pub const EFFORT: u32 = 200_000;

    fn check(&self) -> Result<(), Mismatch> {
        let numbers = [
            ("window_secs", self.window_secs, 1e9),
            ("pixels_per_metre", self.pixels_per_metre, 1e9),
            ("enough_px", self.enough_px, f64::INFINITY),
        ];
        for (name, value, limit) in numbers {
            if !(value >= 0.0 && value <= limit) {
                let what = format!("{value}, expected 0 to {limit:e}");
                return Err(Mismatch::new(name, what));
            }
        }
        Ok(())
    }
}

/// One option for each part.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Index of the option of each part.
    pub options: Vec<usize>,
    /// Bytes within the window.
    pub bytes: u64,
    /// Time per frame, nanoseconds.
    pub frame_ns: u64,
    /// Bytes of memory for what is decoded.
    pub memory_bytes: u64,
    /// Sum of the errors of the parts times their weights, pixels. With weights of 1 no point of the
    /// skin, and no feature of its texture, is farther from its place.
    pub error_px: f64,
    /// No choice within the budget has an error below this, pixels. Equal to `error_px` if the choice
    /// is proved to be the best.
    pub bound_px: f64,
    /// Whether the error is below `enough_px` and bytes were saved instead.
    pub is_enough: bool,
}

impl Choice {
    /// Whether it keeps a budget.
    fn fits(&self, budget: &Budget) -> bool {
        self.bytes <= budget.bytes
            && self.frame_ns <= budget.frame_ns
            && self.memory_bytes <= budget.memory_bytes
    }
}

/// Chooses one option for each part, with the least sum of weighted errors within the budget; `None`
/// if no choice within the budget was found.
///
/// Microseconds to a few milliseconds; memory is linear in the options. The same input gives the
/// same choice.
///
/// ```
/// use articula_stream::decide::{
///     Budget, ChoiceRequest, Part, PartKind, PartOption, choose,
/// };
///
/// let option = |bytes_once, error_m| PartOption { bytes_once, error_m, ..Default::default() };
/// let parts = [
///     Part::new("body", PartKind::BodyMotion, vec![option(1000, 0.050), option(3000, 0.005)]),
///     Part::new("mesh", PartKind::Mesh, vec![option(2000, 0.020), option(9000, 0.002)]),
/// ];
/// let request = ChoiceRequest {
///     budget: Budget { bytes: 10_000, frame_ns: 1_000_000, memory_bytes: Budget::UNBOUNDED },
///     window_secs: 2.0,
///     pixels_per_metre: 100.0,
///     enough_px: 0.0,
///     effort: ChoiceRequest::EFFORT,
/// };
/// // A finer motion is worth more here than a finer mesh: 0.5 + 2.0 pixels are left.
/// let choice = choose(&parts, &request)?.expect("the coarsest options fit");
/// assert_eq!(choice.options, [1, 0]);
/// assert_eq!(choice.error_px, 2.5);
/// # Ok::<(), articula_core::Mismatch>(())
/// ```
///
/// # Errors
/// If there are more than 16 parts, or a number of a part or of the request is negative,
/// NaN or too large.
pub fn choose(parts: &[Part], request: &ChoiceRequest) -> Result<Option<Choice>, Mismatch> {
    check(parts, request)?;
    let all = |part: &Part| (0..part.options.len()).collect();
    let allowed: Vec<Vec<usize>> = parts.iter().map(all).collect();
    Ok(choose_among(parts, &allowed, request))
}

/// The same among some options of each part; parts and request are checked.
pub(super) fn choose_among(
    parts: &[Part],
    allowed: &[Vec<usize>],
    request: &ChoiceRequest,
) -> Option<Choice> {
    let choose = |allowed: &[Vec<usize>]| choose_by_bytes_and_time(parts, allowed, request);
    memory::within(parts, allowed, request.budget.memory_bytes, &choose)
}

/// The same, however much memory that takes.
fn choose_by_bytes_and_time(
    parts: &[Part],
    allowed: &[Vec<usize>],
    request: &ChoiceRequest,
) -> Option<Choice> {
    let budget = [request.budget.bytes, request.budget.frame_ns];
    let items = items(parts, allowed, request);
    let least_error = || {
        let items = items
            .iter()
            .map(|part| part.iter().map(Costed::by_error).collect());
        solve(&Problem::new(items, budget)?, request.effort)
    };
    let found = least_error()?;
    let choice = |found: &Solution, bound_px: f64, is_enough: bool| {
        let options: Vec<usize> = found.options.iter().map(|o| usize::from(*o)).collect();
        summed(parts, &options, request, bound_px, is_enough)
    };
    let best = choice(&found, found.bound, false);
    if best.error_px > request.enough_px {
        return Some(best);
    }
    // The same problem with bytes and error exchanged: the fewest bytes within the error.
    let fewest_bytes = || {
        let items = items
            .iter()
            .map(|part| part.iter().map(Costed::by_bytes).collect());
        let budget = [(request.enough_px / PARTS_PX) as u64, budget[1]];
        solve(&Problem::new(items, budget)?, request.effort)
    };
    let cheaper = fewest_bytes().map(|found| choice(&found, best.bound_px, true));
    let saves = |c: &Choice| c.bytes <= best.bytes && c.error_px <= request.enough_px;
    Some(cheaper.filter(saves).unwrap_or(best))
}

pub(super) fn check(parts: &[Part], request: &ChoiceRequest) -> Result<(), Mismatch> {
    if parts.len() > MAX_PARTS {
        let what = format!("{}, expected at most {MAX_PARTS}", parts.len());
        return Err(Mismatch::new("parts", what));
    }
    request.check()?;
    parts.iter().try_for_each(Part::check)
}

/// Steps in which errors are counted where they are a budget, pixels.
const PARTS_PX: f64 = 1e-6;

/// An option with its costs and its error.
#[derive(Debug, Clone, Copy)]
struct Costed {
    option: u16,
    bytes: u64,
    frame_ns: u64,
    error: f64,
}

impl Costed {
    fn by_error(&self) -> (u16, [u64; 2], f64) {
        (self.option, [self.bytes, self.frame_ns], self.error)
    }

    fn by_bytes(&self) -> (u16, [u64; 2], f64) {
        let error = (self.error / PARTS_PX).ceil() as u64;
        (
            self.option,
            [error.min(MOST), self.frame_ns],
            self.bytes as f64,
        )
    }
}

fn items(parts: &[Part], allowed: &[Vec<usize>], request: &ChoiceRequest) -> Vec<Vec<Costed>> {
    let of_part = |(part, allowed): (&Part, &Vec<usize>)| -> Vec<Costed> {
        let item = |option: &usize| {
            let of = &part.options[*option];
            Costed {
                option: *option as u16,
                bytes: of.bytes(request.window_secs, part.held_bytes),
                frame_ns: of.frame_ns,
                error: part.weight * of.pixels(request.pixels_per_metre),
            }
        };
        allowed.iter().map(item).collect()
    };
    parts.iter().zip(allowed).map(of_part).collect()
}

/// The choice of some options, with its sums.
pub(super) fn summed(
    parts: &[Part],
    options: &[usize],
    request: &ChoiceRequest,
    bound_px: f64,
    is_enough: bool,
) -> Choice {
    let mut choice = Choice {
        options: options.to_vec(),
        bytes: 0,
        frame_ns: 0,
        memory_bytes: 0,
        error_px: 0.0,
        bound_px,
        is_enough,
    };
    for (part, option) in parts.iter().zip(options) {
        let option = &part.options[*option];
        choice.bytes += option.bytes(request.window_secs, part.held_bytes);
        choice.frame_ns += option.frame_ns;
        choice.memory_bytes += option.memory_bytes;
        choice.error_px += part.weight * option.pixels(request.pixels_per_metre);
    }
    choice.bound_px = bound_px.min(choice.error_px);
    choice
}

struct Solution {
    options: Vec<u16>,
    bound: f64,
}

fn solve(problem: &Problem, effort: u32) -> Option<Solution> {
    let dual = dual::dual(problem);
    let (best, is_best) = search::search(problem, &dual, start(problem, &dual), effort);
    let (picks, sums) = best?;
    let option = |(part, pick): (&Vec<problem::Item>, &usize)| part[*pick].option;
    let bound = if is_best { sums.error } else { dual.bound };
    Some(Solution {
        options: problem.parts.iter().zip(&picks).map(option).collect(),
        bound: bound.clamp(0.0, sums.error),
    })
}

/// Number of mixtures of the two budgets by which a first choice is sought.
const MIXTURES: usize = 9;

/// The polished greedy choice, or where that does not fit, the cheapest by some mixture of both
/// budgets; polished.
fn start(problem: &Problem, dual: &dual::Dual) -> Option<(Picks, Sums)> {
    let mut best = None;
    let (picks, _) = greedy::greedy(problem, dual.price);
    keep_better(problem, &mut best, &picks);
    for i in 0..MIXTURES {
        if best.is_some() {
            break;
        }
        let mix = i as f64 / (MIXTURES - 1) as f64;
        let cost = |item: &problem::Item| (1.0 - mix) * item.share[0] + mix * item.share[1];
        let cheapest = |part: &Vec<problem::Item>| {
            let all = 0..part.len();
            let cheapest = all.min_by(|a, b| cost(&part[*a]).total_cmp(&cost(&part[*b])));
            cheapest.unwrap_or(0)
        };
        let picks: Picks = problem.parts.iter().map(cheapest).collect();
        keep_better(problem, &mut best, &picks);
    }
    let (picks, _) = best.clone()?;
    keep_better(problem, &mut best, &polish::polish(problem, picks));
    best
}
