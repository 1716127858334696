//! Sixteen lanes of x86-64 in one vector of 512 bits.
#![expect(
    unsafe_code,
    reason = "vector instructions; the types of this file are private and run by `run` alone"
)]

use super::x86::Avx2;
use super::{Backend, Row, Rows, Tile, Vector, WIDE, WideKernel};
use std::arch::x86_64::*;

/// Runs a kernel on 512-bit vectors.
///
/// # Panics
/// If the machine lacks them.
pub(super) fn run<K: WideKernel>(kernel: K) {
    #[target_feature(enable = "avx2,f16c,avx512f,avx512dq")]
    fn run<K: WideKernel>(kernel: K) {
        kernel.run::<Avx512>();
    }
    let available = Backend::Avx512.is_available();
    assert!(available, "this machine has no AVX-512");
    // SAFETY: the features were just found on this machine.
    unsafe { run(kernel) }
}

/// Sixteen lanes in one vector.
#[derive(Clone, Copy)]
struct Avx512(__m512);

/// Transposes four rows, in each quarter of 128 bits.
///
/// # Safety
/// The machine has AVX-512.
#[inline(always)]
unsafe fn turned(rows: [__m512; 4]) -> [__m512; 4] {
    let [r0, r1, r2, r3] = rows;
    // SAFETY: the caller vouches for AVX-512.
    unsafe {
        let low01 = _mm512_unpacklo_ps(r0, r1);
        let high01 = _mm512_unpackhi_ps(r0, r1);
        let low23 = _mm512_unpacklo_ps(r2, r3);
        let high23 = _mm512_unpackhi_ps(r2, r3);
        [
            _mm512_shuffle_ps::<0x44>(low01, low23),
            _mm512_shuffle_ps::<0xee>(low01, low23),
            _mm512_shuffle_ps::<0x44>(high01, high23),
            _mm512_shuffle_ps::<0xee>(high01, high23),
        ]
    }
}

/// Rows of lanes `i`, `i + 4`, `i + 8` and `i + 12` in one vector.
///
/// # Safety
/// The machine has AVX-512.
#[inline(always)]
unsafe fn four(rows: &[&Row; WIDE], i: usize) -> __m512 {
    // SAFETY: a row is four numbers; the caller vouches for AVX-512.
    unsafe {
        let first = _mm512_castps128_ps512(_mm_loadu_ps(rows[i].as_ptr()));
        let two = _mm512_insertf32x4::<1>(first, _mm_loadu_ps(rows[i + 4].as_ptr()));
        let three = _mm512_insertf32x4::<2>(two, _mm_loadu_ps(rows[i + 8].as_ptr()));
        _mm512_insertf32x4::<3>(three, _mm_loadu_ps(rows[i + 12].as_ptr()))
    }
}

/// The same of 16-bit numbers.
///
/// # Safety
/// The machine has AVX-512.
#[inline(always)]
unsafe fn four_short(rows: &[&[i16; 4]; WIDE], i: usize) -> __m512 {
    // SAFETY: a row is 64 bits, so 64 bits are read of each; the caller vouches for AVX-512.
    unsafe {
        let first = _mm_loadl_epi64(rows[i].as_ptr().cast());
        let second = _mm_loadl_epi64(rows[i + 4].as_ptr().cast());
        let third = _mm_loadl_epi64(rows[i + 8].as_ptr().cast());
        let fourth = _mm_loadl_epi64(rows[i + 12].as_ptr().cast());
        let low = _mm_unpacklo_epi64(first, second);
        let high = _mm_unpacklo_epi64(third, fourth);
        _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(_mm256_set_m128i(high, low)))
    }
}

/// Blends rows and transposes them.
///
/// # Safety
/// The machine has AVX-512.
#[inline(always)]
unsafe fn lerp_turned(
    before: [__m512; 4],
    after: [__m512; 4],
    weights: [__m512; 4],
) -> [Avx512; 4] {
    let mut rows = before;
    for i in 0..4 {
        // SAFETY: the caller vouches for AVX-512.
        rows[i] = unsafe {
            let way = _mm512_sub_ps(after[i], before[i]);
            _mm512_add_ps(before[i], _mm512_mul_ps(way, weights[i]))
        };
    }
    // SAFETY: as above.
    let [x, y, z, w] = unsafe { turned(rows) };
    [Avx512(x), Avx512(y), Avx512(z), Avx512(w)]
}

impl Vector for Avx512 {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: called inside `run` only, here and in all methods below.
        unsafe { Self(_mm512_set1_ps(value)) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm512_add_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm512_sub_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm512_mul_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm512_div_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see `splat`.
        unsafe { Self(_mm512_sqrt_ps(self.0)) }
    }

    #[inline(always)]
    fn sign(self) -> Self {
        // SAFETY: see `splat`.
        unsafe {
            let sign = _mm512_and_ps(self.0, _mm512_set1_ps(-0.0));
            Self(_mm512_or_ps(sign, _mm512_set1_ps(1.0)))
        }
    }

    #[inline(always)]
    fn if_nonzero(self, yes: Self, no: Self) -> Self {
        // SAFETY: see `splat`.
        unsafe {
            let any = _mm512_cmp_ps_mask::<_CMP_NEQ_UQ>(self.0, _mm512_setzero_ps());
            Self(_mm512_mask_blend_ps(any, no.0, yes.0))
        }
    }
}

// No closures and no iterators over vectors: see `x86`.
impl Rows<WIDE> for Avx512 {
    type Weights = [__m512; 4];
    type Eight = Avx2;
    type Piece = Self;

    #[inline(always)]
    fn load(from: &[f32; WIDE]) -> Self {
        // SAFETY: sixteen numbers are read from sixteen.
        unsafe { Self(_mm512_loadu_ps(from.as_ptr())) }
    }

    #[inline(always)]
    fn store(self, to: &mut Tile<WIDE>) {
        // SAFETY: a tile is 64 bytes.
        unsafe { _mm512_storeu_ps(to.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn weights(weights: &[f32; WIDE]) -> [__m512; 4] {
        let mut rows = [[0.0; WIDE]; 4];
        for (i, row) in rows.iter_mut().enumerate() {
            for (lane, number) in row.iter_mut().enumerate() {
                *number = weights[lane / 4 * 4 + i];
            }
        }
        // SAFETY: sixteen numbers are read from sixteen.
        unsafe {
            [
                _mm512_loadu_ps(rows[0].as_ptr()),
                _mm512_loadu_ps(rows[1].as_ptr()),
                _mm512_loadu_ps(rows[2].as_ptr()),
                _mm512_loadu_ps(rows[3].as_ptr()),
            ]
        }
    }

    #[inline(always)]
    fn lerp_rows(a: [&Row; WIDE], b: [&Row; WIDE], weights: [__m512; 4]) -> [Self; 4] {
        // SAFETY: see `splat`.
        unsafe {
            let before = [four(&a, 0), four(&a, 1), four(&a, 2), four(&a, 3)];
            let after = [four(&b, 0), four(&b, 1), four(&b, 2), four(&b, 3)];
            lerp_turned(before, after, weights)
        }
    }

    #[inline(always)]
    fn lerp_short_rows(
        a: [&[i16; 4]; WIDE],
        b: [&[i16; 4]; WIDE],
        weights: [__m512; 4],
    ) -> [Self; 4] {
        // SAFETY: see `splat`.
        unsafe {
            let (a0, a1) = (four_short(&a, 0), four_short(&a, 1));
            let (a2, a3) = (four_short(&a, 2), four_short(&a, 3));
            let (b0, b1) = (four_short(&b, 0), four_short(&b, 1));
            let (b2, b3) = (four_short(&b, 2), four_short(&b, 3));
            lerp_turned([a0, a1, a2, a3], [b0, b1, b2, b3], weights)
        }
    }
}
