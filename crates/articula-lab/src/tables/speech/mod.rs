//! Visemes of a voice: how well they are heard, beside other libraries, and the training of the network
//! (docs/methods/speech.md).

mod augment;
mod corpus;
mod page;
mod peers;
mod recordings;
mod score;
mod systems;
mod text;
mod train;

use super::Run;
use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use corpus::{missing, spoken};
use std::path::PathBuf;

/// Which weights are judged, and on whom.
#[derive(Args)]
pub(crate) struct Choice {
    #[command(subcommand)]
    task: Option<Task>,
}

#[derive(Subcommand)]
enum Task {
    /// Judges weights on synthetic voices that no training heard and on recordings of people.
    Eval(Judged),
    /// Trains weights on synthetic speech (needs python3 with the library of espeak-ng, and flite).
    Train(Trained),
}

#[derive(Args, Default)]
struct Judged {
    /// A file of weights instead of those of the library.
    #[arg(long)]
    weights: Option<PathBuf>,
    /// A folder with recordings of people (`NAME.wav`) and the times of their phones (`NAME.lab` or
    /// `NAME.TextGrid`), as well as those of the repository.
    #[arg(long)]
    people: Option<PathBuf>,
}

#[derive(Args)]
struct Trained {
    /// The file of weights; a note beside it (`.json`) tells how it was made.
    output: PathBuf,
    /// Sentences of espeak-ng.
    #[arg(long, default_value_t = 3_000)]
    espeak: usize,
    /// Sentences of flite; each is taken twice, changed in other ways.
    #[arg(long, default_value_t = 1_000)]
    flite: usize,
    /// Numbers of a frame inside of the network.
    #[arg(long, default_value_t = 64)]
    width: usize,
    /// Steps of 16 sentences.
    #[arg(long, default_value_t = 10_000)]
    steps: usize,
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Writes the page, or trains.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    match &choice.task {
        Some(Task::Train(options)) => train(options),
        Some(Task::Eval(options)) => page::write(run, options),
        None => page::write(run, &Judged::default()),
    }
}

fn train(options: &Trained) -> Result<()> {
    if let Some(what) = missing() {
        println!("skipped: the training needs {what}");
        return Ok(());
    }
    let seed = options.seed;
    eprintln!("speaking {} sentences", options.espeak + options.flite);
    let espeak = spoken(corpus::TRAINING, options.espeak, seed)?;
    let flite = spoken(corpus::FLITE_TRAINING, options.flite, seed + 1)?;
    let hours = |clips: &[corpus::Clip]| {
        clips.iter().map(|c| c.sound.duration_secs()).sum::<f32>() / 3_600.0
    };
    let spoken_hours = [hours(&espeak), hours(&flite)];
    eprintln!(
        "{:.1} h of espeak-ng, {:.1} h of flite",
        spoken_hours[0], spoken_hours[1]
    );
    let plan = train::Plan {
        width: options.width,
        steps: options.steps,
        seed,
    };
    let steps = options.steps;
    let lessons = train::prepared(&[(espeak, 1), (flite, 2)], seed);
    let (network, loss) = train::fit(&lessons, plan, |step, loss| {
        if step % 50 == 0 || step == steps {
            eprintln!("step {step} of {steps}, loss {loss:.3}");
        }
    });
    let note = serde_json::json!({
        "width": options.width,
        "steps": steps,
        "seed": seed,
        "loss": loss,
        "hours": { "espeak-ng": spoken_hours[0], "flite": spoken_hours[1] },
        "versions": corpus::versions(),
    });
    let path = &options.output;
    std::fs::write(path, network.to_bytes()).with_context(|| path.display().to_string())?;
    let beside = path.with_extension("json");
    std::fs::write(&beside, format!("{note:#}\n")).with_context(|| beside.display().to_string())?;
    println!("{}\n{}", path.display(), beside.display());
    Ok(())
}
