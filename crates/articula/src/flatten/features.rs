//! The small features of a figure: eyes, brows, lips, paint, emblems. They are a few thousandths of the surface, so that
//! simplification by distance alone removes them first, and they are what a viewer looks at.

use articula_flat::flatten::JudgedRegion;
use articula_flat::planar::{PlanarSubject, color_contrast};

/// Radius of the surroundings with which a colour is compared, as a fraction of the face's height: an eye and the
/// skin around it.
const RADIUS: f32 = 0.08;
/// Contrast below which a vertex belongs to no feature, and from which it belongs to one fully, units of CIELAB.
const CONTRAST: [f32; 2] = [6.0, 24.0];
/// Factor on the weight of an error at a feature.
const FACTOR: f32 = 16.0;

/// The same elsewhere: emblems, belts and other paint, which show less than a face.
const FACTOR_ELSEWHERE: f32 = 2.0;

/// Factors on the weight of an error at each vertex, 1 or more, by its contrast with the surroundings in
/// those triangles that are `seen`, on the face and elsewhere.
pub(super) fn features(
    whole: &PlanarSubject<'_>,
    seen: &[bool],
    regions: &[JudgedRegion],
) -> Vec<f32> {
    let is_face = |v: &u32| regions[*v as usize] == JudgedRegion::Face;
    let shown = || whole.triangles.iter().zip(seen).filter(|(_, seen)| **seen);
    let (face, rest): (Vec<[u32; 3]>, Vec<_>) = shown()
        .map(|(t, _)| *t)
        .partition(|t| t.iter().all(is_face));
    let of_face = contrasts(whole, &face, FACTOR);
    let mut factors = contrasts(whole, &rest, FACTOR_ELSEWHERE);
    for (factor, face) in factors.iter_mut().zip(of_face) {
        *factor = factor.max(face);
    }
    factors
}

/// Factors up to `most` by the contrast among some triangles; 1 for vertices of others.
fn contrasts(whole: &PlanarSubject<'_>, triangles: &[[u32; 3]], most: f32) -> Vec<f32> {
    let heights = triangles
        .as_flattened()
        .iter()
        .map(|v| whole.mesh.positions[*v as usize].y);
    let [low, high] = heights.fold([f32::MAX, f32::MIN], |[low, high], y| {
        [low.min(y), high.max(y)]
    });
    if low >= high {
        return vec![1.0; whole.mesh.len()];
    }
    let subject = PlanarSubject {
        triangles,
        ..*whole
    };
    let contrast = color_contrast(&subject, RADIUS * (high - low));
    let factor = |contrast: f32| {
        let share = (contrast - CONTRAST[0]) / (CONTRAST[1] - CONTRAST[0]);
        1.0 + (most - 1.0) * share.clamp(0.0, 1.0)
    };
    contrast.into_iter().map(factor).collect()
}
