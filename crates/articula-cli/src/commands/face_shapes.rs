//! `--face-shapes` of `convert` and `flatten`: morph targets for a face, made from its feature points.

use crate::open::face_points;
use articula::CharacterFile;
use articula::face::{FaceShapes, FaceTableTargets, add_face_shapes, add_face_table};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Flags about the morph targets of a face.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct FaceShapeArgs {
    /// Give the face morph targets, made from its feature points; with convert --onto, the face of
    /// that character [default without a value: arkit]
    #[arg(long, value_enum, value_name = "KIND", num_args = 0..=1, require_equals = true,
          default_missing_value = "arkit")]
    face_shapes: Option<ShapesName>,
    /// With --face-shapes: feature points that are known, as JSON or in an FDP file for this mesh; see
    /// inspect --face
    #[arg(long, value_name = "F.json|F.fdp", requires = "face_shapes")]
    face_points: Option<PathBuf>,
}

/// Morph targets to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ShapesName {
    /// The blend shapes of ARKit
    Arkit,
    /// A face animation table: morph targets of single parameters, which drive FAP clips even if the
    /// face has blend shapes
    Fat,
}

/// What was made for a face.
#[derive(Debug, Clone, Default)]
pub(crate) struct MadeFace {
    pub(crate) shapes: Option<FaceShapes>,
    pub(crate) table: Option<FaceTableTargets>,
}

impl FaceShapeArgs {
    /// The file that is read, if any.
    pub(crate) fn input(&self) -> Option<&PathBuf> {
        self.face_points.as_ref()
    }

    /// Whether morph targets are asked for.
    pub(crate) fn asks(&self) -> bool {
        self.face_shapes.is_some()
    }

    /// Adds the morph targets, if they are asked for.
    pub(crate) fn add(&self, opened: &mut CharacterFile) -> anyhow::Result<MadeFace> {
        let mut made = MadeFace::default();
        let Some(name) = self.face_shapes else {
            return Ok(made);
        };
        let given = match &self.face_points {
            Some(path) => face_points(opened, path)?,
            None => Vec::new(),
        };
        match name {
            ShapesName::Arkit => made.shapes = Some(add_face_shapes(opened, &given)?),
            ShapesName::Fat => made.table = Some(add_face_table(opened, &given)?),
        }
        Ok(made)
    }
}

/// Formats what was made.
pub(crate) fn text(shapes: &FaceShapes) -> String {
    let mut text = format!(
        "face: {} blend shapes over {} vertices, made from its feature points\n",
        shapes.made.len(),
        shapes.vertices
    );
    if !shapes.not_made.is_empty() {
        text.push_str(&format!(
            "  nothing of the face shows {}\n",
            shapes.not_made.join(", ")
        ));
    }
    for refused in shapes.refused.chunk_by(|a, b| a.why == b.why) {
        let names: Vec<&str> = refused.iter().map(|r| r.shape).collect();
        text.push_str(&format!(
            "  not made: {}: {}\n",
            names.join(", "),
            refused[0].why
        ));
    }
    text + &doubt(&shapes.doubtful)
}

/// Formats what the table shows.
pub(crate) fn table_text(table: &FaceTableTargets) -> String {
    let mut text = format!(
        "face: a table of {} parameters as {} morph targets over {} vertices, made from its feature points\n",
        table.faps.len(),
        table.targets,
        table.vertices
    );
    if !table.not_shown.is_empty() {
        let faps: Vec<String> = table.not_shown.iter().map(usize::to_string).collect();
        text.push_str(&format!(
            "  nothing of the face shows FAP {}\n",
            faps.join(", ")
        ));
    }
    text + &doubt(&table.doubtful)
}

/// Says which units of the face may be wrong.
fn doubt(units: &[String]) -> String {
    if units.is_empty() {
        return String::new();
    }
    format!(
        "  points may be wrong ({} unusual): look at them with inspect --write face-sheet=F.png, and give the \
         right ones with --face-points\n",
        units.join(", ")
    )
}
