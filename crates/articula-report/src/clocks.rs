//! The clocks by which the programs time what they report.

use articula::crowd::FrameClocks;
use std::sync::OnceLock;
use std::time::Instant;

/// The clocks of this process.
pub const FRAME_CLOCKS: FrameClocks<'static> = FrameClocks {
    thread_ns: &thread_ns,
    wall_ns: &wall_ns,
};

/// Returns the processor time of this thread in nanoseconds; the wall-clock time where a system has no
/// equally precise time of a thread.
pub fn thread_ns() -> u64 {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        // Neither part of a thread's processor time is ever negative.
        time.tv_sec.unsigned_abs() * 1_000_000_000 + time.tv_nsec.unsigned_abs()
    }
    #[cfg(not(unix))]
    wall_ns()
}

/// Runs a closure once; returns its wall-clock time in nanoseconds.
pub fn nanoseconds(run: &mut dyn FnMut()) -> f64 {
    let start = wall_ns();
    run();
    (wall_ns() - start) as f64
}

/// Wall-clock time since the first call, nanoseconds.
#[allow(
    clippy::disallowed_methods,
    reason = "the one clock of the programs' reports"
)]
fn wall_ns() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_works_takes_time() {
        let before = thread_ns();
        let mut sum = 0u64;
        for i in 0..2_000_000u64 {
            sum = std::hint::black_box(sum.wrapping_mul(31).wrapping_add(i));
        }
        assert!(thread_ns() > before, "{sum}");
    }
}
