//! One module per command; a command reads files, calls the libraries and prints the result.

pub(crate) mod adapt;
pub(crate) mod build;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod crowd;
pub(crate) mod demo;
pub(crate) mod flatten;
pub(crate) mod gbsd;
pub(crate) mod human;
pub(crate) mod inspect;
pub(crate) mod lod;
pub(crate) mod package;

use crate::command_line::{Command, CommandLine};
use crate::console::Console;
use clap::CommandFactory;

/// Runs one command.
pub(crate) fn run(command: &Command, console: &Console) -> anyhow::Result<()> {
    match command {
        Command::Demo(args) => demo::run(args, console),
        Command::Inspect(args) => inspect::run(args, console),
        Command::Convert(args) => convert::run(args, console),
        Command::Human(args) => human::run(args, console),
        Command::Build(args) => build::run(args, console),
        Command::Lod(args) => lod::run(args, console),
        Command::Crowd(args) => crowd::run(args, console),
        Command::Flatten(args) => flatten::run(args, console),
        Command::Package(args) => package::run(args, console),
        Command::Adapt(args) => adapt::run(args, console),
        Command::Gbsd(args) => gbsd::run(args, console),
        Command::Completions(args) => completions::run(args, CommandLine::command(), console),
    }
}
