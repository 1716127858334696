//! The check of the packages for web pages: their types, what they publish, and pages in Chromium.

use crate::node::{browser, install_in};
use crate::outcome::Outcome;
use crate::processes::run;
use crate::workspace::{cargo, root};
use anyhow::Result;
use std::process::Command;

/// Folder of the packages.
const FOLDER: &str = "web";

/// Installs what the packages and their tests need, pinned by `web/package-lock.json`.
pub(crate) fn install() -> Result<Outcome> {
    install_in(FOLDER, "packages for web pages")
}

/// The page that stands on the packages.
const STUDIO: &str = "articula-studio";

/// Builds the pages of the studio over the modules that are built, and puts them where the program with the feature
/// `studio` embeds them.
pub(crate) fn embed() -> Result<()> {
    npm(&["run", "build"])?;
    for script in ["build", "embed"] {
        npm(&["run", script, "--workspace", STUDIO])?;
    }
    Ok(())
}

/// Records the moving picture of the studio, whose pages are built; needs Chromium.
pub(crate) fn record() -> Result<Outcome> {
    if let missing @ Outcome::Skipped(_) = browser()? {
        return Ok(missing);
    }
    npm(&["run", "record", "--workspace", STUDIO])?;
    Ok(Outcome::Done)
}

fn npm(words: &[&str]) -> Result<()> {
    let mut npm = Command::new("npm");
    run(npm
        .args(words)
        .arg("--silent")
        .current_dir(root().join(FOLDER)))
}

/// Compiles the packages over the modules that the check in node has built, checks what they publish, and opens their
/// pages.
pub(crate) fn check() -> Result<Outcome> {
    for missing in [install()?, browser()?] {
        if let Outcome::Skipped(_) = missing {
            return Ok(missing);
        }
    }
    let folder = root().join(FOLDER);
    if !folder.join("packages/core/wasm/tools_bg.wasm").is_file() {
        let why = "packages for web pages (their modules are not built)";
        return Ok(Outcome::Skipped(why.to_owned()));
    }
    for words in [
        &["run", "build"][..],
        &["run", "check"],
        &["test"],
        &["run", "build", "--workspace", STUDIO],
        &["test", "--workspace", STUDIO],
        &["run", "embed", "--workspace", STUDIO],
    ] {
        npm(words)?;
    }
    // The server with those pages inside; with other packages, most of the library would be compiled again.
    let words = ["clippy", "--workspace", "--exclude", "articula-cli"];
    let options = [
        "--all-targets",
        "--quiet",
        "--features",
        "articula-serve/studio",
    ];
    run(cargo()
        .args(words)
        .args(options)
        .args(["--", "-D", "warnings"]))?;
    Ok(Outcome::Done)
}
