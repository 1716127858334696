//! The shape of the command line.

use crate::commands::{build, completions, convert, crowd, demo, flatten, human, inspect, lod};
use crate::console::{Answer, Console, Progress};
use clap::{Parser, Subcommand};

/// Author a virtual human once; animate it at the detail that the viewer can see.
#[derive(Debug, Parser)]
#[command(
    name = "articula",
    version,
    propagate_version = true,
    max_term_width = 100
)]
#[command(arg_required_else_help = true, subcommand_required = true)]
#[command(after_help = "Exit status: 0 done, 1 the input or the world is bad, 2 wrong usage.")]
pub(crate) struct CommandLine {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print the result as JSON, with units in the field names
    #[arg(long, global = true, display_order = 900)]
    pub(crate) json: bool,
    /// Show no progress bars (they show on a terminal only)
    #[arg(long, short, global = true, display_order = 901)]
    pub(crate) quiet: bool,
}

impl CommandLine {
    /// How the user wants to be talked to.
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
        Console::new(answer, progress)
    }
}

/// The commands, in the order in which a newcomer meets them.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run the main job on the embedded reference human and write a page about it
    Demo(demo::DemoArgs),
    /// Say what is in a file, and what is odd about it
    Inspect(inspect::InspectArgs),
    /// Convert between formats, or save a reduced animation
    Convert(convert::ConvertArgs),
    /// Write the procedural reference human
    Human(human::HumanArgs),
    /// Prepare an asset: articulation and motion tables go into the GLB
    Build(build::BuildArgs),
    /// Play a clip under motion level of detail; report what it saves and what it costs
    Lod(lod::LodArgs),
    /// Run a crowd of one character; report what it costs and how far it is off, in pixels
    Crowd(crowd::CrowdArgs),
    /// Turn a character in motion into 2D: animated SVG, Lottie, a talking portrait, stills
    Flatten(flatten::FlattenArgs),
    /// Print completions for a shell
    Completions(completions::CompletionsArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        CommandLine::command().debug_assert();
    }
}
