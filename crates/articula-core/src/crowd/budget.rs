//! Budget of a frame: one tolerance for all crowds and views, such that their measured cost stays
//! within a limit.
//!
//! Source: `docs/methods/runtime.md` 4.4. A tolerance that is the same for all characters makes the
//! greatest visible error as small as the cost allows. Where more has to be given up than the error that
//! should not be exceeded, near characters keep twice that error and the others give the rest. The cost of a
//! tolerance is known from the options of the characters, in nominal nanoseconds; their prices are learned
//! from frame to frame ([`LearnedCost`]). Measured times are arguments, so recorded ones give the same
//! frames.

use super::demand::{Demand, PricedDemand};
use super::frame::Detail;
use super::learned_cost::{LearnedCost, Times};
use super::model::CrowdModel;
use super::tick::Crowd;
use crate::allowance::Allowance;

/// Error of near characters over the one that should not be exceeded.
const NEAR: f32 = 2.0;
/// Frames that are learned from before the first change.
const FIRST_FRAMES: u32 = 8;
/// A change has all levels chosen again, which takes time, so fewer than 5 % of the frames may: after one come
/// so many frames without, or, where the time is exceeded by this factor, at least the second number.
const HOLD: u32 = 32;
const URGENT: f64 = 1.15;
const URGENT_HOLD: u32 = 6;
/// A coarser tolerance differs by this factor at least; any but the one that is aimed at leaves a part of the
/// time for evaluation unused, and a finer one is taken where it is finer by the last factor.
const COARSER: f32 = 1.1;
const USED: f64 = 0.96;
const FINER: f32 = 1.25;
/// Part of the time for evaluation with which triangles are spared again.
const SPARED: f64 = 0.85;
/// Tolerance with options by the time of the processor alone, over that with those by the whole frame, from
/// which on the former are worth their triangles.
const WORTH_TRIANGLES: f32 = 0.9;
/// Nominal cost over the least one that any tolerance has: what is saved below it is not worth the error.
const WORTH: f64 = 1.02;

/// A limit to the processor time of all crowds of a frame together.
///
/// ```
/// use articula_core::crowd::Budget;
/// # use articula_core::crowd::{Crowd, CrowdModel, Frame};
/// # fn frame(crowds: &mut [(Crowd, CrowdModel)], frame: Frame<'_>, budget: &mut Budget) {
/// for (crowd, model) in crowds.iter_mut() {
///     let frame = Frame { detail: budget.detail(), ..frame };
///     crowd.tick(model, &frame, &mut |_| {});
///     budget.add(crowd, model);
/// }
/// // Evaluate, and measure what all of this took.
/// let (tick_ns, evaluate_ns) = (80_000.0, 700_000.0);
/// let report = budget.observe(tick_ns, evaluate_ns);
/// if report.is_overloaded() {
///     println!("{} px would fit", report.next.px);
/// }
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    limit_ns: f64,
    cap_px: f32,
    /// What this frame is allowed.
    allowance: Allowance,
    /// Of each crowd of this frame, with the options by the cost of the frame and by that of the processor.
    demands: Vec<[Demand; 2]>,
    learned: LearnedCost,
    /// Frames since the allowance changed.
    held: u32,
}

/// What a budget did in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetReport {
    /// Limit of the whole frame, nanoseconds.
    pub limit_ns: f64,
    /// Time that was expected for the whole frame, nanoseconds.
    pub expected_ns: f64,
    /// Time that is expected for the next frame, nanoseconds.
    pub expected_next_ns: f64,
    /// The least time of a frame of these characters, with everyone at the cheapest that is allowed at any
    /// tolerance, nanoseconds. Less than this is not kept; a limit below it gets this.
    pub floor_ns: f64,
    /// What the frame was allowed.
    pub shown: Allowance,
    /// What the next frame is allowed.
    pub next: Allowance,
    /// Error that should not be exceeded, pixels.
    pub cap_px: f32,
}

/// What a frame gave up for its budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sacrifice {
    /// Options were chosen by processor time alone: more triangles may be drawn than without a budget.
    pub triangles: bool,
    /// The error exceeds the one that should not be exceeded; of near characters by a factor of 2 at most.
    pub pixels: bool,
    /// The limit itself: it is below the least time of a frame.
    pub time: bool,
}

impl BudgetReport {
    /// Whether the limit does not suffice for the error that should not be exceeded; the tolerance of
    /// [`next`](Self::next) would fit.
    pub fn is_overloaded(&self) -> bool {
        self.next.px > self.cap_px
    }

    /// Whether both the limit and the error that should not be exceeded are kept from the next frame on, as far
    /// as expected.
    pub fn is_satisfied(&self) -> bool {
        !self.is_overloaded() && self.expected_next_ns <= self.limit_ns
    }

    /// What the next frame gives up.
    pub fn sacrifice(&self) -> Sacrifice {
        Sacrifice {
            triangles: self.next.by_processor,
            pixels: self.is_overloaded(),
            time: self.floor_ns > self.limit_ns,
        }
    }
}

impl Budget {
    /// A budget of `limit_ns` nanoseconds of processor time for each frame, tick and evaluation
    /// together. The tolerance is `cap_px` pixels where that fits, and no finer. What is given up where it does
    /// not, in this order: triangles, the error of all up to twice the cap, that of those who are not
    /// [near](Allowance::NEAR_PX_PER_METRE), and the limit. A limit that is negative or NaN counts as 0, a cap
    /// that is not positive as one pixel.
    pub fn new(limit_ns: f64, cap_px: f32) -> Self {
        let cap_px = if cap_px > 0.0 { cap_px } else { 1.0 };
        Self {
            limit_ns: limit_ns.max(0.0),
            cap_px,
            allowance: Allowance {
                px: cap_px,
                near_px: NEAR * cap_px,
                by_processor: false,
            },
            demands: Vec::new(),
            learned: LearnedCost::new(),
            held: 0,
        }
    }

    /// Tolerance of this frame in pixels.
    pub fn px(&self) -> f32 {
        self.allowance.px
    }

    /// What this frame is allowed.
    pub fn allowance(&self) -> Allowance {
        self.allowance
    }

    /// Choice of detail of this frame, the same for all crowds.
    pub fn detail(&self) -> Detail {
        Detail::Within(self.allowance)
    }

    /// Adds a crowd that was ticked with this detail; crowds are added in the same order in each frame,
    /// which [`observe`](Self::observe) ends. The cost of its characters by tolerance is found anew for a part of it;
    /// O(characters / 32). Does not allocate but in the first frame of a crowd.
    pub fn add(&mut self, crowd: &mut Crowd, model: &CrowdModel) {
        let demand = crowd.demand(model, self.allowance.near_px);
        self.demands.push(demand.clone());
    }

    /// Ends the frame with the nanoseconds that the ticks and the evaluation of all crowds took,
    /// summed over threads, and sets what the next one is allowed. Times that are not positive and
    /// finite change nothing.
    pub fn observe(&mut self, tick_ns: f64, evaluate_ns: f64) -> BudgetReport {
        let shown = self.allowance;
        let demands = std::mem::take(&mut self.demands);
        let list = usize::from(shown.by_processor);
        let work = demands.iter().map(|d| d[list].cost_ns(shown.px));
        let expected_ns = self.learned.tick_ns() + self.learned.evaluate_ns(work.clone());
        let is_time = |ns: f64| ns > 0.0 && ns.is_finite();
        let has_work = work.clone().flatten().sum::<f64>() > 0.0;
        if is_time(tick_ns) && is_time(evaluate_ns) && has_work {
            let times = Times {
                tick_ns,
                evaluate_ns,
                is_kept: self.held > 0,
            };
            self.learned.learn(times, work);
            self.held = self.held.saturating_add(1);
            let tables = [0, 1].map(|list| self.learned.priced(&demands, list));
            let next = self.chosen(&tables);
            if next != shown {
                self.held = 0;
            }
            self.allowance = next;
        }
        let next = usize::from(self.allowance.by_processor);
        let least = demands.iter().map(|d| d[1].least_ns());
        let work = demands.iter().map(|d| d[next].cost_ns(self.allowance.px));
        let report = BudgetReport {
            limit_ns: self.limit_ns,
            expected_ns,
            expected_next_ns: self.learned.tick_ns() + self.learned.evaluate_ns(work),
            floor_ns: self.learned.tick_ns() + self.learned.evaluate_ns(least),
            shown,
            next: self.allowance,
            cap_px: self.cap_px,
        };
        // The space is used again.
        self.demands = demands;
        self.demands.clear();
        report
    }

    /// What the next frame is allowed, by the expected times with both lists of options.
    fn chosen(&self, tables: &[PricedDemand; 2]) -> Allowance {
        let now = self.allowance;
        let left_ns = self.limit_ns / self.learned.margin() - self.learned.tick_ns();
        let expected_ns = tables[usize::from(now.by_processor)].cost_ns(now.px);
        let is_urgent = expected_ns + self.learned.tick_ns() > URGENT * self.limit_ns;
        let hold = if is_urgent { URGENT_HOLD } else { HOLD };
        let is_first = self.learned.frames() == FIRST_FRAMES;
        if self.learned.frames() < FIRST_FRAMES || (self.held < hold && !is_first) {
            return now;
        }
        let px = |table: &PricedDemand, left_ns: f64| match table.cost_ns(self.cap_px) <= left_ns {
            // What draws less may cost more, so a coarser tolerance may not fit where this one does.
            true => self.cap_px,
            false => table.px_within(left_ns.max(WORTH * table.least_ns()), self.cap_px),
        };
        let by_processor = self.by_processor(tables, left_ns, &px);
        let table = &tables[usize::from(by_processor)];
        let (fits, with_rest) = (px(table, left_ns), px(table, USED * left_ns));
        let px = if by_processor != now.by_processor {
            with_rest
        } else if fits > now.px {
            with_rest.max(COARSER * now.px)
        } else if with_rest * FINER < now.px || (with_rest == self.cap_px && now.px > self.cap_px) {
            with_rest
        } else {
            now.px
        };
        Allowance {
            px,
            by_processor,
            ..now
        }
    }

    /// Whether options are chosen by processor time alone: where those by the whole frame do not fit, and need
    /// a coarser tolerance.
    fn by_processor(
        &self,
        [by_frame, by_processor]: &[PricedDemand; 2],
        left_ns: f64,
        px: &impl Fn(&PricedDemand, f64) -> f32,
    ) -> bool {
        let part = match self.allowance.by_processor {
            true => SPARED,
            false => 1.0,
        };
        let by_frame_px = px(by_frame, part * left_ns);
        by_frame_px > self.cap_px && px(by_processor, left_ns) < WORTH_TRIANGLES * by_frame_px
    }
}
