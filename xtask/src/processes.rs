//! Calls of other programs, with the processor time that they take.

use anyhow::{Context, Result, bail, ensure};
use std::cell::Cell;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;
use wait4::Wait4;

thread_local! {
    /// Processor time of the programs that this thread has waited for, their own children included.
    static PROCESSOR: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

/// Returns the processor time of the programs that this thread has waited for, since the last call.
pub(crate) fn take_processor_time() -> Duration {
    PROCESSOR.take()
}

/// Adds what programs took that another thread has waited for on behalf of this one.
pub(crate) fn add_processor_time(time: Duration) {
    PROCESSOR.set(PROCESSOR.get() + time);
}

/// Runs a program in the current terminal; an unsuccessful exit is an error.
pub(crate) fn run(call: &mut Command) -> Result<()> {
    let status = wait(start(call)?)?;
    ensure_success(call, status)
}

/// Runs a program and gives each line of its standard output to `line` as it comes; returns how it
/// ended.
pub(crate) fn run_lines(call: &mut Command, mut line: impl FnMut(&str)) -> Result<ExitStatus> {
    let mut child = start(call.stdout(Stdio::piped()))?;
    let said = child.stdout.take().context("no output")?;
    for text in BufReader::new(said).split(b'\n') {
        line(&String::from_utf8_lossy(&text?));
    }
    wait(child)
}

/// Runs a program and returns its standard output, without the spaces at both ends; an unsuccessful
/// exit is an error with everything it printed.
pub(crate) fn output(call: &mut Command) -> Result<String> {
    let mut child = start(call.stdout(Stdio::piped()).stderr(Stdio::piped()))?;
    let faults = child.stderr.take().context("no error output")?;
    let read = |mut from: Box<dyn Read + Send>| {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).map(|_| bytes)
    };
    let faults = std::thread::spawn(move || read(Box::new(faults)));
    let said = read(Box::new(child.stdout.take().context("no output")?))?;
    let Ok(faults) = faults.join() else {
        bail!("the reader of a program's faults panicked");
    };
    let status = wait(child)?;
    let [said, faults] = [said, faults?].map(|text| String::from_utf8_lossy(&text).into_owned());
    ensure!(status.success(), "{call:?}: {said}{faults}");
    Ok(said.trim().to_owned())
}

/// Returns the output of a program, or `None` if it cannot be started or fails.
pub(crate) fn answer(program: &str, words: &[&str]) -> Option<String> {
    output(Command::new(program).args(words)).ok()
}

/// An error if a program ended without success.
pub(crate) fn ensure_success(call: &Command, status: ExitStatus) -> Result<()> {
    let program = call.get_program().to_string_lossy();
    ensure!(status.success(), "{program} failed: {status}");
    Ok(())
}

fn start(call: &mut Command) -> Result<Child> {
    let child = call.spawn();
    child.with_context(|| format!("cannot start {}", call.get_program().to_string_lossy()))
}

fn wait(child: Child) -> Result<ExitStatus> {
    let ended = child.wait4()?;
    add_processor_time(ended.rusage.utime + ended.rusage.stime);
    Ok(ended.status)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_what_a_program_says_and_how_it_ends() {
        let shell = |words: &str| {
            let mut call = Command::new("sh");
            call.args(["-c", words]);
            call
        };
        assert_eq!(output(&mut shell("echo ' a b '")).unwrap(), "a b");
        let fault = output(&mut shell("echo out; echo err >&2; exit 3")).unwrap_err();
        assert!(fault.to_string().ends_with("out\nerr\n"), "{fault}");
        let mut lines = Vec::new();
        let status = run_lines(&mut shell("printf 'x\\ny'; exit 4"), |line| {
            lines.push(line.to_owned());
        });
        assert_eq!(
            (lines.join(","), status.unwrap().code()),
            ("x,y".to_owned(), Some(4))
        );
        assert!(answer("no such program", &[]).is_none());
    }

    #[test]
    fn counts_the_time_of_children_and_theirs() {
        take_processor_time();
        let busy = "i=0; while [ $i -lt 100000 ]; do i=$((i+1)); done";
        let inner = format!("sh -c '{busy}'; true");
        run(Command::new("sh").args(["-c", &inner])).unwrap();
        assert!(take_processor_time() > Duration::ZERO);
        assert_eq!(take_processor_time(), Duration::ZERO);
    }
}
