//! What `cargo xtask test --changed` checks: the crates whose files differ from a revision, and those
//! that use them.

use crate::processes::output;
use crate::workspace::{cargo, root};
use anyhow::{Context, Result};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::process::Command;

/// Crates whose tests read the real characters.
const ON_CHARACTERS: &[&str] = &[
    "articula",
    "articula-cli",
    "articula-flat",
    "articula-formats",
    "articula-lab",
    "articula-stream",
];

/// Files outside of a crate that its tests read or include.
const READ_BY_TESTS: &[(&str, &[&str])] = &[
    (
        "oracle/",
        &[
            "articula",
            "articula-cli",
            "articula-flat",
            "articula-lab",
            "articula-stream",
        ],
    ),
    ("assets/", ON_CHARACTERS),
    ("docs/", &["articula-cli"]),
    ("README.md", &["articula-cli"]),
    ("crates/articula-formats/tests/it/real/", ON_CHARACTERS),
    (
        "crates/articula-formats/tests/it/thinned/",
        &["articula-cli"],
    ),
    ("crates/articula-cli/tests/it/judges/", &["articula-flat"]),
    // The same tests without codecs; they run where those of the crate do.
    ("crates/articula-stream-alone/", &["articula-stream"]),
];

/// Files that every crate is built with.
const READ_BY_ALL: &[&str] = &["Cargo.toml", "Cargo.lock", ".cargo/"];

/// Crates whose tests a difference can change.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Changed {
    revision: String,
    crates: BTreeSet<String>,
}

impl Changed {
    /// Finds the crates that differ from a revision of git, files that git does not track included,
    /// and those that use them.
    pub(crate) fn since(revision: &str) -> Result<Self> {
        let git = |words: &[&str]| output(Command::new("git").args(words).current_dir(root()));
        let differing = git(&["diff", "--name-only", "--no-renames", revision, "--"])?;
        let untracked = git(&["ls-files", "--others", "--exclude-standard"])?;
        let metadata = output(cargo().args(["metadata", "--no-deps", "--format-version", "1"]))?;
        let metadata: Metadata =
            serde_json::from_str(&metadata).context("cargo metadata is not as expected")?;
        let files = differing.lines().chain(untracked.lines());
        Ok(Self {
            revision: revision.to_owned(),
            crates: reached(files, &metadata.packages),
        })
    }

    /// Whether the tests of a crate can have changed.
    pub(crate) fn reaches(&self, package: &str) -> bool {
        self.crates.contains(package)
    }
}

impl fmt::Display for Changed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let crates: Vec<&str> = self.crates.iter().map(String::as_str).collect();
        let crates = if crates.is_empty() {
            vec!["no crate"]
        } else {
            crates
        };
        write!(f, "changed since {}: {}", self.revision, crates.join(", "))
    }
}

#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
    /// `dev` for tests, benches and examples.
    kind: Option<String>,
}

/// Returns the crates of changed files, those that are built with them, and those whose tests are.
fn reached<'a>(files: impl Iterator<Item = &'a str>, packages: &[Package]) -> BTreeSet<String> {
    let mut tested: BTreeSet<&str> = BTreeSet::new();
    let mut built: BTreeSet<&str> = BTreeSet::new();
    let names: BTreeMap<&str, &Package> = packages.iter().map(|p| (p.name.as_str(), p)).collect();
    for file in files {
        if READ_BY_ALL.iter().any(|all| file.starts_with(all)) {
            built.extend(names.keys());
        }
        for (_, readers) in READ_BY_TESTS
            .iter()
            .filter(|(folder, _)| file.starts_with(folder))
        {
            tested.extend(readers.iter());
        }
        let inner = file.strip_prefix("crates/").unwrap_or(file);
        let Some((folder, rest)) = inner.split_once('/') else {
            continue;
        };
        if let Some((name, _)) = names.get_key_value(folder) {
            tested.insert(name);
            if !["tests/", "benches/", "examples/"]
                .iter()
                .any(|own| rest.starts_with(own))
            {
                built.insert(name);
            }
        }
    }
    let uses = |package: &Package, dev: bool, of: &BTreeSet<&str>| {
        (package.dependencies.iter())
            .any(|d| of.contains(d.name.as_str()) && (d.kind.as_deref() == Some("dev")) == dev)
    };
    loop {
        let more = packages.iter().filter(|p| uses(p, false, &built));
        let more: BTreeSet<&str> = more.map(|p| p.name.as_str()).collect();
        if more.is_subset(&built) {
            break;
        }
        built.extend(more);
    }
    let by_tests = packages.iter().filter(|p| uses(p, true, &built));
    tested.extend(by_tests.map(|p| p.name.as_str()));
    tested.extend(&built);
    tested.into_iter().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reached_by(files: &[&str]) -> String {
        let package = |name: &str, uses: &[(&str, Option<&str>)]| Package {
            name: name.to_owned(),
            dependencies: (uses.iter())
                .map(|(name, kind)| Dependency {
                    name: (*name).to_owned(),
                    kind: kind.map(str::to_owned),
                })
                .collect(),
        };
        let packages = [
            package("core", &[("build", Some("dev"))]),
            package("build", &[("core", None)]),
            package("flat", &[("core", None), ("build", Some("dev"))]),
            package("articula", &[("build", None)]),
            package("articula-cli", &[("articula", None)]),
            package("articula-flat", &[]),
            package("articula-stream", &[]),
            package("xtask", &[]),
        ];
        let found = reached(files.iter().copied(), &packages);
        found.into_iter().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_change_reaches_users_and_tests() {
        let all = "articula articula-cli articula-flat articula-stream build core flat xtask";
        assert_eq!(
            reached_by(&["crates/core/src/lib.rs"]),
            "articula articula-cli build core flat"
        );
        // Development dependencies are followed for one step: only the tests are built with them.
        assert_eq!(
            reached_by(&["crates/articula/src/a.rs"]),
            "articula articula-cli"
        );
        assert_eq!(
            reached_by(&["crates/build/src/a.rs"]),
            "articula articula-cli build core flat"
        );
        assert_eq!(reached_by(&["crates/build/tests/it/a.rs"]), "build");
        assert_eq!(reached_by(&["xtask/src/main.rs"]), "xtask");
        assert_eq!(reached_by(&["Cargo.lock"]), all);
        assert_eq!(
            reached_by(&["oracle/scene.mjs"]),
            "articula articula-cli articula-flat articula-lab articula-stream"
        );
        let judge = "crates/articula-cli/tests/it/judges/mod.rs";
        assert_eq!(reached_by(&[judge]), "articula-cli articula-flat");
        let alone = "crates/articula-stream-alone/tests/cut_alone.rs";
        assert_eq!(reached_by(&[alone]), "articula-stream");
        assert_eq!(reached_by(&["LICENSE-MIT", "fuzz/Cargo.toml"]), "");
    }
}
