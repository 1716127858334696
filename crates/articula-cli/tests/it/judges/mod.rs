//! Runs the scripts of the folder `oracle` in node; without node, prints what is skipped.
#![allow(
    dead_code,
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "each test file uses a part of it, hands files over, says what it skips, may panic"
)]

pub(crate) mod browser;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Output of a script of the folder `oracle`, and whether it succeeded.
pub(crate) fn ask(script: &str, words: &[String]) -> (String, bool) {
    let output = Command::new("node")
        .arg(oracle_folder().join(script))
        .args(words)
        .output();
    answer_of(output.unwrap())
}

/// The same for a script that reads its job from standard input.
pub(crate) fn ask_on(script: &str, job: &str) -> (String, bool) {
    ask_on_words(script, &[], job)
}

/// The same with arguments.
pub(crate) fn ask_on_words(script: &str, words: &[String], job: &str) -> (String, bool) {
    let mut node = Command::new("node")
        .arg(oracle_folder().join(script))
        .args(words)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = node.stdin.take().unwrap();
    input.write_all(job.as_bytes()).unwrap();
    drop(input);
    answer_of(node.wait_with_output().unwrap())
}

fn answer_of(output: Output) -> (String, bool) {
    let mut text = String::from_utf8(output.stdout).unwrap();
    text.push_str(&String::from_utf8_lossy(&output.stderr));
    (text, output.status.success())
}

fn oracle_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../oracle")
}

pub(crate) fn is_required(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|v| v == "1")
}

/// Whether node is installed, which suffices for scripts without packages; prints it if not.
pub(crate) fn node_is_here() -> bool {
    let here = is_here("node", "--version");
    assert!(here || !is_required("ARTICULA_REQUIRE_TOOLS"), "no node");
    here
}

/// Whether a program can be started; prints it if not. A test needs it nowhere.
pub(crate) fn is_here(program: &str, question: &str) -> bool {
    let here = starts(program, question);
    if !here {
        println!("skipped: no {program}");
    }
    here
}

fn starts(program: &str, question: &str) -> bool {
    Command::new(program).arg(question).output().is_ok()
}

/// Whether node and the packages of the scripts are installed (`cargo xtask test` installs them).
pub(crate) fn judges_are_here() -> bool {
    let packages = [
        "@lottiefiles/dotlottie-web",
        "gltf-validator",
        "lottie-web",
        "meshoptimizer",
        "playwright-core",
        "three",
        "x_ite",
    ];
    let packages = packages.map(|name| oracle_folder().join("node_modules").join(name));
    let packages = packages.iter().all(|folder| folder.is_dir());
    let here = packages && starts("node", "--version");
    assert!(
        here || !is_required("ARTICULA_REQUIRE_TOOLS"),
        "no node oracle"
    );
    if !here {
        println!("skipped: node oracle (no node, or `npm ci` was not run in oracle)");
    }
    here
}
