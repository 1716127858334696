//! Budget of a frame: one tolerance for all crowds and views, such that their measured cost stays
//! within a limit.
//!
//! Source: `docs/methods/runtime.md` 4.4. A tolerance that is the same for all characters makes the
//! greatest visible error as small as the cost allows. Where more has to be given up than the error that
//! should not be exceeded, near characters keep twice that error and the others give the rest. The cost of a
//! tolerance is known from the options of the characters, in nominal nanoseconds; their prices are learned
//! from frame to frame ([`LearnedCost`]). Measured times are arguments, so recorded ones give the same
//! frames.

use super::demand::{Costs, Demand, PricedDemand, Tolerances};
use super::frame::Detail;
use super::learned_cost::{LearnedCost, Times};
use super::model::CrowdModel;
use super::tick::Crowd;
use crate::allowance::Allowance;

/// Error of near characters over the one that should not be exceeded.
const NEAR: f32 = 2.0;
/// Frames that are learned from before the first change.
const FIRST_FRAMES: u32 = 8;
/// To choose all levels again takes time, so a part of the crowd takes a change over in each of so many frames, and
/// another change waits for it; fewer where the time is exceeded by the factor.
const HOLD: u16 = 32;
const URGENT: f64 = 1.15;
const URGENT_HOLD: u16 = 8;
/// A coarser tolerance differs by this factor at least, and a finer one by the last; the second number is the part of
/// the time for evaluation that one is aimed at.
const COARSER: f32 = 1.04;
const USED: f64 = 0.98;
const FINER: f32 = 1.1;
/// Weight of a new frame in the mean of the tolerance at which the table has its work, over its own; whoever has a
/// level keeps it up to a tolerance that is greater by the factor.
const FIT_GAIN: f32 = 0.2;
const KEPT: f32 = 0.8;
/// Time over the limit that few frames exceed.
const ALLOWED: f64 = 1.02;
/// Part of the time for evaluation with which triangles are spared again.
const SPARED: f64 = 0.85;
/// Tolerance with options by the time of the processor alone, over that with those by the whole frame, from
/// which on the former are worth their triangles.
const WORTH_TRIANGLES: f32 = 0.9;
/// Nominal cost over the least one that any tolerance has: what is saved below it is not worth the error.
const WORTH: f64 = 1.01;
/// The same up to which a tolerance at the floor is kept, unless that which would do is finer by the factor.
const FLOOR: f64 = 1.03;
const FINER_AT_FLOOR: f32 = 1.5;

/// Frames in which the costs of all tolerances are found anew, with one list of options after the other, and fewer
/// where they are not known.
const SWEEP: usize = 32;
const URGENT_SWEEP: usize = 8;
/// Part of the limit up to which nothing has to be given up soon, so that no costs of tolerances are found.
const REST: f64 = 0.9;
/// Frames at rest after which the costs of tolerances are not known any more.
const REMEMBERED: f32 = 64.0;

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
    crowds: Vec<OfCrowd>,
    learned: LearnedCost,
    /// Tolerance at which the tables have the work of frames, over that of the frames: whoever has a level keeps it
    /// for a while.
    fit: f32,
    /// Frames since the allowance changed.
    held: u32,
    /// Whether the expected time is so far below the limit that costs of other tolerances are not needed, and how
    /// much of the lists of options has to be summed up for them to be known.
    rests: bool,
    unknown_lists: f32,
}

/// What is known of a crowd of this frame.
#[derive(Debug, Clone, PartialEq)]
struct OfCrowd {
    /// Nominal work of the frame.
    work_ns: Costs,
    /// That by tolerance, with the options by the cost of the frame and by that of the processor.
    demands: [Demand; 2],
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
    /// Whether the expected time is so far below the limit that the frame costs as much as without a budget.
    pub rests: bool,
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
                frames: HOLD,
            },
            crowds: Vec::new(),
            learned: LearnedCost::new(),
            fit: 1.0,
            held: 0,
            rests: false,
            unknown_lists: 0.0,
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
    /// which [`observe`](Self::observe) ends. The cost of its characters by tolerance is found anew for a part of it,
    /// O(characters / 32), unless the limit is far from being reached. Does not allocate but in the first frame of a
    /// crowd.
    pub fn add(&mut self, crowd: &mut Crowd, model: &CrowdModel) {
        // Whoever has a level keeps it at a tighter tolerance, and near ones become coarser up to theirs.
        let [least_px, most_px] = [self.cap_px, self.allowance.near_px].map(|px| KEPT * px);
        let tolerances = Tolerances::new(least_px, most_px);
        let frames = self.sweep_frames();
        self.crowds.push(OfCrowd {
            work_ns: crowd.work_ns(model),
            demands: crowd.demand(model, tolerances, frames).clone(),
        });
    }

    /// Frames in which the costs of tolerances are found anew; 0 for none.
    fn sweep_frames(&self) -> usize {
        match self.unknown_lists > 0.0 {
            _ if self.rests => 0,
            true => URGENT_SWEEP,
            false => SWEEP,
        }
    }

    /// Ends the frame with the nanoseconds that the ticks and the evaluation of all crowds took,
    /// summed over threads, and sets what the next one is allowed. Times that are not positive and
    /// finite change nothing.
    pub fn observe(&mut self, tick_ns: f64, evaluate_ns: f64) -> BudgetReport {
        let crowds = std::mem::take(&mut self.crowds);
        let list = usize::from(self.allowance.by_processor);
        let work = crowds.iter().map(|c| c.work_ns);
        let expected_ns = self.learned.tick_ns(list) + self.learned.evaluate_ns(work.clone());
        let is_time = |ns: f64| ns > 0.0 && ns.is_finite();
        let has_work = work.clone().flatten().sum::<f64>() > 0.0;
        let is_known = is_time(tick_ns) && is_time(evaluate_ns) && has_work;
        if is_known {
            let times = Times {
                tick_ns,
                evaluate_ns,
                list,
            };
            self.learned.learn(times, work.clone());
            self.held = self.held.saturating_add(1);
            self.rest(self.learned.evaluate_ns(work));
        }
        let report = match self.rests {
            true => self.rested(&crowds, expected_ns),
            false => self.looked_ahead(&crowds, expected_ns, is_known),
        };
        // The space is used again.
        self.crowds = crowds;
        self.crowds.clear();
        report
    }

    /// Finds out whether costs of other tolerances are needed, by the expected time of evaluation.
    fn rest(&mut self, evaluate_ns: f64) {
        let swept = match self.sweep_frames() {
            0 => -1.0 / REMEMBERED,
            frames => 1.0 / frames as f32,
        };
        self.unknown_lists = (self.unknown_lists - swept).clamp(0.0, 2.0);
        let now = self.allowance;
        let has_settled = self.held >= u32::from(now.frames) && !now.by_processor;
        let expected_ns = self.learned.tick_ns(0) + evaluate_ns;
        self.rests = has_settled && now.px == self.cap_px && expected_ns <= REST * self.all_ns();
    }

    /// Time of a frame that is aimed at.
    fn all_ns(&self) -> f64 {
        ALLOWED * self.limit_ns / self.learned.margin()
    }

    /// The report of a frame at rest: the next one is as this.
    fn rested(&self, crowds: &[OfCrowd], expected_ns: f64) -> BudgetReport {
        let work = crowds.iter().map(|c| c.work_ns);
        let next_ns = self.learned.tick_ns(0) + self.learned.evaluate_ns(work);
        let least = crowds.iter().map(|c| c.demands[1].least_ns());
        let least_ns = self.learned.tick_ns(1) + self.learned.evaluate_ns(least);
        BudgetReport {
            limit_ns: self.limit_ns,
            expected_ns,
            expected_next_ns: next_ns,
            // The costs may be old, but this one is possible.
            floor_ns: least_ns.min(next_ns),
            shown: self.allowance,
            next: self.allowance,
            cap_px: self.cap_px,
            rests: true,
        }
    }

    /// Sets what the next frame is allowed by the costs of tolerances, and reports it.
    fn looked_ahead(
        &mut self,
        crowds: &[OfCrowd],
        expected_ns: f64,
        is_known: bool,
    ) -> BudgetReport {
        let shown = self.allowance;
        let tables = self.tables(crowds);
        if is_known {
            let work = crowds.iter().map(|c| c.work_ns);
            let found_ns = self.learned.evaluate_ns(work);
            self.learn_fit(&tables[usize::from(shown.by_processor)], found_ns);
            let next = self.chosen(&tables);
            if next != shown {
                self.held = 0;
            }
            self.allowance = next;
        }
        let next = usize::from(self.allowance.by_processor);
        let next_ns = tables[next].cost_ns(self.fit * self.allowance.px);
        BudgetReport {
            limit_ns: self.limit_ns,
            expected_ns,
            expected_next_ns: self.learned.tick_ns(next) + next_ns,
            floor_ns: self.learned.tick_ns(1) + tables[1].least_ns(),
            shown,
            next: self.allowance,
            cap_px: self.cap_px,
            rests: false,
        }
    }

    /// Expected time of evaluation by tolerance, with both lists of options.
    fn tables(&self, crowds: &[OfCrowd]) -> [PricedDemand; 2] {
        [0, 1].map(|list| {
            let demands = crowds.iter().map(|c| &c.demands[list]);
            self.learned.priced(demands)
        })
    }

    /// Learns at which tolerance the table has the work of a frame, once all have taken that of the frame over.
    fn learn_fit(&mut self, table: &PricedDemand, found_ns: f64) {
        let px = self.allowance.px;
        if self.held >= u32::from(self.allowance.frames) {
            let told_px = table.px_within(found_ns, KEPT * px).min(px);
            self.fit += FIT_GAIN * (told_px / px - self.fit);
        }
    }

    /// What the next frame is allowed, by the expected times with both lists of options.
    fn chosen(&self, tables: &[PricedDemand; 2]) -> Allowance {
        let now = self.allowance;
        let all_ns = self.all_ns();
        let left_ns = [0, 1].map(|list| all_ns - self.learned.tick_ns(list));
        let list = usize::from(now.by_processor);
        let expected_ns = tables[list].cost_ns(self.fit * now.px) + self.learned.tick_ns(list);
        // At the floor there is nothing to hurry for.
        let floor_ns = self.learned.tick_ns(1) + tables[1].least_ns();
        let is_urgent = expected_ns > URGENT * self.limit_ns.max(floor_ns);
        let hold = u32::from(if is_urgent { URGENT_HOLD } else { now.frames });
        let is_first = self.learned.frames() == FIRST_FRAMES;
        let has_to_wait = self.unknown_lists > 0.0 || (self.held < hold && !is_first);
        if self.learned.frames() < FIRST_FRAMES || has_to_wait {
            return now;
        }
        let px = |list: usize, part: f64| {
            let (table, left_ns) = (&tables[list], part * left_ns[list]);
            // What draws less may cost more, so a coarser tolerance may not fit where this one does.
            if table.cost_ns(self.fit * self.cap_px) <= left_ns {
                return self.cap_px;
            }
            let worth_ns = WORTH * table.least_ns();
            // At the floor nobody is to keep a finer level.
            let fit = if left_ns < worth_ns { KEPT } else { self.fit };
            (table.px_within(left_ns.max(worth_ns), 0.0) / fit).max(self.cap_px)
        };
        let by_processor = self.by_processor(&px);
        let list = usize::from(by_processor);
        let (fits, with_rest) = (px(list, 1.0), px(list, USED));
        let is_at_floor = by_processor == now.by_processor
            && left_ns[list] < WORTH * tables[list].least_ns()
            && tables[list].cost_ns(KEPT * now.px) <= FLOOR * tables[list].least_ns();
        let px = if by_processor != now.by_processor {
            with_rest
        } else if is_at_floor {
            // To change takes time and saves none.
            if with_rest * FINER_AT_FLOOR < now.px {
                with_rest
            } else {
                now.px
            }
        } else if fits > now.px {
            with_rest.max(COARSER * now.px)
        } else if with_rest * FINER < now.px || (with_rest == self.cap_px && now.px > self.cap_px) {
            with_rest
        } else {
            now.px
        };
        if (px, by_processor) == (now.px, now.by_processor) {
            return now;
        }
        Allowance {
            px,
            by_processor,
            frames: if is_urgent { URGENT_HOLD } else { HOLD },
            ..now
        }
    }

    /// Whether options are chosen by processor time alone: where those by the whole frame do not fit, and need
    /// a coarser tolerance.
    fn by_processor(&self, px: &impl Fn(usize, f64) -> f32) -> bool {
        let part = match self.allowance.by_processor {
            true => SPARED,
            false => 1.0,
        };
        let by_frame_px = px(0, part);
        by_frame_px > self.cap_px && px(1, 1.0) < WORTH_TRIANGLES * by_frame_px
    }
}
