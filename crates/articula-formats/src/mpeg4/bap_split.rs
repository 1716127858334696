//! Closest approximation of a rotation by rotations about one, two or three perpendicular axes.

use articula_core::{Libm, LibmQuat};
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Returns the angles whose product is closest to a rotation; of equivalent ones, the closest to
/// `last`. Angles beyond the number of axes are 0.
pub(super) fn split(target: DQuat, turns: &[(usize, Vec3)], last: [f64; 3]) -> [f64; 3] {
    let axis = |turn: usize| turns[turn].1.as_dvec3();
    match turns.len() {
        0 => [0.0; 3],
        1 => near([one(target, axis(0)), 0.0, 0.0], last),
        2 => {
            let [a, b] = nearest_two(target, axis(0), axis(1));
            near([a, b, 0.0], last)
        }
        _ => {
            let [a, b, c] = three(target, axis(0), axis(1), axis(2), last[2]);
            let first = near([a, b, c], last);
            let second = near([a + PI, PI - b, c + PI], last);
            let far = |angles: [f64; 3]| -> f64 {
                angles.iter().zip(last).map(|(a, l)| (a - l).abs()).sum()
            };
            if far(second) < far(first) {
                second
            } else {
                first
            }
        }
    }
}

/// Returns the rotation about an axis that is closest to a rotation: its twist.
fn one(q: DQuat, axis: DVec3) -> f64 {
    2.0 * q.xyz().dot(axis).libm_atan2(q.w)
}

/// Returns the angles about two perpendicular axes, the first on the parent's side, whose product
/// is closest to a rotation.
///
/// The product is `(ca cb, u sa cb + v ca sb + u x v sa sb)` with the cosines and sines of half the
/// angles. Its dot product with the rotation, twice, is `(w + z) cos(a/2 - b/2) + (w - z) cos(a/2 +
/// b/2) + (x + y) sin(a/2 + b/2) + (x - y) sin(a/2 - b/2)`: sum and difference are independent.
pub(super) fn nearest_two(q: DQuat, u: DVec3, v: DVec3) -> [f64; 2] {
    let (w, x, y, z) = (q.w, q.xyz().dot(u), q.xyz().dot(v), q.xyz().dot(u.cross(v)));
    let sum = (x + y).libm_atan2(w - z);
    let difference = (x - y).libm_atan2(w + z);
    [sum + difference, sum - difference]
}

/// Returns the angles about three perpendicular axes whose product is a rotation; where the first
/// and the third axis coincide, the third angle stays `c`.
fn three(q: DQuat, u: DVec3, v: DVec3, w: DVec3, c: f64) -> [f64; 3] {
    // In a right-handed frame the third axis may be negated.
    let hand = u.cross(v).dot(w);
    let third = w * hand;
    let turned = q * third;
    let sine = turned.dot(u).clamp(-1.0, 1.0);
    if sine.abs() > 1.0 - 1e-12 {
        let rest = q * DQuat::libm_axis_angle(w, -c);
        let turned = rest * v;
        return [
            turned.dot(third).libm_atan2(turned.dot(v)),
            sine.libm_asin(),
            c,
        ];
    }
    let a = (-turned.dot(v)).libm_atan2(turned.dot(third));
    let c = (-(q * v).dot(u)).libm_atan2((q * u).dot(u));
    [a, sine.libm_asin(), hand * c]
}

/// Returns equivalent angles, each within half a turn of the previous frame.
pub(super) fn near(angles: [f64; 3], last: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| angles[i] + TAU * ((last[i] - angles[i]) / TAU).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turns(axes: &[Vec3]) -> Vec<(usize, Vec3)> {
        axes.iter().copied().enumerate().collect()
    }

    fn product(turns: &[(usize, Vec3)], angles: [f64; 3]) -> DQuat {
        turns
            .iter()
            .zip(angles)
            .fold(DQuat::IDENTITY, |q, ((_, axis), angle)| {
                q * DQuat::from_axis_angle(axis.as_dvec3(), angle)
            })
    }

    #[test]
    fn three_turns_are_found_again() {
        for axes in [
            [Vec3::NEG_X, Vec3::Z, Vec3::NEG_Y],
            [Vec3::NEG_Z, Vec3::NEG_X, Vec3::NEG_Y],
            [Vec3::Y, Vec3::Z, Vec3::X],
            [Vec3::NEG_X, Vec3::Y, Vec3::Z],
        ] {
            let turns = turns(&axes);
            for angles in [[0.3, -0.7, 1.1], [-2.0, 1.5, 3.0], [0.0, -1.2, -0.4]] {
                // Two sets of angles are equivalent; the previous frame selects one.
                let last = angles.map(|angle| angle + 0.2);
                let found = split(product(&turns, angles), &turns, last);
                for (a, b) in angles.iter().zip(found) {
                    assert!((a - b).abs() < 1e-9, "{axes:?}: {angles:?} {found:?}");
                }
            }
            // A quarter turn about the middle axis: the first and the third axis coincide.
            let q = product(&turns, [0.4, PI / 2.0, 0.3]);
            let found = split(q, &turns, [0.0, 0.0, 0.1]);
            assert!(product(&turns, found).angle_between(q) < 1e-6);
            assert_eq!(found[2], 0.1);
        }
    }

    #[test]
    fn beyond_a_quarter_the_frame_before_decides() {
        let turns = turns(&[Vec3::X, Vec3::Y, Vec3::Z]);
        let angles = [0.1, 1.8, -0.2];
        let found = split(product(&turns, angles), &turns, [0.1, 1.5, -0.2]);
        assert!((found[1] - 1.8).abs() < 1e-9, "{found:?}");
        let wound = split(product(&turns, [0.1, 0.2, 0.3]), &turns, [6.4, 0.2, 0.3]);
        assert!((wound[0] - (0.1 + TAU)).abs() < 1e-9);
    }

    #[test]
    fn one_and_two_turns_are_the_nearest() {
        let two = turns(&[Vec3::NEG_X, Vec3::NEG_Y]);
        let exact = split(product(&two, [1.1, -0.6, 0.0]), &two, [0.0; 3]);
        assert!((exact[0] - 1.1).abs() < 1e-9 && (exact[1] + 0.6).abs() < 1e-9);
        for turns in [turns(&[Vec3::Z]), two] {
            let q = DQuat::from_euler(glam::EulerRot::XYZ, 0.5, -0.8, 0.9);
            let found = split(q, &turns, [0.0; 3]);
            let best = product(&turns, found).angle_between(q);
            for (i, step) in [(0, 0.01), (0, -0.01), (1, 0.01), (1, -0.01)] {
                let mut other = found;
                other[i] += step;
                let off = product(&turns, other).angle_between(q);
                assert!(off >= best - 1e-9, "{found:?}: {off} < {best}");
            }
        }
    }
}
