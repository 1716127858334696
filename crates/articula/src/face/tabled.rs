//! A head with its feature points and its face animation table.

use super::stored::{found, no_face};
use super::surface::HeadSurface;
use crate::error::Result;
use crate::figure::Figure;
use articula_build::face::{FacePoints, FaceTable};
use articula_core::feature_points::PointId;
use glam::Vec3;

/// A head with its feature points and its table.
pub(super) struct TabledHead {
    pub(super) head: HeadSurface,
    pub(super) points: FacePoints,
    pub(super) table: FaceTable,
}

impl TabledHead {
    /// That of a figure. `given` are points that are known, with their places in model space.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) if it shows too little of a face.
    pub(super) fn of(figure: &Figure, given: &[(PointId, Vec3)]) -> Result<Self> {
        let head = HeadSurface::of(figure);
        let points = found(figure, &head, given)?;
        let table = FaceTable::new(&head.surface, &points);
        let table = table.ok_or_else(|| no_face(&"its feature points lie in a plane"))?;
        Ok(Self {
            head,
            points,
            table,
        })
    }

    /// Units of the face that may be wrong.
    pub(super) fn doubtful(&self) -> Vec<String> {
        let ratios = self.points.units().ratios(self.points.height());
        let doubtful = ratios.into_iter().filter(|(_, r)| r.doubtful);
        doubtful.map(|(unit, _)| unit.to_string()).collect()
    }
}
