//! What a conversion says of itself, for programs and for people.

use super::reduction::Reduction;
use crate::fault::clean;
use crate::files;
use crate::table::{Table, counted};
use serde::Serialize;
use std::path::Path;

/// One file that was written.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    #[serde(rename = "in")]
    pub(super) input: String,
    pub(super) out: String,
    pub(super) format_in: &'static str,
    pub(super) format_out: &'static str,
    pub(super) bytes_in: usize,
    /// Of all files together.
    pub(super) bytes_out: usize,
    /// Files that were written beside `out`.
    pub(super) beside: Vec<String>,
    pub(super) clips: Vec<String>,
    pub(super) reduction: Option<Reduction>,
    /// What the format of the output cannot hold.
    pub(super) left_out: Vec<String>,
    pub(super) warnings: Vec<String>,
}

/// A folder of files that were written.
#[derive(Debug, Serialize)]
pub(super) struct Batch {
    pub(super) out: String,
    pub(super) files: Vec<Report>,
    pub(super) failed: Vec<Failure>,
}

/// A file that was not converted.
#[derive(Debug, Serialize)]
pub(super) struct Failure {
    #[serde(rename = "in")]
    pub(super) input: String,
    pub(super) why: String,
}

impl Failure {
    /// The reason without the file's name in front of it.
    pub(super) fn new(path: &Path, fault: &anyhow::Error) -> Self {
        let input = files::shown(path);
        let why = format!("{fault:#}");
        let why = why.strip_prefix(&format!("{input}: ")).unwrap_or(&why);
        Self {
            why: clean(why),
            input,
        }
    }
}

impl Report {
    /// The report for people.
    pub(super) fn text(&self) -> String {
        let mut text = format!(
            "{} ({}, {} bytes) -> {} ({}, {} bytes), {}\n",
            clean(&self.input),
            self.format_in,
            self.bytes_in,
            clean(&self.out),
            self.format_out,
            self.bytes_out,
            counted(self.clips.len(), "clip", "clips")
        );
        for beside in &self.beside {
            text.push_str(&format!("beside it: {}\n", clean(beside)));
        }
        if let Some(reduction) = &self.reduction {
            text.push_str(&reduction.text());
        }
        for left in &self.left_out {
            text.push_str(&format!("left out: {}\n", clean(left)));
        }
        for warning in &self.warnings {
            text.push_str(&format!("warning: {}\n", clean(warning)));
        }
        text
    }
}

impl Batch {
    /// One line for each file; what is odd about a file is counted, `--json` spells it out.
    pub(super) fn text(&self) -> String {
        let mut table = Table::new(&["file", "clips", "bytes", "saved", "left out", "warnings"]);
        for file in &self.files {
            let saved = file.reduction.as_ref().map(Reduction::percent);
            table.row([
                file.out.clone(),
                file.clips.len().to_string(),
                file.bytes_out.to_string(),
                saved.unwrap_or_else(|| "-".into()),
                file.left_out.len().to_string(),
                file.warnings.len().to_string(),
            ]);
        }
        let mut text = format!(
            "{}: {} written",
            clean(&self.out),
            counted(self.files.len(), "file", "files")
        );
        if !self.failed.is_empty() {
            text.push_str(&format!(", {} failed", self.failed.len()));
        }
        text.push('\n');
        if !table.is_empty() {
            text.push_str(&table.text());
        }
        text
    }
}
