//! The project's chores, run as `cargo xtask <chore>`.
//!
//! It depends on no crate of the workspace, so that a chore runs even if a crate does not compile.
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a program for the project's own developers: it prints, reads files and measures time"
)]

mod bench_web;
mod changed;
mod chores;
mod cut_alone;
mod dependencies;
mod fuzz;
mod heartbeat;
mod mutants;
mod neon;
mod node;
mod outcome;
mod passed;
mod pictures;
mod platform;
mod playback;
mod processes;
mod run_times;
mod steps;
mod studio;
mod test_compiler;
mod test_programs;
mod tidy;
mod wasm;
mod wasm_build;
mod web;
mod web_pages;
mod workspace;

use std::process::ExitCode;

const HELP: &str = "\
Developer tasks of the workspace.

Usage: cargo xtask <CHORE>

Chores:
  demo     Run the demo and print the path of its page (articula-demo/index.html); with Node, then open the studio
  studio   Build the release program with the studio inside, for `articula serve`; needs Node
  test     Run everything that CI runs, row by row, up to the first row with a failure
  tidy     Check what lints cannot: crate edges, file sizes, names, records
  golden   Rewrite the golden files, then list those that changed
  fuzz     Run the fuzz targets and renew their table (docs/results/fuzz.md)
  mutants  Count the changes of the code that no test notices (docs/results/mutants.md)
  web      Build the modules for web pages into web/packages/core/wasm and print their sizes
  bench-web  Time crowds in Chromium beside what else shows many characters in three.js
  pictures Rebuild the moving pictures of the readme and that of the reference human (docs/pictures); records the studio where Node and Chromium are

Options:
  -h, --help   Print this

Tests: cargo xtask test [--again] [--changed [REV]]
  Prints what each step took and the slowest tests, and writes target/xtask/steps.json. A tree that
  passed as a whole (target/xtask/passed) is not tested again, unless --again asks for it.
  --changed checks what differs from a revision (default HEAD) only: format, clippy, tidy and the
  tests of the crates that have changed and of those that use them.

Fuzzing: cargo xtask fuzz [--minutes M] [TARGET…]
  Runs each target (all without a name) for M minutes (default 1) on the nightly toolchain with
  cargo-fuzz, from seeds of ARTICULA_DATA and of the repository. Findings are kept in fuzz/artifacts
  and make the exit status 1.

Mutants: cargo xtask mutants [--module M]… [--sample N] [--seed S]
  Runs N random mutants (default 80) of each module, such as articula_core::crowd (all of the page
  without a name), with cargo-mutants in a copy of the tree. The seed (default 1) draws the sample.

Modules for web pages: cargo xtask web [--dev | --write]
  --dev builds them as the tests do, in less time and larger. --write renews docs/results/web-sizes.md.

Crowds in a page: cargo xtask bench-web [--write] [FILE…]
  Builds all that is needed, prepares the files (two of assets/glb without a name) and measures them.
  --write renews docs/results/web.md. Needs npm, and a registry for what web/package.json names.

Environment:
  CHROMIUM                  The browser's program (else chromium, chromium-browser, google-chrome)
  ARTICULA_DATA             Folder of real character files (else ../shared/data)
  ARTICULA_REQUIRE_DATA=1   A missing data file fails instead of being skipped
  ARTICULA_REQUIRE_TOOLS=1  A missing tool (node, Chromium, qemu, a target) fails instead of being skipped
";

fn main() -> ExitCode {
    if let Some(ended) = test_compiler::compile() {
        return ended;
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["demo"] => chores::demo(),
        ["test", ref rest @ ..] => match steps::TestOptions::parse(rest) {
            Some(options) => steps::test(&options),
            None => return usage(),
        },
        ["studio"] => chores::studio(),
        ["tidy"] => chores::tidy(),
        ["golden"] => chores::golden(),
        ["pictures"] => pictures::pictures(),
        ["fuzz", ref rest @ ..] => match fuzz::FuzzOptions::parse(rest) {
            Some(options) => fuzz::fuzz(&options),
            None => return usage(),
        },
        ["web", ref rest @ ..] => match web::WebOptions::parse(rest) {
            Some(options) => web::web(&options),
            None => return usage(),
        },
        ["bench-web", ref rest @ ..] => match bench_web::BenchOptions::parse(rest) {
            Some(options) => bench_web::bench(&options),
            None => return usage(),
        },
        ["mutants", ref rest @ ..] => match mutants::MutantOptions::parse(rest) {
            Some(options) => mutants::mutants(&options),
            None => return usage(),
        },
        ["-h" | "--help" | "help"] => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        _ => return usage(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("xtask: {fault:#}");
            ExitCode::FAILURE
        }
    }
}

fn usage() -> ExitCode {
    eprint!("{HELP}");
    ExitCode::from(2)
}
