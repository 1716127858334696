//! Distance of a point to a triangle, and the barycentric coordinates of the closest point.
//!
//! Source: Ericson, *Real-Time Collision Detection* (2005), 5.1.5, by the regions of the triangle.
//! In addition, a triangle with (nearly) no area is treated as its three sides.

use glam::Vec3;

/// Fraction of the product of two sides' squared lengths below which a squared area counts as 0:
/// the plane of a thinner triangle is dominated by rounding, and its sides lie within a few
/// thousandths of it.
const NO_AREA: f32 = 1e-5;

/// Returns the squared distance of a point to a triangle in metres²; NaN if an argument is NaN.
///
/// Source: Ericson, *Real-Time Collision Detection* (2005), 5.1.5. A triangle with (nearly) no area
/// is treated as its three sides.
#[inline]
pub fn triangle_distance_squared(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length_squared();
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length_squared();
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length_squared();
    }
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    if area <= NO_AREA * ab.length_squared() * ac.length_squared() {
        return sides(point, [a, b, c]);
    }
    let outside_ab = d1 * d4 - d3 * d2 <= 0.0 && d1 >= 0.0 && d3 <= 0.0;
    let outside_ac = d5 * d2 - d1 * d6 <= 0.0 && d2 >= 0.0 && d6 <= 0.0;
    let outside_bc = d3 * d6 - d5 * d4 <= 0.0 && d4 >= d3 && d5 >= d6;
    if outside_ab || outside_ac || outside_bc {
        return sides(point, [a, b, c]);
    }
    let height = normal.dot(ap);
    height * height / area
}

/// Returns the barycentric coordinates of the triangle's closest point to `point`; they are at
/// least 0 and sum to 1.
pub fn triangle_weights(point: Vec3, [a, b, c]: [Vec3; 3]) -> [f32; 3] {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    if area > NO_AREA * ab.length_squared() * ac.length_squared() {
        let u = normal.dot((b - point).cross(c - point)) / area;
        let v = normal.dot((c - point).cross(a - point)) / area;
        let w = 1.0 - u - v;
        if u >= 0.0 && v >= 0.0 && w >= 0.0 {
            return [u, v, w];
        }
    }
    let [s, t, r] = [along(point, a, b), along(point, b, c), along(point, c, a)];
    let all = [[1.0 - s, s, 0.0], [0.0, 1.0 - t, t], [r, 0.0, 1.0 - r]];
    let apart = |[u, v, w]: [f32; 3]| (a * u + b * v + c * w).distance_squared(point);
    let closer = |x: [f32; 3], y: [f32; 3]| if apart(y) < apart(x) { y } else { x };
    closer(closer(all[0], all[1]), all[2])
}

fn sides(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let ab = segment(point, a, b);
    ab.min(segment(point, b, c)).min(segment(point, c, a))
}

fn segment(point: Vec3, a: Vec3, b: Vec3) -> f32 {
    let (ab, ap) = (b - a, point - a);
    (ap - ab * along(point, a, b)).length_squared()
}

/// Position of the closest point along a segment, 0 at `a` and 1 at `b`.
fn along(point: Vec3, a: Vec3, b: Vec3) -> f32 {
    let (ab, ap) = (b - a, point - a);
    let length = ab.length_squared();
    if length > 0.0 {
        (ab.dot(ap) / length).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn distance(point: Vec3, corners: [Vec3; 3]) -> f32 {
        triangle_distance_squared(point, corners).sqrt()
    }

    #[test]
    fn each_region_by_hand() {
        let t = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0];
        let at = |x: f32, y: f32, z: f32| distance(Vec3::new(x, y, z), t);
        assert_eq!(at(0.5, 0.5, 3.0), 3.0, "above the face");
        assert_eq!(at(-3.0, -4.0, 0.0), 5.0, "corner a");
        assert_eq!(at(5.0, -4.0, 0.0), 5.0, "corner b");
        assert_eq!(at(-4.0, 5.0, 0.0), 5.0, "corner c");
        assert_eq!(at(1.0, -3.0, 4.0), 5.0, "side ab");
        assert_eq!(at(-3.0, 1.0, 4.0), 5.0, "side ac");
        assert!((at(2.0, 2.0, 0.0) - 2f32.sqrt()).abs() < 1e-6, "side bc");
        assert_eq!(at(0.0, 2.0, 0.0), 0.0, "a corner itself");
    }

    #[test]
    fn without_area() {
        let line = [Vec3::ZERO, Vec3::X, Vec3::X * 3.0];
        assert_eq!(distance(Vec3::new(2.0, 4.0, 0.0), line), 4.0);
        assert_eq!(distance(Vec3::new(6.0, 4.0, 0.0), line), 5.0);
        let back = [Vec3::X, Vec3::ZERO, Vec3::X * 3.0];
        assert_eq!(distance(Vec3::new(2.0, 4.0, 0.0), back), 4.0);
        assert_eq!(distance(Vec3::Y, [Vec3::ZERO; 3]), 1.0);
        let double = [Vec3::ZERO, Vec3::ZERO, Vec3::X];
        assert_eq!(distance(Vec3::new(0.5, 2.0, 0.0), double), 2.0);
        assert!(distance(Vec3::NAN, line).is_nan());
    }

    /// By dense sampling in f64, refined around the best point.
    fn slow(point: Vec3, corners: [Vec3; 3]) -> f64 {
        let [a, b, c] = corners.map(|v| v.as_dvec3());
        let p = point.as_dvec3();
        let at = |u: f64, v: f64| -> f64 {
            let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
            let (u, v) = if u + v > 1.0 {
                (u / (u + v), v / (u + v))
            } else {
                (u, v)
            };
            p.distance(a + (b - a) * u + (c - a) * v)
        };
        let (mut best, mut middle, mut step) = (f64::INFINITY, (0.33, 0.33), 0.1);
        for _ in 0..28 {
            let (u, v) = middle;
            for i in -10..=10 {
                for j in -10..=10 {
                    let here = (u + f64::from(i) * step, v + f64::from(j) * step);
                    if at(here.0, here.1) < best {
                        best = at(here.0, here.1);
                        middle = (here.0.clamp(0.0, 1.0), here.1.clamp(0.0, 1.0));
                    }
                }
            }
            step *= 0.6;
        }
        best
    }

    fn point() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from_array)
    }

    proptest! {
        #[test]
        fn agrees_with_dense_sampling(p in point(), a in point(), b in point(), c in point()) {
            let fast = f64::from(distance(p, [a, b, c]));
            let [u, v, w] = triangle_weights(p, [a, b, c]);
            let point = a * u + b * v + c * w;
            prop_assert!((f64::from(point.distance(p)) - fast).abs() < 1e-4);
            prop_assert!(u.min(v).min(w) >= 0.0 && (u + v + w - 1.0).abs() < 1e-5);
            let slow = slow(p, [a, b, c]);
            prop_assert!((fast - slow).abs() < 2e-3, "{} {}", fast, slow);
            prop_assert!(fast <= slow + 1e-5, "nothing sampled is nearer than the nearest");
        }

        #[test]
        fn nothing_of_a_triangle_is_nearer(
            corners in prop::array::uniform3(point()),
            place in point(),
            mixed in (0.0f32..=1.0, 0.0f32..=1.0),
        ) {
            let [a, b, c] = corners;
            let other = a.lerp(b, mixed.0).lerp(c, mixed.1);
            prop_assert!(distance(place, corners) <= other.distance(place) + 1e-5);
            let [u, v, w] = triangle_weights(place, corners);
            let nearest = a * u + b * v + c * w;
            // It lies in the triangle: the areas between it and the corners sum to no more.
            let area = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).length();
            let parts = area(nearest, b, c) + area(a, nearest, c) + area(a, b, nearest);
            prop_assert!(parts <= area(a, b, c) + 1e-4);
        }

        #[test]
        fn thin_ones_too(p in point(), a in point(), b in point(), t in -0.5f32..1.5, off in point(), thin in 0u32..8) {
            let c = a + (b - a) * t + off * 0.1f32.powi(thin as i32);
            let fast = f64::from(distance(p, [a, b, c]));
            let slow = slow(p, [a, b, c]);
            prop_assert!((fast - slow).abs() < 1e-2, "{} {}", fast, slow);
            prop_assert!(fast <= slow + 1e-5 + 4e-3, "{} {}", fast, slow);
        }
    }
}
