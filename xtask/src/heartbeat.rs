//! Lines that tell that work goes on.

use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Time between two lines.
const HEARTBEAT: Duration = Duration::from_secs(8);

/// Does `work` and tells meanwhile how long it takes, unless there is a terminal, on which programs
/// show their progress themselves.
pub(crate) fn with_heartbeat<T>(what: &str, work: impl FnOnce() -> T) -> T {
    match std::io::stderr().is_terminal() {
        true => work(),
        false => told(what, work),
    }
}

/// Does `work`, of programs that are silent, and tells meanwhile how long it takes.
pub(crate) fn told<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let (working, is_done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            while is_done.recv_timeout(HEARTBEAT) == Err(RecvTimeoutError::Timeout) {
                println!("{what}: {} s so far", begin.elapsed().as_secs());
            }
        });
        let done = work();
        drop(working);
        done
    })
}
