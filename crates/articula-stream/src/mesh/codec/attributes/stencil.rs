//! Linear predictors over the known surroundings of an element.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (d, e). A predictor is a list of weights of
//! the known elements around, so one set of weights serves all kinds of values. The local affine
//! fit is a weighted least squares fit over the neighbours and the corners beyond them, evaluated
//! at the element's position; a small multiple of the identity is added to its matrix, so that it
//! is regular for flat surroundings.

use super::ring::Ring;

/// Number of predictors: mean, parallelograms, affine fit, mean by inverse distance.
pub(super) const PREDICTORS: usize = 4;
/// Number of classes of surroundings, see [`Stencils::class`].
pub(super) const CLASSES: usize = 6;
/// The weight 1.
const UNIT: i64 = 1 << UNIT_BITS;
const UNIT_BITS: u32 = 14;
/// Fractional bits of a predicted value.
pub(super) const FRACTION: u32 = 4;
/// Maximum number of elements that a predictor uses.
const MOST: usize = 16;
/// Maximum absolute value of inputs and predictions.
pub(super) const REACH: i64 = 1 << 28;

/// Predictors of each element to be coded.
#[derive(Debug)]
pub(super) struct Stencils {
    from: usize,
    starts: Vec<u32>,
    entries: Vec<(u32, [i32; PREDICTORS])>,
    classes: Vec<u8>,
    neighbours: Vec<u8>,
}

impl Stencils {
    /// Computes the predictors of the elements from `from` on.
    pub(super) fn new(ring: &Ring, position: impl Fn(u32) -> [i32; 3], from: usize) -> Self {
        let mut out = Self {
            from,
            starts: vec![0],
            entries: Vec::new(),
            classes: Vec::new(),
            neighbours: Vec::new(),
        };
        let mut around = Surroundings::default();
        for v in from as u32..ring.len() as u32 {
            around.collect(ring, v);
            around.weigh(&position, v);
            out.classes.push(around.class());
            out.neighbours.push(around.neighbours as u8);
            out.entries.append(&mut around.entries);
            out.starts.push(out.entries.len() as u32);
        }
        out
    }

    fn entries(&self, v: u32) -> &[(u32, [i32; PREDICTORS])] {
        let i = v as usize - self.from;
        &self.entries[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// The known neighbours of an element.
    pub(super) fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> + Clone + '_ {
        let count = usize::from(self.neighbours[v as usize - self.from]);
        self.entries(v)[..count].iter().map(|e| e.0)
    }

    /// Class of an element: 0 no known neighbour, 1 no parallelogram, 2 to 4 one, two, or more; 5
    /// all neighbours known.
    pub(super) fn class(&self, v: u32) -> usize {
        usize::from(self.classes[v as usize - self.from])
    }

    /// Applies each predictor to a value, in 1/2^[`FRACTION`]; zero if nothing is known.
    pub(super) fn predict<const D: usize>(
        &self,
        v: u32,
        value: impl Fn(u32) -> [i32; D],
    ) -> [[i32; D]; PREDICTORS] {
        let entries = self.entries(v);
        let Some(first) = entries.first() else {
            return [[0; D]; PREDICTORS];
        };
        let base = value(first.0);
        let mut sums = [[0i64; D]; PREDICTORS];
        for (u, weights) in &entries[1..] {
            let given = value(*u);
            for d in 0..D {
                let step = i64::from(given[d]) - i64::from(base[d]);
                for k in 0..PREDICTORS {
                    sums[k][d] += step * i64::from(weights[k]);
                }
            }
        }
        let shift = UNIT_BITS - FRACTION;
        std::array::from_fn(|k| {
            std::array::from_fn(|d| {
                let all = (i64::from(base[d]) << FRACTION) + (sums[k][d] >> shift);
                all.clamp(-REACH, REACH) as i32
            })
        })
    }
}

/// Known surroundings of one element.
#[derive(Debug, Default)]
struct Surroundings {
    known: Vec<u32>,
    neighbours: usize,
    parallelograms: Vec<[u32; 3]>,
    entries: Vec<(u32, [i32; PREDICTORS])>,
    is_whole: bool,
}

impl Surroundings {
    fn collect(&mut self, ring: &Ring, v: u32) {
        self.parallelograms.clear();
        ring.known(v, &mut self.known);
        self.known.truncate(MOST);
        self.neighbours = self.known.len();
        self.is_whole = ring.edges(v).flatten().all(|u| u < v);
        for [a, b] in ring.edges(v) {
            if a < v
                && b < v
                && self.parallelograms.len() < MOST / 2
                && self.known.contains(&a)
                && self.known.contains(&b)
                && let Some(o) = ring.across(a, b)
                && o < v
            {
                self.parallelograms.push([a, b, o]);
                if !self.known.contains(&o) {
                    self.known.push(o);
                }
            }
        }
        self.entries.clear();
        let entries = self.known.iter().map(|u| (*u, [0; PREDICTORS]));
        self.entries.extend(entries);
    }

    fn class(&self) -> u8 {
        match (self.neighbours, self.parallelograms.len()) {
            (0, _) => 0,
            (3.., _) if self.is_whole => 5,
            (_, n) => 1 + n.min(3) as u8,
        }
    }

    fn weigh(&mut self, position: &impl Fn(u32) -> [i32; 3], v: u32) {
        if self.neighbours == 0 {
            return;
        }
        let each = UNIT as i32 / self.neighbours as i32;
        for entry in &mut self.entries[..self.neighbours] {
            entry.1[0] = each;
        }
        let count = self.parallelograms.len() as i32;
        for corners in &self.parallelograms {
            for (u, sign) in corners.iter().zip([1, 1, -1]) {
                if let Some(i) = self.known.iter().position(|k| k == u) {
                    self.entries[i].1[1] += sign * UNIT as i32 / count;
                }
            }
        }
        let here = position(v);
        let offsets: Vec<[i64; 3]> = (self.known.iter())
            .map(|u| {
                let p = position(*u);
                std::array::from_fn(|d| i64::from(p[d]) - i64::from(here[d]))
            })
            .collect();
        let squares: Vec<i64> = (offsets.iter())
            .map(|o| o.iter().map(|x| x * x).sum::<i64>().max(1))
            .collect();
        let near = &squares[..self.neighbours];
        let inverse: Vec<i64> = near
            .iter()
            .map(|s| (1 << 20) / (s.isqrt().clamp(1, 1 << 19)))
            .collect();
        let sum: i64 = inverse.iter().sum();
        for (entry, i) in self.entries.iter_mut().zip(&inverse) {
            entry.1[3] = (i * UNIT / sum) as i32;
        }
        for (entry, weight) in self.entries.iter_mut().zip(affine(&offsets, &squares)) {
            entry.1[2] = weight;
        }
        if count == 0 {
            for entry in &mut self.entries {
                entry.1[1] = entry.1[0];
            }
        }
    }
}

/// Weights that evaluate, at 0, the affine function fitted to values at `offsets`.
fn affine(offsets: &[[i64; 3]], squares: &[i64]) -> Vec<i32> {
    // Coordinates of ten bits are precise enough and leave room for the products below.
    let widest = offsets.iter().flatten().map(|x| x.unsigned_abs()).max();
    let shift = (64 - widest.unwrap_or(0).leading_zeros()).saturating_sub(10);
    let least = squares.iter().copied().min().unwrap_or(1);
    let counts: Vec<i128> = squares
        .iter()
        .map(|s| i128::from((64 * least / s).max(1)))
        .collect();
    let total: i128 = counts.iter().sum();
    let places: Vec<[i128; 3]> = offsets
        .iter()
        .map(|o| o.map(|x| i128::from(x >> shift)))
        .collect();
    let mut middle = [0i128; 3];
    for (place, count) in places.iter().zip(&counts) {
        for d in 0..3 {
            middle[d] += place[d] * count;
        }
    }
    // In quarters, so that rounding the mean loses little.
    let middle = middle.map(|m| m * 4 / total);
    let mut m = [[0i128; 3]; 3];
    let steps: Vec<[i128; 3]> = places
        .iter()
        .map(|p| std::array::from_fn(|d| p[d] * 4 - middle[d]))
        .collect();
    for (step, count) in steps.iter().zip(&counts) {
        for r in 0..3 {
            for c in 0..3 {
                m[r][c] += count * step[r] * step[c];
            }
        }
    }
    let spare = (m[0][0] + m[1][1] + m[2][2]) / 64 + 1;
    for (d, row) in m.iter_mut().enumerate() {
        row[d] += spare;
    }
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let adjugate: [[i128; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| minor(r, c)));
    let determinant: i128 = (0..3).map(|c| m[0][c] * adjugate[0][c]).sum();
    // The element itself is at 0.
    let toward: [i128; 3] =
        std::array::from_fn(|r| (0..3).map(|c| -adjugate[r][c] * middle[c]).sum());
    steps
        .iter()
        .zip(&counts)
        .map(|(step, count)| {
            let along: i128 = (0..3).map(|d| step[d] * toward[d]).sum();
            let slope = quotient(along * count, determinant);
            let share = count * i128::from(UNIT) / total;
            (slope + share as i64).clamp(-8 * UNIT, 8 * UNIT) as i32
        })
        .collect()
}

/// `a / b * UNIT` for a positive `b`, by 64-bit division.
fn quotient(a: i128, b: i128) -> i64 {
    let bits = 128 - b.leading_zeros();
    let shift = bits.saturating_sub(40);
    let (a, b) = (a >> shift, (b >> shift) as i64);
    let most = i128::from(i64::MAX >> UNIT_BITS);
    (a.clamp(-most, most) as i64) * UNIT / b.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Predictions of the last of four points, whose two faces form a quad with the given corners.
    fn predictions(corners: [[i32; 3]; 4], values: [i32; 3]) -> [i32; PREDICTORS] {
        let ring = Ring::new(4, vec![[0, 1, 2], [1, 3, 2]]);
        let stencils = Stencils::new(&ring, |v| corners[v as usize], 0);
        assert_eq!(stencils.class(0), 0);
        stencils.predict(3, |v| [values[v as usize]]).map(|p| p[0])
    }

    #[test]
    fn predictors_by_hand() {
        let square = [[0, 0, 0], [1000, 0, 0], [0, 1000, 0], [1000, 1000, 0]];
        let [mean, parallelogram, affine, inverse] = predictions(square, [5, 7, 11]);
        // In sixteenths: (7 + 11) / 2, and 7 + 11 - 5.
        assert_eq!((mean, parallelogram, inverse), (144, 208, 144));
        // Weights 2, 2, 1 by squared distance: mean 8.2; along the diagonal the spread is 0.4, with
        // 2.4 / 64 added; 8.2 + 0.6 * 3.2 / 0.4375 = 12.589.
        assert!((affine - 201).abs() <= 2, "{affine}");
        // Distances 10 and 30 weigh 3 to 1: (3 * 11 + 7) / 4 = 10. 2^20 over each is rounded down.
        let long = [[0, 0, 0], [10, -20, 0], [0, 10, 0], [10, 10, 0]];
        let inverse = predictions(long, [5, 7, 11])[3];
        assert!((inverse - 160).abs() <= 1, "{inverse}");
    }

    #[test]
    fn quotients_are_scaled() {
        assert_eq!(quotient(3, 4), UNIT * 3 / 4);
        assert_eq!(quotient(-3, 4), -UNIT * 3 / 4);
        assert_eq!(quotient(3 << 60, 4 << 60), UNIT * 3 / 4);
        assert_eq!(quotient(5, 1 << 20), 0);
    }
}
