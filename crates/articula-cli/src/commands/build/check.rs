//! `articula build --check ASSET.glb`: whether an asset is whole, and its parts belong to it.

use super::BuildArgs;
use crate::console::Console;
use crate::fault::clean;
use crate::open;
use crate::table::{Table, warnings};
use crate::{fault, files};
use articula::{CheckedPart, PartState, check_prepared};
use serde::Serialize;

#[derive(Debug, Serialize)]
struct CheckReport {
    file: String,
    bytes: usize,
    generator: String,
    is_whole: bool,
    parts: Vec<CheckedPart>,
    warnings: Vec<String>,
}

/// Checks the asset and prints the state of each part; an asset that is not whole is an error.
pub(super) fn run(args: &BuildArgs, console: &Console) -> anyhow::Result<()> {
    let [path] = &args.paths[..] else {
        return Err(fault::usage("--check takes one file, the asset"));
    };
    let opened = open::character(&console.files, path, &args.names)?;
    let bytes = opened.bytes();
    let found = check_prepared(opened)?;
    let report = CheckReport {
        file: files::shown(path),
        bytes,
        is_whole: found.is_whole(),
        generator: found.generator,
        parts: found.parts,
        warnings: found.warnings,
    };
    console.result(&report, CheckReport::text)?;
    if report.is_whole {
        return Ok(());
    }
    let file = &report.file;
    anyhow::bail!("{file}: the asset is not whole; `articula build {file} OUT.glb` renews it")
}

impl CheckReport {
    fn text(&self) -> String {
        let mut table = Table::new(&["part", "state", "bytes"]);
        for part in &self.parts {
            let state = match part.state {
                PartState::Current => "current",
                PartState::Missing => "missing",
                PartState::Stale => "stale",
                PartState::NotNeeded => "not needed",
            };
            table.row([
                part.part.to_owned(),
                state.to_owned(),
                part.bytes.to_string(),
            ]);
        }
        let by = match self.generator.as_str() {
            "" => "not prepared".to_owned(),
            name => format!("prepared by {}", clean(name)),
        };
        let mut text = format!(
            "{} ({} bytes), {by}\n{}",
            clean(&self.file),
            self.bytes,
            table.text()
        );
        text.push_str(&warnings(&self.warnings));
        text
    }
}
