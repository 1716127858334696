//! `articula bench device`: plays graded content, a frame at a time.

use super::report::{BenchReport, Played};
use super::{hardware, send};
use crate::arguments::{ReadArgs, positive};
use crate::commands::server::Server;
use crate::console::Console;
use crate::{fault, files, open};
use anyhow::Context;
use articula::core::Backend;
use articula::device::{
    Application, BenchmarkContent, BenchmarkOptions, BenchmarkRun, DeviceReport, FirstGuess,
};
use articula::{Executor, Figure, Job, reference_mannequin};
use articula_report::nanoseconds;
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use std::hint::black_box;
use std::path::PathBuf;

/// Maximum number of threads.
const MAX_THREADS: usize = 256;
/// Most seconds of frames of an application.
const MAX_SECS: f32 = 3600.0;
/// Steps of the progress bar for a second.
const STEPS_PER_SEC: f64 = 10.0;

/// Arguments of `bench device`.
#[derive(Debug, Args)]
pub(crate) struct DeviceArgs {
    /// Character to play in place of the reference human; scores of two characters are not comparable
    #[arg(conflicts_with = "send")]
    file: Option<PathBuf>,
    /// Application to play (repeatable) [default: all three]
    #[arg(long, value_enum, value_name = "NAME")]
    application: Vec<ApplicationArgument>,
    /// Most seconds of frames of an application
    #[arg(long, value_name = "S", default_value = "10", value_parser = seconds)]
    seconds: f32,
    /// Grades to play, in place of those around 25 and 60 frames per second: 0, the finest, to 11
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(0..12))]
    grades: Vec<u8>,
    /// Number of threads that pose a crowd
    #[arg(long, value_name = "T", default_value = "1", value_parser = threads)]
    threads: usize,
    /// Instruction set that poses a crowd: scalar, sse2, avx2, avx512 or neon [default: the fastest]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    backend: Option<Backend>,
    /// Write a plot of the frame rates
    #[arg(long, value_name = "F.svg")]
    plot: Option<PathBuf>,
    /// Put the result to a server, whose address `articula serve` prints
    #[arg(long, value_name = "URL")]
    send: Option<String>,
    /// What the server must be told to take it
    #[arg(long, value_name = "TOKEN", requires = "send")]
    token: Option<String>,
}

/// What is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ApplicationArgument {
    /// A walking figure, drawn
    Body,
    /// A close-up of a moving face, drawn
    Face,
    /// Many figures, posed
    Crowd,
}

impl ApplicationArgument {
    fn application(self) -> Application {
        match self {
            Self::Body => Application::Body,
            Self::Face => Application::Face,
            Self::Crowd => Application::Crowd,
        }
    }
}

fn seconds(text: &str) -> Result<f32, String> {
    let secs = positive(text)?;
    match secs <= MAX_SECS {
        true => Ok(secs),
        false => Err(format!("expected at most {MAX_SECS} seconds")),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok();
    let number = number.filter(|n| (1..=MAX_THREADS).contains(n));
    number.ok_or_else(|| format!("expected a whole number of 1 to {MAX_THREADS}"))
}

fn backend(text: &str) -> Result<Backend, String> {
    let backend: Backend = text.parse().map_err(|e| format!("{e}"))?;
    match backend.is_available() {
        true => Ok(backend),
        false => Err(format!("this processor has no {backend}")),
    }
}

impl DeviceArgs {
    fn backend(&self) -> Backend {
        self.backend.unwrap_or_else(Backend::best)
    }

    fn applications(&self) -> Vec<Application> {
        let asked = |application: &Application| {
            let mut all = self.application.iter();
            all.any(|argument| argument.application() == *application)
        };
        let all = Application::ALL.into_iter();
        all.filter(|a| self.application.is_empty() || asked(a))
            .collect()
    }
}

/// Plays every application, reports, and sends the report.
pub(crate) fn run(args: &DeviceArgs, console: &Console) -> anyhow::Result<()> {
    let server = args.send.as_deref().map(Server::new).transpose();
    let server = server.context("--send")?;
    if let Some(plot) = &args.plot {
        if files::extension(plot) != "svg" {
            let path = files::shown(plot);
            let what = format!("--plot {path}: plots are SVG; name a .svg file");
            return Err(fault::usage(what));
        }
        console.files.plan(args.file.as_deref(), [plot.as_path()])?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads);
    let pool = pool.build().context("threads")?;
    let guess = hardware::first_guess(args.threads);
    let mut report = BenchReport::new(hardware::description(args.backend(), args.threads));
    let mut character = match &args.file {
        Some(path) => open::character(&console.files, path, &ReadArgs::default())?,
        None => reference_mannequin()?,
    };
    // What travels would leave the picture.
    character.put_in_place();
    for application in args.applications() {
        let figure = Figure::new(character.clone())?;
        let played = pool.install(|| play(application, figure, (args, &guess), console))?;
        report.results.push(played);
    }
    if let Some(plot) = &args.plot {
        console.files.write(plot, report.plot().as_bytes())?;
        report.written.push(files::shown(plot));
    }
    if let Some(server) = server {
        let results = report.results.iter().map(|played| played.result.clone());
        let sent = DeviceReport {
            device: report.device.clone(),
            results: results.collect(),
        };
        report.sent = Some(send::put(&server, &sent, args.token.as_deref())?);
    }
    console.result(&report, BenchReport::text)
}

/// Plays one application until the answer is certain or the time is over.
fn play(
    application: Application,
    figure: Figure,
    (args, guess): (&DeviceArgs, &FirstGuess),
    console: &Console,
) -> anyhow::Result<Played> {
    let run_jobs = |jobs: &mut [Job<'_>]| jobs.par_iter_mut().for_each(Job::run);
    let work = match args.threads {
        1 => Executor::default(),
        _ => Executor::default().run_jobs(&run_jobs),
    };
    let mut content = BenchmarkContent::new(application, figure, args.backend(), &work)?;
    let options = BenchmarkOptions {
        grades: args
            .grades
            .iter()
            .map(|grade| usize::from(*grade))
            .collect(),
        most_secs: args.seconds.into(),
        ..BenchmarkOptions::default()
    };
    let mut run = BenchmarkRun::new(application, guess, &options);
    let steps = (options.most_secs * STEPS_PER_SEC).ceil() as usize;
    let bar = console.progress(&format!("playing {application}"), steps);
    while let Some(grade) = run.next_grade() {
        let mut shown = Ok(None);
        let ns = nanoseconds(&mut || shown = content.play(&grade, &work));
        black_box(shown?);
        run.record(&grade, 1e-9 * ns);
        bar.set_position((run.secs() * STEPS_PER_SEC) as u64);
    }
    bar.finish_and_clear();
    let result = run.result();
    Ok(Played::new(
        &run,
        result.with_context(|| format!("{application}: no frame was played"))?,
        &content,
    ))
}
