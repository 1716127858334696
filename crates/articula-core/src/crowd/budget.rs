//! Budget of a frame: one tolerance for all crowds and views, such that their measured cost stays
//! within a limit.
//!
//! Source: `docs/methods/runtime.md` 4.4. A tolerance that is the same for all characters makes the
//! greatest visible error as small as the cost allows, so nobody near is sacrificed for many who are
//! far. The cost of a tolerance is known from the options of the characters, in nominal nanoseconds;
//! the ratio of measured to nominal cost is learned from frame to frame. Measured times are
//! arguments, so recorded ones give the same frames.

use super::demand::Demand;
use super::frame::Detail;
use super::model::CrowdModel;
use super::tick::Crowd;

/// Least tolerance in pixels that a budget buys: no display shows less.
const FINEST_PX: f32 = 1.0 / 16.0;
/// Weight of a new frame in the means.
const GAIN: f64 = 0.1;
/// Greatest factor of a new time against the mean; an interrupted frame counts as this.
const OUTLIER: f64 = 1.5;
/// Frames whose times are remembered for the margin, a second of display, and how many of them may
/// exceed it: less than 5 %.
const REMEMBERED: usize = 64;
const MAY_EXCEED: usize = 2;
/// Margin that is kept before the first frames have shown how much their times vary.
const FIRST_MARGIN: f32 = 1.03;
/// A change of the tolerance has all levels chosen again, which takes time. So a finer or a coarser one
/// differs by these factors at least, and a coarser one leaves a part of the time for evaluation unused.
const FINER: f32 = 1.25;
const COARSER: f32 = 1.1;
const USED: f64 = 0.96;
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
///     println!("{} px would fit", report.next_px);
/// }
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    limit_ns: f64,
    cap_px: f32,
    px: f32,
    demand: Demand,
    /// Measured over nominal cost; `None` before the first frame.
    ratio: Option<f64>,
    /// Mean time of a frame outside of evaluation, of those with the tolerance of the frame before.
    tick_ns: f64,
    /// Whether the tolerance of this frame is that of the frame before.
    is_kept: bool,
    /// Ratio of measured to expected time of the last frames, and which of them is the oldest.
    ratios: [f32; REMEMBERED],
    oldest: usize,
}

/// What a budget did in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetReport {
    /// Limit of the whole frame, nanoseconds.
    pub limit_ns: f64,
    /// Time that was expected for the whole frame, nanoseconds.
    pub expected_ns: f64,
    /// Tolerance of the frame, pixels.
    pub px: f32,
    /// Tolerance of the next frame: the least whose expected time fits.
    pub next_px: f32,
    /// Error that should not be exceeded, pixels.
    pub cap_px: f32,
}

impl BudgetReport {
    /// Whether the limit does not suffice for the error that should not be exceeded;
    /// [`next_px`](Self::next_px) would fit.
    pub fn is_overloaded(&self) -> bool {
        self.next_px > self.cap_px
    }
}

impl Budget {
    /// A budget of `limit_ns` nanoseconds of processor time for each frame, tick and evaluation
    /// together. Errors above `cap_px` pixels count as overload; it is also the tolerance of the
    /// first frame. A limit that is negative or NaN counts as 0, a cap that is not positive as one
    /// pixel.
    pub fn new(limit_ns: f64, cap_px: f32) -> Self {
        let cap_px = if cap_px > 0.0 { cap_px } else { 1.0 };
        Self {
            limit_ns: limit_ns.max(0.0),
            cap_px,
            px: cap_px,
            demand: Demand::NONE,
            ratio: None,
            tick_ns: 0.0,
            is_kept: true,
            ratios: [FIRST_MARGIN; REMEMBERED],
            oldest: 0,
        }
    }

    /// Tolerance of this frame in pixels.
    pub fn px(&self) -> f32 {
        self.px
    }

    /// Choice of detail of this frame, the same for all crowds.
    pub fn detail(&self) -> Detail {
        Detail::Tolerance { px: self.px }
    }

    /// Adds a crowd that was ticked with this detail. The cost of its characters by tolerance is
    /// found anew for a sixteenth of it; O(characters / 16), does not allocate.
    pub fn add(&mut self, crowd: &mut Crowd, model: &CrowdModel) {
        self.demand.add(crowd.demand(model));
    }

    /// Ends the frame with the nanoseconds that the ticks and the evaluation of all crowds took,
    /// summed over threads, and sets the tolerance of the next one. Times that are not positive and
    /// finite change nothing.
    pub fn observe(&mut self, tick_ns: f64, evaluate_ns: f64) -> BudgetReport {
        let demand = std::mem::replace(&mut self.demand, Demand::NONE);
        let nominal_ns = demand.cost_ns(self.px);
        let expected_ns = self.tick_ns + self.ratio.unwrap_or(1.0) * nominal_ns;
        let px = self.px;
        let is_time = |ns: f64| ns > 0.0 && ns.is_finite();
        if is_time(tick_ns) && is_time(evaluate_ns) && nominal_ns > 0.0 {
            self.learn(tick_ns, evaluate_ns, nominal_ns, expected_ns);
            self.px = self.chosen(&demand);
            self.is_kept = self.px == px;
        }
        BudgetReport {
            limit_ns: self.limit_ns,
            expected_ns,
            px,
            next_px: self.px,
            cap_px: self.cap_px,
        }
    }

    fn learn(&mut self, tick_ns: f64, evaluate_ns: f64, nominal_ns: f64, expected_ns: f64) {
        let measured = evaluate_ns / nominal_ns;
        let Some(ratio) = self.ratio else {
            self.ratio = Some(measured);
            self.tick_ns = tick_ns;
            return;
        };
        self.ratios[self.oldest] = ((tick_ns + evaluate_ns) / expected_ns) as f32;
        self.oldest = (self.oldest + 1) % REMEMBERED;
        self.ratio = Some(ratio + GAIN * (measured.min(OUTLIER * ratio) - ratio));
        if self.is_kept {
            self.tick_ns += GAIN * (tick_ns.min(OUTLIER * self.tick_ns) - self.tick_ns);
        }
    }

    /// Ratio of measured to expected time that few of the last frames exceed.
    fn margin(&self) -> f64 {
        let mut ratios = self.ratios;
        let (_, margin, _) = ratios.select_nth_unstable_by(MAY_EXCEED, |a, b| b.total_cmp(a));
        f64::from(*margin).clamp(1.0, OUTLIER)
    }

    fn chosen(&self, demand: &Demand) -> f32 {
        let left_ns = self.limit_ns / self.margin() - self.tick_ns;
        let nominal_ns = left_ns / self.ratio.unwrap_or(1.0);
        let least_ns = WORTH * demand.least_ns();
        let px = demand.px_within(nominal_ns.max(least_ns), FINEST_PX);
        if px > self.px {
            let px = demand.px_within((USED * nominal_ns).max(least_ns), FINEST_PX);
            px.max(COARSER * self.px)
        } else if px * FINER < self.px {
            px
        } else {
            self.px
        }
    }
}
