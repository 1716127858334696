//! Feature points of a face: the flags, the table and the picture.

use super::WrittenFiles;
use crate::console::Console;
use crate::fault::clean;
use crate::table::Table;
use crate::{fault, files, open};
use articula::core::{ModelPose, local_to_model};
use articula::face::{FaceLayout, face_fdp, face_layout};
use articula::flat::{Appearance, Picture};
use articula::formats::face_points;
use articula::formats::mpeg4::fdp;
use articula::inspect::FaceInspection;
use articula::{Figure, facing};
use articula_report::{FaceMark, clip_sheet, face_sheet, morph_target_sheet};
use clap::Args;
use glam::Vec3;
use std::path::{Path, PathBuf};

/// Number of moments of a clip that are drawn.
const MOMENTS: usize = 28;

/// Flags about the face.
#[derive(Debug, Args)]
pub(super) struct FaceArgs {
    /// Find and list the feature points of the face, and the distances by which facial animation
    /// parameters are measured
    #[arg(long)]
    face: bool,
    /// Feature points that are known, as JSON or in an FDP file for this mesh; the others follow
    #[arg(long, value_name = "F.json|F.fdp")]
    face_points: Option<PathBuf>,
}

impl FaceArgs {
    /// Whether a flag asks for feature points.
    pub(super) fn asks(&self) -> bool {
        self.face || self.face_points.is_some()
    }

    /// The file that is read, if any.
    pub(super) fn input(&self) -> Option<&Path> {
        self.face_points.as_deref()
    }

    /// Finds the points, and writes what was asked for. Returns them and the files written.
    pub(super) fn run(
        &self,
        figure: &Figure,
        files: &WrittenFiles,
        console: &Console,
    ) -> anyhow::Result<(FaceLayout, Vec<String>)> {
        let given = match &self.face_points {
            Some(path) => open::face_points(&figure.opened, path)?,
            None => Vec::new(),
        };
        let layout = face_layout(figure, &given)?;
        let mut written = Vec::new();
        if let Some(path) = &files.face_sheet {
            written.push(files::write_png(
                &console.files,
                path,
                &draw(figure, &layout)?,
            )?);
        }
        if let Some(path) = &files.face_points {
            let bytes = if files::extension(path) == "fdp" {
                fdp::write(&face_fdp(figure, &given)?)
            } else {
                let points = layout.points.iter();
                let points = points.map(|p| (p.point, Vec3::from(p.place_m)));
                face_points::write(&points.collect::<Vec<_>>())
            };
            console.files.write(path, &bytes)?;
            written.push(files::shown(path));
        }
        Ok((layout, written))
    }
}

/// Draws the morph targets and the clip, if that was asked for; returns the files written.
pub(super) fn draw_shapes(
    figure: &Figure,
    clip: Option<usize>,
    files: &WrittenFiles,
    console: &Console,
) -> anyhow::Result<Vec<String>> {
    let mut written = Vec::new();
    if let Some(path) = &files.shape_sheet {
        let none = || fault::usage("--write shape-sheet: the file has no morph target to draw");
        let picture = morph_target_sheet(figure)?.ok_or_else(none)?;
        written.push(files::write_png(&console.files, path, &picture)?);
    }
    if let Some(path) = &files.clip_sheet {
        let none = || fault::usage("--write clip-sheet: the file has no clip to draw");
        let picture = clip_sheet(figure, clip.ok_or_else(none)?, MOMENTS)?;
        written.push(files::write_png(&console.files, path, &picture)?);
    }
    Ok(written)
}

/// Draws the points on the face.
fn draw(figure: &Figure, layout: &FaceLayout) -> anyhow::Result<Picture> {
    let asset = &figure.asset;
    let mut rest = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest);
    let character = figure.opened.character();
    let (look, _) = Appearance::new(&character.materials, &character.images);
    let marks: Vec<FaceMark> = layout
        .points
        .iter()
        .map(|p| FaceMark {
            name: p.name.clone(),
            place: Vec3::from(p.place_m),
            confidence: p.confidence,
            inside: p.vertex.is_none(),
        })
        .collect();
    let notes = vec![
        units_line(layout),
        "green: sure, red: unsure; rings: inside the head".to_owned(),
    ];
    let title = format!("feature points of {}", figure.opened.name());
    let facing = facing(&asset.rig, &rest);
    let figure = (&*asset.rig, &*asset.mesh);
    Ok(face_sheet(figure, &look, facing, &marks, (&title, notes))?)
}

/// What the face can be driven by.
pub(super) fn drives(face: &FaceInspection) -> String {
    let Some(by) = &face.driven_by else {
        return "  driven by: no name of a morph target is known\n".to_owned();
    };
    let mut kinds = Vec::new();
    if by.arkit_shapes > 0 {
        kinds.push(format!("{} of 52 ARKit shapes", by.arkit_shapes));
    }
    if by.visemes > 0 {
        kinds.push(format!("{} of 15 visemes", by.visemes));
    }
    if !by.emotions.is_empty() {
        kinds.push(format!("emotions {}", by.emotions.join(", ")));
    }
    let mut text = format!(
        "  driven by: {}; they show {} of 68 facial animation parameters\n",
        kinds.join("; "),
        by.faps
    );
    for (name, control) in &by.unsure {
        text.push_str(&format!("  unsure: {} as {control}\n", clean(name)));
    }
    text
}

/// Which lids are not moved, and why.
fn lids(layout: &FaceLayout) -> String {
    match &layout.without_lids {
        [Some(left), Some(right)] if left == right => format!("  no lids are moved: {left}\n"),
        lids => {
            let named = ["left", "right"].iter().zip(lids);
            let lines = named.filter_map(|(side, why)| {
                Some(format!(
                    "  the {side} lids are not moved: {}\n",
                    why.as_ref()?
                ))
            });
            lines.collect()
        }
    }
}

/// The table of the points.
pub(super) fn text(layout: &FaceLayout) -> String {
    let mut text = format!(
        "\nface: {:.1} mm from chin to inner brows; {}\n",
        1e3 * layout.height_m,
        units_line(layout)
    );
    for unit in layout.units.iter().filter(|u| u.doubtful) {
        text.push_str(&format!(
            "  {} is {:.2} times that of an average face; look at the points (--write face-sheet=F.png) and give the \
             right ones (--face-points)\n",
            unit.name, unit.ratio
        ));
    }
    if !layout.dropped.is_empty() {
        text.push_str(&format!(
            "  the shape misled at {}; these follow from the others\n",
            layout.dropped.join(", ")
        ));
    }
    text.push_str(&lids(layout));
    let mut table = Table::new(&[
        "point",
        "place",
        "x mm",
        "y mm",
        "z mm",
        "source",
        "confidence",
    ]);
    for point in &layout.points {
        let [x, y, z] = point.place_m.map(|v| format!("{:.1}", 1e3 * v));
        let confidence = format!("{:.2}", point.confidence);
        let cells = [
            point.name.clone(),
            point.is.to_owned(),
            x,
            y,
            z,
            point.source.to_owned(),
            confidence,
        ];
        table.row(cells);
    }
    text.push_str(&table.text());
    text
}

/// The distances of the units in one line.
fn units_line(layout: &FaceLayout) -> String {
    let unit = |u: &articula::face::FaceUnit| format!("{} {:.1}", u.name, 1e3 * u.distance_m);
    let units: Vec<String> = layout.units.iter().map(unit).collect();
    format!("{} mm", units.join(", "))
}
