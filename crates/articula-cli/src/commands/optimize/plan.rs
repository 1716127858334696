//! Which files are read, and which are written of them.

use crate::{fault, files};
use articula::Format;
use std::path::{Path, PathBuf};

/// A file to write.
#[derive(Debug, PartialEq)]
pub(super) struct PlannedFile {
    /// What it is made of: one file, or several whose clips are put together.
    pub(super) inputs: Vec<PathBuf>,
    pub(super) out: PathBuf,
}

/// All files to write.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) files: Vec<PlannedFile>,
    /// The folder that receives them, if there is one.
    pub(super) folder: Option<PathBuf>,
}

impl Plan {
    /// Plans what is written of inputs, the last of these paths being the output.
    pub(super) fn of(paths: &[PathBuf], is_together: bool) -> anyhow::Result<Self> {
        let Some((out, named)) = paths.split_last() else {
            return Err(fault::usage("no file to read".to_owned()));
        };
        let inputs = inputs(named)?;
        let is_one = is_together || named.len() == 1 && !named[0].is_dir();
        if is_one && !is_folder(out) {
            if !matches!(files::format(out), Some(Format::Glb | Format::Vrm)) {
                let what =
                    "an optimised file is a GLB; name the file .glb or .vrm, or a folder with /";
                return Err(fault::usage(format!("{}: {what}", files::shown(out))));
            }
            let out = out.clone();
            return Ok(Self {
                files: vec![PlannedFile { inputs, out }],
                folder: None,
            });
        }
        if is_together {
            let what = "this is a folder; --together writes one file, named .glb or .vrm";
            return Err(fault::usage(format!("{}: {what}", files::shown(out))));
        }
        if matches!(files::format(out), Some(Format::Glb | Format::Vrm)) && !out.is_dir() {
            let what = "several files become several; name a folder, or give --together for one file \
                with the clips of all";
            return Err(fault::usage(format!("{}: {what}", files::shown(out))));
        }
        if files::is_no_folder(out) {
            let what = "this is a file; name a folder for several files";
            return Err(fault::usage(format!("{}: {what}", files::shown(out))));
        }
        Ok(Self {
            files: each_alone(&inputs, out)?,
            folder: Some(out.clone()),
        })
    }
}

fn is_folder(out: &Path) -> bool {
    out.is_dir() || files::ends_with_separator(out)
}

/// The files that are named, those of a folder by name.
fn inputs(named: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut inputs = Vec::new();
    for path in named {
        if !path.is_dir() {
            inputs.push(path.clone());
            continue;
        }
        let place = |fault: std::io::Error| anyhow::anyhow!("{}: {fault}", files::shown(path));
        let entries = path.read_dir().map_err(place)?;
        let mut within: Vec<PathBuf> = Vec::new();
        for entry in entries {
            let file = entry.map_err(place)?.path();
            if file.is_file() && files::format(&file).is_some() {
                within.push(file);
            }
        }
        if within.is_empty() {
            let what = "no character file is in this folder";
            return Err(fault::usage(format!("{}: {what}", files::shown(path))));
        }
        within.sort();
        inputs.append(&mut within);
    }
    Ok(inputs)
}

/// Each input by itself, under its own name in a folder.
fn each_alone(inputs: &[PathBuf], folder: &Path) -> anyhow::Result<Vec<PlannedFile>> {
    let mut plan: Vec<PlannedFile> = Vec::new();
    for input in inputs {
        let extension = match files::format(input) {
            Some(Format::Vrm) => "vrm",
            _ => "glb",
        };
        let name = input.file_stem().unwrap_or_default();
        let out = folder.join(name).with_extension(extension);
        if let Some(other) = plan.iter().find(|file| file.out == out) {
            let (a, b) = (files::shown(&other.inputs[0]), files::shown(input));
            let what = format!("{a} and {b} would both become {}", files::shown(&out));
            return Err(fault::usage(what));
        }
        plan.push(PlannedFile {
            inputs: vec![input.clone()],
            out,
        });
    }
    Ok(plan)
}
