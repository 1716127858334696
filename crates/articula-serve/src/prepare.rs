//! The threads that package characters, stage by stage.

use crate::catalogue::{Catalogue, Taken};
use crate::error::ServeError;
use crate::found::job_of;
use crate::metrics::Metrics;
use crate::packed::{open_folder, open_packed};
use crate::served::Served;
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
    while let Some(of) = catalogue.take(|| is_over.load(Ordering::Acquire)) {
        // One character must not end the thread for all others.
        let made = catch_unwind(AssertUnwindSafe(|| made(catalogue, &of, is_over)));
        let made = made.unwrap_or_else(|_| Err(Error::Io("packaging it failed".into()).into()));
        if let Err(error) = made
            && !is_over.load(Ordering::Acquire)
        {
            Metrics::add(&catalogue.metrics().failed, 1);
            catalogue.fail(&of, &error);
        }
        catalogue.done(&of);
    }
}

/// Does a job, or finds that it is done, or that there is another file by now.
fn made(catalogue: &Catalogue, of: &Taken, is_over: &AtomicBool) -> Result<(), ServeError> {
    if !patiently(is_over, || catalogue.begin(of))? {
        return Ok(());
    }
    let source = Source::read(&of.path)?;
    let hash = source.hash().to_hex();
    if job_of(&hash, catalogue.options()) != of.job {
        return patiently(is_over, || catalogue.renew(of));
    }
    let item = packaged(catalogue, of, &source, is_over)?;
    let served = Served::store(&item, catalogue.objects())?;
    patiently(is_over, || catalogue.finish(of, &served))
}

/// Writes once no other program does: what a thread makes is not given up for that.
fn patiently<T>(
    is_over: &AtomicBool,
    write: impl Fn() -> Result<T, ServeError>,
) -> Result<T, ServeError> {
    loop {
        match write() {
            Err(ServeError::Locked { .. }) if !is_over.load(Ordering::Acquire) => {}
            written => return written,
        }
    }
}

/// Makes the item of a character, and serves its stages.
fn packaged(
    catalogue: &Catalogue,
    of: &Taken,
    source: &Source,
    is_over: &AtomicBool,
) -> Result<Item, ServeError> {
    let limits = Limits {
        bytes: catalogue.options().most_bytes as u64,
        ..Limits::default()
    };
    match source {
        Source::Packed(bytes) => Ok(open_packed(bytes, &limits)?),
        Source::Folder(manifest) => Ok(open_folder(&of.path, manifest, &limits)?),
        Source::Figure { bytes, with } => in_stages(catalogue, of, (bytes, with), is_over),
    }
}

/// Packages a character file and serves its stages.
fn in_stages(
    catalogue: &Catalogue,
    of: &Taken,
    (figure, with): (&[u8], &[CarriedFile]),
    is_over: &AtomicBool,
) -> Result<Item, ServeError> {
    let options = catalogue.options();
    let file_name = of.path.file_name().unwrap_or_default().to_string_lossy();
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
        let staged = served.and_then(|served| catalogue.stage(of, &served));
        staged.map_err(|error| Error::Io(error.to_string()))?;
        Metrics::add(&catalogue.metrics().stages, 1);
        Ok(())
    })?;
    Ok(item)
}
