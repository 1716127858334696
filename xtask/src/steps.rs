//! `cargo xtask test`: all checks of CI, row by row; the steps of a row run in parallel.
//!
//! All checks share one build and all tests another, because on two cores most of the time is spent
//! on compiling.

use crate::changed::Changed;
use crate::chores::tidy;
use crate::outcome::Outcome;
use crate::passed::Tested;
use crate::processes::{output, run, take_processor_time};
use crate::run_times::{RunTimes, StepTime};
use crate::test_programs::{self, TestTime};
use crate::workspace::{cargo, data_folder, root, target};
use crate::{cut_alone, dependencies, neon, node, playback, wasm, web_pages};
use anyhow::{Result, anyhow};
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

/// One check of CI.
struct Step {
    name: &'static str,
    /// Processor minutes that it may take from a cold clone, on one of CI's cores; what takes more is
    /// told.
    budget_minutes: f64,
    check: fn(&Run) -> Result<Outcome>,
}

/// What the steps of a run share.
struct Run {
    /// The crates whose tests run; all without it.
    changed: Option<Changed>,
    /// Times of all tests that have ended.
    tests: Mutex<Vec<TestTime>>,
}

const fn step(name: &'static str, budget_minutes: f64, check: fn(&Run) -> Result<Outcome>) -> Step {
    Step {
        name,
        budget_minutes,
        check,
    }
}

/// The steps in order; those of one row run in parallel, as they wait for different resources. **A
/// new step is one line here and one function below.**
const STEPS: &[&[Step]] = &[
    &[step("format", 0.2, |_| format())],
    &[
        step("clippy", 5.0, |_| clippy()),
        step("dependencies", 0.1, |_| dependencies::check()),
        step("oracle packages", 0.5, |_| node::install()),
        step("oracle browser", 0.1, |_| node::browser()),
        step("web packages", 0.5, |_| web_pages::install()),
    ],
    &[
        step("build of the tests", 15.0, |_| build_tests()),
        step("oracle self-test", 1.5, |_| node::self_test()),
    ],
    &[step("tests", 14.0, tests)],
    &[
        step("doctests", 1.0, |_| doctests()),
        step("examples", 0.5, |_| examples()),
        step("documentation", 1.5, |_| documentation()),
        step("wasm build", 2.0, |_| wasm::check()),
        step("tidy", 0.1, |_| tidy_step()),
        step("playback without codecs", 0.1, |_| playback::check()),
        step("cut alone", 2.0, cut_alone),
    ],
    &[
        step("playback in node", 3.0, |_| wasm::playback()),
        step("neon under emulation", 3.0, |_| neon::check()),
    ],
    &[step("pages", 3.0, |_| web_pages::check())],
];

/// Steps of `--changed`.
const STEPS_OF_A_CHANGE: &[&str] = &[
    "format",
    "clippy",
    "tidy",
    "build of the tests",
    "tests",
    "cut alone",
];

/// What was asked for.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct TestOptions {
    /// Run although the same tree has passed.
    again: bool,
    /// Check only what differs from this revision.
    changed: Option<String>,
}

impl TestOptions {
    /// Reads `[--again] [--changed [REV]]`; `None` for anything else.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        let mut options = Self::default();
        let mut words = words.iter().peekable();
        while let Some(word) = words.next() {
            match *word {
                "--again" => options.again = true,
                "--changed" => {
                    let revision = words.next_if(|word| !word.starts_with('-'));
                    options.changed = Some((*revision.unwrap_or(&"HEAD")).to_owned());
                }
                _ => return None,
            }
        }
        Some(options)
    }
}

/// Runs the rows up to the first with a failure and tells what each step took.
pub(crate) fn test(options: &TestOptions) -> Result<()> {
    let tested = Tested::now();
    let is_whole = options.changed.is_none();
    if is_whole && !options.again && tested.as_ref().is_some_and(Tested::has_passed) {
        println!("every step has passed on this tree; `cargo xtask test --again` runs them again");
        return Ok(());
    }
    let run = Run {
        changed: (options.changed.as_deref())
            .map(Changed::since)
            .transpose()?,
        tests: Mutex::new(Vec::new()),
    };
    if let Some(changed) = &run.changed {
        println!("{changed}");
    }
    let begin = Instant::now();
    let mut steps = Vec::new();
    let mut fault = None;
    for row in STEPS {
        for (time, failed) in run.row(row)? {
            let name = time.name;
            fault = fault.or(failed.map(|f| f.context(format!("step \"{name}\" failed"))));
            steps.push(time);
        }
        if fault.is_some() {
            break;
        }
    }
    let report = RunTimes::new(begin.elapsed(), steps, run.tests.into_inner()?);
    print!("{report}");
    report.write()?;
    if let Some(fault) = fault {
        return Err(fault);
    }
    if is_whole && !report.has_skipped() && tested == Tested::now() {
        tested.as_ref().map_or(Ok(()), Tested::record)?;
    }
    println!("all steps passed");
    Ok(())
}

impl Run {
    /// Runs the steps of a row side by side; returns what each took, and the fault of those that
    /// failed.
    fn row(&self, row: &'static [Step]) -> Result<Vec<(StepTime, Option<anyhow::Error>)>> {
        let asked = |step: &&Step| self.changed.is_none() || STEPS_OF_A_CHANGE.contains(&step.name);
        std::thread::scope(|scope| {
            let started: Vec<_> = (row.iter().filter(asked))
                .map(|step| scope.spawn(|| self.timed(step)))
                .collect();
            let ended = started.into_iter().map(|step| step.join());
            ended
                .map(|ended| ended.map_err(|_| anyhow!("a step panicked")))
                .collect()
        })
    }

    /// Runs a step and prints its outcome.
    fn timed(&self, step: &Step) -> (StepTime, Option<anyhow::Error>) {
        let name = step.name;
        println!("== {name}");
        let start = Instant::now();
        let ended = (step.check)(self);
        let wall_secs = start.elapsed().as_secs_f64();
        let processor_secs = take_processor_time().as_secs_f64();
        match &ended {
            Ok(Outcome::Done) => println!("== {name}: done in {wall_secs:.1} s"),
            Ok(Outcome::Skipped(why)) => println!("skipped: {why}"),
            Err(_) => println!("== {name}: failed after {wall_secs:.1} s"),
        }
        let time = StepTime {
            name,
            wall_secs,
            processor_secs,
            budget_secs: step.budget_minutes * 60.0,
            outcome: match &ended {
                Ok(Outcome::Done) => "done",
                Ok(Outcome::Skipped(_)) => "skipped",
                Err(_) => "failed",
            },
        };
        (time, ended.err())
    }
}

fn format() -> Result<Outcome> {
    run(cargo().args(["fmt", "--all", "--", "--check"]))?;
    Ok(Outcome::Done)
}

fn clippy() -> Result<Outcome> {
    let words = ["clippy", "--workspace", "--all-targets", "--quiet"];
    run(cargo().args(words).args(["--", "-D", "warnings"]))?;
    Ok(Outcome::Done)
}

fn build_tests() -> Result<Outcome> {
    test_programs::build()?;
    Ok(Outcome::Done)
}

/// Runs all test programs, or those of the crates that a change reaches.
fn tests(this: &Run) -> Result<Outcome> {
    // The output of passing tests is not shown, so skipped data is reported here.
    if !data_folder().is_dir() {
        println!("skipped: no data (tests on real characters; set ARTICULA_DATA)");
    }
    let mut programs = test_programs::build()?;
    if let Some(changed) = &this.changed {
        programs.retain(|program| changed.reaches(program.package()));
    }
    let times = test_programs::run_all(programs)?;
    *this.tests.lock().map_err(|_| anyhow!("a step panicked"))? = times;
    Ok(Outcome::Done)
}

fn doctests() -> Result<Outcome> {
    run(cargo().args(["test", "--workspace", "--doc", "--quiet"]))?;
    Ok(Outcome::Done)
}

fn documentation() -> Result<Outcome> {
    let words = ["doc", "--workspace", "--no-deps", "--quiet"];
    run(cargo().args(words).env("RUSTDOCFLAGS", "-D warnings"))?;
    Ok(Outcome::Done)
}

/// Runs the tests of streams without codecs, unless nothing of streams has changed.
fn cut_alone(this: &Run) -> Result<Outcome> {
    if (this.changed.as_ref()).is_some_and(|changed| !changed.reaches("articula-stream")) {
        return Ok(Outcome::Done);
    }
    cut_alone::check()
}

fn tidy_step() -> Result<Outcome> {
    tidy()?;
    Ok(Outcome::Done)
}

/// Runs the examples of the library's first page: on the reference human, and on characters of
/// `assets`, of which one has no clips and plays those of the other; that of descriptions on the
/// reference human alone. The library's tests run the same calls on every kind of file, where
/// vertices must move.
fn examples() -> Result<Outcome> {
    const FILES: [&str; 2] = [
        "assets/glb/Quaternius_modular_men__Worker.glb",
        "assets/glb/RobotExpressive.glb",
    ];
    // The tests have just built them.
    let built = target().join("debug/examples");
    for (files, names) in [
        (&[][..], &["crowd", "describe", "hero"][..]),
        (&FILES, &["crowd", "hero"]),
    ] {
        for example in names {
            let mut call = Command::new(built.join(example));
            output(call.args(files).current_dir(root()))?;
        }
    }
    Ok(Outcome::Done)
}
