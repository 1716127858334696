//! One job of a conversion: files are read, changed as asked for, and written.

use super::joint_scheme::SchemeName;
use super::onto::{Hero, MotionReport};
use super::plan::{Input, Job};
use super::reduction::{Reduction, Selected};
use super::report::{self, ConvertReport, Onto};
use super::{ConvertArgs, boxing};
use crate::console::on_all_processors;
use crate::files::{self, Files};
use crate::open;
use anyhow::bail;
use articula::convert::ConvertOptions;
use articula::{CharacterFile, ClipResampling};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Result of one job.
#[derive(Debug)]
pub(super) struct Done {
    /// Report of the file that was written, if any was.
    pub(super) report: Option<ConvertReport>,
    /// Files that were not used, with the reasons.
    pub(super) faults: Vec<(PathBuf, anyhow::Error)>,
}

/// Settings that all jobs share.
pub(super) struct Recipe<'a> {
    pub(super) args: &'a ConvertArgs,
    pub(super) hero: Option<Hero>,
    pub(super) selected: Option<Selected>,
    pub(super) files: &'a Files,
    /// The output folder, if there is one.
    pub(super) folder: Option<&'a Path>,
    /// Progress bar; advances with every file read.
    pub(super) bar: ProgressBar,
}

impl Recipe<'_> {
    /// Runs one job.
    pub(super) fn run(&self, job: &Job) -> Done {
        let mut faults = Vec::new();
        let made = match &self.hero {
            None => {
                let read = self.read(job);
                self.bar.inc(1);
                read.map(Some)
            }
            Some(hero) => self.gathered(job, hero, &mut faults),
        };
        let finished = |(opened, report)| self.finished(job, opened, report);
        let report = made.and_then(|made| made.map(finished).transpose());
        let report = report.unwrap_or_else(|fault| {
            faults.push((job.inputs[0].path.clone(), fault));
            None
        });
        Done { report, faults }
    }

    /// Reads one file without changes.
    fn read(&self, job: &Job) -> anyhow::Result<(CharacterFile, ConvertReport)> {
        let input = &job.inputs[0];
        let mut opened = open::motion(self.files, &input.path, &self.args.names)?;
        self.options(self.args.clip.clone())
            .check(opened.format(), job.format)?;
        let mut report = ConvertReport::new(job, opened.name().to_owned());
        report.put_face(&self.args.shapes.add(&mut opened)?);
        report.format_in = opened.format().name().to_owned();
        report.bytes_in = opened.bytes();
        report.warnings = open::warnings(opened.warnings());
        Ok((opened, report))
    }

    /// The character with the motions of several files; an error if no file could be used.
    fn gathered(
        &self,
        job: &Job,
        hero: &Hero,
        faults: &mut Vec<(PathBuf, anyhow::Error)>,
    ) -> anyhow::Result<Option<(CharacterFile, ConvertReport)>> {
        self.options(None).check(hero.opened.format(), job.format)?;
        let mut report = ConvertReport::new(job, job.named.clone());
        report.warnings = open::warnings(hero.opened.warnings());
        report.put_face(&hero.made);
        let motions = |input: &Input| {
            let motions = hero.motions(input, self.args, self.files);
            self.bar.inc(1);
            motions
        };
        let results: Vec<_> = job.inputs.par_iter().map(motions).collect();
        let (mut fitted, mut reports) = (Vec::new(), Vec::new());
        let mut formats: Vec<&str> = Vec::new();
        for (input, result) in job.inputs.iter().zip(results) {
            match result {
                Ok(Some(new)) => {
                    fitted.extend(new.fitted);
                    formats.push(new.format);
                    report.bytes_in += new.bytes;
                    report.warnings.extend(new.warnings);
                    reports.push(new.report);
                }
                Ok(None) => {
                    let place = files::shown(&input.path);
                    report.left_out.push(format!("{place} (it has no clip)"));
                }
                Err(fault) => faults.push((input.path.clone(), fault)),
            }
        }
        if reports.is_empty() {
            return Ok(None);
        }
        let mut opened = hero.opened.clone();
        let fits = opened.put_clips(fitted, self.args.keep_clips);
        let names = reports.iter_mut().flat_map(MotionReport::names);
        for (name, fit) in names.zip(&fits) {
            name.clone_from(&fit.name);
        }
        let clips = opened.character().clips.len();
        let kept = clips - fits.len();
        if job.format.holds_one_clip() {
            // The new motions come first, the clips that the character had before last.
            let order: Vec<usize> = (kept..clips).chain(0..kept).collect();
            opened.select_clips(&order);
        }
        let (mut motions, mut faces) = (Vec::new(), Vec::new());
        for report in reports {
            match report {
                MotionReport::Body(body) => motions.push(body),
                MotionReport::Face(face) => faces.push(face),
            }
        }
        let retargeted = motions.iter().flat_map(|motion| &motion.clips);
        let resampled = retargeted.filter_map(|clip| clip.resampling.as_ref());
        let told = resampled.filter_map(ClipResampling::warning);
        report.warnings.extend(told);
        formats.dedup();
        report.format_in = formats.join(", ");
        report.onto = Some(Onto {
            character: hero.opened.name().to_owned(),
            clips_kept: kept,
            motions,
            faces,
        });
        Ok(Some((opened, report)))
    }

    /// Applies the edits that were asked for, and writes the file.
    fn finished(
        &self,
        job: &Job,
        opened: CharacterFile,
        mut report: ConvertReport,
    ) -> anyhow::Result<ConvertReport> {
        let reduces = self.selected.is_some();
        if reduces && opened.character().clips.is_empty() && !job.format.needs_a_clip() {
            let place = opened.name();
            bail!("{place}: clips: the file has none to reduce; leave --loa out");
        }
        let clip = self.hero.is_none().then(|| self.args.clip.clone());
        let options = self.options(clip.flatten());
        let opened_name = opened.name().to_owned();
        let made = articula::convert(opened, job.format, &options, &on_all_processors());
        let made = made.map_err(|fault| self.placed(fault))?;
        let mut bytes = Cow::Borrowed(&made.written.bytes[..]);
        if !self.args.with.is_empty() {
            let first = (opened_name, bytes.into_owned());
            bytes = Cow::Owned(boxing::with(self.args, self.files, first)?);
        }
        let mut files: Vec<(PathBuf, &[u8])> = vec![(job.out.clone(), &bytes)];
        if let Some((format, bytes)) = &made.written.beside {
            files.push((job.out.with_extension(format.name()), bytes));
        }
        if let Some(folder) = self.folder {
            self.files.make_folder(folder)?;
        }
        self.files.write_all(&files)?;
        let left_out = made.written.left_out.iter();
        report
            .left_out
            .extend(left_out.map(|what| report::left_out(what, job.format.name())));
        if reduces && job.format.stores_every_joint() {
            let format = job.format.name();
            report.warnings.push(format!(
                "a .{format} file stores every joint in every frame, so the file does not become smaller; write .glb to save bytes"
            ));
        }
        if let Some(shown) = made.mesh {
            report
                .written
                .extend(self.args.mesh.draw(&shown, self.files)?);
            report.mesh = Some(shown.report);
        }
        report.tiers = made.written.tiers;
        if made.joint_scheme.as_ref().is_some_and(|s| s.drops_prepared) {
            let what =
                "the prepared data, which was computed for the joints before (build makes it anew)";
            report.left_out.push(what.to_owned());
        }
        report.joint_scheme = made.joint_scheme;
        report.edits = made.edits;
        let told = made.resampling.iter().filter_map(ClipResampling::warning);
        report.warnings.extend(told);
        report.resampling = made.resampling;
        let reduction = self.selected.as_ref().zip(made.reduction);
        report.reduction = reduction.map(|(selected, saved)| Reduction::new(selected, saved));
        report.clips = made.clips;
        report.bytes_out = files.iter().map(|(_, bytes)| bytes.len()).sum();
        let beside = files[1..].iter();
        report.beside = beside.map(|(path, _)| files::shown(path)).collect();
        Ok(report)
    }

    fn options(&self, clip: Option<String>) -> ConvertOptions {
        ConvertOptions {
            clip,
            mesh: self.args.mesh.options(),
            joint_scheme: self.args.joint_scheme.map(SchemeName::of_library),
            edits: self.args.hygiene.edits(),
            reduction: self.selected.as_ref().map(|s| s.reduction.clone()),
            khr_character: self.args.khr_character,
            abp: self.args.stream.profile(),
        }
    }

    /// An error of the library with the flags that caused it.
    fn placed(&self, fault: articula::Error) -> articula::Error {
        let mut fault = match &self.selected {
            Some(selected) => selected.placed(fault),
            None => fault,
        };
        if let articula::Error::At { cause, .. } = &mut fault
            && let articula::Error::At { place, .. } = &mut **cause
            && place == "trim"
        {
            "--trim (--clip NAME chooses one clip)".clone_into(place);
        }
        fault
    }
}
