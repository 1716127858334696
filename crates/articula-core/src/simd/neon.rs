//! Lanes of AArch64: two vectors of 128 bits.
#![expect(
    unsafe_code,
    reason = "vector instructions; loads and stores by address, checked next to each"
)]

use super::{Halves, Kernel, LANES, Lanes, Row, Rows, Tile, Vector};
use std::arch::aarch64::*;

/// Runs a kernel on 128-bit vectors, which every AArch64 machine with an operating system has.
pub(super) fn run<K: Kernel>(kernel: K) {
    kernel.run::<Neon>();
}

/// Eight lanes in two vectors.
#[derive(Clone, Copy)]
struct Neon([float32x4_t; 2]);

impl Neon {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(float32x4_t, float32x4_t) -> float32x4_t) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn compare(
        self,
        other: Self,
        f: impl Fn(float32x4_t, float32x4_t) -> uint32x4_t,
    ) -> [uint32x4_t; 2] {
        [f(self.0[0], other.0[0]), f(self.0[1], other.0[1])]
    }

    #[inline(always)]
    fn lerp(
        before: impl Fn(usize) -> float32x4_t,
        after: impl Fn(usize) -> float32x4_t,
        weights: [float32x4_t; LANES],
    ) -> [Self; 4] {
        let blend = |lane: usize| blended(before(lane), after(lane), weights[lane]);
        let low = turned(std::array::from_fn(blend));
        let high = turned(std::array::from_fn(|i| blend(i + 4)));
        std::array::from_fn(|c| Self([low[c], high[c]]))
    }

    /// The rows of each lane.
    #[inline(always)]
    fn rows<const W: usize>(row: [&Tile<W>; 4], eight: usize) -> [float32x4_t; LANES] {
        let lanes = row.map(|tile| Self::load(tile.eight(eight)));
        let low = turned(lanes.map(|c| c.0[0]));
        let high = turned(lanes.map(|c| c.0[1]));
        std::array::from_fn(|lane| if lane < 4 { low[lane] } else { high[lane - 4] })
    }
}

/// `before + (after - before) * weight`, rounded twice: the fused instruction rounds once.
#[inline(always)]
fn blended(before: float32x4_t, after: float32x4_t, weight: float32x4_t) -> float32x4_t {
    // SAFETY: NEON belongs to AArch64.
    unsafe { vaddq_f32(before, vmulq_f32(vsubq_f32(after, before), weight)) }
}

/// Transposes four rows.
#[inline(always)]
fn turned(rows: [float32x4_t; 4]) -> [float32x4_t; 4] {
    let [a, b, c, d] = rows;
    // SAFETY: NEON belongs to AArch64.
    unsafe {
        let pairs = |first: float32x4_t, second: float32x4_t| {
            (
                vreinterpretq_f64_f32(vzip1q_f32(first, second)),
                vreinterpretq_f64_f32(vzip2q_f32(first, second)),
            )
        };
        let (low01, high01) = pairs(a, b);
        let (low23, high23) = pairs(c, d);
        [
            vreinterpretq_f32_f64(vzip1q_f64(low01, low23)),
            vreinterpretq_f32_f64(vzip2q_f64(low01, low23)),
            vreinterpretq_f32_f64(vzip1q_f64(high01, high23)),
            vreinterpretq_f32_f64(vzip2q_f64(high01, high23)),
        ]
    }
}

impl Vector for Neon {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: NEON belongs to AArch64, here and in all methods below.
        unsafe { Self([vdupq_n_f32(value); 2]) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { vaddq_f32(a, b) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { vsubq_f32(a, b) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { vmulq_f32(a, b) })
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { vdivq_f32(a, b) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see `splat`.
        Self(self.0.map(|v| unsafe { vsqrtq_f32(v) }))
    }

    #[inline(always)]
    fn sign(self) -> Self {
        // SAFETY: see `splat`.
        Self(self.0.map(|v| unsafe {
            let sign = vdupq_n_u32(1 << 31);
            vbslq_f32(sign, v, vdupq_n_f32(1.0))
        }))
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        let none = self.0.map(|v| unsafe { vceqzq_f32(v) });
        Self::select(none, no, yes)
    }
}

impl Rows<LANES> for Neon {
    type Weights = [float32x4_t; LANES];
    type Eight = Self;
    type Piece = Self;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        let at = from.as_ptr();
        // SAFETY: eight numbers are read from eight.
        unsafe { Self([vld1q_f32(at), vld1q_f32(at.add(4))]) }
    }

    #[inline(always)]
    fn store(self, to: &mut Tile) {
        let at = to.0.as_mut_ptr();
        // SAFETY: a tile is eight numbers.
        unsafe {
            vst1q_f32(at, self.0[0]);
            vst1q_f32(at.add(4), self.0[1]);
        }
    }

    #[inline(always)]
    fn weights(weights: &[f32; LANES]) -> [float32x4_t; LANES] {
        // SAFETY: see `splat`.
        weights.map(|w| unsafe { vdupq_n_f32(w) })
    }

    #[inline(always)]
    fn lerp_rows(
        before: [&Row; LANES],
        after: [&Row; LANES],
        weights: [float32x4_t; LANES],
    ) -> [Self; 4] {
        // SAFETY: a row is four numbers.
        let row = |row: &Row| unsafe { vld1q_f32(row.as_ptr()) };
        Self::lerp(|i| row(before[i]), |i| row(after[i]), weights)
    }

    #[inline(always)]
    fn lerp_short_rows(
        before: [&[i16; 4]; LANES],
        after: [&[i16; 4]; LANES],
        weights: [float32x4_t; LANES],
    ) -> [Self; 4] {
        // SAFETY: a row is four 16-bit numbers, so 64 bits are read.
        let row = |row: &[i16; 4]| unsafe { vcvtq_f32_s32(vmovl_s16(vld1_s16(row.as_ptr()))) };
        Self::lerp(|i| row(before[i]), |i| row(after[i]), weights)
    }
}

impl Lanes for Neon {
    type Mask = [uint32x4_t; 2];

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `splat`.
        Self(self.0.map(|v| unsafe { vabsq_f32(v) }))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // The instruction for a minimum returns NaN if either is NaN, and -0 of two zeros.
        Self::select(self.less(other), self, other)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }

    #[inline(always)]
    fn less(self, other: Self) -> [uint32x4_t; 2] {
        // SAFETY: see `splat`.
        self.compare(other, |a, b| unsafe { vcltq_f32(a, b) })
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> [uint32x4_t; 2] {
        // SAFETY: see `splat`.
        self.compare(other, |a, b| unsafe { vcleq_f32(a, b) })
    }

    #[inline(always)]
    fn both(a: [uint32x4_t; 2], b: [uint32x4_t; 2]) -> [uint32x4_t; 2] {
        // SAFETY: see `splat`.
        unsafe { [vandq_u32(a[0], b[0]), vandq_u32(a[1], b[1])] }
    }

    #[inline(always)]
    fn select(mask: [uint32x4_t; 2], yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        let pick = |i: usize| unsafe { vbslq_f32(mask[i], yes.0[i], no.0[i]) };
        Self([pick(0), pick(1)])
    }

    #[inline(always)]
    fn bits([low, high]: [uint32x4_t; 2]) -> u8 {
        const BITS: [u32; LANES] = [1, 2, 4, 8, 16, 32, 64, 128];
        // SAFETY: four numbers are read from the first and four from the second half of eight. No
        // two lanes share a bit, so the sum is below 256.
        unsafe {
            let low = vandq_u32(low, vld1q_u32(BITS.as_ptr()));
            let high = vandq_u32(high, vld1q_u32(BITS.as_ptr().add(4)));
            vaddvq_u32(vorrq_u32(low, high)) as u8
        }
    }

    #[inline(always)]
    fn lerp_halves(before: &Halves, after: &Halves, weight: f32, out: &mut Halves) {
        // Without remainder, as there are eight.
        let each = before.as_chunks::<4>().0.iter();
        let each = each.zip(after.as_chunks::<4>().0);
        for (out, (a, b)) in out.as_chunks_mut::<4>().0.iter_mut().zip(each) {
            // SAFETY: four half floats are read from each and written to four.
            unsafe {
                let value =
                    |from: &[u16; 4]| vcvt_f32_f16(vreinterpret_f16_u16(vld1_u16(from.as_ptr())));
                let sum = blended(value(a), value(b), vdupq_n_f32(weight));
                vst1_u16(out.as_mut_ptr(), vreinterpret_u16_f16(vcvt_f16_f32(sum)));
            }
        }
    }

    #[inline(always)]
    fn store_rows<const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [Row],
        stride: usize,
        at: usize,
    ) {
        for (row, tiles) in rows.into_iter().enumerate() {
            for (lane, numbers) in Self::rows(tiles, eight).into_iter().enumerate() {
                let out: &mut Row = &mut out[lane * stride + at + row];
                // SAFETY: four numbers are written to four.
                unsafe { vst1q_f32(out.as_mut_ptr(), numbers) };
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
                let out: &mut [u16; 4] = &mut out[lane * stride + at + row];
                // SAFETY: four half floats are written to four.
                unsafe {
                    let halves = vreinterpret_u16_f16(vcvt_f16_f32(numbers));
                    vst1_u16(out.as_mut_ptr(), halves);
                }
            }
        }
    }
}
