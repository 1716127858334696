//! The small features of a face: eyes, brows, lips, paint. They are a few thousandths of the surface, so that
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

/// Factors on the weight of an error at each vertex of the face, 1 or more, by its contrast with the
/// surroundings in those triangles that are `seen`; 1 elsewhere.
pub(super) fn features(
    whole: &PlanarSubject<'_>,
    seen: &[bool],
    regions: &[JudgedRegion],
) -> Vec<f32> {
    let mut factors = vec![1.0; regions.len()];
    let of_face = |v: &u32| regions[*v as usize] == JudgedRegion::Face;
    let shown = whole.triangles.iter().zip(seen);
    let face: Vec<[u32; 3]> = shown
        .filter(|(t, seen)| **seen && t.iter().all(of_face))
        .map(|(t, _)| *t)
        .collect();
    let heights = face
        .as_flattened()
        .iter()
        .map(|v| whole.mesh.positions[*v as usize].y);
    let [low, high] = heights.fold([f32::MAX, f32::MIN], |[low, high], y| {
        [low.min(y), high.max(y)]
    });
    if low >= high {
        return factors;
    }
    let subject = PlanarSubject {
        triangles: &face,
        ..*whole
    };
    let contrast = color_contrast(&subject, RADIUS * (high - low));
    let (least, most) = (CONTRAST[0], CONTRAST[1]);
    for (factor, contrast) in factors.iter_mut().zip(contrast) {
        let share = ((contrast - least) / (most - least)).clamp(0.0, 1.0);
        *factor = 1.0 + (FACTOR - 1.0) * share;
    }
    factors
}
