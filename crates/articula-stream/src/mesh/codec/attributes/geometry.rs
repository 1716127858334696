//! Normals in whole numbers: of faces, of what lies between them, and on the octahedron.
//!
//! Source: `docs/methods/clustered-mesh.md` 8.1 (e); G. Thürmer and C. Wüthrich, "Computing vertex normals
//! from polygonal facets", 1998, for the weights by angle.

use super::ring::Ring;

/// Length of a unit vector.
pub(super) const UNIT: i64 = 1 << 14;

/// A vector of length [`UNIT`]; zero for zero. Coordinates are below 2^62.
pub(super) fn unit(v: [i64; 3]) -> [i32; 3] {
    let widest = v.iter().map(|x| x.unsigned_abs()).max().unwrap_or(0);
    let bits = 64 - widest.leading_zeros();
    // Thirty bits fill a sum of squares; fewer are brought up, so that short ones are as exact.
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

/// Angle between two vectors of length [`UNIT`], in 1/4096: the arc tangent within 0.004.
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
    // atan r = r (pi / 4 + 0.273 (1 - r)) from 0 to 1.
    let r = low * 4096 / high;
    let first = (r * (3217 + ((1118 * (4096 - r)) >> 12))) >> 12;
    let within = if sine > cosine.abs() {
        6434 - first
    } else {
        first
    };
    if cosine < 0 { 12868 - within } else { within }
}

/// The normals that faces give to elements.
#[derive(Debug, Default)]
pub(super) struct Normals {
    /// By the angle of each face.
    pub(super) by_angle: Vec<[i32; 3]>,
    /// By the area of each face.
    pub(super) by_area: Vec<[i32; 3]>,
}

impl Normals {
    /// Of each element, over all faces.
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
                    // 2^43 for the widest grid: a million faces fit.
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

/// Half the width of the octahedron's square in steps.
fn half(bits: u8) -> i32 {
    ((1 << (bits - 1)) - 1).max(1)
}

/// The last place of the octahedron's square.
pub(super) fn last(bits: u8) -> i32 {
    2 * half(bits)
}

/// The unit vector of a place on the octahedron.
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

/// The nearest place on the octahedron of a vector.
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

/// A place beyond the rim of the square, by less than its width, brought back: a normal's other
/// name.
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

/// The name of a place, of those beyond the rim too, that is nearest to another.
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
    // Only names that fold back to the very place: one on the rim has none other.
    let is_name = |n: &&[i32; 2]| folded(**n, bits) == place;
    let found = names.iter().filter(is_name).min_by_key(|n| far(n));
    found.copied().unwrap_or(place)
}
