//! A run of the benchmark, as a state machine without a clock.
//!
//! Bisection over grades brackets the finest one that holds each of [`TARGETS_FPS`], from the first guess
//! on. The grades around it are then played in turns until their medians are certain.

use super::grade::{Application, GRADES, Grade};
use super::guess::FirstGuess;
use super::median::{LEAST_VALUES, Median};
use super::result::{ApplicationResult, GradeRate, TARGETS_FPS, bracket};

/// Frames of a run after its first, which fills caches and does not count.
const RUN_FRAMES: usize = 5;
/// Seconds of counted frames after which a run is over, though it has fewer of them.
const RUN_SECS: f64 = 0.5;
/// Most runs of a grade.
const MOST_RUNS: usize = 15;
/// Half width of a confidence interval, as a fraction of the median, at which a grade is certain wherever
/// the targets lie.
const PRECISION: f64 = 0.03;
/// The same where all of the interval is on one side of the target: enough for the score.
const SCORE_PRECISION: f64 = 0.06;
/// Most grades that a step goes beyond all that were played: a frame of a far finer one might take seconds.
const FARTHEST: usize = 3;
/// Time of a frame that is told as none, seconds.
const LEAST_SECS: f64 = 1e-7;
/// A frame that takes longer is taken as this long, seconds.
const LONGEST_SECS: f64 = 1e3;

/// Options of a [`BenchmarkRun`].
#[derive(Debug, Clone, PartialEq)]
pub struct BenchmarkOptions {
    /// Numbers of the grades that are played, in turns; if empty, those around each of [`TARGETS_FPS`].
    pub grades: Vec<usize>,
    /// Seconds of frames after which it ends with what it knows.
    pub most_secs: f64,
    /// Number of frames after which it does.
    pub most_frames: usize,
}

impl Default for BenchmarkOptions {
    /// 10 seconds, 1000 frames.
    fn default() -> Self {
        Self {
            grades: Vec::new(),
            most_secs: 10.0,
            most_frames: 1000,
        }
    }
}

/// Decides which grade of an application is played next, from the times of those that were.
///
/// ```
/// use articula::device::{Application, BenchmarkOptions, BenchmarkRun, FirstGuess};
///
/// let guess = FirstGuess { calibration_secs: 0.004, cores: 2, threads: 1 };
/// let mut run = BenchmarkRun::new(Application::Body, &guess, &BenchmarkOptions::default());
/// while let Some(grade) = run.next_grade() {
///     // A device half as fast as the reference machine.
///     run.record(&grade, 2.0 * grade.reference_secs());
/// }
/// let result = run.result().unwrap();
/// assert!((result.score - 50.0).abs() < 0.1);
/// ```
#[derive(Debug, Clone)]
pub struct BenchmarkRun {
    application: Application,
    options: BenchmarkOptions,
    /// Medians of the runs of each grade, seconds.
    runs: Vec<Vec<f64>>,
    /// The grade of the run that is going on; `None` at the end.
    now: Option<usize>,
    /// Its frames, seconds; the first is not among them.
    times: Vec<f64>,
    has_begun: bool,
    frames: usize,
    secs: f64,
    is_certain: bool,
}

impl BenchmarkRun {
    /// Begins with the grade that the hardware may hold at the first of [`TARGETS_FPS`], or with the first
    /// that is asked for. Grades that there are not are left out.
    pub fn new(application: Application, guess: &FirstGuess, options: &BenchmarkOptions) -> Self {
        let mut options = options.clone();
        options.grades.retain(|grade| *grade < GRADES);
        let guessed = || guess.grade(application, TARGETS_FPS[0]);
        let first = options.grades.first().copied().unwrap_or_else(guessed);
        Self {
            application,
            options,
            runs: vec![Vec::new(); GRADES],
            now: Some(first),
            times: Vec::with_capacity(RUN_FRAMES),
            has_begun: false,
            frames: 0,
            secs: 0.0,
            is_certain: false,
        }
    }

    /// Returns the grade of which a frame is to be played next; `None` at the end.
    pub fn next_grade(&self) -> Option<Grade> {
        self.now.map(|number| Grade::of(self.application, number))
    }

    /// Takes the time of a frame of the grade that was asked for. A frame of another one is left out.
    pub fn record(&mut self, grade: &Grade, seconds: f64) {
        let Some(now) = self.now.filter(|now| *now == grade.number) else {
            return;
        };
        // A clock that does not advance shows a fast frame, and NaN a clock that fails.
        let seconds = if seconds.is_nan() {
            LONGEST_SECS
        } else {
            seconds
        };
        let seconds = seconds.clamp(LEAST_SECS, LONGEST_SECS);
        self.frames += 1;
        self.secs += seconds;
        if self.has_begun {
            self.times.push(seconds);
        }
        self.has_begun = true;
        let is_over =
            self.secs >= self.options.most_secs || self.frames >= self.options.most_frames;
        let is_long = self.times.iter().sum::<f64>() >= RUN_SECS;
        if self.times.len() < RUN_FRAMES && !is_long && !is_over {
            return;
        }
        if is_over && self.times.is_empty() && self.runs.iter().all(Vec::is_empty) {
            // One frame is better than no result.
            self.times.push(seconds);
        }
        self.runs[now].extend(Median::of(&self.times).map(|m| m.value));
        self.times.clear();
        self.has_begun = false;
        self.now = if is_over { None } else { self.choice() };
        self.is_certain = self.now.is_none() && !is_over;
    }

    /// Number of frames that were played.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Sum of their times, seconds.
    pub fn secs(&self) -> f64 {
        self.secs
    }

    /// Whether it ended because the answer is certain.
    pub fn is_certain(&self) -> bool {
        self.is_certain
    }

    /// Returns what the frames so far say; `None` before the first run is over.
    pub fn result(&self) -> Option<ApplicationResult> {
        ApplicationResult::of(self.application, self.rates())
    }

    fn rates(&self) -> Vec<GradeRate> {
        let played = self.runs.iter().enumerate();
        let rate = |(grade, runs): (usize, &Vec<f64>)| {
            Some(GradeRate {
                grade,
                fps: 1.0 / Median::of(runs)?.value,
                runs: runs.len(),
            })
        };
        played.filter_map(rate).collect()
    }

    /// The grade of the next run; `None` if all that matters is certain.
    fn choice(&self) -> Option<usize> {
        let fewest = |grade: &usize| self.runs[*grade].len();
        if !self.options.grades.is_empty() {
            let grades = self.options.grades.iter().copied();
            let open = grades.filter(|grade| !self.is_known(*grade, None));
            return open.min_by_key(fewest);
        }
        let rates = self.rates();
        let mut watched: Vec<(usize, f64)> = Vec::new();
        for fps in TARGETS_FPS {
            let (fails, holds) = bracket(&rates, fps);
            // What is one finer than all fails, and one coarser than all holds.
            let low = fails.map_or(0, |grade| grade + 1);
            let high = holds.unwrap_or(GRADES);
            if low < high {
                // From the first guess on by one, two and three grades, until it lies between two.
                let step = rates.len().min(FARTHEST);
                return Some(match (fails, holds) {
                    (None, Some(holds)) => holds.saturating_sub(step),
                    (Some(fails), None) => (fails + step).min(GRADES - 1),
                    _ => (low + high - 1).div_ceil(2).min(GRADES - 1),
                });
            }
            watched.extend(fails.into_iter().chain(holds).map(|grade| (grade, fps)));
        }
        let open = watched
            .iter()
            .filter(|(grade, fps)| !self.is_known(*grade, Some(*fps)));
        open.map(|(grade, _)| *grade).min_by_key(fewest)
    }

    /// Whether the rate of a grade is certain, and on which side of another one it is.
    fn is_known(&self, grade: usize, fps: Option<f64>) -> bool {
        let runs = &self.runs[grade];
        let Some(median) = Median::of(runs) else {
            return false;
        };
        let is_beside = |wanted: f64| median.high < wanted || median.low > wanted;
        let is_clear = fps.is_none_or(|fps| is_beside(1.0 / fps));
        let precision = if is_clear { SCORE_PRECISION } else { PRECISION };
        let is_narrow = median.high - median.low <= 2.0 * precision * median.value;
        runs.len() >= MOST_RUNS || (runs.len() >= LEAST_VALUES && is_narrow)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::guess::REFERENCE_SECS;
    use std::f64::consts::TAU;

    /// A device with noise: frames vary, some take several times as long, and now and then all of a
    /// while do, as when another program runs.
    struct NoisyDevice {
        speed: f64,
        state: u64,
        burst: usize,
    }

    impl NoisyDevice {
        fn new(speed: f64, seed: u64) -> Self {
            Self {
                speed,
                state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
                burst: 0,
            }
        }

        fn unit(&mut self) -> f64 {
            self.state ^= self.state << 13;
            self.state ^= self.state >> 7;
            self.state ^= self.state << 17;
            (self.state >> 11) as f64 / (1u64 << 53) as f64
        }

        fn frame(&mut self, grade: &Grade) -> f64 {
            let (a, b) = (self.unit().max(1e-12), self.unit());
            let normal = (-2.0 * a.ln()).sqrt() * (TAU * b).cos();
            let mut secs = grade.reference_secs() / self.speed * (0.08 * normal).exp();
            if self.unit() < 0.1 {
                secs *= 2.0 + 8.0 * self.unit();
            }
            if self.unit() < 0.004 {
                self.burst = 12;
            }
            if self.burst > 0 {
                self.burst -= 1;
                secs *= 2.5;
            }
            secs
        }
    }

    fn guess(times: f64) -> FirstGuess {
        FirstGuess {
            calibration_secs: REFERENCE_SECS * times,
            cores: 1,
            threads: 1,
        }
    }

    fn played(run: &mut BenchmarkRun, mut frame: impl FnMut(&Grade) -> f64) -> ApplicationResult {
        while let Some(grade) = run.next_grade() {
            let secs = frame(&grade);
            run.record(&grade, secs);
        }
        run.result().unwrap()
    }

    #[test]
    fn of_noisy_devices_nineteen_of_twenty_are_measured_within_five_percent() {
        let mut far = 0;
        for seed in 1..=300u64 {
            let speed = [0.05, 0.3, 1.0, 3.0, 12.0][seed as usize % 5];
            let application = Application::ALL[seed as usize % 3];
            let mut device = NoisyDevice::new(speed, seed);
            // The first guess is wrong by up to a factor of ten, either way.
            let wrong = 10.0_f64.powf(2.0 * device.unit() - 1.0) / speed;
            let options = BenchmarkOptions {
                most_secs: 1e6,
                ..BenchmarkOptions::default()
            };
            let mut run = BenchmarkRun::new(application, &guess(wrong), &options);
            let result = played(&mut run, |grade| device.frame(grade));
            assert!(
                run.is_certain() && run.frames() <= 450,
                "{} frames",
                run.frames()
            );
            let off = (result.score / (100.0 * speed)).ln().abs();
            assert!(off < 0.1, "{speed} {application} {seed}: {result:?}");
            far += usize::from(off > 0.05);
            for held in &result.holds {
                let number = held.grade.map_or(GRADES, |grade| grade.number);
                let holds = |times: f64| {
                    let all = Grade::all(application);
                    let of = |g: &Grade| g.reference_secs() * held.fps <= speed * times;
                    all.iter().position(of).unwrap_or(GRADES)
                };
                assert!((holds(1.05)..=holds(0.95)).contains(&number), "{held:?}");
            }
        }
        assert!(far * 20 < 300, "{far} of 300");
    }

    #[test]
    fn the_first_guess_saves_frames_and_changes_nothing_else() {
        let options = BenchmarkOptions::default();
        let ideal = |grade: &Grade| grade.reference_secs() / 1.3;
        let mut near = BenchmarkRun::new(Application::Body, &guess(1.0 / 1.3), &options);
        let mut far = BenchmarkRun::new(Application::Body, &guess(1e-3), &options);
        let (a, b) = (played(&mut near, ideal), played(&mut far, ideal));
        assert!((a.score - 130.0).abs() < 1e-6 && (b.score - 130.0).abs() < 1e-6);
        assert_eq!(a.holds, b.holds);
        assert!(near.frames() < far.frames());
    }

    #[test]
    fn grades_that_are_asked_for_are_played_and_no_others() {
        let options = BenchmarkOptions {
            grades: vec![7, 2, 99],
            ..BenchmarkOptions::default()
        };
        let mut run = BenchmarkRun::new(Application::Body, &guess(1.0), &options);
        let result = played(&mut run, |grade| 0.5 * grade.reference_secs());
        let grades: Vec<usize> = result.grades.iter().map(|rate| rate.grade).collect();
        assert!(run.is_certain() && grades == [2, 7]);
        assert!((result.score - 200.0).abs() < 1e-9);
    }

    #[test]
    fn slow_and_fast_devices_end_at_the_last_grade() {
        let options = BenchmarkOptions {
            most_secs: 1e9,
            ..BenchmarkOptions::default()
        };
        for (speed, grade) in [(1e-3, None), (1e5, Some(0))] {
            let mut run = BenchmarkRun::new(Application::Face, &guess(1.0), &options);
            let result = played(&mut run, |grade| grade.reference_secs() / speed);
            assert!(run.is_certain());
            for held in result.holds {
                assert_eq!(held.grade.map(|g| g.number), grade, "{}", held.fps);
            }
            assert!((result.score / (100.0 * speed) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn time_and_frames_are_bounded_whatever_is_told() {
        for told in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 1e9] {
            let mut run = BenchmarkRun::new(Application::Crowd, &guess(1.0), &Default::default());
            let result = played(&mut run, |_| told);
            assert!(run.frames() <= 1000 && result.score.is_finite(), "{told}");
        }
        // A device that answers at random.
        let mut device = NoisyDevice::new(1.0, 7);
        let options = BenchmarkOptions {
            most_secs: f64::INFINITY,
            ..BenchmarkOptions::default()
        };
        let mut run = BenchmarkRun::new(Application::Body, &guess(1.0), &options);
        let result = played(&mut run, |_| 10.0_f64.powf(4.0 * device.unit() - 3.0));
        assert!(run.frames() <= 1000 && result.score > 0.0);
        let options = BenchmarkOptions {
            most_secs: 0.1,
            ..options
        };
        let mut run = BenchmarkRun::new(Application::Body, &guess(1.0), &options);
        let result = played(&mut run, |_| 3.0);
        assert!(!run.is_certain() && run.frames() == 1 && result.grades.len() == 1);
    }

    #[test]
    fn a_frame_that_was_not_asked_for_is_left_out() {
        let mut run = BenchmarkRun::new(Application::Body, &guess(1.0), &Default::default());
        let asked = run.next_grade().unwrap();
        let other = Grade::of(Application::Body, (asked.number + 1) % GRADES);
        run.record(&other, 1.0);
        assert_eq!((run.frames(), run.next_grade()), (0, Some(asked)));
        assert_eq!(run.result(), None);
    }
}
