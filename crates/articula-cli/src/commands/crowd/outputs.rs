//! Files that `crowd` writes: scene, plot, picture and buffers.

use super::cast::{self, CastFile};
use super::report::CrowdRunReport;
use super::{CrowdArgs, PICTURE_PX, Piece};
use crate::fault;
use crate::files::{self, Files};
use anyhow::Context;
use articula::crowd::{CrowdBuffers, SceneMeasurement, ScenePlayer, write_scene};
use articula_report::{crowd_plots, scene_picture, stacked};
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
            let svg = stacked(&crowd_plots(&report.measured));
            files.write(path, svg.as_bytes())?;
            report.written.push(files::shown(path));
        }
        if let Some(path) = &self.picture {
            let characters = piece.cast.iter().map(|c| c.opened.character());
            let characters: Vec<_> = characters.collect();
            let (title, notes) = heading(piece, &report.measured);
            let heading = (&title[..], notes);
            let frame = piece.first_frame()?;
            let picture = scene_picture(&frame, &characters, PICTURE_PX, heading);
            let picture = picture.context("drawing the crowd")?;
            let png = picture.to_png().with_context(|| files::shown(path))?;
            files.write(path, &png)?;
            report.written.push(files::shown(path));
        }
        if let Some(folder) = &self.buffers {
            let player = piece.first_frame()?;
            let names = piece.cast.iter().map(|c| c.file.name.as_str());
            for (folder, crowd) in folders(folder, names).zip(player.crowds()) {
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

impl Piece {
    /// The scene with its frame at time 0.
    fn first_frame(&self) -> articula::Result<ScenePlayer> {
        let scene = self.scene.clone();
        let mut player = ScenePlayer::new(&self.assets(), scene, self.options.scene)?;
        player.plan(0.0)?;
        player.evaluate();
        Ok(player)
    }
}

/// Title of the picture and the lines below it: who is drawn, the time of a frame, and the error.
fn heading(piece: &Piece, measured: &SceneMeasurement) -> (String, Vec<String>) {
    let names: Vec<&str> = piece.cast.iter().map(|c| c.file.name.as_str()).collect();
    let title = format!("A crowd of {}: {}", measured.characters, names.join(", "));
    let bound = measured.error_bound_px;
    let bound = bound.map_or("full detail".to_owned(), |px| {
        format!("chosen for {px:.2} px")
    });
    let notes = vec![
        "The first frame: above as it is shown, below in the colours of the levels.".to_owned(),
        format!(
            "Over {} frames: time {:.3} ms per frame (median, {} thread{}), error {:.2} px (p95), {:.2} px (maximum), {bound}.",
            measured.frames,
            measured.frame_ms.median,
            measured.threads,
            if measured.threads == 1 { "" } else { "s" },
            measured.error_px.p95,
            measured.error_px.max,
        ),
        format!(
            "In view {}, hidden {}, behind others or walls {} (medians).",
            measured.visible, measured.hidden, measured.occluded
        ),
    ];
    (title, notes)
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
