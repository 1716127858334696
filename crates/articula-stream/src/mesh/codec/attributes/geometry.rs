//! Normals in whole numbers: of faces, their weighted means, and their octahedral form.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (e); G. Thürmer and C. Wüthrich, "Computing
//! vertex normals from polygonal facets", 1998, for the weights by angle.

use super::ring::Ring;

/// Length of a unit vector.
pub(super) const UNIT: i64 = 1 << 14;

/// Scales a vector to the length [`UNIT`]; zero stays zero. Coordinates are below 2^62.
pub(super) fn unit(v: [i64; 3]) -> [i32; 3] {
    let widest = v.iter().map(|x| x.unsigned_abs()).max().unwrap_or(0);
    let bits = 64 - widest.leading_zeros();
    // Normalised to 30 bits, so that squares fit and short vectors keep their precision.
    let v = v.map(|x| {
        if bits > 30 {
            x >> (bits - 30)
        } else {
            x << (30 - bits)
        }
    });
    let square: u64 = v.iter().map(|x| x.unsigned_abs().pow(2)).sum();
    let length = square.isqrt() as i64;
    if length == 0 {
        return [0; 3];
    }
    v.map(|x| (x * UNIT / length) as i32)
}

fn cross(a: [i64; 3], b: [i64; 3]) -> [i64; 3] {
    std::array::from_fn(|d| {
        let (e, f) = ((d + 1) % 3, (d + 2) % 3);
        a[e] * b[f] - a[f] * b[e]
    })
}

/// Angle between two vectors of length [`UNIT`], in 1/4096, by an arc tangent with an error of at
/// most 0.004.
fn angle(a: [i32; 3], b: [i32; 3]) -> i64 {
    let (a, b) = (a.map(i64::from), b.map(i64::from));
    let cosine: i64 = (0..3).map(|d| a[d] * b[d]).sum();
    let sine = cross(a, b)
        .iter()
        .map(|x| x.unsigned_abs().pow(2))
        .sum::<u64>()
        .isqrt() as i64;
    let (low, high) = (sine.min(cosine.abs()), sine.max(cosine.abs()));
    if high == 0 {
        return 0;
    }
    // atan r ≈ r (pi / 4 + 0.273 (1 - r)) from 0 to 1.
    let r = low * 4096 / high;
    let first = (r * (3217 + ((1118 * (4096 - r)) >> 12))) >> 12;
    let within = if sine > cosine.abs() {
        6434 - first
    } else {
        first
    };
    if cosine < 0 { 12868 - within } else { within }
}

/// Normals of elements computed from faces.
#[derive(Debug, Default)]
pub(super) struct Normals {
    /// Weighted by the angle of each face.
    pub(super) by_angle: Vec<[i32; 3]>,
    /// Weighted by the area of each face.
    pub(super) by_area: Vec<[i32; 3]>,
}

impl Normals {
    /// Computes the normals of all elements.
    pub(super) fn new(ring: &Ring, position: impl Fn(u32) -> [i32; 3]) -> Self {
        let mut angles = vec![[0i64; 3]; ring.len()];
        let mut areas = vec![[0i64; 3]; ring.len()];
        for face in ring.faces() {
            let p = face.map(|v| position(v).map(i64::from));
            let edge =
                |i: usize| -> [i64; 3] { std::array::from_fn(|d| p[(i + 1) % 3][d] - p[i][d]) };
            let edges = [edge(0), edge(1), edge(2)];
            let area = cross(edges[0], edges[1]);
            let normal = unit(area);
            let along = edges.map(unit);
            for (k, &v) in face.iter().enumerate() {
                let back = along[(k + 2) % 3].map(|x| -x);
                let angle = angle(along[k], back);
                for d in 0..3 {
                    angles[v as usize][d] += i64::from(normal[d]) * angle;
                    // At most 2^43 on the largest grid: a million faces fit.
                    areas[v as usize][d] = areas[v as usize][d].saturating_add(area[d]);
                }
            }
        }
        let units = |sums: Vec<[i64; 3]>| {
            let fit = |x: i64| x.clamp(-(1 << 60), 1 << 60);
            sums.into_iter().map(|v| unit(v.map(fit))).collect()
        };
        Self {
            by_angle: units(angles),
            by_area: units(areas),
        }
    }
}

/// Half the width of the octahedral square in steps.
fn half(bits: u8) -> i32 {
    ((1 << (bits - 1)) - 1).max(1)
}

/// Largest coordinate on the octahedral square.
pub(super) fn last(bits: u8) -> i32 {
    2 * half(bits)
}

/// Unit vector of an octahedral position.
pub(super) fn of_octahedron(place: [i32; 2], bits: u8) -> [i32; 3] {
    let half = half(bits);
    let [x, y] = place.map(|n| i64::from(n - half));
    let z = i64::from(half) - x.abs() - y.abs();
    let sign = |a: i64| if a < 0 { -1 } else { 1 };
    if z >= 0 {
        return unit([x, y, z]);
    }
    let half = i64::from(half);
    unit([(half - y.abs()) * sign(x), (half - x.abs()) * sign(y), z])
}

/// Octahedral position nearest to a vector.
pub(super) fn on_octahedron(v: [i32; 3], bits: u8) -> [i32; 2] {
    let half = i64::from(half(bits));
    let [x, y, z] = v.map(i64::from);
    let sum = x.abs() + y.abs() + z.abs();
    if sum == 0 {
        return [half as i32; 2];
    }
    let sign = |a: i64| if a < 0 { -1 } else { 1 };
    let (x, y) = if z >= 0 {
        (x, y)
    } else {
        ((sum - y.abs()) * sign(x), (sum - x.abs()) * sign(y))
    };
    [x, y].map(|n| {
        let steps = (n * half * 2 + sum * sign(n)) / (2 * sum);
        (half + steps).clamp(0, 2 * half) as i32
    })
}

/// Folds a position beyond the rim of the square, by less than its width, back into it: the same
/// normal in its regular form.
pub(super) fn folded(place: [i32; 2], bits: u8) -> [i32; 2] {
    let last = last(bits);
    let [mut x, mut y] = place;
    if x < 0 || x > last {
        (x, y) = (if x < 0 { -x } else { 2 * last - x }, last - y);
    }
    if y < 0 || y > last {
        (x, y) = (last - x, if y < 0 { -y } else { 2 * last - y });
    }
    [x.clamp(0, last), y.clamp(0, last)]
}

/// The representation of a normal, positions beyond the rim included, that is nearest to another
/// position.
pub(super) fn nearest_name(place: [i32; 2], to: [i32; 2], bits: u8) -> [i32; 2] {
    let last = last(bits);
    let [x, y] = place;
    let names = [
        [x, y],
        [-x, last - y],
        [2 * last - x, last - y],
        [last - x, -y],
        [last - x, 2 * last - y],
    ];
    let far = |n: &[i32; 2]| (n[0] - to[0]).abs() + (n[1] - to[1]).abs();
    // Only positions that fold back to the same one; a position on the rim has no other.
    let is_name = |n: &&[i32; 2]| folded(**n, bits) == place;
    let found = names.iter().filter(is_name).min_by_key(|n| far(n));
    found.copied().unwrap_or(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const U: i32 = UNIT as i32;

    #[test]
    fn products_and_lengths_by_hand() {
        assert_eq!(cross([1, 2, 3], [4, 5, 6]), [-3, 6, -3]);
        assert_eq!(cross([1, 0, 0], [0, 1, 0]), [0, 0, 1]);
        // 3/5 and 4/5 of 16384, rounded toward zero, at any scale.
        assert_eq!(unit([3, -4, 0]), [9830, -13107, 0]);
        assert_eq!(unit([3 << 50, -4 << 50, 0]), [9830, -13107, 0]);
        assert_eq!(unit([0; 3]), [0; 3]);
    }

    #[test]
    fn angles_are_those_of_the_plane() {
        for degrees in 0..=180 {
            let turn = f64::from(degrees).to_radians();
            let b = [turn.cos(), turn.sin(), 0.0].map(|x| (x * f64::from(U)).round() as i32);
            let off = angle([U, 0, 0], b) as f64 / 4096.0 - turn;
            assert!(off.abs() < 0.005, "{degrees} degrees: {off}");
        }
    }

    #[test]
    fn the_octahedron_by_hand() {
        // Three bits: steps from 0 to 6, the pole at 3.
        assert_eq!(last(3), 6);
        assert_eq!(of_octahedron([3, 3], 3), [0, 0, U]);
        assert_eq!(of_octahedron([6, 3], 3), [U, 0, 0]);
        assert_eq!(of_octahedron([3, 0], 3), [0, -U, 0]);
        assert_eq!(of_octahedron([0, 6], 3), [0, 0, -U]);
        assert_eq!(of_octahedron([5, 3], 3), unit([2, 0, 1]));
        assert_eq!(of_octahedron([5, 1], 3), unit([1, -1, -1]));
        assert_eq!(of_octahedron([1, 4], 3), unit([-2, 1, 0]));
        assert_eq!(on_octahedron([0; 3], 3), [3, 3]);
    }

    #[test]
    fn places_within_the_square_come_back() {
        for bits in [3, 5, 8] {
            let last = last(bits);
            for x in 1..last {
                for y in 1..last {
                    let v = of_octahedron([x, y], bits);
                    assert_eq!(on_octahedron(v, bits), [x, y], "{bits} bits");
                }
            }
        }
    }

    #[test]
    fn folding_mirrors_at_the_rim() {
        let cases = [
            ([-1, 2], [1, 4]),
            ([7, 2], [5, 4]),
            ([2, -1], [4, 1]),
            ([2, 7], [4, 5]),
            ([0, 2], [0, 2]),
            ([6, 2], [6, 2]),
            ([2, 0], [2, 0]),
            ([2, 6], [2, 6]),
            ([-1, -1], [5, 5]),
        ];
        for (place, expected) in cases {
            assert_eq!(folded(place, 3), expected, "{place:?}");
        }
    }

    /// Against a search of all positions within the square or beyond one side of it.
    #[test]
    fn the_nearest_name_is_the_nearest() {
        let last = last(3);
        let inside = |x: i32| (0..=last).contains(&x);
        let square = || (0..=last).flat_map(|x| (0..=last).map(move |y| [x, y]));
        let around = || (-last..=2 * last).flat_map(|x| (-last..=2 * last).map(move |y| [x, y]));
        for place in square() {
            let names: Vec<[i32; 2]> = around()
                .filter(|q| (inside(q[0]) || inside(q[1])) && folded(*q, 3) == place)
                .collect();
            for to in square() {
                let far = |n: [i32; 2]| (n[0] - to[0]).abs() + (n[1] - to[1]).abs();
                let found = nearest_name(place, to, 3);
                assert_eq!(folded(found, 3), place);
                let least = names.iter().map(|n| far(*n)).min();
                assert_eq!(Some(far(found)), least, "{place:?} to {to:?}");
            }
        }
    }
}
