//! The files that a conversion reads, and the files that it writes.

use super::ConvertArgs;
use crate::fault;
use crate::files::{self, Files};
use crate::open;
use anyhow::{Context, bail};
use articula::{DataFormat, Format};
use std::collections::HashMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The files to write.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) jobs: Vec<Job>,
    /// The output folder, if there is one.
    pub(super) folder: Option<PathBuf>,
}

/// One file to write.
#[derive(Debug, PartialEq)]
pub(super) struct Job {
    /// The inputs as named on the command line.
    pub(super) named: String,
    pub(super) inputs: Vec<Input>,
    pub(super) out: PathBuf,
    pub(super) format: Format,
}

/// One file to read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Input {
    pub(super) path: PathBuf,
    /// Whether it was found in a folder rather than named.
    pub(super) found: bool,
}

impl Plan {
    /// Lists the files of folders and decides the output of each.
    pub(super) fn of(args: &ConvertArgs) -> anyhow::Result<Self> {
        match file_format(args)? {
            Some(format) => into_one(args, format),
            None => into_folder(args),
        }
    }

    /// Declares all inputs and checks all outputs, before anything is read.
    pub(super) fn check_files(&self, args: &ConvertArgs, files: &Files) -> anyhow::Result<()> {
        let found = self.jobs.iter().flat_map(|job| &job.inputs);
        let found = found.filter(|input| input.found);
        let inputs = found.map(|input| input.path.as_path()).chain(args.inputs());
        if let Some(folder) = self.folder.as_ref().filter(|f| files::is_no_folder(f)) {
            let what = format!("{}: this is a file; name a folder", files::shown(folder));
            return Err(fault::usage(what));
        }
        // A folder that does not exist is made for the first file that is written.
        let is_made = |folder: &PathBuf| folder.is_dir();
        let is_there = self.folder.as_ref().is_none_or(is_made);
        let outputs = self.jobs.iter().filter(|_| is_there);
        let outputs = outputs.map(|job| job.out.as_path());
        Ok(files.plan(inputs, outputs.chain(args.mesh.output()))?)
    }

    /// Total number of files to read.
    pub(super) fn inputs(&self) -> usize {
        self.jobs.iter().map(|job| job.inputs.len()).sum()
    }
}

/// Format of the output file; `None` if the output is a folder.
fn file_format(args: &ConvertArgs) -> anyhow::Result<Option<Format>> {
    let out = args.out();
    let as_folder = files::ends_with_separator(out);
    match files::format(out) {
        Some(_) if args.to.is_some() => Err(fault::usage(format!(
            "--to names the format of the files of a folder; {} is a file, leave --to out",
            files::shown(out)
        ))),
        Some(format) if !as_folder => Ok(Some(format)),
        _ if as_folder || args.to.is_some() || out.is_dir() || reads_many(args) => Ok(None),
        _ => Err(fault::usage(format!(
            "{}: unknown extension; supported conversions: {}; \
             for a folder of files give --to FORMAT or end the name with /",
            files::shown(out),
            articula::conversions()
        ))),
    }
}

/// Whether a path is a folder of files; the folder of a digital item is one character.
fn is_folder(path: &Path) -> bool {
    path.is_dir() && !files::is_item(path)
}

/// Whether more than one file may be read.
pub(super) fn reads_many(args: &ConvertArgs) -> bool {
    args.sources().len() > 1 || args.sources().iter().any(|path| is_folder(path))
}

fn into_one(args: &ConvertArgs, format: Format) -> anyhow::Result<Plan> {
    if reads_many(args) && args.onto.is_none() {
        return Err(fault::usage(format!(
            "{} can receive several files only as motions of one character, with --onto CHARACTER; \
             or name a folder, such as {}/ --to {}",
            files::shown(args.out()),
            files::shown(&args.out().with_extension("")),
            format.name()
        )));
    }
    let named = args.sources().iter().map(|path| files::shown(path));
    let job = Job {
        named: named.collect::<Vec<_>>().join(", "),
        inputs: inputs(args)?,
        out: args.out().to_owned(),
        format,
    };
    Ok(Plan {
        jobs: vec![job],
        folder: None,
    })
}

fn into_folder(args: &ConvertArgs) -> anyhow::Result<Plan> {
    let format = args.to.unwrap_or(Format::Glb);
    let inputs = inputs(args)?;
    let mut stems: HashMap<OsString, usize> = HashMap::new();
    for input in &inputs {
        *stems.entry(stem(&input.path)).or_default() += 1;
    }
    let job = |input: Input| {
        let mut name = stem(&input.path);
        if stems[&name] > 1 {
            // walk.bvh and walk.amc must not be written to the same file.
            name = input.path.file_name().unwrap_or_default().to_owned();
        }
        name.push(".");
        name.push(format.name());
        Job {
            named: files::shown(&input.path),
            inputs: vec![input],
            out: args.out().join(name),
            format,
        }
    };
    let jobs: Vec<Job> = inputs.into_iter().map(job).collect();
    let mut writers: HashMap<&Path, &Path> = HashMap::new();
    for job in &jobs {
        let from = &job.inputs[0].path;
        if let Some(other) = writers.insert(&job.out, from) {
            return Err(fault::usage(format!(
                "{} and {} would both become {}; convert them into two folders",
                files::shown(other),
                files::shown(from),
                files::shown(&job.out)
            )));
        }
    }
    Ok(Plan {
        jobs,
        folder: Some(args.out().to_owned()),
    })
}

/// The file name without folder and extension.
pub(super) fn stem(path: &Path) -> OsString {
    path.file_stem().unwrap_or_default().to_owned()
}

/// The named files, and the files of the named folders sorted by name.
fn inputs(args: &ConvertArgs) -> anyhow::Result<Vec<Input>> {
    let mut all = Vec::new();
    for path in args.sources() {
        if is_folder(path) {
            all.extend(inside(path, args.onto.is_some())?);
        } else {
            all.push(Input {
                path: path.clone(),
                found: false,
            });
        }
    }
    // Outputs of an earlier run in this folder are not inputs, nor is the character.
    let onto = args.onto.iter();
    let onto = onto.map(PathBuf::as_path);
    let apart: Vec<&Path> = onto.chain([args.out()]).collect();
    all.retain(|input| !input.found || !apart.iter().any(|a| files::same(&input.path, a)));
    Ok(all)
}

/// The files of a folder that can be read; those of faces too if there is a character for them.
fn inside(folder: &Path, with_faces: bool) -> anyhow::Result<Vec<Input>> {
    let place = || files::shown(folder);
    let mut paths = files::in_folder(folder).with_context(place)?;
    let is_face = |path: &Path| files::data_format(path).is_some_and(DataFormat::animates_a_face);
    paths.retain(|path| files::format(path).is_some() || with_faces && is_face(path));
    // Videos have the names of MP4 files with streams.
    let has_none =
        |path: &Path| open::streams_in(path).is_ok_and(|s| s.is_some_and(|s| s.is_empty()));
    paths.retain(|path| !has_none(path));
    // In a folder with motions, skeleton files are not inputs themselves.
    let is = |path: &PathBuf, format| files::format(path) == Some(format);
    if paths.iter().any(|path| is(path, Format::Amc)) {
        paths.retain(|path| !is(path, Format::Asf));
    }
    if paths.is_empty() {
        bail!(
            "{}: no file in this folder can be read; readable are {}",
            place(),
            articula::readable()
        );
    }
    let found = |path| Input { path, found: true };
    Ok(paths.into_iter().map(found).collect())
}
