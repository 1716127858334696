//! `articula completions SHELL`: what the shell needs to complete commands and flags.

use crate::arguments::CommandLine;
use crate::console;
use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Prints the script.
pub(crate) fn run(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(
        args.shell,
        &mut CommandLine::command(),
        "articula",
        &mut script,
    );
    console::print(&String::from_utf8(script).context("the completions are no text")?)
}
