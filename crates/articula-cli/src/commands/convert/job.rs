//! One file of a conversion: read, changed as asked for, written.

use super::onto::{self, Hero, NoClip};
use super::plan::{Input, Job};
use super::report::{Onto, Report};
use super::written::{self, Asked};
use super::{ConvertArgs, reduction};
use crate::open;
use crate::table::counted;
use crate::{fault, files};
use anyhow::{Context, bail};
use articula::{Format, Opened, Writes};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::path::PathBuf;

/// What became of one job.
#[derive(Debug)]
pub(super) struct Done {
    /// The file that was written, if any was.
    pub(super) report: Option<Report>,
    /// Files that were not used, and why.
    pub(super) faults: Vec<(PathBuf, anyhow::Error)>,
}

/// What one job writes.
struct Work {
    opened: Opened,
    /// Whether the clips are other than the document of the character has.
    changed: bool,
    /// Clips that were dropped because the format holds one.
    dropped: usize,
    report: Report,
}

/// Runs one job; the bar moves on for every file that was read.
pub(super) fn run(job: &Job, args: &ConvertArgs, hero: Option<&Hero>, bar: &ProgressBar) -> Done {
    let mut faults = Vec::new();
    let work = match hero {
        None => {
            let read = read(job, args);
            bar.inc(1);
            read.map(Some)
        }
        Some(hero) => gathered(job, args, hero, bar, &mut faults),
    };
    let report = work.and_then(|work| work.map(|work| finished(job, args, work)).transpose());
    let report = report.unwrap_or_else(|fault| {
        faults.push((job.inputs[0].path.clone(), fault));
        None
    });
    Done { report, faults }
}

/// One file as it is.
fn read(job: &Job, args: &ConvertArgs) -> anyhow::Result<Work> {
    let input = &job.inputs[0];
    let mut opened = open::character(&input.path, &args.names)?;
    check_pair(opened.format, job.format, args)?;
    let place = opened.name.clone();
    if input.found && files::same(&input.path, &job.out) {
        bail!("{place}: it would be replaced by what is made of it; name another folder");
    }
    let dropped = choose_clips(args, &mut opened, job.format).context(place)?;
    let mut report = Report::new(job, opened.name.clone());
    report.format_in = opened.format.name().to_owned();
    report.bytes_in = opened.bytes;
    report.warnings = open::warnings(&opened);
    Ok(Work {
        changed: dropped > 0,
        dropped: if args.clip.is_none() { dropped } else { 0 },
        opened,
        report,
    })
}

/// The character with the motions of several files; none if no file could be used.
fn gathered(
    job: &Job,
    args: &ConvertArgs,
    hero: &Hero,
    bar: &ProgressBar,
    faults: &mut Vec<(PathBuf, anyhow::Error)>,
) -> anyhow::Result<Option<Work>> {
    check_pair(hero.opened.format, job.format, args)?;
    let mut report = Report::new(job, job.named.clone());
    report.warnings = open::warnings(&hero.opened);
    let motions = |input: &Input| {
        let motions = hero.motions(input, args);
        bar.inc(1);
        motions
    };
    let results: Vec<_> = job.inputs.par_iter().map(motions).collect();
    let mut all = Vec::new();
    for (input, motions) in job.inputs.iter().zip(results) {
        match motions {
            Ok(motions) => all.push(motions),
            Err(fault) if input.found && fault.downcast_ref::<NoClip>().is_some() => {
                let place = files::shown(&input.path);
                report.left_out.push(format!("{place} (it has no clip)"));
            }
            Err(fault) => faults.push((input.path.clone(), fault)),
        }
    }
    if all.is_empty() {
        return Ok(None);
    }
    let mut opened = hero.opened.clone();
    let clips = &mut opened.character.clips;
    if !args.keep_clips {
        clips.clear();
    }
    onto::distinct(clips, &mut all);
    let mut formats: Vec<&str> = all.iter().map(|m| m.report.format).collect();
    formats.dedup();
    report.format_in = formats.join(", ");
    report.bytes_in = all.iter().map(|m| m.report.bytes).sum();
    let kept = clips.len();
    report
        .warnings
        .extend(all.iter_mut().flat_map(|m| m.warnings.drain(..)));
    report.onto = Some(Onto {
        character: hero.opened.name.clone(),
        clips_kept: kept,
        motions: Vec::new(),
    });
    for motions in all {
        clips.extend(motions.clips);
        if let Some(onto) = &mut report.onto {
            onto.motions.push(motions.report);
        }
    }
    let mut dropped = 0;
    if written::holds_one_clip(job.format) {
        // The motion is what was asked for, not what the character had before.
        dropped = clips.len() - 1;
        *clips = vec![clips.swap_remove(kept)];
    }
    Ok(Some(Work {
        opened,
        changed: true,
        dropped,
        report,
    }))
}

/// Changes what is asked for, and writes.
fn finished(job: &Job, args: &ConvertArgs, work: Work) -> anyhow::Result<Report> {
    let Work {
        mut opened,
        changed,
        dropped,
        mut report,
    } = work;
    let place = opened.name.clone();
    report.edits = args.hygiene.apply(&mut opened)?;
    report.reduction = reduction::apply(args, &mut opened)?;
    args.hygiene.reduce_keys(&mut opened, &mut report.edits)?;
    let reduced = report.reduction.is_some();
    let asked = Asked {
        clips_changed: changed || reduced || !report.edits.is_empty(),
        khr_character: args.khr_character,
    };
    let made = written::written(&opened, &job.out, job.format, asked);
    let made = made.context(place)?;
    for (path, bytes) in &made.files {
        files::write(path, bytes)?;
    }
    report.left_out.extend(made.left_out);
    if dropped > 0 {
        let dropped = counted(dropped, "clip", "clips");
        let format = job.format.name();
        report.left_out.push(format!(
            "{dropped} (a .{format} file holds one; --clip NAME chooses)"
        ));
    }
    if reduced && written::holds_one_clip(job.format) {
        let format = job.format.name();
        report.warnings.push(format!(
            "a .{format} file stores every joint in every frame, so it gets no smaller; write .glb to save bytes"
        ));
    }
    let clips = opened.character.clips.iter();
    report.clips = clips.map(|c| c.name.clone()).collect();
    report.bytes_out = made.files.iter().map(|(_, bytes)| bytes.len()).sum();
    let beside = made.files[1..].iter();
    report.beside = beside.map(|(path, _)| files::shown(path)).collect();
    Ok(report)
}

fn check_pair(input: Format, out: Format, args: &ConvertArgs) -> anyhow::Result<()> {
    if args.khr_character && out != Format::Glb {
        let what = "--khr-character writes into a .glb file, not into a";
        return Err(fault::usage(format!("{what} .{}", out.name())));
    }
    let fits = match out.writes() {
        Writes::Any => true,
        Writes::Back => input == out,
        Writes::Never => false,
    };
    if fits {
        return Ok(());
    }
    Err(fault::usage(format!(
        "{} to {} is not converted; converted are {}",
        input.name(),
        out.name(),
        articula::conversions()
    )))
}

/// Keeps the clips that go into the output; says how many were dropped.
fn choose_clips(args: &ConvertArgs, opened: &mut Opened, out: Format) -> anyhow::Result<usize> {
    let clips = &mut opened.character.clips;
    let index = match &args.clip {
        Some(name) => open::choose("clip", name, clips.iter().map(|c| c.name.as_str()))?,
        None if written::holds_one_clip(out) && !clips.is_empty() => 0,
        None if written::needs_a_clip(out) => {
            anyhow::bail!("clips: there is none to write; give a file that has one")
        }
        None => return Ok(0),
    };
    let dropped = clips.len() - 1;
    *clips = vec![clips.swap_remove(index)];
    Ok(dropped)
}
