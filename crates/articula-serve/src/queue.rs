//! Jobs that wait for a thread, each of which one thread has at a time.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Jobs in the order in which they came.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    jobs: Mutex<Jobs>,
    /// A job came, or one is done.
    news: Condvar,
}

#[derive(Debug, Default)]
struct Jobs {
    waiting: VecDeque<String>,
    /// Those that threads have.
    taken: BTreeSet<String>,
}

impl Queue {
    /// Adds a job at the end, also one that a thread has: it may have read what was there before.
    pub(crate) fn push(&self, job: String) {
        let mut jobs = self.lock();
        jobs.waiting.retain(|other| *other != job);
        jobs.waiting.push_back(job);
        self.news.notify_one();
    }

    /// Takes the next job that no other thread has; blocks until there is one, or `is_over`.
    pub(crate) fn take(&self, is_over: impl Fn() -> bool) -> Option<String> {
        let mut jobs = self.lock();
        while !is_over() {
            let Jobs { waiting, taken } = &mut *jobs;
            let next = waiting.iter().position(|job| !taken.contains(job));
            if let Some(job) = next.and_then(|next| waiting.remove(next)) {
                taken.insert(job.clone());
                return Some(job);
            }
            jobs = self.news.wait(jobs).unwrap_or_else(PoisonError::into_inner);
        }
        None
    }

    /// Gives a job back that was taken.
    pub(crate) fn done(&self, job: &str) {
        self.lock().taken.remove(job);
        self.news.notify_all();
    }

    /// Wakes who waits for a job.
    pub(crate) fn wake(&self) {
        let _jobs = self.lock();
        self.news.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Jobs> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn a_job_is_with_one_thread_at_a_time_and_no_place_is_lost() {
        let queue = Queue::default();
        let take = || queue.take(|| false).unwrap();
        for job in ["a", "b", "a"] {
            queue.push(job.to_owned());
        }
        // The second time it came it goes behind the other one.
        assert_eq!(take(), "b");
        queue.push("b".to_owned());
        assert_eq!(take(), "a");
        // Another thread has it, so that this one waits until it is done.
        let again = std::thread::scope(|scope| {
            let other = scope.spawn(take);
            queue.done("b");
            other.join().unwrap()
        });
        assert_eq!(again, "b");
    }

    #[test]
    fn who_waits_is_woken_at_the_end() {
        let (queue, is_over) = (Queue::default(), AtomicBool::new(false));
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| queue.take(|| is_over.load(Ordering::Acquire)));
            is_over.store(true, Ordering::Release);
            queue.wake();
            assert_eq!(waiting.join().unwrap(), None);
        });
    }
}
