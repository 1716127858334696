//! Feature points that an asset keeps.

use super::surface::HeadSurface;
use articula_build::face::{FacePoint, FacePoints, PointSource};
use articula_core::feature_points::{FEATURE_POINT_COUNT, PointId};
use articula_formats::gltf::{Document, StoredFace};
use glam::Vec3;

/// Distance from the skin from which a stored point is not on the head, by the height of the face.
const FAR: f32 = 0.15;
/// Number of such points up to which the points are those of the head: the top of the skull may be of
/// another part, such as hair.
const MOST_FAR: usize = 8;

/// The points that a document stores; `None` without all of them, for those that cannot be read, and
/// for those that do not lie on the head.
pub(super) fn points(document: &Document, head: &HeadSurface) -> Option<FacePoints> {
    let stored = document.face().ok().flatten()?;
    if stored.points.len() != FEATURE_POINT_COUNT {
        return None;
    }
    on_head(&stored, head)
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
