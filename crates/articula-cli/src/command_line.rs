//! The top level of the command line.

use crate::commands::{
    adapt, bench, build, completions, convert, crowd, demo, flatten, gbsd, human, inspect, lod,
    optimize, package, play, serve, speak,
};
use crate::console::{Answer, Console, Progress};
use articula::fs::Existing;
use clap::{CommandFactory, Parser, Subcommand};

/// Animates virtual humans at the level of detail that the viewer can see.
#[derive(Debug, Parser)]
#[command(name = "articula", version, max_term_width = 100)]
#[command(arg_required_else_help = true, subcommand_required = true)]
#[command(after_help = "Exit status: 0 done, 1 faulty input or environment, 2 wrong usage.")]
pub(crate) struct CommandLine {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print the result as JSON; units are part of the field names
    #[arg(long, global = true, display_order = 900)]
    pub(crate) json: bool,
    /// Replace output files that exist; inputs are never replaced
    #[arg(long, global = true, display_order = 899)]
    pub(crate) force: bool,
    /// Hide progress bars, which otherwise show on a terminal
    #[arg(long, short, global = true, display_order = 901)]
    pub(crate) quiet: bool,
}

impl CommandLine {
    /// The console that these flags ask for.
    pub(crate) fn console(&self) -> Console {
        let answer = if self.json {
            Answer::Json
        } else {
            Answer::Text
        };
        let progress = if self.quiet {
            Progress::Hidden
        } else {
            Progress::Shown
        };
        let existing = if self.force {
            Existing::Replaced
        } else {
            Existing::Kept
        };
        Console::new(answer, progress, existing)
    }
}

/// The commands, in the order in which a new user meets them.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run all steps on the built-in reference human and write an HTML report
    Demo(demo::DemoArgs),
    /// Show the contents of a file and warn about irregularities
    Inspect(inspect::InspectArgs),
    /// Convert between formats, retarget, clean or reduce animations
    Convert(convert::ConvertArgs),
    /// Make a face speak: a recording as blend shapes, visemes or facial animation parameters
    Speak(speak::SpeakArgs),
    /// Write the procedural reference human as GLB
    Human(human::HumanArgs),
    /// Prepare an asset: store articulation, motion tables and mesh levels in a GLB
    Build(build::BuildArgs),
    /// Write characters in fewer bytes, at an error in motion that is measured on what is written
    Optimize(optimize::OptimizeArgs),
    /// Play a clip under motion level of detail; report the updates saved and the error in pixels
    Lod(Box<lod::LodArgs>),
    /// Simulate a crowd of one character; report frame time, memory and error in pixels
    Crowd(crowd::CrowdArgs),
    /// Convert an animated character to 2D: animated SVG, Lottie, talking portrait, still picture
    Flatten(flatten::FlattenArgs),
    /// Package a character as a digital item: a folder of streams that can be cut, with their errors
    Package(package::PackageArgs),
    /// Cut a digital item to what network, device, viewer and view allow, with the least visible error
    Adapt(adapt::AdaptArgs),
    /// Serve a folder of characters over HTTP as digital items, from the first stage of packaging on
    Serve(serve::ServeArgs),
    /// Show a served character in the terminal while it arrives; report times and bytes
    Play(play::PlayArgs),
    /// Measure what this device can play, and send the result to a server
    Bench(bench::BenchArgs),
    /// Print the description of a stream after MPEG-21 (gBSD), or the stylesheet that adapts it
    Gbsd(gbsd::GbsdArgs),
    /// Print a completion script for a shell
    Completions(completions::CompletionsArgs),
}

impl Command {
    /// Runs the command.
    pub(crate) fn run(&self, console: &Console) -> anyhow::Result<()> {
        match self {
            Self::Demo(args) => demo::run(args, console),
            Self::Inspect(args) => inspect::run(args, console),
            Self::Convert(args) => convert::run(args, console),
            Self::Speak(args) => speak::run(args, console),
            Self::Human(args) => human::run(args, console),
            Self::Build(args) => build::run(args, console),
            Self::Optimize(args) => optimize::run(args, console),
            Self::Lod(args) => lod::run(args, console),
            Self::Crowd(args) => crowd::run(args, console),
            Self::Flatten(args) => flatten::run(args, console),
            Self::Package(args) => package::run(args, console),
            Self::Adapt(args) => adapt::run(args, console),
            Self::Serve(args) => serve::run(args, console),
            Self::Play(args) => play::run(args, console),
            Self::Bench(args) => bench::run(args, console),
            Self::Gbsd(args) => gbsd::run(args, console),
            Self::Completions(args) => completions::run(args, CommandLine::command(), console),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        CommandLine::command().debug_assert();
    }
}
