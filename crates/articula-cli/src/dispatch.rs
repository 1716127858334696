//! The command line to its command.

use crate::command_line::{Command, CommandLine};
use crate::commands::{
    adapt, build, completions, convert, crowd, demo, flatten, gbsd, human, inspect, lod, package,
};
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
