//! The chores that are a single program call.

use crate::cut_alone;
use crate::processes::run;
use crate::workspace::{cargo, root, target};
use anyhow::{Result, bail};
use std::io::IsTerminal;
use std::process::Command;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Output folder of `demo`.
const DEMO_FOLDER: &str = "articula-demo";

/// A clothed character without clips, and a file of motions for it.
const DEMO_CHARACTER: &str = "assets/glb/Quaternius_modular_men__Worker.glb";
const DEMO_MOTION: &str = "assets/glb/pab_arnaud.glb";

/// Seconds between two lines that tell that work goes on.
const HEARTBEAT: Duration = Duration::from_secs(8);

/// Runs the demo in a release build and prints the path of its page.
pub(crate) fn demo() -> Result<()> {
    println!("building the program (some minutes the first time)");
    let build = ["build", "--release", "-p", "articula-cli"];
    with_heartbeat("building", || run(cargo().args(build)))?;
    let words = ["demo", DEMO_CHARACTER, DEMO_MOTION, "--out", DEMO_FOLDER];
    let mut demo = Command::new(target().join("release/articula"));
    with_heartbeat("demo", || run(demo.args(words).current_dir(root())))?;
    let page = root().join(DEMO_FOLDER).join("index.html");
    if !page.is_file() {
        bail!("the demo did not write {}", page.display());
    }
    println!("open {} in a browser", page.display());
    Ok(())
}

/// Does `work` and tells meanwhile how long it takes, unless there is a terminal, on which programs
/// show their progress themselves.
fn with_heartbeat<T>(what: &str, work: impl FnOnce() -> T) -> T {
    if std::io::stderr().is_terminal() {
        return work();
    }
    let begin = Instant::now();
    let (working, is_done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            while is_done.recv_timeout(HEARTBEAT) == Err(RecvTimeoutError::Timeout) {
                println!("{what}: {} s so far", begin.elapsed().as_secs());
            }
        });
        let done = work();
        drop(working);
        done
    })
}

/// Checks the tree and prints every fault.
pub(crate) fn tidy() -> Result<()> {
    let faults = crate::tidy::check(&root())?;
    for fault in &faults {
        println!("{fault}");
    }
    if !faults.is_empty() {
        bail!("{} faults", faults.len());
    }
    Ok(())
}

/// Rewrites all golden files with the results of the tests, then lists those that changed.
pub(crate) fn golden() -> Result<()> {
    let words = ["test", "--workspace", "--quiet"];
    run(cargo().args(words).env("ARTICULA_GOLDEN", "renew"))?;
    run(cut_alone::call().env("ARTICULA_GOLDEN", "renew"))?;
    println!("changed golden files (review each one before committing):");
    run(Command::new("git")
        .args(["status", "--short", "--", ":(glob)**/tests/golden/**"])
        .current_dir(root()))
}
