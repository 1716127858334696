//! A face that moves with a body: how many parameters the error leaves that the body does not use.

use super::detail::MeasuredFace;
use super::fit::{NotDriven, fit_face};
use super::found::FoundFace;
use crate::error::Result;
use crate::figure::Figure;
use articula_core::Viewport;
use articula_core::face_levels::FapRoles;
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_formats::mpeg4::fap::FapClip;
use serde::Serialize;

/// A face clip beside a body at levels of detail, under one error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceWithBody {
    /// Name of the FAP file.
    pub file: String,
    /// Tolerated error of body and face together, pixels.
    pub tolerance_px: f32,
    /// Number of parameters that move in the clip.
    pub moving: usize,
    /// Those of them that nothing of the face shows.
    pub not_driven: Vec<NotDriven>,
    /// Mean confidence of the feature points that parameters move, 0 to 1; null if no face is found.
    pub confidence: Option<f32>,
    /// One entry for each distance.
    pub rows: Vec<FaceWithBodyRow>,
}

/// Body and face at a distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceWithBodyRow {
    /// Distance from the camera in metres.
    pub distance_m: f32,
    /// Greatest error of a vertex of the head by the body's method, pixels.
    pub body_px: f32,
    /// Numbers of the parameters that are kept.
    pub parameters: Vec<usize>,
    /// Greatest error of a vertex by those that are left out, pixels.
    pub face_px: f32,
    /// Both together, which no vertex of the head exceeds.
    pub both_px: f32,
    /// Whether both together are within the tolerance.
    pub meets_target: bool,
}

/// Chooses the parameters of a face clip for each distance: as few as keep their error within what the
/// body leaves of the tolerance. `body` are distances in metres, and the greatest error of a vertex of
/// the head there in pixels.
///
/// # Errors
/// As from [`fit_face`](super::fit_face).
pub fn face_with_body(
    clip: &FapClip,
    file: &str,
    figure: &Figure,
    body: &[[f32; 2]],
    tolerance_px: f32,
    viewport: Viewport,
) -> Result<FaceWithBody> {
    let shown = fit_face(clip, file, &figure.opened)?.report;
    let face = MeasuredFace::new(clip, file, figure)?;
    let detail = face.detail();
    let all = FapRoles::keeping(&[true; FAP_COUNT]);
    let row = |[distance_m, body_px]: &[f32; 2]| {
        let px = viewport.pixels_per_metre(*distance_m);
        let left_px = (tolerance_px - body_px).max(0.0);
        let kept = detail.faps_within(&all, left_px / px);
        let face_px = px * detail.error_m(&kept);
        FaceWithBodyRow {
            distance_m: *distance_m,
            body_px: *body_px,
            parameters: LOW_FAPS.filter(|fap| kept.keeps(*fap)).collect(),
            face_px,
            both_px: body_px + face_px,
            meets_target: body_px + face_px <= tolerance_px,
        }
    };
    Ok(FaceWithBody {
        file: file.to_owned(),
        tolerance_px,
        moving: shown.faps_moving,
        not_driven: shown.not_driven,
        confidence: FoundFace::of(figure, &[])
            .ok()
            .map(|face| face.confidence()),
        rows: body.iter().map(row).collect(),
    })
}
