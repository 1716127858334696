//! `cargo xtask test`: all checks of CI, row by row; the steps of a row run in parallel.
//!
//! All checks share one build and all tests another, because on two cores most of the time is spent
//! on compiling.

use crate::chores::{cargo, root, run, tidy};
use crate::outcome::Outcome;
use crate::{dependencies, neon, node, wasm};
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// One step: its displayed name and its function.
type Step = (&'static str, fn() -> Result<Outcome>);

/// The steps in order; those of one row run in parallel, as they wait for different resources. **A
/// new step is one line here and one function below.**
const STEPS: &[&[Step]] = &[
    &[("format", format)],
    &[
        ("clippy", clippy),
        ("dependencies", dependencies::check),
        ("oracle packages", node::install),
        ("oracle browser", node::browser),
    ],
    &[
        ("build of the tests", build_tests),
        ("oracle self-test", node::self_test),
    ],
    &[
        ("unit tests", unit_tests),
        ("other tests", other_tests),
        ("tests of the program", program_tests),
    ],
    &[
        ("examples", examples),
        ("documentation", documentation),
        ("wasm build", wasm::check),
        ("tidy", tidy_step),
        ("cut alone", cut_alone),
    ],
    &[
        ("playback in node", wasm::playback),
        ("neon under emulation", neon::check),
    ],
];

/// Runs the rows up to the first with a failure and prints the duration of each step.
pub(crate) fn test() -> Result<()> {
    let begin = Instant::now();
    let mut times = Vec::new();
    for row in STEPS {
        let ended: Vec<Result<f64>> = std::thread::scope(|scope| {
            let started: Vec<_> = row
                .iter()
                .map(|step| scope.spawn(move || timed(step)))
                .collect();
            let ended = started.into_iter().map(|step| step.join());
            ended
                .map(|e| e.unwrap_or_else(|_| bail!("a step panicked")))
                .collect()
        });
        for ((name, _), secs) in row.iter().zip(ended) {
            times.push((
                name,
                secs.with_context(|| format!("step \"{name}\" failed"))?,
            ));
        }
    }
    println!();
    for (name, secs) in times {
        println!("{secs:7.1} s  {name}");
    }
    let total = begin.elapsed().as_secs_f64();
    println!("{total:7.1} s  all steps passed");
    Ok(())
}

/// Runs a step and prints its outcome; returns its duration in seconds.
fn timed((name, step): &Step) -> Result<f64> {
    println!("== {name}");
    let start = Instant::now();
    let outcome = step();
    let secs = start.elapsed().as_secs_f64();
    match outcome {
        Ok(Outcome::Done) => println!("== {name}: done in {secs:.1} s"),
        Ok(Outcome::Skipped(why)) => println!("skipped: {why}"),
        Err(fault) => {
            println!("== {name}: failed after {secs:.1} s");
            return Err(fault);
        }
    }
    Ok(secs)
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
    run(cargo().args(["test", "--workspace", "--no-run"]))?;
    Ok(Outcome::Done)
}

/// Runs the unit tests of libraries and programs, and the doctests.
fn unit_tests() -> Result<Outcome> {
    run(cargo().args(["test", "--workspace", "--lib", "--bins"]))?;
    run(cargo().args(["test", "--workspace", "--doc"]))?;
    Ok(Outcome::Done)
}

/// Runs the integration tests, without those of the command line.
fn other_tests() -> Result<Outcome> {
    // The output of passing tests is not shown, so skipped data is reported here.
    if !data_folder().is_dir() {
        println!("skipped: no data (tests on real characters; set ARTICULA_DATA)");
    }
    let but = ["--exclude", PROGRAM, "--test", "*"];
    run(cargo().args(["test", "--workspace"]).args(but))?;
    Ok(Outcome::Done)
}

/// Package of the command line.
const PROGRAM: &str = "articula-cli";

/// Runs the tests of the command line, which take as long as those of all libraries together. They
/// are started without cargo: `cargo test --package` would rebuild everything with the features of
/// this package alone.
fn program_tests() -> Result<Outcome> {
    let words = ["test", "--workspace", "--no-run", "--message-format=json"];
    let built = cargo().args(words).stderr(Stdio::null()).output()?;
    anyhow::ensure!(built.status.success(), "the tests do not build");
    let folder = root().join("crates").join(PROGRAM);
    let tests = test_program(&String::from_utf8_lossy(&built.stdout), &folder)
        .context("cargo reported no test program of articula-cli")?;
    run(Command::new(tests).current_dir(folder))?;
    Ok(Outcome::Done)
}

/// Returns the executable of a package's only test program, from the messages of cargo.
fn test_program(messages: &str, package: &Path) -> Option<PathBuf> {
    let manifest = package.join("Cargo.toml");
    let messages = messages.lines().map(serde_json::from_str::<Value>);
    let mut programs = messages.flatten().filter(|message| {
        let is_test = message["target"]["kind"][0] == "test";
        is_test && message["manifest_path"].as_str().map(Path::new) == Some(&manifest)
    });
    programs.next()?["executable"].as_str().map(PathBuf::from)
}

fn data_folder() -> PathBuf {
    let given = std::env::var_os("ARTICULA_DATA").map(PathBuf::from);
    given.unwrap_or_else(|| root().join("../shared/data"))
}

fn documentation() -> Result<Outcome> {
    let words = ["doc", "--workspace", "--no-deps", "--quiet"];
    run(cargo().args(words).env("RUSTDOCFLAGS", "-D warnings"))?;
    Ok(Outcome::Done)
}

/// Runs the tests of cuts and descriptions with a library that has no codec.
fn cut_alone() -> Result<Outcome> {
    let words = [
        "test",
        "--quiet",
        "-p",
        "articula-stream",
        "--no-default-features",
    ];
    let tests = ["--test", "cut_alone", "--test", "descriptions_alone"];
    run(cargo().args(words).args(tests))?;
    Ok(Outcome::Done)
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
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let built = target.unwrap_or_else(|| root().join("target"));
    for (files, names) in [
        (&[][..], &["crowd", "describe", "hero"][..]),
        (&FILES, &["crowd", "hero"]),
    ] {
        for example in names {
            let program = built.join("debug/examples").join(example);
            let ran = Command::new(program)
                .args(files)
                .current_dir(root())
                .output()?;
            anyhow::ensure!(
                ran.status.success(),
                "{example} {files:?}: {}",
                String::from_utf8_lossy(&ran.stderr)
            );
        }
    }
    Ok(Outcome::Done)
}
