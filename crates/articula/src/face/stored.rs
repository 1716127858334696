//! Feature points that an asset keeps.

use super::surface::HeadSurface;
use crate::error::{Error, Result};
use crate::figure::Figure;
use articula_build::face::{FacePoint, FacePoints, PointSource};
use articula_core::fap_table::FapUnit;
use articula_core::feature_points::{FEATURE_POINT_COUNT, PointId};
use articula_formats::gltf::{StoredFace, StoredPoint};
use glam::Vec3;
use std::fmt::Display;

/// Distance from the skin from which a stored point is not on the head, by the height of the face.
const FAR: f32 = 0.15;
/// Number of such points up to which the points are those of the head: the top of the skull may be of
/// another part, such as hair.
const MOST_FAR: usize = 8;

/// The feature points of a figure's head. `given` are points that are known, with their places in
/// model space. Without any, those that the document stores are used, if they lie on the head.
///
/// # Errors
/// [`Error::Unsupported`](crate::Error::Unsupported) if the surface shows too little of a face.
pub(super) fn found(
    figure: &Figure,
    head: &HeadSurface,
    given: &[(PointId, Vec3)],
) -> Result<FacePoints> {
    let to_head = head.model_from_head.inverse();
    if given.is_empty()
        && let Some(stored) = kept(figure)
        && let Some(points) = on_head(&stored, head)
    {
        return Ok(points);
    }
    let given: Vec<(PointId, Vec3)> = given.iter().map(|(p, at)| (*p, to_head * *at)).collect();
    FacePoints::find(&head.surface, &given).map_err(|e| no_face(&e))
}

/// The error of a figure that shows too little of a face.
pub(super) fn no_face(what: &dyn Display) -> Error {
    let what = format!("face: {what}; feature points need a closed face with nose and mouth");
    Error::unsuited(what)
}

/// The feature points of a figure, as an asset stores them; `None` if it shows too little of a face.
pub(crate) fn stored_face(figure: &Figure, given: &[(PointId, Vec3)]) -> Option<StoredFace> {
    let head = HeadSurface::of(figure);
    let found = found(figure, &head, given).ok()?;
    let units = found.units();
    let points = found.points.iter().map(|p| StoredPoint {
        point: p.point,
        position: head.model_from_head * p.place,
        source: p.source.name().to_owned(),
        confidence: p.confidence,
    });
    Some(StoredFace {
        rotation: head.model_from_head,
        units: FapUnit::DISTANCES.map(|u| (u, units.distance(u))).to_vec(),
        points: points.collect(),
    })
}

/// All points of a document; `None` without any, and for those that cannot be read.
fn kept(figure: &Figure) -> Option<StoredFace> {
    let document = &figure.opened.gltf.as_ref()?.document;
    let stored = document.face().ok().flatten()?;
    (stored.points.len() == FEATURE_POINT_COUNT).then_some(stored)
}

/// Stored points on the head; `None` if they are far from it.
fn on_head(stored: &StoredFace, head: &HeadSurface) -> Option<FacePoints> {
    let to_head = head.model_from_head.inverse();
    let places = stored
        .points
        .iter()
        .map(|p| (p.point, to_head * p.position));
    let places: Vec<(PointId, Vec3)> = places.collect();
    let mut points = FacePoints::find(&head.surface, &places).ok()?;
    let far = FAR * points.height();
    let is_far = |point: &&FacePoint| {
        let at = |vertex: u32| head.surface.positions[vertex as usize];
        point
            .vertex
            .is_some_and(|v| at(v).distance(point.place) > far)
    };
    if points.points.iter().filter(is_far).count() > MOST_FAR {
        return None;
    }
    for (point, stored) in points.points.iter_mut().zip(&stored.points) {
        let named = PointSource::ALL
            .into_iter()
            .find(|s| s.name() == stored.source);
        point.source = named.unwrap_or(PointSource::Given);
        point.confidence = stored.confidence;
    }
    Some(points)
}
