//! `convert --mesh-level --mesh-distance --mesh-picture`: the mesh levels that are written, and the
//! report about them.

use crate::arguments::{ViewArgs, positive};
use crate::fault;
use crate::files::{self, Files};
use crate::table::{Table, millimetres};
use anyhow::Context;
use articula::core::{ModelPose, Viewport, Wrap, local_to_model, sample};
use articula::flat::Picture;
use articula::{LevelChoice, MeshView, ShownLevelOptions, ShownLevels, ShownLevelsReport, facing};
use articula_report::{FacetRow, UsedAt, facet_sheet};
use clap::Args;
use std::path::{Path, PathBuf};

/// Choice of mesh levels.
#[derive(Debug, Clone, Args)]
pub(super) struct MeshArgs {
    /// Write the mesh at one of its levels (0 is the finest); or regions of the body at levels of their
    /// own, as face=0,rest=3, where regions without a level have that of rest, or 0; or with
    /// --mesh-distance the coarsest level within an error, as 2px
    #[arg(long, value_name = "LEVEL|REGION=LEVEL,…|PXpx", value_parser = level)]
    mesh_level: Option<LevelArgument>,
    /// Distance from the camera in metres at which the error of the mesh is reported in pixels;
    /// without --mesh-level it chooses the coarsest level within 1px
    #[arg(long, value_name = "M", value_parser = positive)]
    mesh_distance: Option<f32>,
    #[command(flatten)]
    view: ViewArgs,
    /// Write a picture of the chosen levels below the original, with every triangle visible
    #[arg(long, value_name = "OUT.png")]
    mesh_picture: Option<PathBuf>,
}

/// How a level is chosen.
#[derive(Debug, Clone, PartialEq)]
enum LevelArgument {
    Chosen(LevelChoice),
    /// The coarsest within so many pixels.
    Within(f32),
}

impl MeshArgs {
    /// Refuses flags that have no effect.
    pub(super) fn check(&self, folder: bool) -> anyhow::Result<()> {
        if let (Some(LevelArgument::Within(px)), None) = (&self.mesh_level, self.mesh_distance) {
            let what = format!("--mesh-level {px}px needs the distance, --mesh-distance M");
            return Err(fault::usage(what));
        }
        let Some(path) = &self.mesh_picture else {
            return Ok(());
        };
        if self.options().is_none() {
            let what = "--mesh-picture needs --mesh-level or --mesh-distance";
            return Err(fault::usage(what));
        }
        if files::extension(path) != "png" {
            let path = files::shown(path);
            let what = format!("--mesh-picture {path}: pictures are PNG; name the file .png");
            return Err(fault::usage(what));
        }
        if folder {
            let what = "--mesh-picture draws one file; convert the files one by one";
            return Err(fault::usage(what));
        }
        Ok(())
    }

    /// The file that is written besides the result.
    pub(super) fn output(&self) -> Option<&Path> {
        self.mesh_picture.as_deref()
    }

    /// The choice, if there is one.
    pub(super) fn options(&self) -> Option<ShownLevelOptions> {
        let (level, epsilon_px) = match &self.mesh_level {
            Some(LevelArgument::Chosen(level)) => (level.clone(), 1.0),
            Some(LevelArgument::Within(px)) => (LevelChoice::default(), *px),
            None => (LevelChoice::default(), 1.0),
        };
        let view = self.mesh_distance.map(|distance_m| MeshView {
            distance_m,
            epsilon_px,
            viewport: self.view.viewport(),
        });
        let is_asked = self.mesh_level.is_some() || view.is_some();
        is_asked.then_some(ShownLevelOptions { level, view })
    }

    /// Writes the picture, if one was asked for; returns its path.
    pub(super) fn draw(
        &self,
        shown: &ShownLevels,
        files: &Files,
    ) -> anyhow::Result<Option<String>> {
        let Some(path) = &self.mesh_picture else {
            return Ok(None);
        };
        let picture = picture(shown, self.view.viewport())?;
        files::write_png(files, path, &picture).map(Some)
    }
}

/// Parses a level, levels of regions, or an error in pixels.
fn level(text: &str) -> Result<LevelArgument, String> {
    if let Some(number) = text.strip_suffix("px") {
        return positive(number.trim()).map(LevelArgument::Within);
    }
    choice(text).map(LevelArgument::Chosen)
}

fn choice(text: &str) -> Result<LevelChoice, String> {
    let wrong = || "expected a level such as 2, levels of regions such as face=0,rest=3, or 2px";
    let number = |text: &str| text.trim().parse::<u16>().map_err(|_| wrong().to_owned());
    if !text.contains('=') {
        return number(text).map(LevelChoice::Whole);
    }
    let mut named: Vec<(String, u16)> = Vec::new();
    for entry in text.split(',') {
        let (name, level) = entry.split_once('=').ok_or_else(wrong)?;
        let name = name.trim().to_owned();
        if named.iter().any(|(n, _)| *n == name) {
            return Err(format!("\"{name}\" has two levels"));
        }
        named.push((name, number(level)?));
    }
    Ok(LevelChoice::Regions(named))
}

/// Where the shown levels are used: the nearest distance at which the view keeps them; else where their
/// error is a pixel.
fn used_at(report: &ShownLevelsReport, viewport: Viewport) -> Option<UsedAt> {
    let in_view = report
        .view
        .map(|view| view.from_m.unwrap_or(view.distance_m));
    let of_a_pixel = || Some(report.error_lod_m? * viewport.pixels_per_metre(1.0));
    let distance_m = in_view.or_else(of_a_pixel).filter(|metres| *metres > 0.0)?;
    Some(UsedAt {
        distance_m,
        pixels_per_metre: viewport.pixels_per_metre(distance_m),
    })
}

/// The original and the chosen levels, in the first clip after a quarter of its time.
fn picture(shown: &ShownLevels, viewport: Viewport) -> anyhow::Result<Picture> {
    let asset = &shown.asset;
    let mut pose = asset.rig.rest_pose().clone();
    let mut rest = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, &pose, &mut rest);
    if let Some(clip) = asset.clips.first() {
        let secs = f64::from(clip.duration_secs()) / 4.0;
        sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
    }
    let report = &shown.report;
    let levels = report.regions.iter();
    let levels: Vec<String> = levels
        .map(|r| format!("{} {}", r.region, r.level))
        .collect();
    let labels = [report.triangles_before, report.triangles].map(|n| format!("{n} triangles"));
    let rows = [&shown.original, &shown.shown];
    let row = |(label, triangles)| FacetRow { label, triangles };
    let rows: Vec<FacetRow<'_>> = labels
        .iter()
        .map(String::as_str)
        .zip(rows.map(Vec::as_slice))
        .map(row)
        .collect();
    let notes = vec![format!(
        "Above level 0, below levels: {}.",
        levels.join(", ")
    )];
    let facing = facing(&asset.rig, &rest);
    let drawn = facet_sheet(
        (&asset.rig, &asset.mesh),
        (&pose, facing),
        (&rows, used_at(report, viewport)),
        ("Mesh levels", notes),
    );
    drawn.context("the picture of mesh levels")
}

/// Formats the report for people.
pub(super) fn text(report: &ShownLevelsReport) -> String {
    let mut text = format!(
        "mesh: {} -> {} triangles, {} -> {} vertices ({} where the asset itself is drawn)\n",
        report.triangles_before,
        report.triangles,
        report.vertices_before,
        report.vertices,
        report.vertices_in_asset,
    );
    let mut table = Table::new(&["region", "level", "triangles", "of"]);
    for region in &report.regions {
        table.row([
            region.region.clone(),
            region.level.to_string(),
            region.triangles.to_string(),
            region.triangles_before.to_string(),
        ]);
    }
    text.push_str(&table.text());
    text.push_str(&format!(
        "  error: at most {} at rest, {} in motion over {} poses; {} where levels are chosen\n",
        millimetres(report.error_rest_m),
        millimetres(report.error_motion_m),
        report.poses_measured,
        millimetres(report.error_lod_m),
    ));
    if let Some(view) = &report.view {
        let px = view
            .error_px
            .map_or("-".to_owned(), |px| format!("{px:.2}"));
        text.push_str(&format!("  at {} m: {px} px", view.distance_m));
        if let Some(from) = view.from_m {
            let to = view
                .to_m
                .map_or("on".to_owned(), |to| format!("to {to:.1} m"));
            text.push_str(&format!(
                "; within {} px this level is kept from {from:.1} m {to}",
                view.epsilon_px
            ));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_one_number_or_named() {
        assert_eq!(choice("3"), Ok(LevelChoice::Whole(3)));
        let named = vec![("face".to_owned(), 0), ("rest".to_owned(), 2)];
        assert_eq!(choice("face=0, rest=2"), Ok(LevelChoice::Regions(named)));
        assert_eq!(level("1.5px"), Ok(LevelArgument::Within(1.5)));
        for bad in [
            "px",
            "0px",
            "",
            "-1",
            "face",
            "face=",
            "face=0,",
            "face=0,face=1",
            "1,2",
        ] {
            assert!(level(bad).is_err(), "{bad}");
        }
    }
}
