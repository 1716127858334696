//! Feature points of the face of a figure.

use super::found::FoundFace;
use crate::error::{Context, Result};
use crate::figure::Figure;
use articula_build::face::without_lids;
use articula_core::feature_points::{FEATURE_POINTS, PointId};
use glam::Vec3;
use serde::Serialize;

/// The feature points of a figure's face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceLayout {
    /// Height of the inner brows above the bottom of the chin, metres.
    pub height_m: f32,
    /// Distances by which facial animation parameters are measured.
    pub units: Vec<FaceUnit>,
    /// The 84 points, in the order of the standard.
    pub points: Vec<FeaturePoint>,
    /// Points at which the geometry misled: they follow the template.
    pub dropped: Vec<String>,
    /// Why the lids of the left and of the right eye are not moved by parameters and made blend shapes; null where they
    /// are.
    pub without_lids: [Option<String>; 2],
    /// Places that the geometry shows, in model space; for measuring the search.
    #[serde(skip)]
    pub seen: Vec<(PointId, [f32; 3])>,
}

/// A distance of the neutral face, of which the unit is a 1024th.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceUnit {
    /// Abbreviation in the standard.
    pub name: String,
    /// The distance, metres.
    pub distance_m: f32,
    /// Ratio to that of an average face of the same height.
    pub ratio: f32,
    /// Whether the ratio is so far from 1 that points may be wrong.
    pub doubtful: bool,
}

/// A feature point on a figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeaturePoint {
    /// Group and number, such as `2.10`.
    pub name: String,
    /// Group and number.
    #[serde(skip)]
    pub point: PointId,
    /// Where it is.
    pub is: &'static str,
    /// Place in model space, metres.
    pub place_m: [f32; 3],
    /// Vertex of the figure's mesh that stands for it; null for points inside the head.
    pub vertex: Option<u32>,
    /// How it was found.
    pub source: &'static str,
    /// 0 to 1 (`docs/methods/faces.md`).
    pub confidence: f32,
}

/// Finds the feature points of a figure's face at rest. `given` are points that are known, with
/// their places in model space.
///
/// # Errors
/// [`Error::Unsupported`](crate::Error::Unsupported) that names the file, if it shows too little of a face, such as one of
/// loose parts.
pub fn face_layout(figure: &Figure, given: &[(PointId, Vec3)]) -> Result<FaceLayout> {
    let face = FoundFace::of(figure, given).context(figure.opened.name())?;
    let (head, found) = (&face.head, &face.points);
    let points = found.points.iter().zip(&FEATURE_POINTS);
    let points = points.map(|(found, entry)| FeaturePoint {
        name: named(found.point),
        point: found.point,
        is: entry.place,
        place_m: (head.model_from_head * found.place).to_array(),
        vertex: found.vertex.map(|v| head.vertices[v as usize]),
        source: found.source.name(),
        confidence: found.confidence,
    });
    let units = found.units();
    let ratios = units.ratios(found.height());
    Ok(FaceLayout {
        height_m: found.height(),
        units: ratios
            .into_iter()
            .map(|(unit, ratio)| FaceUnit {
                name: unit.to_string(),
                distance_m: units.distance(unit),
                ratio: ratio.ratio,
                doubtful: ratio.doubtful,
            })
            .collect(),
        points: points.collect(),
        without_lids: without_lids(&head.surface, found).map(|why| Some(why?.to_string())),
        dropped: found.dropped.iter().map(|p| named(*p)).collect(),
        seen: found
            .seen
            .iter()
            .map(|(point, at)| (*point, (head.model_from_head * *at).to_array()))
            .collect(),
    })
}

pub(super) fn named((group, number): PointId) -> String {
    format!("{group}.{number}")
}
