//! Lanes as plain arrays: the oracle of the other backends.
//!
//! The functions are not `#[inline(always)]` as in the other backends: the compiler would put a
//! whole kernel of thousands of scalar instructions into one function, and spend more time on it
//! than on the rest of the crate.

use super::half::half_from_f32;
use super::{LANES, Lanes, Row, Rows, Tile, Vector, WIDE};

/// Numbers in an array.
#[derive(Clone, Copy)]
pub(crate) struct Plain([f32; LANES]);

impl Plain {
    #[inline]
    fn each(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self.0;
        for (a, b) in out.iter_mut().zip(other.0) {
            *a = f(*a, b);
        }
        Self(out)
    }

    #[inline]
    fn compare(self, other: Self, f: impl Fn(f32, f32) -> bool) -> [bool; LANES] {
        let mut out = [false; LANES];
        for (out, (a, b)) in out.iter_mut().zip(self.0.into_iter().zip(other.0)) {
            *out = f(a, b);
        }
        out
    }
}

impl Vector for Plain {
    fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    fn add(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }

    fn sub(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }

    fn mul(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }

    fn div(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
    }

    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    fn sign(self) -> Self {
        Self(self.0.map(|v| 1f32.copysign(v)))
    }

    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        let mut out = no;
        for lane in 0..LANES {
            if self.0[lane] != 0.0 {
                out.0[lane] = yes.0[lane];
            }
        }
        out
    }
}

impl Rows<LANES> for Plain {
    type Weights = [f32; LANES];
    type Eight = Plain;
    type Piece = Self;

    fn load(from: &[f32; LANES]) -> Self {
        Self(*from)
    }

    fn store(self, to: &mut Tile) {
        to.0 = self.0;
    }

    fn weights(weights: &[f32; LANES]) -> [f32; LANES] {
        *weights
    }

    fn lerp_rows(before: [&Row; LANES], after: [&Row; LANES], weights: [f32; LANES]) -> [Self; 4] {
        let mut out = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            for (c, component) in out.iter_mut().enumerate() {
                let (a, b) = (before[lane][c], after[lane][c]);
                component[lane] = a + (b - a) * weights[lane];
            }
        }
        out.map(Self)
    }

    fn lerp_short_rows(
        before: [&[i16; 4]; LANES],
        after: [&[i16; 4]; LANES],
        weights: [f32; LANES],
    ) -> [Self; 4] {
        let a = before.map(|row| row.map(f32::from));
        let b = after.map(|row| row.map(f32::from));
        Self::lerp_rows(a.each_ref(), b.each_ref(), weights)
    }
}

/// Sixteen lanes as twice eight.
#[derive(Clone, Copy)]
pub(crate) struct PlainWide([Plain; 2]);

impl PlainWide {
    fn each(self, other: Self, f: impl Fn(Plain, Plain) -> Plain) -> Self {
        let ([a, b], [c, d]) = (self.0, other.0);
        Self([f(a, c), f(b, d)])
    }

    /// Puts the components of the first and the last eight lanes together.
    fn of([first, last]: [[Plain; 4]; 2]) -> [Self; 4] {
        std::array::from_fn(|c| Self([first[c], last[c]]))
    }
}

/// The first and the last eight lanes.
fn halves<T>(lanes: &[T; WIDE]) -> [&[T; LANES]; 2] {
    let eights = lanes.as_chunks().0;
    [&eights[0], &eights[1]]
}

impl Vector for PlainWide {
    fn splat(value: f32) -> Self {
        Self([Plain::splat(value); 2])
    }

    fn add(self, other: Self) -> Self {
        self.each(other, Plain::add)
    }

    fn sub(self, other: Self) -> Self {
        self.each(other, Plain::sub)
    }

    fn mul(self, other: Self) -> Self {
        self.each(other, Plain::mul)
    }

    fn div(self, other: Self) -> Self {
        self.each(other, Plain::div)
    }

    fn sqrt(self) -> Self {
        Self(self.0.map(Plain::sqrt))
    }

    fn sign(self) -> Self {
        Self(self.0.map(Plain::sign))
    }

    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        let pick = |i: usize| self.0[i].if_nonzero(yes.0[i], no.0[i]);
        Self([pick(0), pick(1)])
    }
}

impl Rows<WIDE> for PlainWide {
    type Weights = [f32; WIDE];
    type Eight = Plain;
    type Piece = Self;

    fn load(from: &[f32; WIDE]) -> Self {
        Self(halves(from).map(Plain::load))
    }

    fn store(self, to: &mut Tile<WIDE>) {
        let numbers = self.0.map(|eight| eight.0);
        to.0.copy_from_slice(numbers.as_flattened());
    }

    fn weights(weights: &[f32; WIDE]) -> [f32; WIDE] {
        *weights
    }

    fn lerp_rows(before: [&Row; WIDE], after: [&Row; WIDE], weights: [f32; WIDE]) -> [Self; 4] {
        let (a, b, w) = (halves(&before), halves(&after), halves(&weights));
        Self::of([0, 1].map(|i| Plain::lerp_rows(*a[i], *b[i], *w[i])))
    }

    fn lerp_short_rows(
        before: [&[i16; 4]; WIDE],
        after: [&[i16; 4]; WIDE],
        weights: [f32; WIDE],
    ) -> [Self; 4] {
        let (a, b, w) = (halves(&before), halves(&after), halves(&weights));
        Self::of([0, 1].map(|i| Plain::lerp_short_rows(*a[i], *b[i], *w[i])))
    }
}

impl Lanes for Plain {
    type Mask = [bool; LANES];

    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    fn min(self, other: Self) -> Self {
        self.each(other, |a, b| if a < b { a } else { b })
    }

    fn max(self, other: Self) -> Self {
        self.each(other, |a, b| if a > b { a } else { b })
    }

    fn less(self, other: Self) -> [bool; LANES] {
        self.compare(other, |a, b| a < b)
    }

    fn at_most(self, other: Self) -> [bool; LANES] {
        self.compare(other, |a, b| a <= b)
    }

    fn both(a: [bool; LANES], b: [bool; LANES]) -> [bool; LANES] {
        std::array::from_fn(|lane| a[lane] && b[lane])
    }

    fn select(mask: [bool; LANES], yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|lane| {
            if mask[lane] { yes.0[lane] } else { no.0[lane] }
        }))
    }

    fn bits(mask: [bool; LANES]) -> u8 {
        let lanes = mask.into_iter().enumerate();
        lanes.fold(0, |bits, (lane, is)| bits | u8::from(is) << lane)
    }

    fn store_rows<const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [Row],
        stride: usize,
        at: usize,
    ) {
        for lane in 0..LANES {
            for (i, row) in rows.iter().enumerate() {
                let number = |tile: &Tile<W>| tile.eight(eight)[lane];
                out[lane * stride + at + i] = row.map(number);
            }
        }
    }

    fn store_half_rows<const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [[u16; 4]],
        stride: usize,
        at: usize,
    ) {
        for lane in 0..LANES {
            for (i, row) in rows.iter().enumerate() {
                let half = |tile: &Tile<W>| half_from_f32(tile.eight(eight)[lane]);
                out[lane * stride + at + i] = row.map(half);
            }
        }
    }
}
