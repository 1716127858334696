//! `convert --face-shapes`: blend shapes for a face without them.

use crate::open::face_points;
use articula::CharacterFile;
use articula::face::{FaceShapes, add_face_shapes};
use clap::Args;
use std::path::PathBuf;

/// Flags about the blend shapes of a face.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct FaceShapeArgs {
    /// Give the face the blend shapes of ARKit, made from its feature points; with --onto, the face of
    /// that character
    #[arg(long)]
    face_shapes: bool,
    /// With --face-shapes: feature points that are known, as JSON or in an FDP file for this mesh; see
    /// inspect --face
    #[arg(long, value_name = "F.json|F.fdp", requires = "face_shapes")]
    face_points: Option<PathBuf>,
}

impl FaceShapeArgs {
    /// The file that is read, if any.
    pub(super) fn input(&self) -> Option<&PathBuf> {
        self.face_points.as_ref()
    }

    /// Whether blend shapes are asked for.
    pub(super) fn asks(&self) -> bool {
        self.face_shapes
    }

    /// Adds the blend shapes, if they are asked for.
    pub(super) fn add(&self, opened: &mut CharacterFile) -> anyhow::Result<Option<FaceShapes>> {
        if !self.face_shapes {
            return Ok(None);
        }
        let given = match &self.face_points {
            Some(path) => face_points(opened, path)?,
            None => Vec::new(),
        };
        Ok(Some(add_face_shapes(opened, &given)?))
    }
}

/// Formats what was made.
pub(super) fn text(shapes: &FaceShapes) -> String {
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
    if !shapes.doubtful.is_empty() {
        text.push_str(&format!(
            "  points may be wrong ({} unusual): look at them with inspect --face-sheet, and give the \
             right ones with --face-points\n",
            shapes.doubtful.join(", ")
        ));
    }
    text
}
