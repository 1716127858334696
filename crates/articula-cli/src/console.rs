//! Output for the user: results on standard output, progress and errors on standard error.

use crate::fault;
use anyhow::Context;
use articula::fs::{Existing, Files};
use articula::{Executor, Job, Step};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use serde::Serialize;
use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Format of the results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answer {
    /// Text for people.
    Text,
    /// JSON for programs.
    Json,
}

/// Whether progress bars are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Progress {
    /// Shown on a terminal.
    Shown,
    /// Never shown.
    Hidden,
}

/// Output settings and files of one run of the program.
#[derive(Debug)]
pub(crate) struct Console {
    answer: Answer,
    progress: Progress,
    /// The files of this run.
    pub(crate) files: Files,
}

impl Console {
    /// A console with this result format and progress setting, and a treatment of existing files.
    pub(crate) fn new(answer: Answer, progress: Progress, existing: Existing) -> Self {
        Self {
            answer,
            progress,
            files: Files::new(existing),
        }
    }

    /// Prints a result as JSON, or as the text that `text` makes of it.
    pub(crate) fn result<T: Serialize>(
        &self,
        value: &T,
        text: impl FnOnce(&T) -> String,
    ) -> anyhow::Result<()> {
        let out = if self.answer == Answer::Json {
            let mut json = serde_json::to_string_pretty(value).context("standard output")?;
            json.push('\n');
            json
        } else {
            text(value)
        };
        print(&out)
    }

    /// Whether results are JSON.
    pub(crate) fn is_json(&self) -> bool {
        self.answer == Answer::Json
    }

    /// Prints an error on one line.
    pub(crate) fn fault(&self, error: &anyhow::Error) {
        complain(&fault::line(error));
    }

    /// Prints a line on standard error that is no error.
    pub(crate) fn note(&self, text: &str) {
        complain(text);
    }

    /// Runs `make` with an executor that shows each step as a progress bar and runs jobs on all
    /// processors.
    pub(crate) fn work<T>(
        &self,
        make: impl FnOnce(&Executor<'_>) -> articula::Result<T>,
    ) -> articula::Result<T> {
        let shown: Mutex<Option<(&'static str, ProgressBar)>> = Mutex::new(None);
        let on_step = |step: Step| {
            let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
            if shown.as_ref().is_none_or(|(what, _)| *what != step.what) {
                if let Some((_, bar)) = shown.take() {
                    bar.finish_and_clear();
                }
                *shown = Some((step.what, self.progress(step.what, step.of)));
            }
            if let Some((_, bar)) = &*shown {
                bar.set_position(step.done as u64);
            }
            ControlFlow::Continue(())
        };
        let made = make(&on_all_processors().on_step(&on_step));
        if let Some((_, bar)) = shown.into_inner().unwrap_or_else(PoisonError::into_inner) {
            bar.finish_and_clear();
        }
        made
    }

    /// A progress bar of `steps` steps on standard error; hidden with `--quiet` and where standard
    /// error is not a terminal.
    pub(crate) fn progress(&self, what: &str, steps: usize) -> ProgressBar {
        let hidden = self.progress == Progress::Hidden || !std::io::stderr().is_terminal();
        let target = if hidden {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(steps as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{msg:22} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

/// An executor that runs jobs on all processors and reports no progress.
pub(crate) fn on_all_processors<'a>() -> Executor<'a> {
    Executor::default().run_jobs(&run_jobs)
}

fn run_jobs(jobs: &mut [Job<'_>]) {
    jobs.par_iter_mut().for_each(Job::run);
}

/// Writes to standard output. A closed pipe (`| head`) is not an error.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(e).context("standard output"),
        _ => Ok(()),
    }
}

fn complain(text: &str) {
    // There is no channel left on which to report that standard error is closed.
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
