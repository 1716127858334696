//! Colour tolerances of small triangles and slivers, which contribute little to the error of a picture.

use glam::Vec2;

/// Triangles smaller than this, in square pixels, have a larger colour tolerance: twice for a
/// quarter of the area, so that their contribution to the image error stays the same.
const SMALL_PX2: f64 = 16.0;
/// Slivers thinner than this, in pixels, have a larger colour tolerance too.
const THIN_PX: f64 = 3.0;

/// Area in square pixels.
pub(super) fn area([a, b, c]: &[Vec2; 3]) -> f64 {
    f64::from((*b - *a).perp_dot(*c - *a).abs()) / 2.0
}

/// Factor of the colour tolerance of small triangles and slivers.
pub(super) fn slack_of_small(places: &[Vec2; 3]) -> f64 {
    let [a, b, c] = *places;
    let area = area(places);
    let longest = f64::from(a.distance(b).max(b.distance(c)).max(c.distance(a)));
    let thickness = 2.0 * area / longest.max(1e-3);
    let small = (SMALL_PX2 / area.max(1e-3)).sqrt();
    small.max(THIN_PX / thickness.max(1e-3)).clamp(1.0, 8.0)
}
