//! Between weights of a face's controls and FAP values.

use super::fap_values::FapValues;
use super::intervals::FapInterval;
use super::opposed::OpposedSolver;
use articula_core::arkit_table::twin_lip;
use articula_core::fap_table::{LOW_FAP_COUNT, LOW_FAPS, TABLE, unit_mm};

/// Weight of the lengths of the weighted columns (in mm) beside half the squared errors, in mm. It
/// prefers one control to several that together show the same.
const LENGTH: f64 = 1e-2;
/// Weight of the squared weights beside the squared errors, in mm²; it makes the solution unique, and
/// continuous over time.
const RIDGE: f64 = 1e-3;

/// The relation between weights of a face's controls and FAP values.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceBridge {
    relation: Relation,
}

#[derive(Debug, Clone, PartialEq)]
enum Relation {
    Columns(Columns),
    /// Each control is a part of a face animation table.
    Table(Vec<FapInterval>),
}

#[derive(Debug, Clone, PartialEq)]
struct Columns {
    /// The values of each control at weight 1.
    of_control: Vec<FapValues>,
    /// Pairs of controls that undo each other.
    opposites: Vec<[usize; 2]>,
}

/// Solver of the weights of one frame after the other.
#[derive(Debug, Clone)]
pub struct FaceSolver(Solver);

#[derive(Debug, Clone)]
enum Solver {
    Columns(Box<ColumnSolver>),
    Table(TableSolver),
}

#[derive(Debug, Clone)]
struct ColumnSolver {
    /// Columns in millimetres; 0 for FAPs that do not count.
    scaled: Vec<[f64; LOW_FAP_COUNT]>,
    counts: [bool; LOW_FAP_COUNT],
    solver: OpposedSolver,
    b: Vec<f64>,
}

/// The intervals of each parameter, by their place among the controls. FAPs that do not count follow
/// their twin on the other contour of the lips.
#[derive(Debug, Clone)]
struct TableSolver {
    controls: usize,
    of_fap: Vec<(Vec<FapInterval>, Vec<usize>)>,
    counts: [bool; LOW_FAP_COUNT],
}

/// Weights that show FAP values as closely as the controls can.
#[derive(Debug, Clone, PartialEq)]
pub struct ShownFace {
    /// One weight for each control: 0 to 1, and any value for parts of a table.
    pub weights: Vec<f32>,
    /// Difference of each FAP (3 at index 0) to its value, in millimetres on an average face; 0 for
    /// those that do not count.
    pub error_mm: [f32; LOW_FAP_COUNT],
}

impl FaceBridge {
    /// Creates a bridge from the values of each control at weight 1.
    pub fn new(columns: Vec<FapValues>) -> Self {
        let relation = Relation::Columns(Columns {
            of_control: columns,
            opposites: Vec::new(),
        });
        Self { relation }
    }

    /// Of these pairs of controls, by their indices, no two have a weight in one frame
    /// ([`FaceBridge::solver`]). A bridge to a table has no such pairs.
    ///
    /// # Panics
    /// If there is no such control.
    #[must_use]
    pub fn with_opposites(mut self, pairs: Vec<[usize; 2]>) -> Self {
        let controls = self.controls();
        assert!(pairs.iter().flatten().all(|c| *c < controls), "a control");
        if let Relation::Columns(columns) = &mut self.relation {
            columns.opposites = pairs;
        }
        self
    }

    /// Returns the pairs of controls that undo each other.
    pub fn opposites(&self) -> &[[usize; 2]] {
        match &self.relation {
            Relation::Columns(columns) => &columns.opposites,
            Relation::Table(_) => &[],
        }
    }

    /// Creates a bridge to the parts of a face animation table.
    pub fn of_table(intervals: Vec<FapInterval>) -> Self {
        let relation = Relation::Table(intervals);
        Self { relation }
    }

    /// Returns the number of controls.
    pub fn controls(&self) -> usize {
        match &self.relation {
            Relation::Columns(columns) => columns.of_control.len(),
            Relation::Table(intervals) => intervals.len(),
        }
    }

    /// Returns whether a control moves a FAP, by its number.
    pub fn moves(&self, fap: usize) -> bool {
        match &self.relation {
            Relation::Columns(columns) => columns.of_control.iter().any(|c| c.get(fap) != 0.0),
            Relation::Table(intervals) => intervals.iter().any(|i| i.fap == fap),
        }
    }

    /// Returns the FAP values of weights; those with one direction only are not negative.
    ///
    /// # Panics
    /// If there are not as many weights as controls.
    pub fn faps(&self, weights: &[f32]) -> FapValues {
        assert_eq!(
            weights.len(),
            self.controls(),
            "one weight for each control"
        );
        let mut sum = FapValues::default();
        match &self.relation {
            Relation::Columns(columns) => {
                for (column, weight) in columns.of_control.iter().zip(weights) {
                    sum = sum.plus(column, *weight);
                }
            }
            Relation::Table(intervals) => {
                for (interval, weight) in intervals.iter().zip(weights) {
                    let value = weight * (interval.to - interval.from) as f32;
                    sum.0[interval.fap - LOW_FAPS.start()] += value;
                }
            }
        }
        for (value, fap) in sum.0.iter_mut().zip(&TABLE[LOW_FAPS.start() - 1..]) {
            if fap.action.is_some_and(|a| !a.two_sided) {
                *value = value.max(0.0);
            }
        }
        sum
    }

    /// Returns a solver for the opposite way. FAPs for which `counts` (3 at index 0) is false, such
    /// as those of the outer lips in a stream without them, are left out.
    pub fn solver(&self, counts: [bool; LOW_FAP_COUNT]) -> FaceSolver {
        FaceSolver(match &self.relation {
            Relation::Columns(columns) => {
                Solver::Columns(Box::new(ColumnSolver::new(columns, counts)))
            }
            Relation::Table(intervals) => Solver::Table(TableSolver::new(intervals, counts)),
        })
    }
}

impl ColumnSolver {
    fn new(columns: &Columns, counts: [bool; LOW_FAP_COUNT]) -> Self {
        let all = columns.of_control.iter();
        let scaled: Vec<[f64; LOW_FAP_COUNT]> = all.map(|c| millimetres(c, &counts)).collect();
        let n = scaled.len();
        let mut gram = vec![0.0; n * n];
        for (i, a) in scaled.iter().enumerate() {
            for (j, b) in scaled.iter().enumerate() {
                gram[i * n + j] = a.iter().zip(b).map(|(a, b)| a * b).sum();
            }
            gram[i * n + i] += RIDGE;
        }
        Self {
            scaled,
            counts,
            solver: OpposedSolver::new(gram, n, columns.opposites.clone()),
            b: vec![0.0; n],
        }
    }

    fn solve(&mut self, values: &FapValues) -> ShownFace {
        let wanted = millimetres(values, &self.counts);
        for (b, column) in self.b.iter_mut().zip(&self.scaled) {
            let along: f64 = column.iter().zip(&wanted).map(|(a, f)| a * f).sum();
            let length: f64 = column.iter().map(|a| a * a).sum();
            *b = along - LENGTH * length.sqrt();
        }
        let weights = self.solver.solve(&self.b);
        let mut error = wanted;
        for (column, weight) in self.scaled.iter().zip(weights) {
            let shown = error.iter_mut().zip(column);
            shown.for_each(|(e, c)| *e -= weight * c);
        }
        ShownFace {
            weights: weights.iter().map(|w| *w as f32).collect(),
            error_mm: error.map(|e| e as f32),
        }
    }
}

impl TableSolver {
    fn new(intervals: &[FapInterval], counts: [bool; LOW_FAP_COUNT]) -> Self {
        let of_fap = LOW_FAPS.map(|fap| {
            let own = (0..intervals.len()).filter(|i| intervals[*i].fap == fap);
            own.map(|i| (intervals[i], i)).unzip()
        });
        Self {
            controls: intervals.len(),
            of_fap: of_fap.collect(),
            counts,
        }
    }

    fn solve(&self, values: &FapValues) -> ShownFace {
        let mut weights = vec![0.0; self.controls];
        let mut error_mm = [0.0; LOW_FAP_COUNT];
        for (index, (intervals, places)) in self.of_fap.iter().enumerate() {
            let fap = LOW_FAPS.start() + index;
            let counts = self.counts[index];
            let leader = twin_lip(fap).filter(|_| !counts).unwrap_or(fap);
            let value = values.get(leader);
            for (interval, place) in intervals.iter().zip(places) {
                weights[*place] = interval.weight(value, intervals);
            }
            if intervals.is_empty() && counts {
                error_mm[index] = value * unit_mm(fap);
            }
        }
        ShownFace { weights, error_mm }
    }
}

/// The values as lengths; 0 for those that do not count.
fn millimetres(values: &FapValues, counts: &[bool; LOW_FAP_COUNT]) -> [f64; LOW_FAP_COUNT] {
    std::array::from_fn(|i| {
        let length = values.0[i] * unit_mm(LOW_FAPS.start() + i);
        if counts[i] { f64::from(length) } else { 0.0 }
    })
}

impl FaceSolver {
    /// Returns the weights that show FAP values most closely, by the sum of squared differences in
    /// millimetres. O(n³) for n controls, less if few are active; O(n) for a table.
    pub fn solve(&mut self, values: &FapValues) -> ShownFace {
        match &mut self.0 {
            Solver::Columns(columns) => columns.solve(values),
            Solver::Table(table) => table.solve(values),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::controls::{blend_shape, opposite_controls, vrm_preset};
    use super::super::high_level::VISEMES;
    use super::*;
    use crate::split_mix::SplitMix;
    use articula_core::arkit_table::{BLEND_SHAPES, OPPOSITES, are_opposite};
    use articula_core::face_control::ShapeSet;
    use proptest::prelude::*;

    const ALL: [bool; LOW_FAP_COUNT] = [true; LOW_FAP_COUNT];

    /// The generic columns, with no opposites.
    fn free() -> FaceBridge {
        let all = BLEND_SHAPES.iter();
        FaceBridge::new(all.map(|s| blend_shape(s.name).unwrap()).collect())
    }

    fn arkit() -> FaceBridge {
        let shapes: Vec<_> = (0..BLEND_SHAPES.len())
            .map(|shape| Some(ShapeSet::of([shape])))
            .collect();
        free().with_opposites(opposite_controls(&shapes))
    }

    fn index(name: &str) -> usize {
        BLEND_SHAPES.iter().position(|s| s.name == name).unwrap()
    }

    /// Root of the mean squared difference of a parameter, in millimetres.
    fn rms_mm(shown: &ShownFace) -> f32 {
        let squares = shown.error_mm.iter().map(|e| e * e);
        (squares.sum::<f32>() / LOW_FAP_COUNT as f32).sqrt()
    }

    /// The most that any two opposites have at once.
    fn most_at_once(shown: &ShownFace) -> f32 {
        let both = |[a, b]: &[&str; 2]| shown.weights[index(a)].min(shown.weights[index(b)]);
        OPPOSITES.iter().map(both).fold(0.0, f32::max)
    }

    fn rounded(values: FapValues) -> FapValues {
        FapValues(values.0.map(f32::round))
    }

    /// Whether a pose has a shape that undoes another one, such as the look to the other side.
    fn is_undone(shape: usize, weights: &[f32]) -> bool {
        let jaw = [index("jawOpen"), index("mouthClose")];
        let undoes = |other: usize| {
            are_opposite(shape, other) || jaw == [shape, other] || jaw == [other, shape]
        };
        (0..weights.len()).any(|other| weights[other] > 0.0 && undoes(other))
    }

    /// Mean error of the weights of random poses that went through rounded FAP values and back, and
    /// the number of shapes (without tongueOut) whose own mean is at most 3 %.
    fn round_trip(active: usize) -> (f32, usize) {
        const POSES: usize = 80;
        let shapes = BLEND_SHAPES.len() - 1;
        let bridge = arkit();
        let mut solver = bridge.solver(ALL);
        let mut random = SplitMix(7);
        let mut errors = vec![0.0; shapes];
        for _ in 0..POSES {
            let mut weights = vec![0.0; BLEND_SHAPES.len()];
            let mut left = active;
            while left > 0 {
                let shape = random.below(shapes);
                if weights[shape] == 0.0 && !is_undone(shape, &weights) {
                    weights[shape] = 0.05 + 0.95 * random.unit();
                    left -= 1;
                }
            }
            let back = solver.solve(&rounded(bridge.faps(&weights)));
            for (error, (a, b)) in errors.iter_mut().zip(weights.iter().zip(&back.weights)) {
                *error += (a - b).abs() / POSES as f32;
            }
        }
        let good = errors.iter().filter(|e| **e <= 0.03).count();
        (errors.iter().sum::<f32>() / shapes as f32, good)
    }

    #[test]
    fn weights_come_back() {
        let (mean, good) = round_trip(6);
        assert!(mean <= 0.015 && good >= 40, "{mean}, {good}");
        // Ten shapes move the corners of the lips, for which there are four parameters: with half
        // of all shapes active, dimples, stretches and shifts of the mouth replace each other.
        let (mean, good) = round_trip(25);
        assert!(mean <= 0.05 && good >= 25, "{mean}, {good}");
    }

    #[test]
    fn one_shape_comes_back_alone() {
        let bridge = arkit();
        let mut solver = bridge.solver(ALL);
        for (shape, known) in BLEND_SHAPES.iter().enumerate() {
            let mut weights = vec![0.0; BLEND_SHAPES.len()];
            weights[shape] = 1.0;
            let shown = solver.solve(&bridge.faps(&weights));
            let weight = shown.weights[shape];
            assert!(weight > 0.9, "{} {weight}", known.name);
            let most = shown.error_mm.iter().fold(0.0_f32, |m, e| m.max(e.abs()));
            assert!(most < 0.1, "{} {most} mm", known.name);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]
        /// Values that no face makes: each parameter on its own.
        #[test]
        fn opposites_are_not_shown_at_once(values in prop::collection::vec(-300.0..300.0_f32, LOW_FAP_COUNT)) {
            let values = FapValues(values.try_into().unwrap());
            let shown = arkit().solver(ALL).solve(&values);
            prop_assert_eq!(most_at_once(&shown), 0.0);
            prop_assert!(shown.weights.iter().all(|w| (0.0..=1.0).contains(w)));
            let best = free().solver(ALL).solve(&values);
            prop_assert!(rms_mm(&shown) < 1.1 * rms_mm(&best) + 0.1, "{} {}", rms_mm(&shown), rms_mm(&best));
        }
    }

    fn shown(viseme: usize) -> ShownFace {
        let mut values = FapValues::default();
        values.add(VISEMES[viseme], 1.0);
        arkit().solver(ALL).solve(&values)
    }

    #[test]
    fn visemes_cancel_nothing() {
        for viseme in 1..VISEMES.len() {
            assert_eq!(most_at_once(&shown(viseme)), 0.0, "{viseme}");
        }
        // Lips that press, 1.2 mm, are no work for whole shapes, as dimples against a pucker.
        let pressed = shown(1);
        assert!(pressed.weights.iter().all(|w| *w < 0.2), "{pressed:?}");
        // 480 of the 1000 units of jawOpen, and no side.
        let open = shown(10);
        let weight = |name| open.weights[index(name)];
        assert!((0.4..0.6).contains(&weight("jawOpen")), "{open:?}");
        assert_eq!([weight("jawLeft"), weight("jawRight")], [0.0, 0.0]);
    }

    #[test]
    fn a_stream_without_outer_lips_opens_the_jaw_as_far() {
        let bridge = arkit();
        let mut weights = vec![0.0; BLEND_SHAPES.len()];
        let jaw = BLEND_SHAPES
            .iter()
            .position(|s| s.name == "jawOpen")
            .unwrap();
        weights[jaw] = 0.5;
        let mut values = bridge.faps(&weights);
        let outer = 51 - LOW_FAPS.start()..=60 - LOW_FAPS.start();
        values.0[outer.clone()].fill(0.0);
        let counts = std::array::from_fn(|i| !outer.contains(&i));
        let open = bridge.solver(counts).solve(&values).weights[jaw];
        assert!((open - 0.5).abs() < 0.01, "{open}");
        let closed = bridge.solver(ALL).solve(&values);
        assert!(closed.error_mm.iter().any(|e| e.abs() > 1.0));
    }

    #[test]
    fn what_no_control_moves_stays_as_an_error() {
        let bridge = FaceBridge::new(vec![vrm_preset("aa").unwrap()]);
        assert!(bridge.moves(3) && bridge.moves(51) && !bridge.moves(31));
        let mut values = FapValues::default();
        values.0[31 - LOW_FAPS.start()] = 512.0;
        let shown = bridge.solver(ALL).solve(&values);
        assert_eq!(shown.weights, [0.0]);
        assert!((shown.error_mm[31 - LOW_FAPS.start()] - 24.0).abs() < 1e-3);
    }

    #[test]
    fn parameters_of_one_direction_are_not_negative() {
        let mut back = FapValues::default();
        back.0[0] = -100.0;
        back.0[1] = -100.0;
        let shown = FaceBridge::new(vec![back]).faps(&[1.0]);
        assert_eq!((shown.get(3), shown.get(4)), (0.0, -100.0));
    }
}
