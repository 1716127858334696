//! Lanes of WebAssembly: two vectors of 128 bits.
#![expect(
    unsafe_code,
    reason = "loads and stores by address; every address is checked next to it"
)]

use super::half::half_from_f32;
use super::{Kernel, LANES, Lanes, Piece, Row, Rows, Tile, Vector};
use std::arch::wasm32::*;

/// Runs a kernel on 128-bit vectors.
pub(super) fn run<K: Kernel>(kernel: K) {
    kernel.run::<Simd128>();
}

/// Eight lanes in two vectors.
#[derive(Clone, Copy)]
struct Simd128([v128; 2]);

impl Simd128 {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(v128, v128) -> v128) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn lerp(
        before: impl Fn(usize) -> v128,
        after: impl Fn(usize) -> v128,
        weights: [v128; LANES],
    ) -> [Self; 4] {
        let blend = |lane: usize| {
            let (a, b) = (before(lane), after(lane));
            f32x4_add(a, f32x4_mul(f32x4_sub(b, a), weights[lane]))
        };
        let low = turned(std::array::from_fn(blend));
        let high = turned(std::array::from_fn(|i| blend(i + 4)));
        std::array::from_fn(|c| Self([low[c], high[c]]))
    }

    /// The rows of each lane.
    #[inline(always)]
    fn rows<const W: usize>(row: [&Tile<W>; 4], eight: usize) -> [v128; LANES] {
        let lanes = row.map(|tile| Self::load(tile.eight(eight)));
        let low = turned(lanes.map(|c| c.0[0]));
        let high = turned(lanes.map(|c| c.0[1]));
        std::array::from_fn(|lane| if lane < 4 { low[lane] } else { high[lane - 4] })
    }
}

/// Transposes four rows.
#[inline(always)]
fn turned(rows: [v128; 4]) -> [v128; 4] {
    let [a, b, c, d] = rows;
    let low01 = i32x4_shuffle::<0, 4, 1, 5>(a, b);
    let high01 = i32x4_shuffle::<2, 6, 3, 7>(a, b);
    let low23 = i32x4_shuffle::<0, 4, 1, 5>(c, d);
    let high23 = i32x4_shuffle::<2, 6, 3, 7>(c, d);
    [
        i64x2_shuffle::<0, 2>(low01, low23),
        i64x2_shuffle::<1, 3>(low01, low23),
        i64x2_shuffle::<0, 2>(high01, high23),
        i64x2_shuffle::<1, 3>(high01, high23),
    ]
}

/// The four numbers of a row.
#[inline(always)]
fn loaded(row: &Row) -> v128 {
    // SAFETY: a row is four numbers, and WebAssembly loads need no alignment.
    unsafe { v128_load(row.as_ptr().cast()) }
}

impl Vector for Simd128 {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([f32x4_splat(value); 2])
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.each(other, |a, b| f32x4_add(a, b))
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.each(other, |a, b| f32x4_sub(a, b))
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.each(other, |a, b| f32x4_mul(a, b))
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.each(other, |a, b| f32x4_div(a, b))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(|v| f32x4_sqrt(v)))
    }

    #[inline(always)]
    fn sign(self) -> Self {
        let sign = f32x4_splat(-0.0);
        Self(self.0.map(|v| v128_or(v128_and(v, sign), f32x4_splat(1.0))))
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        let any = self.0.map(|v| f32x4_ne(v, f32x4_splat(0.0)));
        Self::select(any, yes, no)
    }
}

impl Rows<LANES> for Simd128 {
    type Weights = [v128; LANES];
    type Eight = Self;
    type Piece = Four;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        let at = from.as_ptr();
        // SAFETY: eight numbers are read from eight.
        unsafe { Self([v128_load(at.cast()), v128_load(at.add(4).cast())]) }
    }

    #[inline(always)]
    fn store(self, to: &mut Tile) {
        let at = to.0.as_mut_ptr();
        // SAFETY: a tile is eight numbers.
        unsafe {
            v128_store(at.cast(), self.0[0]);
            v128_store(at.add(4).cast(), self.0[1]);
        }
    }

    #[inline(always)]
    fn weights(weights: &[f32; LANES]) -> [v128; LANES] {
        weights.map(|w| f32x4_splat(w))
    }

    #[inline(always)]
    fn lerp_rows(before: [&Row; LANES], after: [&Row; LANES], weights: [v128; LANES]) -> [Self; 4] {
        Self::lerp(|i| loaded(before[i]), |i| loaded(after[i]), weights)
    }

    #[inline(always)]
    fn lerp_short_rows(
        before: [&[i16; 4]; LANES],
        after: [&[i16; 4]; LANES],
        weights: [v128; LANES],
    ) -> [Self; 4] {
        let row = |row: &[i16; 4]| {
            // SAFETY: a row is four 16-bit numbers, so 64 bits are read.
            let wide = unsafe { i32x4_load_extend_i16x4(row.as_ptr()) };
            f32x4_convert_i32x4(wide)
        };
        Self::lerp(|i| row(before[i]), |i| row(after[i]), weights)
    }
}

/// Four of the lanes. Of eight, a product of matrices does not fit the registers.
#[derive(Clone, Copy)]
struct Four(v128);

impl Piece<LANES> for Four {
    const COUNT: usize = 2;

    #[inline(always)]
    fn load_piece(from: &[f32; LANES], piece: usize) -> Self {
        let from = &from.as_chunks::<4>().0[piece];
        Self(loaded(from))
    }

    #[inline(always)]
    fn store_piece(self, to: &mut Tile, piece: usize) {
        let to = &mut to.0.as_chunks_mut::<4>().0[piece];
        // SAFETY: four numbers are written to four.
        unsafe { v128_store(to.as_mut_ptr().cast(), self.0) };
    }
}

impl Vector for Four {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(f32x4_splat(value))
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(f32x4_add(self.0, other.0))
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(f32x4_sub(self.0, other.0))
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(f32x4_mul(self.0, other.0))
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(f32x4_div(self.0, other.0))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(f32x4_sqrt(self.0))
    }

    #[inline(always)]
    fn sign(self) -> Self {
        let sign = v128_and(self.0, f32x4_splat(-0.0));
        Self(v128_or(sign, f32x4_splat(1.0)))
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        let any = f32x4_ne(self.0, f32x4_splat(0.0));
        Self(v128_bitselect(yes.0, no.0, any))
    }
}

impl Lanes for Simd128 {
    type Mask = [v128; 2];

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(|v| f32x4_abs(v)))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // The pseudo-minimum keeps its first operand unless the second is less.
        self.each(other, |a, b| f32x4_pmin(b, a))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.each(other, |a, b| f32x4_pmax(b, a))
    }

    #[inline(always)]
    fn less(self, other: Self) -> [v128; 2] {
        self.each(other, |a, b| f32x4_lt(a, b)).0
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> [v128; 2] {
        self.each(other, |a, b| f32x4_le(a, b)).0
    }

    #[inline(always)]
    fn both(a: [v128; 2], b: [v128; 2]) -> [v128; 2] {
        Self(a).each(Self(b), |a, b| v128_and(a, b)).0
    }

    #[inline(always)]
    fn select(mask: [v128; 2], yes: Self, no: Self) -> Self {
        let pick = |i: usize| v128_bitselect(yes.0[i], no.0[i], mask[i]);
        Self([pick(0), pick(1)])
    }

    #[inline(always)]
    fn bits([low, high]: [v128; 2]) -> u8 {
        i32x4_bitmask(low) | i32x4_bitmask(high) << 4
    }

    #[inline(always)]
    fn store_rows<const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [Row],
        stride: usize,
        at: usize,
    ) {
        let whole = out.len() >= (LANES - 1) * stride + at + R;
        assert!(whole, "the slice must hold the rows of eight lanes");
        let out = out.as_mut_ptr();
        for (row, tiles) in rows.into_iter().enumerate() {
            for (lane, numbers) in Self::rows(tiles, eight).into_iter().enumerate() {
                // SAFETY: the row lies within `out`, as was just checked.
                unsafe { v128_store(out.add(lane * stride + at + row).cast(), numbers) };
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
        for (row, tiles) in rows.into_iter().enumerate() {
            for (lane, numbers) in Self::rows(tiles, eight).into_iter().enumerate() {
                let mut values = [0.0; 4];
                // SAFETY: four numbers are written to four.
                unsafe { v128_store(values.as_mut_ptr().cast(), numbers) };
                out[lane * stride + at + row] = values.map(half_from_f32);
            }
        }
    }
}
