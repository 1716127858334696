//! What the rates of some grades say about a device.

use super::grade::{Application, GRADES, Grade};
use super::median::{LEAST_VALUES, Median};
use articula_core::Libm;
use serde::Serialize;

/// Frame rates for which the finest grade is looked for, frames per second.
pub const TARGETS_FPS: [f64; 2] = [25.0, 60.0];

/// The frame rate of a grade.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GradeRate {
    /// Number of the grade.
    pub grade: usize,
    /// Frames per second: the median of its runs.
    pub fps: f64,
    /// Number of runs.
    pub runs: usize,
}

/// The finest grade that a device holds at a frame rate: *h(d)* of thesis 5.1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Held {
    /// The frame rate, frames per second.
    pub fps: f64,
    /// The grade; `None` if even the coarsest is slower.
    pub grade: Option<Grade>,
}

/// The result of one application.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ApplicationResult {
    /// What was played.
    pub application: Application,
    /// Frame rates in percent of the reference machine's: the geometric mean over grades.
    pub score: f64,
    /// The finest grade at each of [`TARGETS_FPS`].
    pub holds: Vec<Held>,
    /// Frame rates, the finest grade first.
    pub grades: Vec<GradeRate>,
}

impl ApplicationResult {
    /// What rates say; `None` without any. Grades of few runs count for `holds` alone: they are no
    /// protection from what else the device does.
    pub(super) fn of(application: Application, mut grades: Vec<GradeRate>) -> Option<Self> {
        grades.retain(|rate| rate.grade < GRADES && rate.fps > 0.0 && rate.fps.is_finite());
        grades.sort_by_key(|rate| rate.grade);
        grades.dedup_by_key(|rate| rate.grade);
        let speeds = counted(&grades).map(|rate| {
            let reference = Grade::of(application, rate.grade).reference_secs();
            (rate.fps * reference).libm_ln()
        });
        let speeds: Vec<f64> = speeds.collect();
        if speeds.is_empty() {
            return None;
        }
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        let holds = TARGETS_FPS.map(|fps| Held {
            fps,
            grade: bracket(&grades, fps).1.map(|n| Grade::of(application, n)),
        });
        Some(Self {
            application,
            score: 100.0 * mean.libm_exp(),
            holds: holds.to_vec(),
            grades,
        })
    }

    /// The result of several runs of one application on one device, each grade by the median of its rates;
    /// `None` of none.
    pub(super) fn combined(application: Application, runs: &[&Self]) -> Option<Self> {
        let rates = runs.iter().flat_map(|run| counted(&run.grades));
        let of = |grade: usize| {
            let of_grade = rates.clone().filter(|rate| rate.grade == grade);
            let fps: Vec<f64> = of_grade.map(|rate| rate.fps).collect();
            Some(GradeRate {
                grade,
                fps: Median::of(&fps)?.value,
                runs: fps.len(),
            })
        };
        Self::of(application, (0..GRADES).filter_map(of).collect())
    }

    /// Frame rate of the full grade by the score, frames per second.
    pub fn full_fps(&self) -> f64 {
        self.score / 100.0 / self.application.full_grade().reference_secs()
    }
}

/// The rates of grades with enough runs for their median to be bounded; without any, those with the most.
fn counted(grades: &[GradeRate]) -> impl Iterator<Item = &GradeRate> + Clone {
    let most = grades.iter().map(|rate| rate.runs).max().unwrap_or(0);
    let enough = most.min(LEAST_VALUES);
    grades.iter().filter(move |rate| rate.runs >= enough)
}

/// The coarsest grade that is slower than a rate, and the finest beyond it that holds the rate.
pub(super) fn bracket(grades: &[GradeRate], fps: f64) -> (Option<usize>, Option<usize>) {
    let slower = grades.iter().filter(|rate| rate.fps < fps);
    let fails = slower.map(|rate| rate.grade).max();
    let beyond = |rate: &&GradeRate| fails.is_none_or(|fails| rate.grade > fails);
    let holds = grades.iter().filter(beyond).map(|rate| rate.grade).min();
    (fails, holds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(grade: usize, times: f64, runs: usize) -> GradeRate {
        let reference = Grade::of(Application::Body, grade).reference_secs();
        GradeRate {
            grade,
            fps: times / reference,
            runs,
        }
    }

    #[test]
    fn the_score_is_a_geometric_mean_of_grades_with_enough_runs() {
        let of = |rates: &[GradeRate]| ApplicationResult::of(Application::Body, rates.to_vec());
        // A half and twice the reference: as fast in the mean. One run of another grade does not count.
        let result = of(&[rate(5, 0.5, 6), rate(3, 2.0, 6), rate(9, 50.0, 1)]).unwrap();
        assert!((result.score - 100.0).abs() < 1e-9, "{result:?}");
        let full = Application::Body.full_grade().reference_secs();
        assert!((result.full_fps() * full - 1.0).abs() < 1e-9);
        assert_eq!(of(&[]), None);
        assert_eq!(
            of(&[rate(99, 1.0, 6), rate(3, f64::NAN, 6), rate(4, -1.0, 6)]),
            None
        );
    }

    #[test]
    fn the_finest_grade_that_holds_lies_beyond_all_that_fail() {
        let at = |grade, fps| GradeRate {
            grade,
            fps,
            runs: 6,
        };
        let grades = [at(3, 30.0), at(5, 20.0), at(6, 26.0), at(8, 70.0)];
        assert_eq!(bracket(&grades, 25.0), (Some(5), Some(6)));
        assert_eq!(bracket(&grades, 60.0), (Some(6), Some(8)));
        assert_eq!(bracket(&grades, 10.0), (None, Some(3)));
        assert_eq!(bracket(&grades, 90.0), (Some(8), None));
        assert_eq!(bracket(&[], 25.0), (None, None));
    }

    #[test]
    fn runs_are_combined_by_their_medians() {
        let run = |times: f64| {
            let grades = vec![rate(4, times, 6), rate(5, times, 6)];
            ApplicationResult::of(Application::Body, grades).unwrap()
        };
        let runs = [run(0.5), run(0.52), run(40.0)];
        let all: Vec<_> = runs.iter().collect();
        let combined = ApplicationResult::combined(Application::Body, &all).unwrap();
        assert!((combined.score - 52.0).abs() < 1e-9);
        assert_eq!(combined.grades[0].runs, 3);
        assert_eq!(ApplicationResult::combined(Application::Body, &[]), None);
    }
}
