//! Progress, cancellation and parallel execution of long operations, controlled by the caller.
//!
//! No function here starts a thread: work that can be split is passed to the caller as a slice of
//! [`Job`]s, whose results do not depend on order or thread.

use crate::error::{Error, Result};
use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Progress of one step of a long operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// The step in words, such as `making motion tables`.
    pub what: &'static str,
    /// Number of finished parts.
    pub done: usize,
    /// Total number of parts.
    pub of: usize,
}

/// One independent piece of a long operation.
pub struct Job<'a>(Option<Box<dyn FnOnce() + Send + 'a>>);

impl Job<'_> {
    /// Runs the job; a second call does nothing.
    pub fn run(&mut self) {
        if let Some(work) = self.0.take() {
            work();
        }
    }
}

impl fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Job").field(&self.0.is_some()).finish()
    }
}

/// Callback after each part of a step; `Break` stops the work with [`Error::Cancelled`].
pub type StepCallback<'a> = &'a (dyn Fn(Step) -> ControlFlow<()> + Sync);

/// Callback that runs all given jobs, on any threads.
pub type JobRunner<'a> = &'a (dyn Fn(&mut [Job<'_>]) + Sync);

/// Reports progress, allows cancellation and runs jobs. The default reports nothing and runs jobs
/// one after the other.
///
/// ```
/// use articula::{Executor, Step};
/// use std::ops::ControlFlow;
///
/// let say = |step: Step| {
///     eprintln!("{} {}/{}", step.what, step.done, step.of);
///     ControlFlow::Continue(())
/// };
/// let work = Executor::default().on_step(&say);
/// let on_threads = Executor::default().run_jobs(&|jobs| {
///     std::thread::scope(|threads| {
///         for job in jobs {
///             threads.spawn(|| job.run());
///         }
///     });
/// });
/// # let _ = (work, on_threads);
/// ```
#[derive(Clone, Copy, Default)]
pub struct Executor<'a> {
    on_step: Option<StepCallback<'a>>,
    run_jobs: Option<JobRunner<'a>>,
}

impl fmt::Debug for Executor<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Work")
            .field("on_step", &self.on_step.is_some())
            .field("run_jobs", &self.run_jobs.is_some())
            .finish()
    }
}

impl<'a> Executor<'a> {
    /// Sets the callback that receives progress.
    #[must_use]
    pub fn on_step(self, on_step: StepCallback<'a>) -> Self {
        Self {
            on_step: Some(on_step),
            ..self
        }
    }

    /// Sets the callback that runs the jobs; without it they run one after the other.
    #[must_use]
    pub fn run_jobs(self, run_jobs: JobRunner<'a>) -> Self {
        Self {
            run_jobs: Some(run_jobs),
            ..self
        }
    }

    /// Tells of a step of work that the caller does itself.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the callback asks to stop.
    pub fn step(&self, what: &'static str, done: usize, of: usize) -> Result<()> {
        let step = Step { what, done, of };
        match self.on_step.map(|tell| tell(step)) {
            Some(ControlFlow::Break(())) => Err(Error::Cancelled),
            _ => Ok(()),
        }
    }

    /// Runs `make` with a progress hook that takes a fraction and reports it in hundredths.
    #[cfg(feature = "flat")]
    pub(crate) fn with_progress<T>(
        &self,
        what: &'static str,
        make: impl FnOnce(&mut articula_core::Progress<'_>) -> T,
    ) -> T {
        const HUNDRED: usize = 100;
        let mut hook = |share: f32| {
            let done = (HUNDRED as f32 * share.clamp(0.0, 1.0)) as usize;
            match self.step(what, done, HUNDRED) {
                Ok(()) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            }
        };
        make(&mut articula_core::Progress::new(&mut hook))
    }

    /// Runs functions as jobs, without reporting them.
    pub(crate) fn run<F: FnOnce() + Send>(&self, functions: impl Iterator<Item = F>) {
        let jobs = functions.map(|function| Job(Some(Box::new(function))));
        let mut jobs: Vec<Job<'_>> = jobs.collect();
        if let Some(run) = self.run_jobs {
            run(&mut jobs);
        }
        // Runs the jobs that the caller did not run, or all of them without a callback.
        jobs.iter_mut().for_each(Job::run);
    }

    /// Applies `make` to each item, one job per item; results are in the order of the items.
    pub(crate) fn map<T: Send, R: Send>(
        &self,
        what: &'static str,
        items: Vec<T>,
        make: impl Fn(T) -> Result<R> + Sync,
    ) -> Result<Vec<R>> {
        let of = items.len();
        self.step(what, 0, of)?;
        let done = AtomicUsize::new(0);
        let is_cancelled = AtomicBool::new(false);
        let mut results: Vec<Result<R>> = items.iter().map(|_| Err(Error::Cancelled)).collect();
        let (make, done, is_cancelled) = (&make, &done, &is_cancelled);
        let job = |(item, result): (T, &'_ mut Result<R>)| {
            if is_cancelled.load(Ordering::Relaxed) {
                return;
            }
            *result = make(item);
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if self.step(what, count, of).is_err() {
                is_cancelled.store(true, Ordering::Relaxed);
            }
        };
        let job = &job;
        let pairs = items.into_iter().zip(&mut results);
        self.run(pairs.map(|pair| move || job(pair)));
        if is_cancelled.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        results.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_their_order_whoever_runs_the_jobs() {
        let items = || (0..20u32).collect::<Vec<_>>();
        let square = |x: u32| Ok(x * x);
        let expected: Vec<u32> = (0..20).map(|x| x * x).collect();
        let plain = Executor::default();
        assert_eq!(plain.map("x", items(), square).unwrap(), expected);
        let backwards = |jobs: &mut [Job<'_>]| jobs.iter_mut().rev().skip(3).for_each(Job::run);
        let work = Executor::default().run_jobs(&backwards);
        assert_eq!(work.map("x", items(), square).unwrap(), expected);
        let threads = |jobs: &mut [Job<'_>]| {
            std::thread::scope(|scope| {
                for job in jobs {
                    scope.spawn(|| job.run());
                }
            });
        };
        let work = Executor::default().run_jobs(&threads);
        assert_eq!(work.map("x", items(), square).unwrap(), expected);
    }

    #[test]
    fn a_break_stops_the_work() {
        let made = AtomicUsize::new(0);
        let stop = |step: Step| match step.done {
            5 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let work = Executor::default().on_step(&stop);
        let count = |_: u32| Ok(made.fetch_add(1, Ordering::Relaxed));
        let result = work.map("x", (0..20).collect(), count);
        assert!(matches!(result, Err(Error::Cancelled)));
        assert_eq!(made.into_inner(), 5);
    }
}
