//! The chores that are a single program call, and the folders that all chores use.

use crate::cut_alone;
use crate::processes::run;
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Output folder of `demo`.
const DEMO_FOLDER: &str = "articula-demo";

/// A clothed character without clips, and a file of motions for it.
const DEMO_CHARACTER: &str = "assets/glb/Quaternius_modular_men__Worker.glb";
const DEMO_MOTION: &str = "assets/glb/pab_arnaud.glb";

/// Runs the demo in a release build and prints the path of its page.
pub(crate) fn demo() -> Result<()> {
    let words = ["run", "--release", "-p", "articula-cli", "--"];
    let demo = ["demo", DEMO_CHARACTER, DEMO_MOTION, "--out", DEMO_FOLDER];
    run(cargo().args(words).args(demo))?;
    let page = root().join(DEMO_FOLDER).join("index.html");
    if !page.is_file() {
        bail!("the demo did not write {}", page.display());
    }
    println!("open {} in a browser", page.display());
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

/// Returns the root of the repository.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// Returns the folder of everything that is built.
pub(crate) fn target() -> PathBuf {
    let given = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    given.unwrap_or_else(|| root().join("target"))
}

/// Returns the folder of real characters, whether it is there or not.
pub(crate) fn data_folder() -> PathBuf {
    let given = std::env::var_os("ARTICULA_DATA").map(PathBuf::from);
    given.unwrap_or_else(|| root().join("../shared/data"))
}

/// Returns a call of the running cargo, in the root of the repository.
pub(crate) fn cargo() -> Command {
    let mut call = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    call.current_dir(root());
    call
}
