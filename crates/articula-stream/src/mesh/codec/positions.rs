//! Positions of new points, predicted over the connectivity.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (d). The base is the mean of the known
//! neighbours. Three directions are added, with coefficients in 1/64 fitted to the level: from the
//! base to the mean parallelogram, the known neighbours' mean offset from their own neighbours, and
//! the component of that offset along the normal. The axis with the largest normal component is
//! coded last, shifted so that the point stays in its plane. Integer arithmetic only; the encoder's
//! choice of coefficients uses floating point.

use super::connectivity::Fault;
use super::half_edges::{self, NONE, Rings};
use super::mixing::MixedNatural;
use super::number::Integer;
use crate::range_coder::{Bit, Coder};

type Vector = [i64; 3];

/// Number of directions added to the base.
const PARTS: usize = 3;
/// Number of classes, each with its own coefficients: known parallelograms up to 3, and whether all
/// neighbours are known.
const CLASSES: usize = 8;
/// The coefficient 1.
const UNIT: i64 = 64;
/// Maximum coefficient, either way.
const MOST: i32 = 256;
/// Fixed-point unit of predictions.
const FINE: i64 = 16;

type Parts = [[i32; PARTS]; CLASSES];

/// Surface data used while positions are coded.
struct Places<'a> {
    faces: &'a [[u32; 3]],
    twins: &'a [u32],
    rings: Rings,
    bits: u8,
}

/// Known surroundings of a point, in 1/[`FINE`].
#[derive(Debug, Clone, Default)]
struct Around {
    class: usize,
    known: usize,
    base: Vector,
    parts: [Vector; PARTS],
    /// Normal of arbitrary length; zero if nothing is known.
    normal: Vector,
    /// Mean edge length from the known neighbours to their own neighbours.
    scale: i64,
}

fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + b[i])
}

fn sub(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: Vector, b: Vector) -> i64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Rounded division; halves away from zero.
fn divide(a: i64, b: i64) -> i64 {
    let half = b.abs() / 2;
    if a < 0 {
        (a - half) / b
    } else {
        (a + half) / b
    }
}

fn scaled(v: Vector, times: i64, over: i64) -> Vector {
    v.map(|x| divide(x * times, over))
}

/// Largest absolute coordinate.
fn extent(v: Vector) -> i64 {
    v.iter().map(|x| x.abs()).max().unwrap_or(0)
}

/// Shifts a direction to at most 2^12 in each coordinate.
fn shortened(v: Vector) -> Vector {
    let most = extent(v);
    let places = 64 - most.leading_zeros();
    let shift = places.saturating_sub(12);
    v.map(|x| x >> shift)
}

impl Places<'_> {
    fn at(positions: &[[i32; 3]], point: u32) -> Vector {
        positions[point as usize].map(|x| i64::from(x) * FINE)
    }

    /// Computes the surroundings of `point`; the points below `known` have positions.
    fn around(&self, positions: &[[i32; 3]], point: u32, known: u32) -> Around {
        let mut around = Around::default();
        let at = |p: u32| Self::at(positions, p);
        let leaving = &self.rings.leaving(point)[..self.rings.leaving(point).len().min(MAX_FACES)];
        let mut sum = [0; 3];
        let mut count = 0;
        let mut all = 0;
        let mut laplace = ([0; 3], 0);
        let mut parallel = ([0; 3], 0);
        let mut scale = (0, 0);
        for &h in leaving {
            let opposite = half_edges::next(h);
            let n1 = half_edges::start(self.faces, opposite);
            let n2 = half_edges::end(self.faces, opposite);
            let twin = self.twins[opposite as usize];
            // Counts each neighbour once: the first end of each opposite half-edge, and the second
            // where the fan ends.
            let is_last = self.twins[half_edges::next(opposite) as usize] == NONE;
            for n in [n1, n2].into_iter().take(1 + usize::from(is_last)) {
                all += 1;
                if n < known {
                    count += 1;
                    sum = add(sum, at(n));
                    if let Some((offset, length)) = self.laplacian(positions, n, known) {
                        laplace = (add(laplace.0, offset), laplace.1 + 1);
                        scale = (scale.0 + length, scale.1 + 1);
                    }
                }
            }
            if n1 < known && n2 < known && twin != NONE {
                let o = half_edges::apex(self.faces, twin);
                if o < known {
                    let (p, q, r) = (at(n1), at(n2), at(o));
                    parallel = (add(parallel.0, sub(add(p, q), r)), parallel.1 + 1);
                    let across = cross(sub(p, r), sub(q, r));
                    // Subtracted, since the face beyond has the opposite orientation.
                    around.normal = sub(around.normal, across);
                }
            }
        }
        around.known = count as usize;
        around.class = (parallel.1 as usize).min(3) + if count == all { 4 } else { 0 };
        if count == 0 {
            return around;
        }
        around.base = scaled(sum, 1, count);
        if parallel.1 > 0 {
            around.parts[0] = sub(scaled(parallel.0, 1, parallel.1), around.base);
        }
        if laplace.1 > 0 {
            around.parts[1] = scaled(laplace.0, 1, laplace.1);
            around.scale = divide(scale.0, scale.1);
        }
        let n = shortened(around.normal);
        let square = dot(n, n);
        if square > 0 {
            let along = dot(n, around.parts[1]);
            around.parts[2] = scaled(n, along, square);
        }
        around
    }

    /// Offset of a known point from the mean of its known neighbours, and the mean edge length to
    /// them.
    fn laplacian(&self, positions: &[[i32; 3]], point: u32, known: u32) -> Option<(Vector, i64)> {
        let at = |p: u32| Self::at(positions, p);
        let here = at(point);
        let (mut sum, mut count, mut length) = ([0; 3], 0, 0);
        for &h in self.rings.leaving(point).iter().take(MAX_FACES) {
            let n = half_edges::end(self.faces, h);
            if n < known {
                sum = add(sum, at(n));
                length += extent(sub(at(n), here));
                count += 1;
            }
        }
        (count > 0).then(|| (sub(here, scaled(sum, 1, count)), divide(length, count)))
    }

    /// The predicted position, clamped to the grid.
    fn prediction(&self, around: &Around, parts: &Parts) -> [i32; 3] {
        let most = (1 << self.bits) - 1;
        let mut at = around.base;
        for (part, direction) in parts[around.class].iter().zip(around.parts) {
            at = add(at, scaled(direction, i64::from(*part), UNIT));
        }
        at.map(|x| divide(x, FINE).clamp(0, most) as i32)
    }
}

/// Maximum number of faces examined per point.
const MAX_FACES: usize = 64;

/// Number of context kinds of a residual.
const KINDS: usize = 5;

/// Models of residuals.
struct Residuals {
    magnitudes: Vec<MixedNatural<KINDS>>,
    signs: [Bit; 3],
    /// Residual of each coded point plus one; 0 for others.
    sizes: Vec<[u32; 3]>,
}

impl Residuals {
    fn new(points: usize) -> Self {
        Self {
            magnitudes: vec![
                MixedNatural::new([
                    24 * 4,
                    24 * CLASSES,
                    24 * 24,
                    24 * CLASSES,
                    24 * 24
                ]);
                3
            ],
            signs: [Bit::default(); 3],
            sizes: vec![[0; 3]; points],
        }
    }

    fn code(&mut self, coder: &mut impl Coder, axis: usize, at: [usize; KINDS], value: i32) -> i32 {
        let magnitude = self.magnitudes[axis].code(coder, at, value.unsigned_abs());
        let magnitude = magnitude.min(1 << 24) as i32;
        if magnitude != 0 && coder.bit(&mut self.signs[axis], value < 0) {
            -magnitude
        } else {
            magnitude
        }
    }
}

fn class_of(x: u64) -> usize {
    // Two classes per octave.
    let x = x.min(1 << 24) + 1;
    let log = 63 - x.leading_zeros() as usize;
    if log == 0 {
        return 0;
    }
    (log * 2 + (x >> (log - 1) & 1) as usize).min(23)
}

/// Codes the positions of the points from `known` on; `positions` has their values on the encoder's
/// side and placeholders on the decoder's.
pub(super) fn code_positions(
    coder: &mut impl Coder,
    faces: &[[u32; 3]],
    known: usize,
    bits: u8,
    (positions, is_given): (&mut [[i32; 3]], bool),
) -> Result<(), Fault> {
    let twins = half_edges::twins(faces);
    let places = Places {
        faces,
        twins: &twins,
        rings: Rings::new(faces, positions.len()),
        bits,
    };
    let mut parts = [[0; PARTS]; CLASSES];
    if is_given {
        parts = fit::parts(&places, positions, known);
    }
    let mut model = Integer::default();
    for part in parts.as_flattened_mut() {
        *part = model.code(coder, *part / 2).clamp(-MOST, MOST) * 2;
    }
    let mut residuals = Residuals::new(positions.len());
    for point in known..positions.len() {
        let around = places.around(positions, point as u32, point as u32);
        let predicted = places.prediction(&around, &parts);
        let found = code_point(coder, &places, &mut residuals, (point, &around), {
            (predicted, positions[point])
        });
        let top = (1 << bits) - 1;
        if found.iter().any(|x| !(0..=top).contains(x)) {
            return Err("a position is outside its grid");
        }
        positions[point] = found;
        if coder.is_exhausted() {
            return Err("unexpected end of the bytes within the positions");
        }
    }
    Ok(())
}

fn code_point(
    coder: &mut impl Coder,
    places: &Places<'_>,
    residuals: &mut Residuals,
    (point, around): (usize, &Around),
    (predicted, given): ([i32; 3], [i32; 3]),
) -> [i32; 3] {
    let n = shortened(around.normal);
    let mut axes = [0, 1, 2];
    axes.sort_by_key(|&i| n[i].abs());
    let (mut sizes, mut count) = ([0; 3], 0);
    for &h in places.rings.leaving(point as u32).iter().take(MAX_FACES) {
        let n = half_edges::end(places.faces, h) as usize;
        if n < point && residuals.sizes[n][0] > 0 {
            for (sum, size) in sizes.iter_mut().zip(residuals.sizes[n]) {
                *sum += u64::from(size - 1);
            }
            count += 1;
        }
    }
    let nearby = |size: u64| u64::checked_div(size, count).map_or(0, |s| 1 + class_of(s).min(22));
    let near = nearby(sizes.iter().sum());
    let bend =
        class_of(extent(sub(predicted.map(|x| i64::from(x) * FINE), around.base)).unsigned_abs());
    let gap = class_of(extent(around.parts[0]).unsigned_abs());
    let scale = class_of(around.scale.unsigned_abs());
    let mut found = predicted;
    let mut done = 0u64;
    for (turn, &axis) in axes.iter().enumerate() {
        let mut shift = 0;
        if turn == 2 && n[axis] != 0 {
            let slope: i64 = axes[..2]
                .iter()
                .map(|&i| n[i] * i64::from(found[i] - predicted[i]))
                .sum();
            shift = divide(-slope, n[axis]) as i32;
        }
        let sum = class_of(done);
        let at = [
            near * 4 + around.known.min(3),
            scale * CLASSES + around.class,
            sum * 24 + nearby(sizes[turn]),
            bend * CLASSES + around.class,
            gap * 24 + scale,
        ];
        let value = given[axis].wrapping_sub(predicted[axis] + shift);
        let residual = residuals.code(coder, turn, at, value);
        found[axis] = predicted[axis] + shift + residual;
        done += u64::from(residual.unsigned_abs());
        residuals.sizes[point][turn] = residual.unsigned_abs().min(1 << 24) + 1;
    }
    found
}

mod fit {
    //! Fitting of the coefficients.

    use super::{Around, CLASSES, MOST, PARTS, Parts, Places, UNIT, sub};

    /// Robust least squares by iterative reweighting, class by class.
    pub(super) fn parts(places: &Places<'_>, positions: &[[i32; 3]], known: usize) -> Parts {
        let mut classes: [Vec<(Around, [f64; 3])>; CLASSES] = Default::default();
        for point in known..positions.len() {
            let around = places.around(positions, point as u32, point as u32);
            if around.known > 0 {
                let goal = sub(Places::at(positions, point as u32), around.base);
                classes[around.class].push((around, goal.map(|x| x as f64)));
            }
        }
        classes.map(|samples| fitted(&samples).map(stored))
    }

    /// A coefficient as it is stored: in steps of 2, within the limits.
    fn stored(coefficient: f64) -> i32 {
        let part = (coefficient * UNIT as f64 / 2.0).round() * 2.0;
        (part as i32).clamp(-MOST, MOST)
    }

    fn fitted(samples: &[(Around, [f64; 3])]) -> [f64; PARTS] {
        let mut found = [0.0; PARTS];
        if samples.len() < 8 {
            return found;
        }
        for _ in 0..6 {
            let mut matrix = [[0.0; PARTS]; PARTS];
            let mut right = [0.0; PARTS];
            for (around, goal) in samples {
                let x = |i: usize, axis: usize| around.parts[i][axis] as f64;
                let miss = |axis: usize| {
                    let sum: f64 = (0..PARTS).map(|i| found[i] * x(i, axis)).sum();
                    goal[axis] - sum
                };
                let size: f64 = (0..3).map(|axis| miss(axis).abs()).sum();
                let weight = 1.0 / (size + 16.0);
                for (axis, goal) in goal.iter().enumerate() {
                    for (i, row) in matrix.iter_mut().enumerate() {
                        for (j, sum) in row.iter_mut().enumerate() {
                            *sum += weight * x(i, axis) * x(j, axis);
                        }
                        right[i] += weight * x(i, axis) * goal;
                    }
                }
            }
            found = solved(matrix, right);
        }
        found
    }

    /// Gaussian elimination; a direction without information gets the coefficient 0.
    fn solved(mut matrix: [[f64; PARTS]; PARTS], mut right: [f64; PARTS]) -> [f64; PARTS] {
        for i in 0..PARTS {
            matrix[i][i] += 1.0 + matrix[i][i] * 1e-6;
            for j in i + 1..PARTS {
                let part = matrix[j][i] / matrix[i][i];
                let row = matrix[i];
                for (sum, x) in matrix[j].iter_mut().zip(row) {
                    *sum -= part * x;
                }
                right[j] -= part * right[i];
            }
        }
        for i in (0..PARTS).rev() {
            for j in i + 1..PARTS {
                right[i] -= matrix[i][j] * right[j];
            }
            right[i] /= matrix[i][i];
        }
        right
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn coefficients_are_those_of_the_samples() {
            let sample = |i: i64| {
                let part =
                    |k: i64| [113 * i * k, 71 * (i + k), 37 * (i - k) * k].map(|x| x % 1009 - 504);
                let parts = [part(1), part(2), part(5)];
                let at = |axis: usize| 0.5 * parts[0][axis] as f64 - 0.25 * parts[1][axis] as f64;
                let around = Around {
                    parts,
                    ..Around::default()
                };
                (around, [at(0), at(1), at(2)])
            };
            let samples: Vec<(Around, [f64; 3])> = (1..40).map(sample).collect();
            let found = fitted(&samples);
            for (found, wanted) in found.into_iter().zip([0.5, -0.25, 0.0]) {
                assert!((found - wanted).abs() < 1e-3, "{found} for {wanted}");
            }
            assert_eq!(fitted(&samples[..7]), [0.0; PARTS], "too few to tell");
        }

        #[test]
        fn coefficients_are_stored_in_even_steps_within_limits() {
            assert_eq!([0.5, -0.25, 0.0].map(stored), [32, -16, 0]);
            assert_eq!(stored(0.49), 32, "31.4 is nearest to an even 32");
            assert_eq!([1e3, -1e3].map(stored), [MOST, -MOST]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::{Decoder, Encoder};

    #[test]
    fn division_rounds_halves_away_from_zero() {
        let cases = [(7, 2, 4), (-7, 2, -4), (6, 4, 2), (5, 4, 1), (-5, 4, -1)];
        for (a, b, expected) in cases {
            assert_eq!(divide(a, b), expected, "{a} / {b}");
            assert_eq!(divide(a, -b), -expected, "{a} / -{b}");
        }
        assert_eq!(divide(0, 9), 0);
        assert_eq!(scaled([7, -7, 9], 3, 2), [11, -11, 14]);
    }

    #[test]
    fn long_directions_are_shortened_to_twelve_bits() {
        assert_eq!(shortened([4095, -4095, 1]), [4095, -4095, 1]);
        assert_eq!(shortened([4096, -4096, 9]), [2048, -2048, 4]);
        assert_eq!(shortened([1 << 40, 0, -(1 << 30)]), [2048, 0, -2]);
        assert_eq!(shortened([0; 3]), [0; 3]);
    }

    #[test]
    fn classes_are_half_octaves() {
        // Of x + 1: 1, 2, 3, 4 to 5, 6 to 7, 8 to 11 ..
        let classes = [0, 1, 2, 3, 4, 5, 6, 7, 10, 11, 1000].map(class_of);
        assert_eq!(classes, [0, 2, 3, 4, 4, 5, 5, 6, 6, 7, 19]);
        assert_eq!(class_of(u64::MAX), 23);
    }

    /// A point beyond the grid can only come from a broken stream.
    #[test]
    fn positions_outside_the_grid_are_refused() {
        let faces = [[0, 1, 2]];
        for (last, is_valid) in [(15, true), (16, false), (-1, false)] {
            let mut positions = [[0, 0, 0], [15, 0, 0], [0, last, 0]];
            let mut encoder = Encoder::new();
            let given = (&mut positions[..], true);
            let found = code_positions(&mut encoder, &faces, 0, 4, given);
            assert_eq!(found.is_ok(), is_valid);
            let bytes = encoder.finish();
            let mut read = [[0; 3]; 3];
            let room = (&mut read[..], false);
            let found = code_positions(&mut Decoder::new(&bytes), &faces, 0, 4, room);
            assert_eq!(found.is_ok(), is_valid);
            assert!(!is_valid || read == positions);
        }
    }
}
