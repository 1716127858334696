//! `cargo xtask bench-web`: crowds in a page, beside what else shows many characters in three.js.

use crate::outcome::Outcome;
use crate::processes::{output, run};
use crate::web::{WebOptions, web};
use crate::web_pages;
use crate::workspace::{cargo, root, target};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Characters that are measured where no file is named.
const FILES: [&str; 2] = [
    "assets/glb/pab_arnaud.glb",
    "assets/glb/Quaternius_single_knight_pack__KnightCharacter.glb",
];

/// Page of the results.
const PAGE: &str = "docs/results/web.md";

/// What was asked for.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct BenchOptions {
    /// Renew the page of the results.
    write: bool,
    files: Vec<PathBuf>,
}

impl BenchOptions {
    /// Reads `[--write] [FILE…]`; `None` for another flag.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        let mut options = Self::default();
        for word in words {
            match *word {
                "--write" => options.write = true,
                flag if flag.starts_with('-') => return None,
                file => options.files.push(PathBuf::from(file)),
            }
        }
        Some(options)
    }
}

/// Builds the program, the modules and the packages, prepares the files and measures them in Chromium.
pub(crate) fn bench(options: &BenchOptions) -> Result<()> {
    if let Outcome::Skipped(why) = web_pages::install()? {
        bail!("{why}");
    }
    let release = ["build", "--quiet", "--release", "-p", "articula-cli"];
    run(cargo().args(release))?;
    web(&WebOptions::default())?;
    let folder = root().join("web");
    let build = ["run", "--silent", "build"];
    run(Command::new("npm").args(build).current_dir(&folder))?;
    let files = match &options.files[..] {
        [] => FILES.map(|file| root().join(file)).to_vec(),
        files => files.to_vec(),
    };
    let prepared = files.iter().map(|file| prepared(file));
    let prepared = prepared.collect::<Result<Vec<_>>>()?;
    let measure = folder.join("bench").join("run.mjs");
    let said = output(Command::new("node").arg(measure).args(prepared))?;
    print!("{said}");
    if options.write {
        std::fs::write(root().join(PAGE), said).context(PAGE)?;
    }
    Ok(())
}

/// Prepares a file for crowds, as its users would.
fn prepared(file: &Path) -> Result<PathBuf> {
    let folder = target().join("bench-web");
    std::fs::create_dir_all(&folder)?;
    let name = file.file_name().context("a file has a name")?;
    let out = folder.join(name).with_extension("glb");
    let mut build = Command::new(target().join("release").join("articula"));
    let flags = ["--levels", "5", "--force", "--quiet"];
    run(build.arg("build").arg(file).arg(&out).args(flags))?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_the_chore() {
        let found = BenchOptions::parse(&["a.glb", "--write"]);
        let files = vec![PathBuf::from("a.glb")];
        assert_eq!(found, Some(BenchOptions { write: true, files }));
        assert_eq!(BenchOptions::parse(&[]), Some(BenchOptions::default()));
        assert_eq!(BenchOptions::parse(&["--json"]), None);
    }
}
