//! Unit vectors as two whole numbers: the octahedron unfolded to a square.

use glam::DVec3;

/// Half the width of the square in steps; its centre is at (half, half).
fn half(bits: u8) -> i32 {
    (1 << (bits - 1)) - 1
}

/// Unit vector of a position on the square; valid for any pair of numbers.
pub(in super::super) fn normal_of(place: [i32; 2], bits: u8) -> DVec3 {
    let half = f64::from(half(bits).max(1));
    let [x, y] = place.map(|n| f64::from(n) / half - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let out = if z >= 0.0 {
        DVec3::new(x, y, z)
    } else {
        let fold = |a: f64, b: f64| (1.0 - b.abs()).copysign(a);
        DVec3::new(fold(x, y), fold(y, x), z)
    };
    out.normalize_or(DVec3::Z)
}

/// Position of the nearest representable vector; that of +Z for a zero vector.
pub(super) fn nearest(normal: DVec3, bits: u8) -> [i32; 2] {
    let sum = normal.x.abs() + normal.y.abs() + normal.z.abs();
    let Some(normal) = normal.try_normalize() else {
        return [half(bits); 2];
    };
    if sum <= 0.0 {
        return [half(bits); 2];
    }
    let flat = normal / (normal.x.abs() + normal.y.abs() + normal.z.abs());
    let (mut x, mut y) = (flat.x, flat.y);
    if flat.z < 0.0 {
        let fold = |a: f64, b: f64| (1.0 - b.abs()).copysign(a);
        (x, y) = (fold(flat.x, flat.y), fold(flat.y, flat.x));
    }
    let width = f64::from(half(bits));
    let low = [x, y].map(|c| ((c + 1.0) * width).floor() as i32);
    let mut best = (f64::NEG_INFINITY, [0; 2]);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let place = [low[0] + dx, low[1] + dy].map(|n| n.clamp(0, 2 * half(bits)));
        // By distance, since the cosine is flat near 1.
        let near = -normal_of(place, bits).distance_squared(normal);
        if near > best.0 {
            best = (near, place);
        }
    }
    at_rim(best.1, bits)
}

/// Canonical one of the two positions that a normal has on the rim of the square.
fn at_rim(place: [i32; 2], bits: u8) -> [i32; 2] {
    let last = 2 * half(bits);
    let [x, y] = place;
    let further = |n: i32| n.max(last - n);
    match (x == 0 || x == last, y == 0 || y == last) {
        (true, true) => [last; 2],
        (true, false) => [x, further(y)],
        (false, true) => [further(x), y],
        (false, false) => place,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn axes_are_exact_and_the_rim_has_one_name() {
        for bits in 2..=16 {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                for axis in [axis, -axis] {
                    assert_eq!(normal_of(nearest(axis, bits), bits), axis, "{bits} bits");
                }
            }
        }
        let last = 2 * half(10);
        assert_eq!(nearest(DVec3::NEG_Z, 10), [last; 2]);
        assert_eq!(nearest(DVec3::ZERO, 10), [half(10); 2]);
        assert_eq!(normal_of([last, 3], 10), normal_of([last, last - 3], 10));
        assert_eq!(at_rim([last, 3], 10), [last, last - 3]);
    }

    proptest! {
        #[test]
        fn normals_are_near_and_whole_ones_stay(
            v in prop::array::uniform3(-1.0f64..1.0),
            bits in 4u8..=16,
        ) {
            let normal = DVec3::from(v).normalize_or(DVec3::X);
            let place = nearest(normal, bits);
            let got = normal_of(place, bits);
            // A step of the square is at most sqrt(3) / half on the sphere, along each axis.
            let bound = 1.7 / f64::from(half(bits));
            prop_assert!(got.distance(normal) < bound, "{} {}", got.distance(normal), bound);
            prop_assert!(place.iter().all(|n| (0..(1 << bits) - 1).contains(n)));
            let again = nearest(got.as_vec3().as_dvec3(), bits);
            prop_assert_eq!(again, place);
        }
    }
}
