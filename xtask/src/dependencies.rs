//! Licences, duplicates, sources and refused crates among all dependencies, by the lists of
//! `deny.toml`.
//!
//! `cargo deny check bans licenses sources` judges the same file; it takes longer to install than all
//! of CI's checks of this kind may take, so it is run by hand. This check reads from `deny.toml` the
//! arrays `allow`, `skip` and `deny`, one entry a line.

use crate::outcome::Outcome;
use crate::processes::output;
use crate::workspace::{cargo, root};
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

/// The one registry.
const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// What `deny.toml` says.
#[derive(Debug, Default, PartialEq, Eq)]
struct Policy {
    /// Licences that may come in.
    licences: Vec<String>,
    /// Crates that may be there in several versions.
    duplicates: Vec<String>,
    /// Refused crates, each with the crates that may depend on it nevertheless.
    refused: Vec<(String, Vec<String>)>,
}

/// The part of `cargo metadata` that is judged.
#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    workspace_members: Vec<String>,
    resolve: Resolve,
}

#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    version: String,
    id: String,
    license: Option<String>,
    /// Absent for a package given by its path.
    source: Option<String>,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
    req: String,
    path: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
    deps: Vec<Edge>,
}

#[derive(Debug, Deserialize)]
struct Edge {
    /// Identifier of the used package.
    pkg: String,
    dep_kinds: Vec<Use>,
}

#[derive(Debug, Deserialize)]
struct Use {
    /// `dev` for tests and benches, `build` for build scripts, absent for code.
    kind: Option<String>,
}

/// Judges the locked dependencies of the workspace with all features, on all platforms.
pub(crate) fn check() -> Result<Outcome> {
    let file = root().join("deny.toml");
    let text = std::fs::read_to_string(&file)
        .with_context(|| format!("cannot read {}", file.display()))?;
    let policy = policy(&text)?;
    let words = ["metadata", "--format-version", "1", "--all-features"];
    let metadata = output(cargo().args(words).arg("--locked"))?;
    let faults = faults(&policy, &serde_json::from_str(&metadata)?);
    for fault in &faults {
        println!("{fault}");
    }
    ensure!(faults.is_empty(), "{} faults by deny.toml", faults.len());
    Ok(Outcome::Done)
}

fn faults(policy: &Policy, metadata: &Metadata) -> Vec<String> {
    let mut faults = Vec::new();
    let used: BTreeSet<&str> = (metadata.resolve.nodes.iter())
        .map(|node| node.id.as_str())
        .collect();
    let packages: BTreeMap<&str, &Package> = (metadata.packages.iter())
        .filter(|package| used.contains(package.id.as_str()))
        .map(|package| (package.id.as_str(), package))
        .collect();
    let mut versions: BTreeMap<&str, Vec<&Package>> = BTreeMap::new();
    for package in packages.values() {
        let name = format!("{} {}", package.name, package.version);
        versions.entry(&package.name).or_default().push(package);
        match &package.license {
            None => faults.push(format!("{name}: it names no licence")),
            Some(licence) if is_allowed(licence, &policy.licences) => {}
            Some(licence) => faults.push(format!("{name}: the licence {licence} is not allowed")),
        }
        match &package.source {
            Some(source) if source != CRATES_IO => {
                faults.push(format!("{name}: it comes from {source}"));
            }
            Some(_) => {}
            None => {
                let any = |d: &&Dependency| d.req == "*" && d.path.is_none();
                for dependency in package.dependencies.iter().filter(any) {
                    let of = &dependency.name;
                    faults.push(format!("{name}: it accepts any version of {of}"));
                }
            }
        }
    }
    // What tests and benches alone use may be there twice.
    let built = built(metadata);
    versions.retain(|_, all| {
        all.retain(|package| built.contains(package.id.as_str()));
        !all.is_empty()
    });
    for (name, versions) in &versions {
        if versions.len() > 1 && !policy.duplicates.iter().any(|n| n == name) {
            let numbers: Vec<&str> = versions.iter().map(|p| p.version.as_str()).collect();
            faults.push(format!("{name}: several versions: {}", numbers.join(", ")));
        }
    }
    for name in &policy.duplicates {
        if versions.get(name.as_str()).is_none_or(|v| v.len() < 2) {
            faults.push(format!("{name}: skipped without need, it has no duplicate"));
        }
    }
    for node in &metadata.resolve.nodes {
        let Some(user) = packages.get(node.id.as_str()) else {
            continue;
        };
        let deps = node.deps.iter().map(|edge| edge.pkg.as_str());
        for dependency in deps.filter_map(|id| packages.get(id)) {
            let refused = policy.refused.iter().find(|r| r.0 == dependency.name);
            if refused.is_some_and(|(_, users)| !users.contains(&user.name)) {
                let (user, name) = (&user.name, &dependency.name);
                faults.push(format!("{name}: refused by deny.toml, but {user} uses it"));
            }
        }
    }
    faults
}

/// Returns the identifiers of the packages that the workspace uses other than for its tests and
/// benches.
fn built(metadata: &Metadata) -> BTreeSet<&str> {
    let nodes = metadata.resolve.nodes.iter();
    let nodes: BTreeMap<&str, &Node> = nodes.map(|n| (n.id.as_str(), n)).collect();
    let mut found = BTreeSet::new();
    let mut open: Vec<&str> = metadata
        .workspace_members
        .iter()
        .map(String::as_str)
        .collect();
    while let Some(id) = open.pop() {
        if !found.insert(id) {
            continue;
        }
        let is_built =
            |edge: &&Edge| (edge.dep_kinds.iter()).any(|used| used.kind.as_deref() != Some("dev"));
        let edges = nodes.get(id).into_iter().flat_map(|node| &node.deps);
        open.extend(edges.filter(is_built).map(|edge| edge.pkg.as_str()));
    }
    found
}

/// Reads the three lists of `deny.toml`.
fn policy(text: &str) -> Result<Policy> {
    let named = |line: &str| -> Result<String> {
        let crates = strings_of(line, "crate");
        let first = crates.into_iter().next();
        first.with_context(|| format!("deny.toml: no crate in the entry {line}"))
    };
    let lists = Policy {
        licences: array(text, "[licenses]", "allow")?
            .into_iter()
            .flat_map(quoted)
            .collect(),
        duplicates: array(text, "[bans]", "skip")?
            .into_iter()
            .map(named)
            .collect::<Result<_>>()?,
        refused: array(text, "[bans]", "deny")?
            .into_iter()
            .map(|line| Ok((named(line)?, strings_of(line, "wrappers"))))
            .collect::<Result<_>>()?,
    };
    if lists.licences.is_empty() {
        bail!("deny.toml allows no licence");
    }
    Ok(lists)
}

/// Returns the lines of an array in a section, without comments; the brackets are at the ends of
/// lines.
fn array<'a>(text: &'a str, section: &str, key: &str) -> Result<Vec<&'a str>> {
    let mut lines = text.lines().map(str::trim).filter(|l| !l.starts_with('#'));
    lines
        .find(|line| *line == section)
        .with_context(|| format!("deny.toml has no section {section}"))?;
    let mut found = Vec::new();
    let mut is_inside = false;
    for line in lines {
        let begins = line.split_once('=').filter(|(k, _)| k.trim() == key);
        match begins {
            _ if !is_inside && line.starts_with('[') => break,
            None if !is_inside => continue,
            None => found.push(line),
            Some((_, rest)) => {
                is_inside = true;
                found.push(rest.trim());
            }
        }
        // An entry of one crate ends with a brace, so a bracket ends the array.
        if line.ends_with(']') {
            let entries = found.into_iter().filter(|line| line.contains('"'));
            return Ok(entries.collect());
        }
    }
    bail!("deny.toml: the array {key} of {section} is missing or has no end")
}

/// Returns the text, or the texts of the array, after `key =` in an inline table.
fn strings_of(table: &str, key: &str) -> Vec<String> {
    let Some((_, rest)) = table.split_once(&format!("{key} = ")) else {
        return Vec::new();
    };
    let value = match rest.strip_prefix('[') {
        Some(list) => list.split(']').next().unwrap_or_default(),
        None => rest,
    };
    let count = if rest.starts_with('[') { usize::MAX } else { 1 };
    quoted(value).take(count).collect()
}

/// Returns the texts in double quotes; none contains an escaped quote.
fn quoted(text: &str) -> impl Iterator<Item = String> {
    text.split('"').skip(1).step_by(2).map(str::to_owned)
}

/// Returns whether an SPDX expression can be met with the allowed licences. `AND` binds closer than
/// `OR`; the older `A/B` means `A OR B`.
fn is_allowed(expression: &str, allowed: &[String]) -> bool {
    let spaced = expression
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ");
    let mut words = spaced.split_whitespace().peekable();
    let met = one_of(&mut words, allowed);
    met && words.next().is_none()
}

type Words<'a> = std::iter::Peekable<std::str::SplitWhitespace<'a>>;

fn one_of(words: &mut Words<'_>, allowed: &[String]) -> bool {
    let mut met = all_of(words, allowed);
    while words.next_if_eq(&"OR").is_some() {
        met |= all_of(words, allowed);
    }
    met
}

fn all_of(words: &mut Words<'_>, allowed: &[String]) -> bool {
    let mut met = licence(words, allowed);
    while words.next_if_eq(&"AND").is_some() {
        met &= licence(words, allowed);
    }
    met
}

fn licence(words: &mut Words<'_>, allowed: &[String]) -> bool {
    let Some(word) = words.next() else {
        return false;
    };
    if word == "(" {
        let met = one_of(words, allowed);
        return met & words.next_if_eq(&")").is_some();
    }
    let mut name = word.to_owned();
    if words.next_if_eq(&"WITH").is_some() {
        name = format!("{name} WITH {}", words.next().unwrap_or_default());
    }
    allowed.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    const TEXT: &str = "\
[licenses]
# Ours.
allow = [\"MIT\", \"Zlib\"]
[bans]
skip = [
    { crate = \"old\", reason = \"allow = [deny]; ends\" },
]
deny = [
    { crate = \"bad\", reason = \"slow\" },
    { crate = \"lab-only\", wrappers = [\"lab\", \"bench\"], reason = \"C\" },
]
[sources]
";

    fn strings(texts: &[&str]) -> Vec<String> {
        texts.iter().map(|t| (*t).to_owned()).collect()
    }

    #[test]
    fn the_lists_are_read() {
        let read = policy(TEXT).unwrap();
        assert_eq!(read.licences, strings(&["MIT", "Zlib"]));
        assert_eq!(read.duplicates, strings(&["old"]));
        let users = strings(&["lab", "bench"]);
        let refused = vec![("bad".to_owned(), vec![]), ("lab-only".to_owned(), users)];
        assert_eq!(read.refused, refused);
        assert!(policy("[licenses]\nallow = []\n[bans]\nskip = []\ndeny = []\n").is_err());
        assert!(policy(&TEXT.replace("skip", "pass")).is_err());
        assert!(policy(&TEXT.replace("{ crate = \"bad\"", "{ name = \"bad\"")).is_err());
    }

    #[test]
    fn an_expression_needs_all_of_one_alternative() {
        let allowed = strings(&["MIT", "Zlib", "Apache-2.0 WITH LLVM-exception"]);
        let is = |expression| is_allowed(expression, &allowed);
        assert!(is("MIT") && is("GPL-3.0 OR MIT") && is("GPL-3.0/MIT"));
        assert!(is("Zlib AND (GPL-3.0 OR MIT)") && is("GPL-3.0 AND BSL-1.0 OR MIT"));
        assert!(is("Apache-2.0 WITH LLVM-exception"));
        assert!(!is("GPL-3.0") && !is("MIT AND GPL-3.0") && !is("Apache-2.0"));
        assert!(!is("(MIT OR Zlib) AND GPL-3.0") && !is("(MIT") && !is("MIT)") && !is(""));
    }

    /// Packages as (name, version, licence, source), of which the first is ours, and uses as pairs of
    /// indices with their kind.
    fn metadata(
        packages: &[(&str, &str, &str, Option<&str>)],
        uses: &[(usize, usize, Option<&str>)],
    ) -> Metadata {
        let id = |i: usize| format!("{} {}", packages[i].0, packages[i].1);
        let listed: Vec<Value> = (packages.iter().enumerate())
            .map(|(i, (name, version, license, source))| {
                json!({ "name": name, "version": version, "id": id(i), "license": license,
                    "source": source, "dependencies": [] })
            })
            .collect();
        let nodes: Vec<Value> = (0..packages.len())
            .map(|i| {
                let used = uses.iter().filter(|u| u.0 == i);
                let deps = used.map(|u| json!({ "pkg": id(u.1), "dep_kinds": [{ "kind": u.2 }] }));
                json!({ "id": id(i), "deps": deps.collect::<Vec<_>>() })
            })
            .collect();
        let metadata = json!({ "packages": listed, "workspace_members": [id(0)],
            "resolve": { "nodes": nodes } });
        serde_json::from_value(metadata).unwrap()
    }

    #[test]
    fn each_kind_of_fault_is_found_once() {
        let registry = Some(CRATES_IO);
        let right = [
            ("lab", "0.1.0", "MIT", None),
            ("lab-only", "1.0.0", "Zlib", registry),
            ("old", "1.0.0", "MIT", registry),
            ("old", "2.0.0", "MIT", registry),
        ];
        let policy = policy(TEXT).unwrap();
        let found = |packages: &[_], uses: &[_]| faults(&policy, &metadata(packages, uses));
        let uses = [(0, 1, None), (0, 2, None), (0, 3, Some("build"))];
        assert_eq!(found(&right, &uses), strings(&[]));

        let mut wrong = right.to_vec();
        wrong.push(("bad", "1.0.0", "GPL-3.0", registry));
        wrong.push((
            "other",
            "1.0.0",
            "MIT",
            Some("git+https://example.org/other"),
        ));
        wrong.push(("other", "1.1.0", "MIT", registry));
        let mut uses = uses.to_vec();
        uses.extend([(2, 1, None), (0, 5, None), (5, 4, None), (5, 6, None)]);
        let expected = [
            "bad 1.0.0: the licence GPL-3.0 is not allowed",
            "other 1.0.0: it comes from git+https://example.org/other",
            "other: several versions: 1.0.0, 1.1.0",
            "lab-only: refused by deny.toml, but old uses it",
            "bad: refused by deny.toml, but other uses it",
        ];
        assert_eq!(found(&wrong, &uses), strings(&expected));
    }

    #[test]
    fn versions_that_tests_alone_use_are_no_duplicates() {
        let registry = Some(CRATES_IO);
        let packages = [
            ("lab", "0.1.0", "MIT", None),
            ("old", "1.0.0", "MIT", registry),
            ("old", "2.0.0", "MIT", registry),
        ];
        let policy = policy(TEXT).unwrap();
        let metadata = metadata(&packages, &[(0, 1, None), (0, 2, Some("dev"))]);
        let unneeded = ["old: skipped without need, it has no duplicate"];
        assert_eq!(faults(&policy, &metadata), strings(&unneeded));
    }

    #[test]
    fn our_manifests_name_versions() {
        let mut metadata = metadata(&[("ours", "0.1.0", "MIT", None)], &[]);
        let dependency = |name: &str, req: &str, path: Option<&str>| {
            let json = json!({ "name": name, "req": req, "path": path });
            serde_json::from_value(json).unwrap()
        };
        metadata.packages[0].dependencies = vec![
            dependency("sibling", "*", Some("/sibling")),
            dependency("fixed", "^1", None),
            dependency("any", "*", None),
        ];
        let policy = Policy {
            licences: strings(&["MIT"]),
            ..Policy::default()
        };
        let expected = ["ours 0.1.0: it accepts any version of any"];
        assert_eq!(faults(&policy, &metadata), strings(&expected));
    }
}
