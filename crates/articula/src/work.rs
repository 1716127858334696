//! How long work is followed, stopped and spread over threads, by the caller alone.
//!
//! Nothing here starts a thread: functions that can be split hand the caller a slice of [`Job`]s,
//! whose results do not depend on the order or the thread that they run on.

use crate::error::{Error, Result};
use articula_core::Progress;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Parts of a step that says how far it is as a share.
const HUNDRED: usize = 100;

/// How far a step has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// What is being done, such as `making motion tables`.
    pub what: &'static str,
    /// Parts that are done.
    pub done: usize,
    /// Parts in all.
    pub of: usize,
}

/// One independent piece of a longer work.
pub struct Job<'a>(Option<Box<dyn FnOnce() + Send + 'a>>);

impl Job<'_> {
    /// Does the piece; does nothing a second time.
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

/// What is called after every part of a step; `Break` stops the work with [`Error::Cancelled`].
pub type StepCallback<'a> = &'a (dyn Fn(Step) -> ControlFlow<()> + Sync);

/// Runs every job it is given, on whatever threads it likes.
pub type JobRunner<'a> = &'a (dyn Fn(&mut [Job<'_>]) + Sync);

/// How a long work reports, whether it may go on, and who runs its jobs.
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
    /// Reports every part of a step.
    #[must_use]
    pub fn on_step(self, on_step: StepCallback<'a>) -> Self {
        Self {
            on_step: Some(on_step),
            ..self
        }
    }

    /// Has the caller run the jobs; without it they run one after the other.
    #[must_use]
    pub fn run_jobs(self, run_jobs: JobRunner<'a>) -> Self {
        Self {
            run_jobs: Some(run_jobs),
            ..self
        }
    }

    /// Reports a part.
    pub(crate) fn step(&self, what: &'static str, done: usize, of: usize) -> Result<()> {
        let step = Step { what, done, of };
        match self.on_step.map(|tell| tell(step)) {
            Some(ControlFlow::Break(())) => Err(Error::Cancelled),
            _ => Ok(()),
        }
    }

    /// Hears the progress of a step that says how far it is as a share; in hundredths.
    pub(crate) fn with_progress<T>(
        &self,
        what: &'static str,
        make: impl FnOnce(&mut Progress<'_>) -> T,
    ) -> T {
        let mut hook = |share: f32| {
            let done = (HUNDRED as f32 * share.clamp(0.0, 1.0)) as usize;
            match self.step(what, done, HUNDRED) {
                Ok(()) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            }
        };
        make(&mut Progress::new(&mut hook))
    }

    /// Makes something of every item, each as a job of its own; results are in the items' order.
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
        let mut jobs: Vec<Job<'_>> = items
            .into_iter()
            .zip(&mut results)
            .map(|pair| Job(Some(Box::new(move || job(pair)))))
            .collect();
        if let Some(run) = self.run_jobs {
            run(&mut jobs);
        }
        // All of them if nobody else runs them, and those that were forgotten.
        jobs.iter_mut().for_each(Job::run);
        drop(jobs);
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
