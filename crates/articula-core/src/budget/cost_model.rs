//! Cost of evaluation on this machine, learned from times that the caller measured.
//!
//! Source: `docs/methods/motion-lod.md` part 7: running means of the nanoseconds per sampled joint,
//! per joint of forward kinematics and per matrix. A caller mostly knows the time of a whole frame,
//! so the means are those of least squares with forgetting (Ljung, *System Identification*, 1999,
//! 11.2): the costs that explain recent frames best. What these frames leave undetermined, such as
//! the division between kinds of work that always occur together, keeps its initial proportion.

use std::ops::{Add, AddAssign};

/// Amount of each kind of evaluation work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Workload {
    /// Number of characters evaluated.
    pub characters: u64,
    /// Number of joints whose channels were sampled.
    pub sampled_joints: u64,
    /// Number of joints whose model transforms were computed.
    pub fk_joints: u64,
    /// Number of matrices written.
    pub matrices: u64,
}

impl Workload {
    fn parts(&self) -> [f64; 4] {
        [
            self.characters as f64,
            self.sampled_joints as f64,
            self.fk_joints as f64,
            self.matrices as f64,
        ]
    }
}

impl Add for Workload {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            characters: self.characters + other.characters,
            sampled_joints: self.sampled_joints + other.sampled_joints,
            fk_joints: self.fk_joints + other.fk_joints,
            matrices: self.matrices + other.matrices,
        }
    }
}

impl AddAssign for Workload {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Nanoseconds per unit of each kind of work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UnitCosts {
    /// Per character.
    pub character_ns: f64,
    /// Per sampled joint.
    pub sampled_joint_ns: f64,
    /// Per joint of forward kinematics.
    pub fk_joint_ns: f64,
    /// Per matrix.
    pub matrix_ns: f64,
}

impl Default for UnitCosts {
    /// The sums are those of the batched floor of `docs/methods/runtime.md` part 1 (8 joints 22 ns,
    /// 67 joints 179 ns); the division of a joint's 2.7 ns is a guess, which observations correct.
    fn default() -> Self {
        Self {
            character_ns: 0.7,
            sampled_joint_ns: 1.3,
            fk_joint_ns: 0.9,
            matrix_ns: 0.5,
        }
    }
}

/// Factor of the weight of earlier observations at each new one: about fifty count.
const KEPT: f64 = 0.98;
/// Weight of the initial costs relative to one observation: it decides only what the observations
/// leave undetermined.
const FIRST_WEIGHT: f64 = 1e-6;
/// Weight of a new observation in the mean spread.
const GAIN: f64 = 0.05;
/// Fraction of observations that stay within the planned time, and the step by which it is learned.
const LATE_SHARE: f64 = 0.95;
const LATE_STEP: f64 = 0.01;
/// Maximum of `late`: however unsteady times are, half of the budget is planned.
const MAX_LATE: f64 = 2.0;
/// Spread assumed before the first observation.
const FIRST_SPREAD: f64 = 1.0;
/// An observation is an outlier if it is off by more than this number of mean deviations and by
/// more than `MIN_DEVIATION`.
const DEVIATIONS: f64 = 4.0;
const MIN_DEVIATION: f64 = 0.5;
/// Number of consecutive outliers after which the machine is taken to have changed.
const PERSISTENT: u32 = 8;

/// Cost of evaluation as running means of unit costs. A model that observes nothing has fixed
/// costs.
///
/// ```
/// use articula_core::budget::{CostModel, Workload};
///
/// // The work of one character at some level, and of a frame with a thousand of them.
/// let one = Workload { characters: 1, sampled_joints: 24, fk_joints: 24, matrices: 24 };
/// let all = (0..1000).fold(Workload::default(), |sum, _| sum + one);
/// let mut model = CostModel::default();
/// for _ in 0..50 {
///     model.observe(&all, 80_000.0);
/// }
/// assert!((model.cost_ns(&one) - 80.0).abs() < 0.1);
/// // From time to time: budget.reprice(|option_set, option| model.cost_ns(&work[option]) as f32).
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CostModel {
    costs: [f64; 4],
    /// Initial costs; the fields below are relative to them, so that they have equal weight.
    first: [f64; 4],
    /// Sums over the observations, normal equations of least squares.
    squares: [[f64; 4]; 4],
    sums: [f64; 4],
    observed: u32,
    out_of_line: u32,
    /// Mean deviation of the observations, as a factor less one.
    spread: f64,
    /// Ratio of measured to expected time that one observation in twenty exceeds.
    late: f64,
}

impl CostModel {
    /// A model with initial costs. A negative cost counts as 0; a cost of 0 stays 0.
    pub(crate) fn measured(first: UnitCosts) -> Self {
        let first = [
            first.character_ns,
            first.sampled_joint_ns,
            first.fk_joint_ns,
            first.matrix_ns,
        ];
        let first = first.map(|c| c.max(0.0));
        Self {
            costs: first,
            first,
            squares: [[0.0; 4]; 4],
            sums: [0.0; 4],
            observed: 0,
            out_of_line: 0,
            spread: FIRST_SPREAD,
            late: 1.0,
        }
    }

    /// Expected time of some work in nanoseconds.
    pub fn cost_ns(&self, work: &Workload) -> f64 {
        dot(&self.costs, &work.parts())
    }

    #[cfg(test)]
    fn unit_costs(&self) -> UnitCosts {
        let [character_ns, sampled_joint_ns, fk_joint_ns, matrix_ns] = self.costs;
        UnitCosts {
            character_ns,
            sampled_joint_ns,
            fk_joint_ns,
            matrix_ns,
        }
    }

    /// Expected time in nanoseconds that may be planned so that only one frame in twenty takes
    /// longer than `budget_ns`, since measured times vary around the expected ones.
    pub fn spendable_ns(&self, budget_ns: f64) -> f64 {
        budget_ns / self.late.max(1.0)
    }

    /// Learns from some work and its time in nanoseconds by the caller's clock. An outlier, such as
    /// the time of an interrupted frame, is ignored unless eight follow each other. Returns whether
    /// the time was used.
    pub fn observe(&mut self, work: &Workload, measured_ns: f64) -> bool {
        let expected = self.cost_ns(work);
        let sound = measured_ns > 0.0 && measured_ns.is_finite() && expected > 0.0;
        if !sound {
            return false;
        }
        // A step up for each late observation and a nineteenth of it down for each of the rest
        // tracks the 95th percentile (Robbins and Monro, 1951). One interrupted frame is one step,
        // however long.
        let is_late = measured_ns > expected * self.late;
        self.late += LATE_STEP
            * if is_late {
                LATE_SHARE
            } else {
                LATE_SHARE - 1.0
            };
        self.late = self.late.clamp(1.0, MAX_LATE);
        // The same for twice as long and for half as long.
        let off = (measured_ns / expected).max(expected / measured_ns) - 1.0;
        if off > (DEVIATIONS * self.spread).max(MIN_DEVIATION) {
            self.out_of_line += 1;
            if self.out_of_line < PERSISTENT {
                return false;
            }
            // Restart from here, with all costs slower or faster by the same factor.
            self.first = self.costs.map(|c| c * measured_ns / expected);
            (self.squares, self.sums) = ([[0.0; 4]; 4], [0.0; 4]);
            (self.observed, self.spread) = (0, FIRST_SPREAD);
        }
        self.out_of_line = 0;
        self.observed = self.observed.saturating_add(1);
        let gain = GAIN.max(1.0 / f64::from(self.observed));
        self.spread += gain * (off - self.spread);
        self.learn(&work.parts(), expected, measured_ns);
        true
    }

    /// Adds one equation: the parts of the time at initial costs, each times its factor, sum to the
    /// measured time. Divided by the expected time, so that large and small frames count equally.
    fn learn(&mut self, parts: &[f64; 4], expected: f64, measured: f64) {
        let shares: [f64; 4] = std::array::from_fn(|i| self.first[i] * parts[i] / expected);
        for i in 0..4 {
            self.sums[i] = KEPT * self.sums[i] + shares[i] * measured / expected;
            for j in 0..4 {
                self.squares[i][j] = KEPT * self.squares[i][j] + shares[i] * shares[j];
            }
        }
        let factors = least_squares(&self.squares, &self.sums);
        self.costs = std::array::from_fn(|i| self.first[i] * factors[i]);
    }
}

/// Non-negative factors of the least-squares solution; near 1 where the equations leave them
/// undetermined.
fn least_squares(squares: &[[f64; 4]; 4], sums: &[f64; 4]) -> [f64; 4] {
    let mut free = [true; 4];
    loop {
        let factors = solve(squares, sums, free);
        let negative = |i: &usize| factors[*i] < 0.0;
        if !(0..4).any(|i| negative(&i)) {
            return factors;
        }
        // A negative factor is set to 0, and the others are solved without it.
        (0..4).filter(negative).for_each(|i| free[i] = false);
    }
}

/// Gaussian elimination; the matrix is symmetric and positive definite, so no pivot is needed.
fn solve(squares: &[[f64; 4]; 4], sums: &[f64; 4], free: [bool; 4]) -> [f64; 4] {
    let (mut a, mut b) = (*squares, *sums);
    for i in 0..4 {
        a[i][i] += FIRST_WEIGHT;
        b[i] += FIRST_WEIGHT;
        if !free[i] {
            a.iter_mut().for_each(|row| row[i] = 0.0);
            a[i] = std::array::from_fn(|j| f64::from(u8::from(i == j)));
            b[i] = 0.0;
        }
    }
    for i in 0..4 {
        for k in i + 1..4 {
            let factor = a[k][i] / a[i][i];
            a[k] = std::array::from_fn(|j| a[k][j] - factor * a[i][j]);
            b[k] -= factor * b[i];
        }
    }
    for i in (0..4).rev() {
        let known: f64 = (i + 1..4).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}

impl Default for CostModel {
    fn default() -> Self {
        Self::measured(UnitCosts::default())
    }
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_in_twenty_takes_longer_than_what_is_spendable() {
        let mut model = CostModel::default();
        let work = Workload {
            characters: 100,
            fk_joints: 3000,
            sampled_joints: 3000,
            matrices: 3000,
        };
        let fair = model.cost_ns(&work);
        // Times spread evenly over a tenth up and a tenth down, in a fixed shuffle.
        let ratio = |i: usize| 0.9 + 0.2 * ((i * 37) % 100) as f64 / 100.0;
        for i in 0..4000 {
            model.observe(&work, fair * ratio(i));
        }
        let planned = model.spendable_ns(1e6);
        let late = (0..1000).filter(|i| {
            let measured = planned / model.cost_ns(&work) * fair * ratio(*i);
            measured > 1e6
        });
        let late = late.count();
        assert!((10..=100).contains(&late), "{late} of 1000");
        // Without observations the whole budget may be planned.
        let first = CostModel::measured(model.unit_costs());
        assert_eq!(first.spendable_ns(1e6), 1e6);
    }

    const TRUE: UnitCosts = UnitCosts {
        character_ns: 30.0,
        sampled_joint_ns: 2.0,
        fk_joint_ns: 5.0,
        matrix_ns: 1.0,
    };

    /// A pseudo-random number from 0 to 1.
    fn random(state: &mut u32) -> f64 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(*state >> 8) / f64::from(1 << 24)
    }

    /// Frames of up to a thousand characters at several levels.
    fn frame(state: &mut u32) -> Workload {
        let mut piece = |most: f64| (most * random(state)) as u64;
        Workload {
            characters: 100 + piece(900.0),
            sampled_joints: 1000 + piece(40_000.0),
            fk_joints: 1000 + piece(60_000.0),
            matrices: 1000 + piece(60_000.0),
        }
    }

    fn within(model: &CostModel, share: f64) {
        let truth = CostModel::measured(TRUE);
        let mut state = 77;
        for _ in 0..100 {
            let work = frame(&mut state);
            let (found, expected) = (model.cost_ns(&work), truth.cost_ns(&work));
            let off = (found / expected - 1.0).abs();
            assert!(
                off < share,
                "{found} for {expected}: {:?}",
                model.unit_costs()
            );
        }
    }

    #[test]
    fn one_kind_of_work_by_hand() {
        let mut model = CostModel::measured(UnitCosts {
            character_ns: 0.0,
            sampled_joint_ns: 2.0,
            fk_joint_ns: 1.0,
            matrix_ns: 1.0,
        });
        let sampled = |n| Workload {
            sampled_joints: n,
            ..Workload::default()
        };
        // The first time counts in full: 300 ns for 100 joints are 3 ns each, not 2. In shares of 2
        // ns and of the expected 200 ns: 1 · f = 1.5.
        assert!(model.observe(&sampled(100), 300.0));
        assert!((model.unit_costs().sampled_joint_ns - 3.0).abs() < 1e-5);
        // Then 40 ns where 30 are expected: (20 / 30) f = 40 / 30, so
        // f = (0.98 · 1.5 + 2/3 · 4/3) / (0.98 + (2/3)²) = 2.35889 / 1.42444 = 1.65601.
        assert!(model.observe(&sampled(10), 40.0));
        assert!((model.unit_costs().sampled_joint_ns - 3.31202).abs() < 1e-4);
        let unseen = model.unit_costs().fk_joint_ns;
        assert!((unseen - 1.0).abs() < 1e-9, "{unseen}");
        // All three together.
        let mut model = CostModel::measured(UnitCosts {
            character_ns: 0.0,
            sampled_joint_ns: 2.0,
            fk_joint_ns: 1.0,
            matrix_ns: 1.0,
        });
        let all = Workload {
            sampled_joints: 10,
            fk_joints: 10,
            matrices: 10,
            characters: 0,
        };
        assert!(model.observe(&all, 52.0));
        let found = model.unit_costs();
        // The time is 1.3 times as long; the shares are 2 : 1 : 1, so the least change of factors
        // is 0.3 / 0.375 times (0.5, 0.25, 0.25).
        assert!((found.sampled_joint_ns - 2.8).abs() < 1e-4);
        assert!((found.fk_joint_ns - 1.2).abs() < 1e-4);
        assert!((model.cost_ns(&all) - 52.0).abs() < 1e-3);
    }

    /// A model of characters that take 1 ns each and of nothing else.
    fn plain() -> CostModel {
        CostModel::measured(UnitCosts {
            character_ns: 1.0,
            sampled_joint_ns: 0.0,
            fk_joint_ns: 0.0,
            matrix_ns: 0.0,
        })
    }

    const HUNDRED: Workload = Workload {
        characters: 100,
        sampled_joints: 0,
        fk_joints: 0,
        matrices: 0,
    };

    /// Observes that many times what the model expects.
    fn observe_times(model: &mut CostModel, factor: f64) -> bool {
        let expected = model.cost_ns(&HUNDRED);
        model.observe(&HUNDRED, factor * expected)
    }

    #[test]
    fn work_adds_kind_by_kind() {
        let work = |characters, sampled_joints, fk_joints, matrices| Workload {
            characters,
            sampled_joints,
            fk_joints,
            matrices,
        };
        let sum = work(1, 20, 300, 4000) + work(5, 60, 700, 8000);
        assert_eq!(sum, work(6, 80, 1000, 12_000));
        let mut grown = work(1, 20, 300, 4000);
        grown += work(5, 60, 700, 8000);
        assert_eq!(grown, sum);
    }

    #[test]
    fn each_late_time_leaves_less_to_spend() {
        let mut model = plain();
        // As long as expected is not late.
        observe_times(&mut model, 1.0);
        assert_eq!(model.spendable_ns(1e6), 1e6);
        // 0.01 · 0.95 up for a late time, 0.01 · 0.05 down for another one.
        observe_times(&mut model, 1.2);
        assert!((model.spendable_ns(1e6) - 1e6 / 1.0095).abs() < 1e-6);
        observe_times(&mut model, 1.0);
        assert!((model.spendable_ns(1e6) - 1e6 / 1.009).abs() < 1e-6);
        // Late, but not later than is planned for.
        observe_times(&mut model, 1.0089);
        assert!((model.spendable_ns(1e6) - 1e6 / 1.0085).abs() < 1e-6);
        for _ in 0..1000 {
            observe_times(&mut model, 10.0);
        }
        assert_eq!(model.spendable_ns(1e6), 5e5);
    }

    #[test]
    fn an_outlier_is_four_mean_deviations_off() {
        let limit = |model: &CostModel, factor: f64| {
            for (factor, taken) in [(factor - 0.01, true), (factor + 0.01, false)] {
                let up = observe_times(&mut model.clone(), factor);
                let down = observe_times(&mut model.clone(), 1.0 / factor);
                assert_eq!([up, down], [taken; 2], "{factor}");
            }
        };
        // Before the first time: 1 + 4 · 1.
        let mut model = plain();
        limit(&model, 5.0);
        assert!(model.clone().observe(&HUNDRED, 500.0), "no more than that");
        // The mean of 0.9, 0.3 and 0.6 is 0.6.
        for factor in [1.9, 1.0 / 1.3, 1.6] {
            assert!(observe_times(&mut model, factor));
        }
        limit(&model, 1.0 + 4.0 * 0.6);
        // Of many, a new one counts for a twentieth: 0.95 · 0.6.
        for _ in 0..200 {
            assert!(observe_times(&mut model, 1.6));
        }
        limit(&model, 1.0 + 4.0 * 0.6);
        assert!(observe_times(&mut model, 1.0));
        limit(&model, 1.0 + 4.0 * 0.57);
        // However steady: half as long again.
        for _ in 0..200 {
            assert!(observe_times(&mut model, 1.0));
        }
        limit(&model, 1.5);
    }

    #[test]
    fn a_slower_machine_is_slower_at_what_was_not_seen_too() {
        let mut model = CostModel::measured(TRUE);
        let sampled = Workload {
            sampled_joints: 1000,
            ..Workload::default()
        };
        for i in 1..=8 {
            assert_eq!(model.observe(&sampled, 6.0 * 2000.0), i == 8);
        }
        let found = model.unit_costs();
        let expected = [180.0, 12.0, 30.0, 6.0];
        let found = [
            found.character_ns,
            found.sampled_joint_ns,
            found.fk_joint_ns,
            found.matrix_ns,
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} ns");
        }
        // Outliers that do not follow each other change nothing.
        for _ in 0..20 {
            assert!(!model.observe(&sampled, 1e6));
            assert!(model.observe(&sampled, 12_000.0));
        }
        assert!((model.unit_costs().fk_joint_ns / 30.0 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn converges_through_noise_and_interrupted_frames() {
        let truth = CostModel::measured(TRUE);
        let mut model = CostModel::default();
        let mut state = 1;
        let (mut odd, mut believed) = (0, 0);
        for i in 0..4000 {
            let work = frame(&mut state);
            let noise = 1.0 + 0.1 * (random(&mut state) - 0.5);
            // One frame in twenty is interrupted and takes three times as long.
            let interrupted = i > 20 && random(&mut state) < 0.05;
            let time = truth.cost_ns(&work) * noise * if interrupted { 3.0 } else { 1.0 };
            let seen = model.observe(&work, time);
            odd += u32::from(interrupted);
            believed += u32::from(interrupted && seen);
        }
        assert!(odd > 100);
        assert_eq!(believed, 0, "of {odd}");
        within(&model, 0.04);
    }

    #[test]
    fn follows_a_machine_that_becomes_slower() {
        let truth = CostModel::measured(TRUE);
        let mut model = CostModel::measured(TRUE);
        let (mut state, mut doubted) = (5, 0);
        for slower in [1.0, 4.0, 0.25] {
            for _ in 0..400 {
                let work = frame(&mut state);
                doubted += u32::from(!model.observe(&work, slower * truth.cost_ns(&work)));
            }
            let work = frame(&mut state);
            let off = model.cost_ns(&work) / (slower * truth.cost_ns(&work)) - 1.0;
            assert!(off.abs() < 0.02, "{slower}: {off}");
            // Seven frames were ignored at each change.
        }
        assert_eq!(doubted, 14);
    }

    #[test]
    fn nonsense_teaches_nothing() {
        let mut model = CostModel::default();
        let before = model.clone();
        let mut state = 9;
        let work = frame(&mut state);
        for time in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!model.observe(&work, time));
        }
        assert!(!model.observe(&Workload::default(), 100.0));
        assert_eq!(model, before);
        assert_eq!(CostModel::measured(TRUE).unit_costs(), TRUE);
    }
}
