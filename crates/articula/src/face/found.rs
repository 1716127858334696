//! A head with its feature points.

use super::stored;
use super::surface::HeadSurface;
use crate::error::{Error, Result};
use crate::figure::Figure;
use articula_build::face::{FacePoints, FaceTable};
use articula_core::fap_table::TABLE;
use articula_core::feature_points::PointId;
use articula_formats::gltf::Document;
use glam::Vec3;
use std::fmt::Display;

/// A head with its feature points.
pub(crate) struct FoundFace {
    pub(crate) head: HeadSurface,
    pub(crate) points: FacePoints,
}

impl FoundFace {
    /// That of a figure. `given` are points that are known, with their places in model space.
    /// Without any, those that its document stores are used, if they lie on the head.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the surface shows too little of a face.
    pub(crate) fn of(figure: &Figure, given: &[(PointId, Vec3)]) -> Result<Self> {
        let document = figure.opened.gltf().map(|gltf| &gltf.document);
        Self::in_document(figure, document, given)
    }

    /// As [`FoundFace::of`], of a figure whose document is kept elsewhere.
    pub(crate) fn in_document(
        figure: &Figure,
        document: Option<&Document>,
        given: &[(PointId, Vec3)],
    ) -> Result<Self> {
        let head = HeadSurface::of(figure);
        if given.is_empty()
            && let Some(points) = document.and_then(|document| stored::points(document, &head))
        {
            return Ok(Self { head, points });
        }
        let to_head = head.model_from_head.inverse();
        let given: Vec<(PointId, Vec3)> = given.iter().map(|(p, at)| (*p, to_head * *at)).collect();
        let points = FacePoints::find(&head.surface, &given).map_err(|e| no_face(&e))?;
        Ok(Self { head, points })
    }

    /// Its face animation table.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if its feature points lie in a plane.
    pub(crate) fn table(&self) -> Result<FaceTable> {
        let table = FaceTable::new(&self.head.surface, &self.points);
        table.ok_or_else(|| no_face(&"its feature points lie in a plane"))
    }

    /// Mean confidence of the feature points that parameters move, 0 to 1.
    pub(crate) fn confidence(&self) -> f32 {
        let moved = |point: &PointId| {
            TABLE
                .iter()
                .any(|f| f.action.is_some_and(|a| a.point == *point))
        };
        let points = self.points.points.iter().filter(|p| moved(&p.point));
        let (count, sum) = points.fold((0, 0.0), |(n, sum), p| (n + 1, sum + p.confidence));
        sum / (count as f32).max(1.0)
    }

    /// Units of the face that may be wrong.
    pub(crate) fn doubtful(&self) -> Vec<String> {
        let ratios = self.points.units().ratios(self.points.height());
        let doubtful = ratios.into_iter().filter(|(_, r)| r.doubtful);
        doubtful.map(|(unit, _)| unit.to_string()).collect()
    }
}

/// The error of a figure that shows too little of a face.
fn no_face(what: &dyn Display) -> Error {
    let what = format!("face: {what}; feature points need a closed face with nose and mouth");
    Error::unsuited(what)
}
