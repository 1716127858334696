//! Lanes as plain arrays: the oracle of the other backends.

use super::half::half_from_f32;
use super::{LANES, Lanes, Row, Rows, Tile, Vector};

/// Numbers in an array.
#[derive(Clone, Copy)]
pub(crate) struct Plain<const W: usize>([f32; W]);

impl<const W: usize> Plain<W> {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self.0;
        for (a, b) in out.iter_mut().zip(other.0) {
            *a = f(*a, b);
        }
        Self(out)
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f32, f32) -> bool) -> [bool; W] {
        let mut out = [false; W];
        for (out, (a, b)) in out.iter_mut().zip(self.0.into_iter().zip(other.0)) {
            *out = f(a, b);
        }
        out
    }
}

impl<const W: usize> Vector for Plain<W> {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; W])
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn sign(self) -> Self {
        Self(self.0.map(|v| 1f32.copysign(v)))
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        let mut out = no;
        for lane in 0..W {
            if self.0[lane] != 0.0 {
                out.0[lane] = yes.0[lane];
            }
        }
        out
    }
}

impl<const W: usize> Rows<W> for Plain<W> {
    type Weights = [f32; W];
    type Eight = Plain<LANES>;

    #[inline(always)]
    fn load(from: &[f32; W]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self, to: &mut Tile<W>) {
        to.0 = self.0;
    }

    #[inline(always)]
    fn weights(weights: &[f32; W]) -> [f32; W] {
        *weights
    }

    #[inline(always)]
    fn lerp_rows(before: [&Row; W], after: [&Row; W], weights: [f32; W]) -> [Self; 4] {
        let mut out = [[0.0; W]; 4];
        for lane in 0..W {
            for (c, component) in out.iter_mut().enumerate() {
                let (a, b) = (before[lane][c], after[lane][c]);
                component[lane] = a + (b - a) * weights[lane];
            }
        }
        out.map(Self)
    }

    #[inline(always)]
    fn lerp_short_rows(
        before: [&[i16; 4]; W],
        after: [&[i16; 4]; W],
        weights: [f32; W],
    ) -> [Self; 4] {
        let a = before.map(|row| row.map(f32::from));
        let b = after.map(|row| row.map(f32::from));
        Self::lerp_rows(a.each_ref(), b.each_ref(), weights)
    }
}

impl Lanes for Plain<LANES> {
    type Mask = [bool; LANES];

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.each(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.each(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn less(self, other: Self) -> [bool; LANES] {
        self.compare(other, |a, b| a < b)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> [bool; LANES] {
        self.compare(other, |a, b| a <= b)
    }

    #[inline(always)]
    fn both(a: [bool; LANES], b: [bool; LANES]) -> [bool; LANES] {
        std::array::from_fn(|lane| a[lane] && b[lane])
    }

    #[inline(always)]
    fn select(mask: [bool; LANES], yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|lane| {
            if mask[lane] { yes.0[lane] } else { no.0[lane] }
        }))
    }

    #[inline(always)]
    fn bits(mask: [bool; LANES]) -> u8 {
        let lanes = mask.into_iter().enumerate();
        lanes.fold(0, |bits, (lane, is)| bits | u8::from(is) << lane)
    }

    #[inline(always)]
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

    #[inline(always)]
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
