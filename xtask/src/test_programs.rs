//! The test programs of the workspace: built once, run side by side, every test timed.
//!
//! They are started without cargo, which would run one after the other, and would build a package
//! again that is named alone, with the features of this package alone.

use crate::processes::{add_processor_time, ensure_success, run_lines, take_processor_time};
use crate::test_compiler;
use crate::workspace::cargo;
use anyhow::{Result, bail, ensure};
use serde::Serialize;
use serde_json::Value;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Test programs that take the longest, the longest first; they are started before the others.
const LONGEST: &[&str] = &[
    "articula-cli it",
    "articula-lab (bin)",
    "articula it",
    "articula-stream it",
];

/// One test program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TestProgram {
    package: String,
    /// Package and target, as `articula-core it`.
    name: String,
    executable: PathBuf,
    /// Folder in which its tests run.
    folder: PathBuf,
}

/// How long a test ran.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TestTime {
    /// Package and target of its program.
    pub(crate) program: String,
    pub(crate) test: String,
    pub(crate) secs: f64,
}

/// Builds the test programs of the workspace, and everything else that `cargo test` builds.
pub(crate) fn build() -> Result<Vec<TestProgram>> {
    let words = ["test", "--workspace", "--no-run", "--message-format"];
    let mut programs = Vec::new();
    let mut call = cargo();
    call.args(words).arg("json-render-diagnostics");
    let status = run_lines(test_compiler::wrap(&mut call)?, |message| {
        programs.extend(program_of(message))
    })?;
    ensure_success(&call, status)?;
    ensure!(!programs.is_empty(), "cargo reported no test programs");
    Ok(programs)
}

/// Reads a test program from a message of cargo.
fn program_of(message: &str) -> Option<TestProgram> {
    let message: Value = serde_json::from_str(message).ok()?;
    if message["profile"]["test"] != true {
        return None;
    }
    let executable = PathBuf::from(message["executable"].as_str()?);
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
    let package = folder.file_name()?.to_str()?;
    let target = &message["target"];
    // The unit tests of a library or program are in a target of its own kind.
    let of = match target["kind"][0].as_str()? {
        "test" => target["name"].as_str()?.to_owned(),
        kind => format!("({})", kind),
    };
    Some(TestProgram {
        package: package.to_owned(),
        name: format!("{package} {of}"),
        executable,
        folder: folder.to_path_buf(),
    })
}

impl TestProgram {
    /// Name of its package.
    pub(crate) fn package(&self) -> &str {
        &self.package
    }
}

/// Runs the programs, as many at a time as there are processors, the longest first; returns the
/// times of all tests. The output of a program is printed if it fails.
pub(crate) fn run_all(programs: Vec<TestProgram>) -> Result<Vec<TestTime>> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let waiting = Mutex::new(VecDeque::from(in_order(programs)));
    let next = || waiting.lock().ok()?.pop_front();
    let worker = || -> (Duration, Vec<Result<Vec<TestTime>>>) {
        let ran = std::iter::from_fn(next).map(|program| run_one(&program));
        let ran = ran.collect();
        (take_processor_time(), ran)
    };
    let ended: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..processors).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().map(|w| w.join()).collect()
    });
    let mut times = Vec::new();
    let mut faults = Vec::new();
    for worker in ended {
        let Ok((processor, ran)) = worker else {
            bail!("a worker panicked");
        };
        add_processor_time(processor);
        for ran in ran {
            match ran {
                Ok(of) => times.extend(of),
                Err(fault) => faults.push(format!("{fault:#}")),
            }
        }
    }
    ensure!(faults.is_empty(), "{}", faults.join("; "));
    Ok(times)
}

/// Sorts programs so that those of [`LONGEST`] come first.
fn in_order(mut programs: Vec<TestProgram>) -> Vec<TestProgram> {
    let place = |program: &TestProgram| {
        let found = LONGEST.iter().position(|name| *name == program.name);
        found.unwrap_or(LONGEST.len())
    };
    programs.sort_by_key(place);
    programs
}

/// Runs the tests of a program, one at a time.
fn run_one(program: &TestProgram) -> Result<Vec<TestTime>> {
    let name = &program.name;
    let mut call = Command::new(&program.executable);
    call.arg("--test-threads=1").current_dir(&program.folder);
    let begin = Instant::now();
    let mut said = Vec::new();
    let mut clock = TestClock::new(begin);
    let status = run_lines(&mut call, |line| {
        clock.line(line, Instant::now());
        said.push(line.to_owned());
    })?;
    let secs = begin.elapsed().as_secs_f64();
    let result = said.iter().rfind(|line| line.starts_with("test result:"));
    if let (true, Some(result)) = (status.success(), result) {
        println!("{name}: {result}");
    } else {
        println!("{}", said.join("\n"));
        bail!("{name} failed after {secs:.1} s: {status}");
    }
    let time = |(test, secs)| TestTime {
        program: name.clone(),
        test,
        secs,
    };
    Ok(clock.times.into_iter().map(time).collect())
}

/// Times tests that run one after the other by the lines that their program prints as they end:
/// libtest itself tells the time of a test on nightly toolchains alone.
struct TestClock {
    /// When the last test ended.
    last: Instant,
    times: Vec<(String, f64)>,
}

impl TestClock {
    fn new(begin: Instant) -> Self {
        Self {
            last: begin,
            times: Vec::new(),
        }
    }

    fn line(&mut self, line: &str, now: Instant) {
        if let Some(test) = ended_test(line) {
            let secs = now.duration_since(self.last).as_secs_f64();
            self.times.push((test.to_owned(), secs));
            self.last = now;
        }
    }
}

/// Returns the name of the test that a line says has ended.
fn ended_test(line: &str) -> Option<&str> {
    let (name, how) = line.strip_prefix("test ")?.split_once(" ... ")?;
    let ends = ["ok", "FAILED", "ignored"]
        .iter()
        .any(|end| how.starts_with(end));
    ends.then(|| name.trim_end_matches(" - should panic"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_which_tests_have_ended() {
        assert_eq!(ended_test("test a::b ... ok"), Some("a::b"));
        assert_eq!(ended_test("test a - should panic ... FAILED"), Some("a"));
        assert_eq!(ended_test("test a ... ignored, why"), Some("a"));
        assert_eq!(ended_test("test result: ok. 1 passed"), None);
        assert_eq!(ended_test("running 3 tests"), None);
    }

    #[test]
    fn a_test_takes_the_time_since_the_one_before() {
        let begin = Instant::now();
        let mut clock = TestClock::new(begin);
        let lines = [
            (1, "running 2 tests"),
            (2, "test a ... ok"),
            (5, "test b ... FAILED"),
        ];
        for (secs, line) in lines {
            clock.line(line, begin + Duration::from_secs(secs));
        }
        assert_eq!(clock.times, [("a".to_owned(), 2.0), ("b".to_owned(), 3.0)]);
    }

    #[test]
    fn reads_test_programs_from_the_messages_of_cargo() {
        let message = |test: bool, kind: &str| {
            serde_json::json!({
                "manifest_path": "/x/crates/some-crate/Cargo.toml",
                "executable": "/x/target/debug/deps/it-1",
                "profile": { "test": test },
                "target": { "kind": [kind], "name": "it" },
            })
            .to_string()
        };
        let found = program_of(&message(true, "test")).unwrap();
        assert_eq!(
            (found.package(), found.name.as_str()),
            ("some-crate", "some-crate it")
        );
        assert_eq!(found.folder, Path::new("/x/crates/some-crate"));
        assert_eq!(
            program_of(&message(true, "lib")).unwrap().name,
            "some-crate (lib)"
        );
        assert_eq!(program_of(&message(false, "bin")), None);
        assert_eq!(program_of("warning: not JSON"), None);
    }
}
