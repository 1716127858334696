//! Files that `crowd` writes: scene, plot, picture and buffers.

use super::cast::{self, CastFile};
use super::report::CrowdRunReport;
use super::storage::MatricesName;
use super::{CrowdArgs, PICTURE_PX, Piece};
use crate::crowd::picture;
use crate::crowd::run::Run;
use crate::crowd::stage::TimedCrowd;
use crate::fault;
use crate::files::{self, Files};
use anyhow::Context;
use articula::crowd::{CrowdBuffers, ErrorSummary, write_scene};
use articula_report::{Plot, PlotOptions, Series, line_plot, stacked};
use std::path::{Path, PathBuf};

impl CrowdArgs {
    /// The files that are written.
    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        let all = [&self.save_scene, &self.plot, &self.picture];
        all.into_iter().flatten().map(PathBuf::as_path)
    }

    /// The files of `--buffers` that may exist already; a missing folder has none.
    pub(super) fn buffer_files(&self, cast: &[CastFile]) -> Vec<PathBuf> {
        let mut found = Vec::new();
        if let Some(folder) = &self.buffers {
            let names = cast.iter().map(|c| c.name.as_str());
            for folder in folders(folder, names).filter(|folder| folder.is_dir()) {
                let files = CrowdBuffers::FILES.into_iter();
                let files = files.chain([CrowdBuffers::MANIFEST]);
                found.extend(files.map(|name| folder.join(name)));
            }
        }
        found
    }

    pub(super) fn check_buffers(&self) -> anyhow::Result<()> {
        let Some(folder) = &self.buffers else {
            return Ok(());
        };
        if self.storage.palette == Some(MatricesName::Joints) {
            let what = "--buffers requires palettes of the skin; leave --palette out";
            return Err(fault::usage(what));
        }
        if files::is_no_folder(folder) {
            let folder = files::shown(folder);
            let what = format!("--buffers {folder}: this is no folder; name a folder");
            return Err(fault::usage(what));
        }
        Ok(())
    }

    pub(super) fn check_outputs(&self) -> anyhow::Result<()> {
        let wanted = [
            ("--plot", &self.plot, "svg", "plots are SVG"),
            ("--picture", &self.picture, "png", "pictures are PNG"),
            ("--save-scene", &self.save_scene, "json", "scenes are JSON"),
        ];
        for (flag, path, ending, what) in wanted {
            let Some(path) = path else { continue };
            let found = path.extension().unwrap_or_default();
            if !found.eq_ignore_ascii_case(ending) {
                let path = files::shown(path);
                let mend = format!("name a .{ending} file");
                return Err(fault::usage(format!("{flag} {path}: {what}; {mend}")));
            }
        }
        Ok(())
    }

    /// Writes the scene, plot, picture and buffers that were asked for.
    pub(super) fn write(
        &self,
        piece: &Piece,
        found: &Run,
        report: &mut CrowdRunReport,
        files: &Files,
    ) -> anyhow::Result<()> {
        if let Some(path) = &self.save_scene {
            let relative = cast::relative(&piece.cast, path)?;
            let members = cast::members(&piece.cast, &relative);
            files.write(path, &write_scene(&piece.scene, &members))?;
            report.written.push(files::shown(path));
        }
        if let Some(path) = &self.plot {
            let svg = stacked(&plots(found, self.budget_ms));
            files.write(path, svg.as_bytes())?;
            report.written.push(files::shown(path));
        }
        if let Some(path) = &self.picture {
            let picture = picture::draw(&piece.assets(), &piece.scene, piece.settings, PICTURE_PX)?;
            let png = picture.to_png().with_context(|| files::shown(path))?;
            files.write(path, &png)?;
            report.written.push(files::shown(path));
        }
        if let Some(folder) = &self.buffers {
            let assets = piece.assets();
            let stage = TimedCrowd::first_frame(&assets, piece.scene.clone(), piece.settings)?;
            let names = piece.cast.iter().map(|c| c.file.name.as_str());
            for (folder, crowd) in folders(folder, names).zip(stage.scene.crowds()) {
                let buffers = CrowdBuffers::new(crowd)?.files()?.into_iter();
                let buffers = buffers.map(|(name, bytes)| (folder.join(name), bytes));
                let buffers: Vec<(PathBuf, Vec<u8>)> = buffers.collect();
                files.make_folder(&folder)?;
                files.write_all(&buffers)?;
                let written = buffers.iter().map(|(path, _)| files::shown(path));
                report.written.extend(written);
            }
        }
        Ok(())
    }
}

/// Plots of frame time and error over the time of the scene.
fn plots(found: &Run, budget_ms: Option<f32>) -> Vec<Plot> {
    let options = |title: &str, y: &str, target| PlotOptions {
        title: title.into(),
        x_label: "time (s)".into(),
        y_label: y.into(),
        target,
        ..PlotOptions::default()
    };
    let target = budget_ms.map(|ms| (f64::from(ms), format!("budget {ms} ms")));
    let time = Series {
        points: found.over_time.clone(),
        ..Series::default()
    };
    let line = |name: &str, of: &dyn Fn(&ErrorSummary) -> f64| Series {
        name: name.into(),
        points: found
            .looks
            .iter()
            .map(|l| {
                let one = std::slice::from_ref(l);
                (l.secs, of(&ErrorSummary::of(one)))
            })
            .collect(),
        dashed: name != "p95 of visible characters",
    };
    let errors = [
        line("p95 of visible characters", &|s| s.p95),
        line("max", &|s| s.max),
        line("max within 20 m", &|s| s.near_max),
    ];
    vec![
        Plot {
            name: "frame-time.svg",
            svg: line_plot(
                &options("Processor time of a frame", "time (ms)", target),
                &[time],
            ),
        },
        Plot {
            name: "crowd-error.svg",
            svg: line_plot(&options("Error of the crowd", "error (px)", None), &errors),
        },
    ]
}

/// The folder of each character of a cast: one for each if there are several.
fn folders<'a>(
    folder: &'a Path,
    names: impl ExactSizeIterator<Item = &'a str> + Clone,
) -> impl Iterator<Item = PathBuf> {
    let several = names.len() > 1;
    names.map(move |name| match several {
        true => folder.join(name),
        false => folder.to_owned(),
    })
}
