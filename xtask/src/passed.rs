//! The record of the last run in which every step passed (`target/xtask/passed`), so that the same
//! tree is not tested twice.

use crate::processes::{answer, output};
use crate::workspace::{data_folder, root, target};
use anyhow::{Context, Result};
use std::path::PathBuf;
use std::process::Command;

/// What a run tests: a tree without changes that are not committed, with a compiler, with or without
/// the data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Tested {
    /// Hash of the tree, by git; what the compiler says of itself; whether there is data.
    text: String,
}

impl Tested {
    /// Returns what would be tested now; `None` if it has changes that are not committed, or without
    /// git.
    pub(crate) fn now() -> Option<Self> {
        let git = |words: &[&str]| output(Command::new("git").args(words).current_dir(root())).ok();
        if !git(&["status", "--porcelain"])?.is_empty() {
            return None;
        }
        let tree = git(&["rev-parse", "HEAD^{tree}"])?;
        let compiler = answer("rustc", &["--version"])?;
        let with = if data_folder().is_dir() {
            "with"
        } else {
            "without"
        };
        Some(Self {
            text: format!("{tree}\n{compiler}\n{with} data\n"),
        })
    }

    /// Whether a run passed every step on this.
    pub(crate) fn has_passed(&self) -> bool {
        std::fs::read_to_string(file()).is_ok_and(|text| text == self.text)
    }

    /// Records that every step passed.
    pub(crate) fn record(&self) -> Result<()> {
        let file = file();
        std::fs::write(&file, &self.text)
            .with_context(|| format!("cannot write {}", file.display()))
    }
}

fn file() -> PathBuf {
    target().join("xtask/passed")
}
