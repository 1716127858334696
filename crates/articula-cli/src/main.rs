//! The command-line program of Articula: parses arguments, runs one command, prints the result.
//!
//! Exit status: 0 done, 1 an input or the environment is faulty, 2 wrong usage. Results go to
//! standard output, everything else to standard error; an error is one line there.
#![allow(
    clippy::disallowed_methods,
    reason = "the program is where files are opened and the clock is read"
)]

mod arguments;
mod command_line;
mod commands;
mod console;
mod fault;
mod files;
mod open;
mod parts_table;
mod play;
mod selection;
mod table;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let line = command_line::CommandLine::parse();
    let console = line.console();
    match line.command.run(&console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            console.fault(&fault);
            ExitCode::from(fault::status(&fault))
        }
    }
}
