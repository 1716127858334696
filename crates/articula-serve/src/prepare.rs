//! The threads that package characters, stage by stage.

use crate::catalogue::{Catalogue, Progress, Waiting};
use crate::error::ServeError;
use crate::metrics::Metrics;
use crate::packed::{open_folder, open_packed};
use crate::record::Served;
use crate::source::Source;
use crate::sweep::sweep;
use articula::formats::Limits;
use articula::item::{CarriedFile, Item, PackageOptions, package_in_stages};
use articula::{Error, Executor, Job, Step, open};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Threads that package what waits in a catalogue.
#[derive(Debug)]
pub struct Preparation {
    catalogue: Catalogue,
    is_over: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Preparation {
    /// Starts the threads, as many as the options say. Each packages one character after the other, so that
    /// a small one need not wait for a large one.
    ///
    /// Before that, files that nothing names any more are removed from the folder.
    pub fn start(catalogue: Catalogue) -> Self {
        // What cannot be removed is in nobody's way.
        let swept = sweep(&catalogue).unwrap_or_default();
        Metrics::add(&catalogue.metrics().swept, swept);
        let is_over = Arc::new(AtomicBool::new(false));
        let start = |_| {
            let (catalogue, is_over) = (catalogue.clone(), Arc::clone(&is_over));
            std::thread::spawn(move || run(&catalogue, &is_over))
        };
        Self {
            threads: (0..catalogue.options().packaging).map(start).collect(),
            catalogue,
            is_over,
        }
    }

    /// Stops the threads at the end of the steps that they are in. What they had not finished is begun anew
    /// by the next server on the folder.
    pub fn stop(self) {
        self.is_over.store(true, Ordering::Release);
        self.catalogue.wake();
        for thread in self.threads {
            // A panic of the thread has been told.
            let _ = thread.join();
        }
    }
}

fn run(catalogue: &Catalogue, is_over: &AtomicBool) {
    while let Some(waiting) = catalogue.next(|| is_over.load(Ordering::Acquire)) {
        catalogue.set(&waiting, Progress::Packaging, None);
        let metrics = catalogue.metrics();
        // One character must not end the thread for all others.
        let made = catch_unwind(AssertUnwindSafe(|| packaged(catalogue, &waiting, is_over)));
        let made = made.unwrap_or_else(|_| Err(Error::Io("packaging it failed".into()).into()));
        match made {
            Ok(served) => {
                Metrics::add(&metrics.packaged, 1);
                catalogue.set(&waiting, Progress::Ready, Some(served));
            }
            Err(_) if is_over.load(Ordering::Acquire) => {}
            Err(error) => {
                Metrics::add(&metrics.failed, 1);
                catalogue.set(&waiting, Progress::Failed(error.to_string()), None);
            }
        }
    }
}

/// Makes the item of a character, and serves its stages.
fn packaged(
    catalogue: &Catalogue,
    waiting: &Waiting,
    is_over: &AtomicBool,
) -> Result<Served, ServeError> {
    let source = Source::read(&waiting.file)?;
    let limits = Limits {
        bytes: catalogue.options().most_bytes as u64,
        ..Limits::default()
    };
    let item = match &source {
        Source::Packed(bytes) => open_packed(bytes, &limits)?,
        Source::Folder(manifest) => open_folder(&waiting.file, manifest, &limits)?,
        Source::Figure { bytes, with } => in_stages(catalogue, waiting, (bytes, with), is_over)?,
    };
    let served = Served::store(&item, catalogue.objects())?;
    catalogue.records().put(&source, &served)?;
    Ok(served)
}

/// Packages a character file and serves its stages.
fn in_stages(
    catalogue: &Catalogue,
    waiting: &Waiting,
    (figure, with): (&[u8], &[CarriedFile]),
    is_over: &AtomicBool,
) -> Result<Item, ServeError> {
    let options = catalogue.options();
    let file_name = waiting
        .file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    let mut nothing = |_: &str| Err("a served character holds all its data".to_owned());
    let opened = open(figure, &file_name, &options.open, &mut nothing)?;
    let on_step = |_: Step| match is_over.load(Ordering::Acquire) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let run_jobs = |jobs: &mut [Job<'_>]| jobs.par_iter_mut().for_each(Job::run);
    let work = Executor::default().on_step(&on_step).run_jobs(&run_jobs);
    let package = PackageOptions {
        with: [&options.package.with[..], with].concat(),
        ..options.package.clone()
    };
    let item = package_in_stages(opened, &package, &work, &mut |stage| {
        let served = Served::store(stage, catalogue.objects());
        let served = served.map_err(|error| Error::Io(error.to_string()))?;
        Metrics::add(&catalogue.metrics().stages, 1);
        catalogue.set(waiting, Progress::Packaging, Some(served));
        Ok(())
    })?;
    Ok(item)
}
