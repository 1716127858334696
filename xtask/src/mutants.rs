//! `cargo xtask mutants`: changes the code of a module with cargo-mutants and counts the changes that
//! the tests of its crate notice.
//!
//! The mutants run in a copy of the tree, so that the working tree stays as it is. In the copy,
//! `articula-core` is without the crates that depend on it and that only its benches and examples
//! use, as each mutant would build those as well.

use crate::processes::answer;
use crate::workspace::root;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Modules of the page, in its order.
const MODULES: &[&str] = &[
    "articula_core::drift",
    "articula_core::joint_lods",
    "articula_core::level_choice",
    "articula_core::level_table",
    "articula_core::level_skins",
    "articula_core::lod_error",
    "articula_core::crowd",
    "articula_build::motion_error",
    "articula_build::surface_distance",
    "articula_build::joint_lods",
    "articula_build::simplify",
    "articula_build::mesh_levels",
    "articula_stream::mesh::codec",
];

/// The crate that depends on no other; in its copy the crates above it are left out.
const CORE: &str = "articula-core";

/// Crates that depend on [`CORE`], and the crate of its benches.
const LEFT_OUT: &[&str] = &["articula-build", "articula-human", "divan"];

/// Minimum seconds after which the tests of one mutant count as a hang.
const HANG_SECS: &str = "15";

/// What was asked for.
#[derive(Debug, PartialEq)]
pub(crate) struct MutantOptions {
    /// Paths of modules; all of the page if empty.
    modules: Vec<String>,
    /// Maximum number of mutants of a module.
    sample: usize,
    seed: u64,
}

impl MutantOptions {
    /// Reads `[--module M]… [--sample N] [--seed S]`; `None` for anything else.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        let mut options = Self {
            modules: Vec::new(),
            sample: 80,
            seed: 1,
        };
        for pair in words.chunks(2) {
            let &[name, value] = pair else { return None };
            match name {
                "--module" => options.modules.push(value.to_owned()),
                "--sample" => options.sample = value.parse().ok().filter(|&n| n > 0)?,
                "--seed" => options.seed = value.parse().ok()?,
                _ => return None,
            }
        }
        Some(options)
    }
}

/// Runs a sample of the mutants of each module and prints a row of the table for each, then the
/// mutants that no test noticed.
pub(crate) fn mutants(options: &MutantOptions) -> Result<()> {
    ensure!(
        answer("cargo", &["mutants", "--version"]).is_some(),
        "cargo-mutants is missing: `cargo install cargo-mutants --locked`"
    );
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let work = target
        .unwrap_or_else(|| root().join("target"))
        .join("mutants");
    let tree = work.join("tree");
    copy_tree(&root(), &tree)?;
    let manifest = tree.join("crates").join(CORE).join("Cargo.toml");
    write_changed(
        &manifest,
        without(&fs::read_to_string(&manifest)?).as_bytes(),
    )?;
    let listed: Vec<&str> = options.modules.iter().map(String::as_str).collect();
    let modules = if listed.is_empty() { MODULES } else { &listed };
    let mut rows = Vec::new();
    let mut missed = Vec::new();
    for module in modules {
        let place = Place::of(module, &work).with_context(|| format!("no module {module}"))?;
        let list = place.call(&["--list"]).output()?;
        let all = String::from_utf8_lossy(&list.stdout).into_owned();
        let all: Vec<&str> = all.lines().collect();
        ensure!(!all.is_empty(), "no mutants of {module}");
        let chosen = sample(&all, options.sample, options.seed);
        println!("== {module}: {} of {} mutants", chosen.len(), all.len());
        // Most are noticed by the tests of the module, which are few; the rest is left to all tests.
        let own = place.run(&chosen, Some(place.filter))?;
        let (left, mut ended): (Vec<_>, Vec<_>) = own.into_iter().partition(Ended::is_missed);
        let left: Vec<&str> = left.iter().map(|mutant| mutant.name.as_str()).collect();
        println!("== {module}: {} of them with all tests", left.len());
        ended.extend(place.run(&left, None)?);
        rows.push(row(module, all.len(), &ended));
        missed.extend(ended.into_iter().filter(Ended::is_missed));
    }
    println!("{}\nmissed:", rows.join("\n"));
    for mutant in missed {
        println!("{}", mutant.name);
    }
    Ok(())
}

/// Where a module is, and its mutants are run.
struct Place<'a> {
    package: String,
    /// Globs of its files.
    files: [String; 2],
    /// What the paths of its own tests have in them.
    filter: &'a str,
    /// Whether some of them are in the integration program of the crate.
    has_outer_tests: bool,
    /// Folder of the copy and of what is built and printed.
    work: &'a Path,
}

impl<'a> Place<'a> {
    /// Finds a module such as `articula_core::crowd`.
    fn of(module: &'a str, work: &'a Path) -> Option<Self> {
        let (name, path) = module.split_once("::")?;
        let package = name.replace('_', "-");
        let stem = format!("crates/{package}/src/{}", path.replace("::", "/"));
        let outer = root().join(format!("crates/{package}/tests/it/{path}"));
        Some(Self {
            has_outer_tests: outer.is_dir() || outer.with_extension("rs").is_file(),
            package,
            files: [format!("{stem}.rs"), format!("{stem}/**")],
            filter: path,
            work,
        })
    }

    /// Returns a call of cargo-mutants for the files of the module in the copy.
    fn call(&self, words: &[&str]) -> Command {
        let mut call = Command::new("cargo");
        call.args(["mutants", "--package", &self.package])
            .args(words);
        for file in &self.files {
            call.args(["--file", file]);
        }
        call.current_dir(self.work.join("tree"));
        call.env("CARGO_TARGET_DIR", self.work.join("target"));
        call.env_remove("CARGO").env_remove("ARTICULA_DATA");
        call
    }

    /// Runs some mutants with the tests whose paths have `filter` in them.
    fn run(&self, mutants: &[&str], filter: Option<&str>) -> Result<Vec<Ended>> {
        if mutants.is_empty() {
            return Ok(Vec::new());
        }
        let mut run = self.call(&["--in-place", "--colors", "never"]);
        run.arg("--output").arg(self.work);
        run.args(["--minimum-test-timeout", HANG_SECS]);
        run.args(["--re", &pattern(mutants)]);
        // The other tests of most crates take minutes unoptimised.
        let is_quick = self.package == CORE || filter.is_some();
        let level = if is_quick { 0 } else { 1 };
        let optimised = format!(
            "--config=profile.test.package.{}.opt-level={level}",
            self.package
        );
        let mut words = vec![&*optimised, "--config=profile.test.debug=false", "--lib"];
        if self.has_outer_tests || filter.is_none() {
            words.push("--test=it");
        }
        run.args(words.iter().map(|word| format!("--cargo-arg={word}")));
        let status = run.arg("--").args(filter).status()?;
        // 2: a mutant was missed; 3: the tests of one hang.
        let ended = matches!(status.code(), Some(0 | 2 | 3));
        ensure!(ended, "cargo-mutants failed: {status}");
        let outcomes = self.work.join("mutants.out/outcomes.json");
        let text = fs::read_to_string(&outcomes).with_context(|| outcomes.display().to_string())?;
        let mut ended = read_outcomes(&serde_json::from_str(&text)?);
        ended.retain(|mutant| mutants.contains(&mutant.name.as_str()));
        Ok(ended)
    }
}

/// Copies the files that git knows or does not ignore; a file with the same content keeps its time,
/// so that its crate is not built again.
fn copy_tree(from: &Path, to: &Path) -> Result<()> {
    let mut git = Command::new("git");
    git.args(["ls-files", "-z", "--cached", "--others"]);
    let names = git.arg("--exclude-standard").current_dir(from).output()?;
    ensure!(names.status.success(), "`git ls-files` failed");
    for name in String::from_utf8(names.stdout)?.split_terminator('\0') {
        let file = from.join(name);
        if file.is_file() {
            write_changed(&to.join(name), &fs::read(file)?)?;
        }
    }
    Ok(())
}

fn write_changed(file: &Path, content: &[u8]) -> Result<()> {
    if fs::read(file).is_ok_and(|old| old == content) {
        return Ok(());
    }
    fs::create_dir_all(file.parent().unwrap_or(file))?;
    fs::write(file, content).with_context(|| file.display().to_string())
}

/// Returns the manifest of `articula-core` without the crates of [`LEFT_OUT`].
fn without(manifest: &str) -> String {
    let is_left_out = |line: &&str| {
        let name = line.split(['.', ' ']).next().unwrap_or_default();
        !LEFT_OUT.contains(&name)
    };
    let lines: Vec<&str> = manifest.lines().filter(is_left_out).collect();
    lines.join("\n") + "\n"
}

/// Returns the `count` mutants whose places in the list have the smallest hashes, in the order of the
/// list; the hash is the output of SplitMix64 for the state `seed · 2³² + place`.
fn sample<'a>(all: &[&'a str], count: usize, seed: u64) -> Vec<&'a str> {
    let mut places: Vec<usize> = (0..all.len()).collect();
    places.sort_by_key(|&place| split_mix(seed.wrapping_mul(1 << 32).wrapping_add(place as u64)));
    places.truncate(count);
    places.sort_unstable();
    places.into_iter().map(|place| all[place]).collect()
}

fn split_mix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Returns a regular expression that only the named mutants match.
fn pattern(names: &[&str]) -> String {
    let mut out = String::from("^(?:");
    for (i, name) in names.iter().enumerate() {
        if i > 0 {
            out.push('|');
        }
        for c in name.chars() {
            if r"\.+*?()|[]{}^$".contains(c) {
                out.push('\\');
            }
            out.push(c);
        }
    }
    out + ")$"
}

/// A mutant that was run.
#[derive(Debug, PartialEq)]
struct Ended {
    name: String,
    /// What cargo-mutants calls the way it ended.
    summary: String,
}

impl Ended {
    /// Whether no test noticed it.
    fn is_missed(&self) -> bool {
        self.summary == "MissedMutant"
    }
}

/// Reads how mutants ended. There may be more than those asked for, as a pattern does not keep out
/// deletions of fields.
fn read_outcomes(outcomes: &Value) -> Vec<Ended> {
    let outcomes = outcomes["outcomes"].as_array().into_iter().flatten();
    let ended = outcomes.filter_map(|outcome| {
        Some(Ended {
            name: outcome["scenario"]["Mutant"]["name"].as_str()?.to_owned(),
            summary: outcome["summary"].as_str()?.to_owned(),
        })
    });
    ended.collect()
}

/// The row of the table; the share is that of the mutants that compile.
fn row(module: &str, all: usize, ended: &[Ended]) -> String {
    let count = |summary: &str| ended.iter().filter(|m| m.summary == summary).count();
    let (caught, missed) = (count("CaughtMutant"), count("MissedMutant"));
    let (unviable, timeouts) = (count("Unviable"), count("Timeout"));
    let found = caught + timeouts;
    let share = 100.0 * found as f64 / (found + missed).max(1) as f64;
    let run = ended.len();
    format!(
        "| `{module}` | {all} | {run} | {caught} | {missed} | {unviable} | {timeouts} | {share:.1} % |"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_modules_and_numbers() {
        let words = ["--module", "articula_core::crowd", "--sample", "9"];
        let parsed = MutantOptions::parse(&words).unwrap();
        assert_eq!((parsed.modules.len(), parsed.sample), (1, 9));
        assert_eq!(MutantOptions::parse(&[]).unwrap().sample, 80);
        for wrong in [&["--seed"][..], &["--sample", "0"], &["--all", "1"]] {
            assert_eq!(MutantOptions::parse(wrong), None);
        }
    }

    #[test]
    fn modules_of_the_page_have_files() {
        for module in MODULES {
            let place = Place::of(module, Path::new("")).unwrap();
            assert!(root().join("crates").join(place.package).is_dir());
            let [file, folder] = place.files;
            let folder = folder.trim_end_matches("/**");
            let exists = root().join(file).is_file() || root().join(folder).is_dir();
            assert!(exists, "{module}");
        }
        assert!(Place::of("articula_core", Path::new("")).is_none());
        let has_outer = |module| Place::of(module, Path::new("")).unwrap().has_outer_tests;
        assert!(has_outer("articula_build::simplify") && has_outer("articula_core::crowd"));
        assert!(!has_outer("articula_stream::mesh::codec"));
    }

    #[test]
    fn a_sample_is_a_part_of_the_list_in_its_order() {
        let names: Vec<String> = (0..100).map(|i| format!("{i:02}")).collect();
        let all: Vec<&str> = names.iter().map(String::as_str).collect();
        let one = sample(&all, 20, 1);
        assert_eq!(one.len(), 20);
        assert!(one.is_sorted() && one.iter().all(|name| all.contains(name)));
        assert_eq!(one, sample(&all, 20, 1));
        assert_ne!(one, sample(&all, 20, 2));
        assert_eq!(sample(&all, 200, 1), all);
    }

    #[test]
    fn the_manifest_loses_the_crates_above() {
        let manifest = "[dependencies]\nglam.workspace = true\n\n[dev-dependencies]\n\
            articula-build.workspace = true\ndivan = \"1\"\nproptest.workspace = true\n";
        let left = "[dependencies]\nglam.workspace = true\n\n[dev-dependencies]\n\
            proptest.workspace = true\n";
        assert_eq!(without(manifest), left);
    }

    #[test]
    fn signs_of_a_name_are_escaped() {
        let names = ["a.rs:1: -> Vec<u8>", "y + z"];
        let expected = r"^(?:a\.rs:1: -> Vec<u8>|y \+ z)$";
        assert_eq!(pattern(&names), expected);
    }

    #[test]
    fn the_share_leaves_out_what_does_not_compile() {
        let outcome = |name: &str, summary| serde_json::json!({ "scenario": { "Mutant": { "name": name } }, "summary": summary });
        let outcomes = serde_json::json!({ "outcomes": [
            { "scenario": "Baseline", "summary": "Success" },
            outcome("a", "CaughtMutant"),
            outcome("b", "CaughtMutant"),
            outcome("c", "Timeout"),
            outcome("d", "Unviable"),
            outcome("e", "MissedMutant"),
        ] });
        let ended = read_outcomes(&outcomes);
        assert_eq!(ended.iter().position(Ended::is_missed), Some(4));
        let expected = "| `m` | 50 | 5 | 2 | 1 | 1 | 1 | 75.0 % |";
        assert_eq!(row("m", 50, &ended), expected);
        assert!(read_outcomes(&serde_json::json!({})).is_empty());
    }
}
