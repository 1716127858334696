//! `articula completions SHELL`: prints a completion script.

use crate::console::Console;
use anyhow::Context;
use clap::{Args, Command};
use clap_complete::Shell;
use serde::Serialize;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell to complete for
    shell: Shell,
}

#[derive(Debug, Serialize)]
struct CompletionsReport {
    shell: String,
    script: String,
}

/// Prints the script.
pub(crate) fn run(
    args: &CompletionsArgs,
    mut program: Command,
    console: &Console,
) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "articula", &mut script);
    let report = CompletionsReport {
        shell: args.shell.to_string(),
        script: String::from_utf8(script).context("the completion script is not UTF-8")?,
    };
    console.result(&report, |report| report.script.clone())
}
