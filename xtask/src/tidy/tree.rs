//! The files of the repository as seen by the rules; tests build a tree from strings.

use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Folders without hand-written files, as in `.gitignore`.
const SKIPPED: &[&str] = &[
    ".git",
    "target",
    "node_modules",
    "articula-demo",
    "corpus",
    "artifacts",
];

/// Extensions of the files whose text is read.
const TEXTS: &[&str] = &[
    "rs", "toml", "md", "json", "mjs", "js", "ts", "sh", "yml", "yaml", "html", "css",
];

/// Paths from the root (with `/`) and, for text files, their text.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    files: BTreeMap<String, Option<String>>,
}

impl Tree {
    /// Reads everything below `root` except the skipped folders.
    pub(crate) fn read(root: &Path) -> Result<Self> {
        let mut tree = Self::default();
        tree.read_folder(root, "")?;
        Ok(tree)
    }

    /// Returns the paths of all files, sorted.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    /// Returns the text files as (path, text), sorted by path.
    pub(crate) fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files
            .iter()
            .filter_map(|(path, text)| Some((path.as_str(), text.as_deref()?)))
    }

    /// Returns the Rust sources as (path, text), sorted by path.
    pub(crate) fn sources(&self) -> impl Iterator<Item = (&str, &str)> {
        self.texts().filter(|(path, _)| path.ends_with(".rs"))
    }

    /// Returns the text of a file.
    pub(crate) fn text(&self, path: &str) -> Option<&str> {
        self.files.get(path)?.as_deref()
    }

    /// Returns whether there is such a file or folder.
    pub(crate) fn has(&self, path: &str) -> bool {
        let folder = format!("{path}/");
        self.files.contains_key(path) || self.paths().any(|p| p.starts_with(&folder))
    }

    /// Creates a tree from (path, text), for tests of the rules.
    #[cfg(test)]
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        let own = |(path, text): &(&str, &str)| ((*path).to_owned(), Some((*text).to_owned()));
        Self {
            files: files.iter().map(own).collect(),
        }
    }

    fn read_folder(&mut self, folder: &Path, prefix: &str) -> Result<()> {
        let place = || format!("cannot read {}", folder.display());
        for entry in fs::read_dir(folder).with_context(place)? {
            let entry = entry.with_context(place)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = format!("{prefix}{name}");
            let kind = entry.file_type().with_context(place)?;
            if kind.is_dir() && !SKIPPED.contains(&name.as_str()) {
                self.read_folder(&entry.path(), &format!("{path}/"))?;
            } else if kind.is_file() {
                let text = is_text(&path).then(|| fs::read_to_string(entry.path()));
                let text = text
                    .transpose()
                    .with_context(|| format!("cannot read {path}"))?;
                self.files.insert(path, text);
            }
        }
        Ok(())
    }
}

fn is_text(path: &str) -> bool {
    let ending = path.rsplit_once('.').map_or("", |(_, ending)| ending);
    TEXTS.contains(&ending) || path == ".ci/run"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_itself_and_skips_what_is_built() {
        let tree = Tree::read(&crate::workspace::root()).unwrap();
        assert!(tree.text("xtask/src/tidy/tree.rs").is_some());
        assert!(tree.paths().all(|p| !p.contains("node_modules")));
    }

    #[test]
    fn pictures_are_no_texts() {
        assert!(is_text("README.md"));
        assert!(is_text(".ci/run"));
        assert!(!is_text("docs/pictures/demo.png"));
    }
}
