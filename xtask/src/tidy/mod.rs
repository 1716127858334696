//! Rules that lints cannot check: dependencies between crates, sizes and names of files,
//! cross-references. Every rule is one function from the tree of files to its faults.

mod circles;
mod citations;
mod graph;
mod imports;
mod items;
mod manifest;
mod names;
mod reach;
mod record;
mod source;
mod tree;
mod unused;

use anyhow::Result;
use std::fmt;
use std::path::Path;
use tree::Tree;

/// A violation of a rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    /// Path of the file, from the root.
    file: String,
    /// Line number from 1, if the fault belongs to a line.
    line: Option<usize>,
    /// What was found and what was expected.
    what: String,
}

impl Fault {
    fn file(file: &str, what: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            line: None,
            what: what.into(),
        }
    }

    fn line(file: &str, line: usize, what: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            ..Self::file(file, what)
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file, self.what),
            None => write!(f, "{}: {}", self.file, self.what),
        }
    }
}

/// All rules. A new one is one line here and one function with a test that shows it can fail.
const RULES: &[fn(&Tree) -> Vec<Fault>] = &[
    circles::circles,
    citations::cited_pages,
    citations::readme_results,
    manifest::crate_edges,
    manifest::reasons,
    names::pictures,
    source::length,
    source::head,
    source::module_names,
    source::ignored_tests,
    source::marks,
    source::machine_paths,
    record::thesis_map,
    reach::thesis_map,
    unused::unused,
    record::data_readmes,
    record::links,
    record::schemas,
    record::lock_files,
];

/// Reads the tree below `root` and returns all faults, in the order of the rules.
pub(crate) fn check(root: &Path) -> Result<Vec<Fault>> {
    let tree = Tree::read(root)?;
    Ok(RULES.iter().flat_map(|rule| rule(&tree)).collect())
}
