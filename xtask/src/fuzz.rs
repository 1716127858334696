//! `cargo xtask fuzz`: runs the fuzz targets with seeds from the data and keeps a table of them.
//!
//! The targets are those of `fuzz`, built on the nightly toolchain by cargo-fuzz with
//! AddressSanitizer, debug assertions and overflow checks. Corpora (`fuzz/corpus`) and findings
//! (`fuzz/artifacts`) stay on the machine.

use crate::processes::{answer, run};
use crate::workspace::root;
use anyhow::{Context, Result, bail, ensure};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Seconds after which one input counts as a hang.
const HANG_SECS: u32 = 20;

/// Maximum size of a seed in bytes: larger files leave little time for mutations.
const SEED_BYTES: u64 = 1 << 18;

/// Number of bytes of a motion that follow its skeleton in a seed of `acclaim`: some frames.
const MOTION_BYTES: usize = 1 << 14;

/// Where the seeds of a target come from.
struct Seeds {
    target: &'static str,
    /// Bytes before the file, by which the target chooses a format.
    prefix: &'static [u8],
    extensions: &'static [&'static str],
    /// Name of the folder, if files with that extension elsewhere have other content.
    folder: Option<&'static str>,
}

const fn seeds(
    target: &'static str,
    prefix: &'static [u8],
    extensions: &'static [&'static str],
) -> Seeds {
    Seeds {
        target,
        prefix,
        extensions,
        folder: None,
    }
}

/// The stored descriptions, which every reader of descriptions gets.
const fn documents(target: &'static str) -> Seeds {
    Seeds {
        folder: Some("descriptions"),
        ..seeds(target, b"", &["xml"])
    }
}

/// Seeds of the targets; those of `acclaim` are pairs of files. Targets without seeds start from
/// nothing.
const SEEDS: &[Seeds] = &[
    seeds("abp1", b"", &["abp", "abpt"]),
    seeds("afp1", b"", &["afp"]),
    Seeds {
        folder: Some("golden"),
        ..seeds("afp2", b"", &["afp"])
    },
    Seeds {
        folder: Some("golden"),
        ..seeds("any_order", b"\x02\x05", &["abp", "afp", "ams"])
    },
    documents("aqos"),
    seeds("bva", b"", &["bva"]),
    seeds("bvh", b"", &["bvh"]),
    documents("context"),
    documents("did"),
    seeds("fba", b"", &["fba"]),
    seeds("fbx", b"", &["fbx"]),
    documents("gbsd"),
    seeds("gltf", b"", &["glb", "gltf", "vrm", "vrma"]),
    Seeds {
        folder: Some("joint_maps"),
        ..seeds("joint_map", b"", &["json"])
    },
    Seeds {
        folder: Some("golden"),
        ..seeds("motion_stream", b"", &["abp"])
    },
    seeds("mp4", b"", &["mp4"]),
    seeds("mpeg4", b"\0", &["fap"]),
    seeds("mpeg4", b"\x01", &["bap"]),
    seeds("mpeg4", b"\x02", &["epf"]),
    seeds("mpeg4", b"\x03", &["fdp"]),
    seeds("optimize", b"", &["glb", "gltf", "vrm"]),
    seeds("speech", b"\0", &["wav"]),
    seeds("speech", b"\x01", &["lab"]),
    seeds("stream_index", b"", &["auix"]),
    seeds("x3d", b"", &["x3d", "wrl"]),
];

/// What was asked for.
#[derive(Debug, PartialEq)]
pub(crate) struct FuzzOptions {
    /// Minutes for each target.
    minutes: f64,
    /// Names of targets; all if empty.
    targets: Vec<String>,
}

impl FuzzOptions {
    /// Reads `[--minutes M] [TARGET…]`; `None` for anything else.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        let mut options = Self {
            minutes: 1.0,
            targets: Vec::new(),
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            if *word == "--minutes" {
                let minutes: f64 = words.next()?.parse().ok()?;
                options.minutes = Some(minutes).filter(|m| *m > 0.0 && m.is_finite())?;
            } else if word.starts_with('-') {
                return None;
            } else {
                options.targets.push((*word).to_owned());
            }
        }
        Some(options)
    }

    fn secs(&self) -> u64 {
        (self.minutes * 60.0).ceil() as u64
    }
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Row {
    secs: u64,
    executions: u64,
    per_sec: u64,
    edges: u64,
    features: u64,
    corpus_files: u64,
    findings: u64,
}

impl Row {
    fn fields(&self) -> [u64; 7] {
        [
            self.secs,
            self.executions,
            self.per_sec,
            self.edges,
            self.features,
            self.corpus_files,
            self.findings,
        ]
    }

    fn of_fields(fields: [u64; 7]) -> Self {
        let [
            secs,
            executions,
            per_sec,
            edges,
            features,
            corpus_files,
            findings,
        ] = fields;
        Self {
            secs,
            executions,
            per_sec,
            edges,
            features,
            corpus_files,
            findings,
        }
    }
}

type Table = BTreeMap<String, Row>;

/// Runs the targets and rewrites their rows in `docs/results/fuzz.md` and `fuzz.csv`. An error
/// names the findings.
pub(crate) fn fuzz(options: &FuzzOptions) -> Result<()> {
    let version = answer("rustup", &["run", "nightly", "cargo", "fuzz", "--version"]);
    ensure!(
        version.is_some(),
        "cargo-fuzz on the nightly toolchain is missing: `rustup toolchain install nightly` and \
         `cargo install cargo-fuzz --locked`"
    );
    let all = targets()?;
    for name in &options.targets {
        let known = all.join(", ");
        ensure!(all.contains(name), "no target {name}; there are {known}");
    }
    let chosen = if options.targets.is_empty() {
        run(&mut cargo_fuzz(&["build"]))?;
        &all
    } else {
        &options.targets
    };
    let results = root().join("docs/results");
    let csv = results.join("fuzz.csv");
    let mut table = read_csv(&fs::read_to_string(&csv).unwrap_or_default());
    table.retain(|target, _| all.contains(target));
    let mut findings = Vec::new();
    for target in chosen {
        let seeds = write_seeds(target)?;
        println!("== {target}: {} s, {seeds} seeds", options.secs());
        let report = run_target(target, options.secs())?;
        let mut row = parse_report(&report)
            .with_context(|| format!("libFuzzer printed no state of {target}:\n{report}"))?;
        row.secs = options.secs();
        println!("{}", last_state(&report).unwrap_or_default());
        for file in found_files(&report) {
            findings.push(format!("rustup run nightly cargo fuzz run {target} {file}"));
        }
        table.insert(target.clone(), row);
        fs::write(&csv, write_csv(&table)).with_context(|| csv.display().to_string())?;
        let page = results.join("fuzz.md");
        fs::write(&page, write_page(&table)).with_context(|| page.display().to_string())?;
    }
    for call in &findings {
        println!("finding, reproduced by: {call}");
    }
    if !findings.is_empty() {
        bail!("{} findings; their inputs are kept", findings.len());
    }
    Ok(())
}

/// Returns the names of the targets, sorted.
fn targets() -> Result<Vec<String>> {
    let files = files_below(&root().join("fuzz/fuzz_targets"))?;
    let names = files.iter().filter_map(|path| path.file_stem());
    Ok(names.map(|n| n.to_string_lossy().into_owned()).collect())
}

/// Returns a call of cargo-fuzz in the root of the repository.
fn cargo_fuzz(words: &[&str]) -> Command {
    let mut call = Command::new("rustup");
    call.args(["run", "nightly", "cargo", "fuzz"]).args(words);
    // Set by the stable cargo that runs this program.
    call.env_remove("CARGO").env_remove("RUSTUP_TOOLCHAIN");
    call.current_dir(root());
    call
}

/// Runs one target and returns what libFuzzer printed; a finding is no error here.
fn run_target(target: &str, secs: u64) -> Result<String> {
    let limits = [
        "-print_final_stats=1".to_owned(),
        format!("-max_total_time={secs}"),
        format!("-timeout={HANG_SECS}"),
        // Slower ones than half of that are told otherwise.
        format!("-report_slow_units={HANG_SECS}"),
    ];
    let output = cargo_fuzz(&["run", target, "--"])
        .args(limits)
        .stdout(Stdio::null())
        .output()?;
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    let found = found_files(&report).next().is_some();
    ensure!(output.status.success() || found, "{target}:\n{report}");
    Ok(report)
}

/// Writes the seeds of a target to its corpus and returns their number.
fn write_seeds(target: &str) -> Result<usize> {
    let corpus = root().join("fuzz/corpus").join(target);
    fs::create_dir_all(&corpus).with_context(|| corpus.display().to_string())?;
    let mut files = Vec::new();
    let data = std::env::var_os("ARTICULA_DATA").map(PathBuf::from);
    let data = data.unwrap_or_else(|| root().join("../shared/data"));
    for folder in [data, root().join("assets"), root().join("crates")] {
        if folder.is_dir() {
            files.extend(files_below(&folder)?);
        }
    }
    let mut count = 0;
    let mut keep = |bytes: &[u8]| -> Result<()> {
        let file = corpus.join(format!("seed-{count}"));
        count += 1;
        fs::write(&file, bytes).with_context(|| file.display().to_string())
    };
    for from in SEEDS.iter().filter(|from| from.target == target) {
        for file in files.iter().filter(|file| from.takes(file)) {
            keep(&[from.prefix, &fs::read(file)?].concat())?;
        }
    }
    if target == "acclaim" {
        let has = |extension| move |file: &&PathBuf| has_extension(file, extension);
        for skeleton in files.iter().filter(has("asf")) {
            let asf = fs::read(skeleton)?;
            keep(&asf)?;
            for motion in files.iter().filter(has("amc")) {
                let amc = fs::read(motion)?;
                let start = &amc[..amc.len().min(MOTION_BYTES)];
                keep(&[&asf, &b"\0"[..], start].concat())?;
            }
        }
    }
    Ok(count)
}

impl Seeds {
    fn takes(&self, file: &Path) -> bool {
        let folder = file.parent().and_then(Path::file_name);
        let is_there = self.folder.is_none_or(|f| folder.is_some_and(|n| n == f));
        let is_small = || fs::metadata(file).is_ok_and(|m| m.len() <= SEED_BYTES);
        is_there && self.extensions.iter().any(|e| has_extension(file, e)) && is_small()
    }
}

fn has_extension(file: &Path, extension: &str) -> bool {
    file.extension().is_some_and(|e| e == extension)
}

/// Returns all files below a folder, sorted.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if path.is_dir() {
                open.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The last line with the state of the fuzzer, such as
/// `#812 DONE   cov: 15 ft: 30 corp: 4/9b lim: 4 exec/s: 406 rss: 30Mb`.
fn last_state(report: &str) -> Option<&str> {
    let is_state = |line: &&str| line.starts_with('#') && line.contains(" cov: ");
    report.lines().rfind(is_state)
}

/// The input files that libFuzzer kept.
fn found_files(report: &str) -> impl Iterator<Item = &str> {
    let lines = report.lines();
    lines.filter_map(|line| Some(line.split_once("Test unit written to ")?.1.trim()))
}

/// Reads the last state and the statistics at the end.
fn parse_report(report: &str) -> Option<Row> {
    let state = last_state(report)?;
    let after = |text: &str, key: &str| -> Option<u64> {
        let rest = text.split_once(key)?.1.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_digit());
        rest[..end.unwrap_or(rest.len())].parse().ok()
    };
    let executions = after(report, "stat::number_of_executed_units:");
    let per_sec = after(report, "stat::average_exec_per_sec:");
    Some(Row {
        secs: 0,
        executions: executions.or_else(|| after(state, "#"))?,
        per_sec: per_sec.or_else(|| after(state, "exec/s:"))?,
        edges: after(state, " cov:")?,
        features: after(state, " ft:")?,
        corpus_files: after(state, " corp:")?,
        findings: found_files(report).count() as u64,
    })
}

const CSV_HEAD: &str =
    "target,secs,executions,executions_per_sec,edges,features,corpus_files,findings\n";

fn write_csv(table: &Table) -> String {
    let mut out = CSV_HEAD.to_owned();
    for (target, row) in table {
        let fields = row.fields().map(|x| x.to_string()).join(",");
        let _ = writeln!(out, "{target},{fields}");
    }
    out
}

/// Reads the rows of [`write_csv`]; others are left out.
fn read_csv(text: &str) -> Table {
    let rows = text.lines().skip(1).filter_map(|line| {
        let (target, rest) = line.split_once(',')?;
        let fields: Vec<u64> = rest.split(',').flat_map(str::parse).collect();
        Some((target.to_owned(), Row::of_fields(fields.try_into().ok()?)))
    });
    rows.collect()
}

fn write_page(table: &Table) -> String {
    let mut out = "\
# Fuzzing

Made by `cargo xtask fuzz [--minutes M] [TARGET…]`, which rewrites the rows of its targets: random bytes, mutated
towards new coverage by libFuzzer from the files of the test data and of the repository that the target reads (those up
to 256 KiB), in one process with AddressSanitizer, debug assertions and overflow checks. *Edges* and *features*: what
the inputs of the corpus reach, as counted by libFuzzer; *findings*: inputs that panic, take more than 20 s or more
than 2 GiB, or break an invariant that the target states. The corpus of earlier runs on the same machine is used again,
so a second run reaches more. Executions depend on the machine and on what else runs on it.

| target | seconds | executions | per second | edges | features | corpus | findings |
| --- | --- | --- | --- | --- | --- | --- | --- |
"
    .to_owned();
    for (target, row) in table {
        let fields = row.fields().map(|x| x.to_string()).join(" | ");
        let _ = writeln!(out, "| {target} | {fields} |");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_minutes_and_targets() {
        let parsed = FuzzOptions::parse(&["--minutes", "0.5", "bvh", "x3d"]).unwrap();
        assert_eq!((parsed.secs(), parsed.targets.len()), (30, 2));
        assert_eq!(FuzzOptions::parse(&[]).unwrap().secs(), 60);
        for wrong in [&["--minutes"][..], &["--minutes", "-1"], &["--all"]] {
            assert_eq!(FuzzOptions::parse(wrong), None);
        }
    }

    #[test]
    fn the_state_and_the_findings_are_read() {
        let report = "\
INFO: seed corpus: files: 2 min: 1b max: 9b total: 10b rss: 31Mb
#3\tINITED cov: 10 ft: 11 corp: 2/10b exec/s: 0 rss: 31Mb
#812\tREDUCE cov: 15 ft: 30 corp: 4/9b lim: 4 exec/s: 406 rss: 31Mb L: 2/4 MS: 1
==7== ERROR: libFuzzer: deadly signal
artifact_prefix='/a/'; Test unit written to /a/crash-1
stat::number_of_executed_units: 815
stat::average_exec_per_sec:     407
";
        let row = parse_report(report).unwrap();
        assert_eq!(row.fields(), [0, 815, 407, 15, 30, 4, 1]);
        assert_eq!(found_files(report).next(), Some("/a/crash-1"));
        // Without statistics the last state counts.
        let cut = report.split("stat::").next().unwrap();
        assert_eq!(
            parse_report(cut).unwrap().fields(),
            [0, 812, 406, 15, 30, 4, 1]
        );
        assert_eq!(parse_report("error: no such command"), None);
    }

    #[test]
    fn rows_of_other_targets_stay() {
        let row = Row::of_fields([60, 10, 1, 4, 5, 6, 0]);
        let table = Table::from([("bvh".to_owned(), row.clone()), ("x3d".to_owned(), row)]);
        assert_eq!(read_csv(&write_csv(&table)), table);
        assert!(read_csv("").is_empty());
        assert!(write_page(&table).ends_with("| x3d | 60 | 10 | 1 | 4 | 5 | 6 | 0 |\n"));
    }

    #[test]
    fn seeds_belong_to_targets() {
        let targets = targets().unwrap();
        let mut named = SEEDS.iter().map(|from| from.target.to_owned());
        assert!(named.all(|name| targets.contains(&name)));
        assert!(targets.contains(&"acclaim".to_owned()));
    }
}
