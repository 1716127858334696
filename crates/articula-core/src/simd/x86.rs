//! Lanes of x86-64: two vectors of 128 bits, or one of 256.
#![expect(
    unsafe_code,
    reason = "vector instructions; the types of this file are private and run by `run_*` alone"
)]

use super::half::half_from_f32;
use super::{Backend, Halves, Kernel, LANES, Lanes, Row, Rows, Tile, Vector};
use std::arch::x86_64::*;

/// Runs a kernel on 256-bit vectors.
///
/// # Panics
/// If the machine lacks them.
pub(super) fn run_avx2<K: Kernel>(kernel: K) {
    #[target_feature(enable = "avx2,f16c")]
    fn run<K: Kernel>(kernel: K) {
        kernel.run::<Avx2>();
    }
    assert!(Backend::Avx2.is_available(), "this machine has no AVX2");
    // SAFETY: the features were just found on this machine.
    unsafe { run(kernel) }
}

/// Runs a kernel on 128-bit vectors, which every x86-64 machine has.
pub(super) fn run_sse2<K: Kernel>(kernel: K) {
    kernel.run::<Sse2>();
}

#[inline(always)]
pub(super) fn prefetch_to_write(address: usize) {
    let at = std::ptr::without_provenance(address);
    // SAFETY: a prefetch neither faults nor changes memory, whatever the address.
    unsafe { _mm_prefetch::<_MM_HINT_ET0>(at) }
}

/// Transposes four rows, in each half of 128 bits.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn turned(rows: [__m256; 4]) -> [__m256; 4] {
    let [r0, r1, r2, r3] = rows;
    // SAFETY: the caller vouches for AVX.
    unsafe {
        let low01 = _mm256_unpacklo_ps(r0, r1);
        let high01 = _mm256_unpackhi_ps(r0, r1);
        let low23 = _mm256_unpacklo_ps(r2, r3);
        let high23 = _mm256_unpackhi_ps(r2, r3);
        [
            _mm256_shuffle_ps::<0x44>(low01, low23),
            _mm256_shuffle_ps::<0xee>(low01, low23),
            _mm256_shuffle_ps::<0x44>(high01, high23),
            _mm256_shuffle_ps::<0xee>(high01, high23),
        ]
    }
}

/// Eight lanes in one vector. Lanes `i` and `i + 4` have the same position within their halves.
#[derive(Clone, Copy)]
pub(super) struct Avx2(pub(super) __m256);

/// Blends pairs of rows (lanes `i` and `i + 4`) and transposes them.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn lerp_turned(before: [__m256; 4], after: [__m256; 4], weights: [__m256; 4]) -> [Avx2; 4] {
    let mut rows = before;
    for i in 0..4 {
        // SAFETY: the caller vouches for AVX2.
        rows[i] = unsafe {
            let way = _mm256_sub_ps(after[i], before[i]);
            _mm256_add_ps(before[i], _mm256_mul_ps(way, weights[i]))
        };
    }
    // SAFETY: as above.
    let [x, y, z, w] = unsafe { turned(rows) };
    [Avx2(x), Avx2(y), Avx2(z), Avx2(w)]
}

/// Rows of lanes `i` and `i + 4` in one vector.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn pair(rows: &[&Row; LANES], i: usize) -> __m256 {
    // SAFETY: a row is four numbers; the caller vouches for AVX.
    unsafe {
        let high = _mm_loadu_ps(rows[i + 4].as_ptr());
        _mm256_set_m128(high, _mm_loadu_ps(rows[i].as_ptr()))
    }
}

/// The same of 16-bit numbers.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn short_pair(rows: &[&[i16; 4]; LANES], i: usize) -> __m256 {
    // SAFETY: a row is 64 bits, so 64 bits are read of each; the caller vouches for AVX2.
    unsafe {
        let low = _mm_loadl_epi64(rows[i].as_ptr().cast());
        let high = _mm_loadl_epi64(rows[i + 4].as_ptr().cast());
        _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_unpacklo_epi64(low, high)))
    }
}

/// Two rows of each of four lanes, those of the lower or upper half.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn row_pairs<const W: usize>(
    first: [&Tile<W>; 4],
    second: [&Tile<W>; 4],
    eight: usize,
    half: usize,
) -> [__m256; 4] {
    // SAFETY: the caller vouches for AVX.
    unsafe {
        let mut columns = [_mm256_setzero_ps(); 4];
        for c in 0..4 {
            // An insertion from memory does not need one of the two ports that shuffle.
            let low = four(first[c].eight(eight), half);
            columns[c] = _mm256_set_m128(four(second[c].eight(eight), half), low);
        }
        turned(columns)
    }
}

/// The first or last four of eight numbers.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn four(from: &[f32; LANES], half: usize) -> __m128 {
    let [low, high] = [&from[..4], &from[4..]];
    // SAFETY: each is four numbers; the caller vouches for AVX.
    unsafe { _mm_loadu_ps(if half == 0 { low } else { high }.as_ptr()) }
}

/// The row of lanes `i` and `i + 4`.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn lane_pairs<const W: usize>(row: [&Tile<W>; 4], eight: usize) -> [__m256; 4] {
    let [x, y, z, w] = row;
    // SAFETY: eight numbers are read from eight; the caller vouches for AVX.
    unsafe {
        turned([
            _mm256_loadu_ps(x.eight(eight).as_ptr()),
            _mm256_loadu_ps(y.eight(eight).as_ptr()),
            _mm256_loadu_ps(z.eight(eight).as_ptr()),
            _mm256_loadu_ps(w.eight(eight).as_ptr()),
        ])
    }
}

/// A weight in the lower and another in the upper half.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn halves(low: f32, high: f32) -> __m256 {
    // SAFETY: the caller vouches for AVX.
    unsafe { _mm256_set_m128(_mm_set1_ps(high), _mm_set1_ps(low)) }
}

impl Vector for Avx2 {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: called inside `run_avx2` only, here and in all methods below.
        unsafe { Self(_mm256_set1_ps(value)) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_add_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_sub_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_mul_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_div_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_sqrt_ps(self.0)) }
    }

    #[inline(always)]
    fn sign(self) -> Self {
        // SAFETY: see `splat`.
        unsafe {
            let sign = _mm256_and_ps(self.0, _mm256_set1_ps(-0.0));
            Self(_mm256_or_ps(sign, _mm256_set1_ps(1.0)))
        }
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe {
            let any = _mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, _mm256_setzero_ps());
            Self(_mm256_blendv_ps(no.0, yes.0, any))
        }
    }
}

impl Rows<LANES> for Avx2 {
    type Weights = [__m256; 4];
    type Eight = Self;
    type Piece = Self;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        // SAFETY: eight numbers are read from eight.
        unsafe { Self(_mm256_loadu_ps(from.as_ptr())) }
    }

    #[inline(always)]
    fn store(self, to: &mut Tile) {
        // SAFETY: a tile is 32 aligned bytes.
        unsafe { _mm256_store_ps(to.0.as_mut_ptr(), self.0) }
    }

    // No closures and no iterators over vectors from here on: they would be compiled without the
    // instructions, and then not be inlined into the kernel.

    #[inline(always)]
    fn weights(w: &[f32; LANES]) -> [__m256; 4] {
        // SAFETY: see `splat`.
        unsafe {
            [
                halves(w[0], w[4]),
                halves(w[1], w[5]),
                halves(w[2], w[6]),
                halves(w[3], w[7]),
            ]
        }
    }

    #[inline(always)]
    fn lerp_rows(a: [&Row; LANES], b: [&Row; LANES], weights: [__m256; 4]) -> [Self; 4] {
        // SAFETY: see `splat`.
        unsafe {
            let before = [pair(&a, 0), pair(&a, 1), pair(&a, 2), pair(&a, 3)];
            let after = [pair(&b, 0), pair(&b, 1), pair(&b, 2), pair(&b, 3)];
            lerp_turned(before, after, weights)
        }
    }

    #[inline(always)]
    fn lerp_short_rows(
        a: [&[i16; 4]; LANES],
        b: [&[i16; 4]; LANES],
        weights: [__m256; 4],
    ) -> [Self; 4] {
        // SAFETY: see `splat`.
        unsafe {
            let (a0, a1) = (short_pair(&a, 0), short_pair(&a, 1));
            let (a2, a3) = (short_pair(&a, 2), short_pair(&a, 3));
            let (b0, b1) = (short_pair(&b, 0), short_pair(&b, 1));
            let (b2, b3) = (short_pair(&b, 2), short_pair(&b, 3));
            lerp_turned([a0, a1, a2, a3], [b0, b1, b2, b3], weights)
        }
    }
}

impl Lanes for Avx2 {
    type Mask = __m256;

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_min_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_max_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn less(self, other: Self) -> __m256 {
        // SAFETY: see `splat`.
        unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> __m256 {
        // SAFETY: see `splat`.
        unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn both(a: __m256, b: __m256) -> __m256 {
        // SAFETY: see `splat`.
        unsafe { _mm256_and_ps(a, b) }
    }

    #[inline(always)]
    fn select(mask: __m256, yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm256_blendv_ps(no.0, yes.0, mask)) }
    }

    #[inline(always)]
    fn bits(mask: __m256) -> u8 {
        // SAFETY: see `splat`.
        unsafe { _mm256_movemask_ps(mask) as u8 }
    }

    #[inline(always)]
    fn lerp_halves(before: &Halves, after: &Halves, weight: f32, out: &mut Halves) {
        // SAFETY: see `splat`; eight half floats are 128 bits.
        unsafe {
            let a = _mm256_cvtph_ps(_mm_loadu_si128(before.as_ptr().cast()));
            let b = _mm256_cvtph_ps(_mm_loadu_si128(after.as_ptr().cast()));
            let way = _mm256_mul_ps(_mm256_sub_ps(b, a), _mm256_set1_ps(weight));
            let sum = _mm256_add_ps(a, way);
            let halves = _mm256_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(sum);
            _mm_storeu_si128(out.as_mut_ptr().cast(), halves);
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
        let whole = out.len() >= (LANES - 1) * stride + at + R;
        assert!(whole, "the slice must hold the rows of eight lanes");
        let out = out.as_mut_ptr();
        // SAFETY: see `splat`; the rows from `lane * stride + at` on lie within `out`, as was just
        // checked.
        unsafe {
            let last = lane_pairs(rows[R - 1], eight);
            for half in 0..2 {
                let mut pairs = [[_mm256_setzero_ps(); 4]; R];
                for first in (0..R - 1).step_by(2) {
                    pairs[first] = row_pairs(rows[first], rows[first + 1], eight, half);
                }
                // All rows of a lane one after the other: two stores to a cache line take one cycle.
                for i in 0..4 {
                    let to = out.add((half * 4 + i) * stride + at);
                    for first in (0..R - 1).step_by(2) {
                        _mm256_storeu_ps(to.add(first).cast(), pairs[first][i]);
                    }
                    if R % 2 == 1 {
                        let row = if half == 0 {
                            _mm256_castps256_ps128(last[i])
                        } else {
                            _mm256_extractf128_ps::<1>(last[i])
                        };
                        _mm_storeu_ps(to.add(R - 1).cast(), row);
                    }
                }
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
        let whole = out.len() >= (LANES - 1) * stride + at + R;
        assert!(whole, "the slice must hold the rows of eight lanes");
        let out = out.as_mut_ptr();
        for half in 0..2 {
            for first in (0..R).step_by(2) {
                // SAFETY: as in `store_rows`.
                unsafe {
                    if first + 1 < R {
                        let pairs = row_pairs(rows[first], rows[first + 1], eight, half);
                        for (i, pair) in pairs.iter().enumerate() {
                            let to = out.add((half * 4 + i) * stride + at + first);
                            let halves = _mm256_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(*pair);
                            _mm_storeu_si128(to.cast(), halves);
                        }
                    } else if half == 1 {
                        let pairs = lane_pairs(rows[first], eight);
                        for (i, pair) in pairs.iter().enumerate() {
                            let halves = _mm256_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(*pair);
                            let to = out.add(i * stride + at + first).cast();
                            _mm_storel_epi64(to, halves);
                            let to = out.add((i + 4) * stride + at + first).cast();
                            _mm_storeh_pd(to, _mm_castsi128_pd(halves));
                        }
                    }
                }
            }
        }
    }
}

/// Eight lanes in two vectors.
#[derive(Clone, Copy)]
struct Sse2([__m128; 2]);

impl Sse2 {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(__m128, __m128) -> __m128) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn lerp(
        before: impl Fn(usize) -> __m128,
        after: impl Fn(usize) -> __m128,
        weights: [__m128; LANES],
    ) -> [Self; 4] {
        // SAFETY: SSE2 belongs to x86-64, here and in all methods below.
        let blend = |lane: usize| unsafe {
            let (a, b) = (before(lane), after(lane));
            _mm_add_ps(a, _mm_mul_ps(_mm_sub_ps(b, a), weights[lane]))
        };
        let low = turned_quarter(std::array::from_fn(blend));
        let high = turned_quarter(std::array::from_fn(|i| blend(i + 4)));
        std::array::from_fn(|c| Self([low[c], high[c]]))
    }

    /// The rows of each lane.
    #[inline(always)]
    fn rows<const W: usize>(row: [&Tile<W>; 4], eight: usize) -> [__m128; LANES] {
        let lanes = row.map(|tile| Self::load(tile.eight(eight)));
        let low = turned_quarter(lanes.map(|c| c.0[0]));
        let high = turned_quarter(lanes.map(|c| c.0[1]));
        std::array::from_fn(|lane| if lane < 4 { low[lane] } else { high[lane - 4] })
    }
}

/// Transposes four rows.
#[inline(always)]
fn turned_quarter(rows: [__m128; 4]) -> [__m128; 4] {
    let [mut a, mut b, mut c, mut d] = rows;
    // SAFETY: SSE belongs to x86-64.
    unsafe { _MM_TRANSPOSE4_PS(&mut a, &mut b, &mut c, &mut d) };
    [a, b, c, d]
}

impl Vector for Sse2 {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: SSE2 belongs to x86-64, here and in all methods below.
        unsafe { Self([_mm_set1_ps(value); 2]) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_add_ps(a, b) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_sub_ps(a, b) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_mul_ps(a, b) })
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_div_ps(a, b) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see `splat`.
        Self(self.0.map(|v| unsafe { _mm_sqrt_ps(v) }))
    }

    #[inline(always)]
    fn sign(self) -> Self {
        // SAFETY: see `splat`.
        Self(self.0.map(|v| unsafe {
            let sign = _mm_and_ps(v, _mm_set1_ps(-0.0));
            _mm_or_ps(sign, _mm_set1_ps(1.0))
        }))
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        let any = Self(
            self.0
                .map(|v| unsafe { _mm_cmpneq_ps(v, _mm_setzero_ps()) }),
        );
        Self::select(any.0, yes, no)
    }
}

impl Rows<LANES> for Sse2 {
    type Weights = [__m128; LANES];
    type Eight = Self;
    type Piece = Self;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        let at = from.as_ptr();
        // SAFETY: eight numbers are read from eight.
        unsafe { Self([_mm_loadu_ps(at), _mm_loadu_ps(at.add(4))]) }
    }

    #[inline(always)]
    fn store(self, to: &mut Tile) {
        let at = to.0.as_mut_ptr();
        // SAFETY: a tile is 32 aligned bytes.
        unsafe {
            _mm_store_ps(at, self.0[0]);
            _mm_store_ps(at.add(4), self.0[1]);
        }
    }

    #[inline(always)]
    fn weights(weights: &[f32; LANES]) -> [__m128; LANES] {
        // SAFETY: see `splat`.
        weights.map(|w| unsafe { _mm_set1_ps(w) })
    }

    #[inline(always)]
    fn lerp_rows(
        before: [&Row; LANES],
        after: [&Row; LANES],
        weights: [__m128; LANES],
    ) -> [Self; 4] {
        // SAFETY: a row is four numbers.
        let row = |row: &Row| unsafe { _mm_loadu_ps(row.as_ptr()) };
        Self::lerp(|i| row(before[i]), |i| row(after[i]), weights)
    }

    #[inline(always)]
    fn lerp_short_rows(
        before: [&[i16; 4]; LANES],
        after: [&[i16; 4]; LANES],
        weights: [__m128; LANES],
    ) -> [Self; 4] {
        // SAFETY: a row is four 16-bit numbers, so 64 bits are read.
        let row = |row: &[i16; 4]| unsafe {
            let short = _mm_loadl_epi64(row.as_ptr().cast());
            // Each number twice, then shifted down with its sign.
            _mm_cvtepi32_ps(_mm_srai_epi32::<16>(_mm_unpacklo_epi16(short, short)))
        };
        Self::lerp(|i| row(before[i]), |i| row(after[i]), weights)
    }
}

impl Lanes for Sse2 {
    type Mask = [__m128; 2];

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `splat`.
        Self(
            self.0
                .map(|v| unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), v) }),
        )
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_min_ps(a, b) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_max_ps(a, b) })
    }

    #[inline(always)]
    fn less(self, other: Self) -> [__m128; 2] {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_cmplt_ps(a, b) }).0
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> [__m128; 2] {
        // SAFETY: see `splat`.
        self.each(other, |a, b| unsafe { _mm_cmple_ps(a, b) }).0
    }

    #[inline(always)]
    fn both(a: [__m128; 2], b: [__m128; 2]) -> [__m128; 2] {
        // SAFETY: see `splat`.
        Self(a).each(Self(b), |a, b| unsafe { _mm_and_ps(a, b) }).0
    }

    #[inline(always)]
    fn select(mask: [__m128; 2], yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        let yes = Self(mask).each(yes, |m, v| unsafe { _mm_and_ps(m, v) });
        // SAFETY: see `splat`.
        let no = Self(mask).each(no, |m, v| unsafe { _mm_andnot_ps(m, v) });
        // SAFETY: see `splat`.
        yes.each(no, |a, b| unsafe { _mm_or_ps(a, b) })
    }

    #[inline(always)]
    fn bits([low, high]: [__m128; 2]) -> u8 {
        // SAFETY: see `splat`.
        unsafe { (_mm_movemask_ps(low) | _mm_movemask_ps(high) << 4) as u8 }
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
                unsafe { _mm_storeu_ps(out.add(lane * stride + at + row).cast(), numbers) };
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
                unsafe { _mm_storeu_ps(values.as_mut_ptr(), numbers) };
                out[lane * stride + at + row] = values.map(half_from_f32);
            }
        }
    }
}
