//! The chores that are a single program call.

use crate::cut_alone;
use crate::heartbeat::with_heartbeat;
use crate::outcome::Outcome;
use crate::processes::run;
use crate::studio;
use crate::workspace::{cargo, root, target};
use anyhow::{Result, bail};
use std::process::Command;

/// Output folder of `demo`.
const DEMO_FOLDER: &str = "articula-demo";

/// A clothed character without clips, and a file of motions for it.
const DEMO_CHARACTER: &str = "assets/glb/Quaternius_modular_men__Worker.glb";
const DEMO_MOTION: &str = "assets/glb/pab_arnaud.glb";

/// Folder of characters to serve, in that of the demo.
const STORE: &str = "articula-demo/store";

/// Runs the demo in a release build and prints the path of its page; with Node, then opens the studio over its
/// characters.
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
    match studio::build()? {
        Outcome::Done => studio::open(STORE),
        Outcome::Skipped(why) => {
            println!("the studio is not built: {why}");
            Ok(())
        }
    }
}

/// Builds the release program with the studio inside.
pub(crate) fn studio() -> Result<()> {
    match studio::build()? {
        Outcome::Done => println!(
            "{} serves the studio",
            target().join("release/articula").display()
        ),
        Outcome::Skipped(why) => bail!("the studio is not built: {why}"),
    }
    Ok(())
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
