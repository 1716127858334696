//! SIMD lanes: the only module that names instruction sets, and the only `unsafe` code.
//!
//! A kernel is written once over [`Lanes`], eight lanes of every [`Backend`], and run by [`dispatch`]
//! on the chosen one. What needs no more than [`Rows`] may also be a [`WideKernel`] of sixteen. No
//! backend fuses multiply and add or estimates a root, so all of them give the same bits; the plain
//! arrays of [`scalar`] are the oracle. Source: `docs/methods/runtime.md` part 3. Transposes are
//! written as intrinsics, since compilers turn plain loops into single inserts (measured: 417
//! against 222 ns for a figure of 67 joints).

#[cfg(target_arch = "x86_64")]
mod avx512;
pub(crate) mod half;
#[cfg(target_arch = "aarch64")]
mod neon;
mod parts;
pub(crate) mod scalar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use parts::Parts;

use crate::Mismatch;
use std::fmt;
use std::str::FromStr;

/// Number of lanes of every backend.
pub(crate) const LANES: usize = 8;

/// Number of lanes where a backend has vectors of 512 bits.
pub(crate) const WIDE: usize = 16;

/// One row of a matrix or one quaternion.
pub(crate) type Row = [f32; 4];

/// Eight half floats, as bits.
pub(crate) type Halves = [u16; LANES];

/// Lanes in memory, aligned for a load of eight.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Tile<const W: usize = LANES>(pub(crate) [f32; W]);

impl<const W: usize> Tile<W> {
    /// Zero in every lane.
    pub(crate) const ZERO: Self = Self([0.0; W]);

    /// Eight of the lanes, from `8 * i` on.
    #[inline(always)]
    pub(crate) fn eight(&self, i: usize) -> &[f32; LANES] {
        &self.0.as_chunks().0[i]
    }
}

/// Instruction sets that a kernel can run on; all give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Backend {
    /// Plain arrays, left to the compiler; available on every machine.
    Scalar,
    /// 128-bit vectors of every x86-64 processor.
    Sse2,
    /// 256-bit vectors of x86-64 processors since 2013, with half floats.
    Avx2,
    /// As [`Avx2`](Self::Avx2), with 512-bit vectors for batches of sixteen characters.
    Avx512,
    /// 128-bit vectors of WebAssembly; chosen when the module is compiled for them.
    Simd128,
    /// 128-bit vectors of every AArch64 processor, with half floats.
    Neon,
}

impl Backend {
    /// All backends, the slowest first.
    pub const ALL: [Self; 6] = [
        Self::Scalar,
        Self::Sse2,
        Self::Avx2,
        Self::Avx512,
        Self::Simd128,
        Self::Neon,
    ];

    /// Returns the fastest backend that this machine supports.
    pub fn best() -> Self {
        let found = Self::ALL.into_iter().rev().find(|b| b.is_available());
        found.unwrap_or(Self::Scalar)
    }

    /// Whether this machine supports it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            Self::Sse2 => cfg!(target_arch = "x86_64"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("f16c"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
            Self::Simd128 => cfg!(all(target_arch = "wasm32", target_feature = "simd128")),
            Self::Neon => cfg!(target_arch = "aarch64"),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Simd128 => "simd128",
            Self::Neon => "neon",
        }
    }
}

/// Writes the name that [`FromStr`] reads.
impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Backend {
    type Err = Mismatch;

    fn from_str(name: &str) -> Result<Self, Mismatch> {
        let found = Self::ALL.into_iter().find(|b| b.name() == name);
        found.ok_or_else(|| Mismatch::new("backend", format!("unknown backend \"{name}\"")))
    }
}

/// Numbers, one for each character of a batch.
pub(crate) trait Vector: Copy {
    fn splat(value: f32) -> Self;
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    /// One with the sign of each lane.
    fn sign(self) -> Self;
    /// `no` where this is zero, `yes` elsewhere.
    fn if_nonzero(self, yes: Self, no: Self) -> Self;
}

/// As many numbers as there are lanes, and rows of each character in memory.
pub(crate) trait Rows<const W: usize>: Vector {
    /// A weight for each lane, laid out for [`Rows::lerp_rows`].
    type Weights: Copy;
    /// The backend's eight lanes.
    type Eight: Lanes;
    /// Lanes that a step of many numbers takes at once.
    type Piece: Piece<W>;

    fn load(from: &[f32; W]) -> Self;
    fn store(self, to: &mut Tile<W>);
    fn weights(weights: &[f32; W]) -> Self::Weights;
    /// `before + (after - before) * weight`, row by row, transposed so that each of the four
    /// results holds one component of all lanes.
    fn lerp_rows(before: [&Row; W], after: [&Row; W], weights: Self::Weights) -> [Self; 4];
    /// The same from 16-bit integers, not scaled.
    fn lerp_short_rows(
        before: [&[i16; 4]; W],
        after: [&[i16; 4]; W],
        weights: Self::Weights,
    ) -> [Self; 4];
}

/// Some of the lanes: all, or one vector of several where a step needs more of these than the processor has
/// registers.
pub(crate) trait Piece<const W: usize>: Vector {
    /// Number of pieces of the lanes.
    const COUNT: usize;

    fn load_piece(from: &[f32; W], piece: usize) -> Self;
    fn store_piece(self, to: &mut Tile<W>, piece: usize);
}

impl<const W: usize, L: Rows<W>> Piece<W> for L {
    const COUNT: usize = 1;

    #[inline(always)]
    fn load_piece(from: &[f32; W], _: usize) -> Self {
        Self::load(from)
    }

    #[inline(always)]
    fn store_piece(self, to: &mut Tile<W>, _: usize) {
        self.store(to);
    }
}

/// Eight numbers that can be compared, and rows written for eight characters.
pub(crate) trait Lanes: Rows<LANES> {
    /// Truth of a comparison in each lane.
    type Mask: Copy;

    /// `R` times four components of the lanes from `8 * eight` on, transposed to `R` rows for each
    /// lane: those from `at` on of every `stride` rows. `out` has at least `7 * stride + at + R` rows.
    fn store_rows<const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [Row],
        stride: usize,
        at: usize,
    );
    /// The same as half floats, rounded to the nearest, ties to even.
    fn store_half_rows<const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [[u16; 4]],
        stride: usize,
        at: usize,
    );

    fn abs(self) -> Self;
    /// The lesser, and `other` where they are equal or either is NaN.
    fn min(self, other: Self) -> Self;
    /// The greater, and `other` where they are equal or either is NaN.
    fn max(self, other: Self) -> Self;
    /// Where this is less than `other`, and not NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// Where this is at most `other`, and not NaN.
    fn at_most(self, other: Self) -> Self::Mask;
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `yes` where the mask is true, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// A mask as bits, the first lane lowest.
    fn bits(mask: Self::Mask) -> u8;
    /// `before + (after - before) * weight` of eight half floats, rounded to the nearest, ties
    /// to even.
    #[inline(always)]
    fn lerp_halves(before: &Halves, after: &Halves, weight: f32, out: &mut Halves) {
        for (out, (a, b)) in out.iter_mut().zip(before.iter().zip(after)) {
            let (a, b) = (half::f32_from_half(*a), half::f32_from_half(*b));
            *out = half::half_from_f32(a + (b - a) * weight);
        }
    }
}

/// Asks for the cache line of an address that will be written soon, whatever lies there. Only the time
/// depends on it.
#[inline(always)]
pub(crate) fn prefetch_to_write(address: usize) {
    #[cfg(target_arch = "x86_64")]
    x86::prefetch_to_write(address);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}

/// Work that runs on lanes. `run` must be `#[inline(always)]`, else it is compiled without the
/// instructions of the backend.
pub(crate) trait Kernel {
    fn run<L: Lanes>(self);
}

/// Work that runs on sixteen lanes; see [`Kernel`].
pub(crate) trait WideKernel {
    fn run<R: Rows<WIDE>>(self);
}

/// Runs a kernel on a backend, or on plain arrays where this machine lacks it. WebAssembly with vectors has no plain
/// arrays, which would be 70 kB of a module.
pub(crate) fn dispatch<K: Kernel>(backend: Backend, kernel: K) {
    match backend {
        #[cfg(target_arch = "x86_64")]
        Backend::Avx2 | Backend::Avx512 if backend.is_available() => x86::run_avx2(kernel),
        #[cfg(target_arch = "x86_64")]
        Backend::Sse2 => x86::run_sse2(kernel),
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        _ => wasm::run(kernel),
        #[cfg(target_arch = "aarch64")]
        Backend::Neon => neon::run(kernel),
        #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
        _ => kernel.run::<scalar::Plain>(),
    }
}

/// Runs a wide kernel on a backend, or on plain arrays if it has no vectors of 512 bits or this
/// machine lacks them.
pub(crate) fn dispatch_wide<K: WideKernel>(backend: Backend, kernel: K) {
    match backend {
        #[cfg(target_arch = "x86_64")]
        Backend::Avx512 if backend.is_available() => avx512::run(kernel),
        _ => kernel.run::<scalar::PlainWide>(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Inputs for every lane, and what has been computed of them.
    struct Everything<'a, const W: usize> {
        floats: &'a [Row; 32],
        shorts: &'a [[i16; 4]; 32],
        weights: [f32; W],
        out: &'a mut Vec<u32>,
    }

    impl<const W: usize> Everything<'_, W> {
        /// Arithmetic and rows; returns what has been interpolated.
        #[inline(always)]
        fn rows<R: Rows<W>>(&mut self) -> [R; 4] {
            let w = R::weights(&self.weights);
            let a = R::lerp_rows(
                std::array::from_fn(|i| &self.floats[i]),
                std::array::from_fn(|i| &self.floats[i + W]),
                w,
            );
            let b = R::lerp_short_rows(
                std::array::from_fn(|i| &self.shorts[i]),
                std::array::from_fn(|i| &self.shorts[i + W]),
                w,
            );
            let [x, y, z, q] = a;
            let sums = [
                x.add(y).mul(b[0]),
                y.sub(z).div(b[1]),
                z.mul(z).add(R::splat(0.5)).sqrt(),
                q.sign(),
            ];
            let mut tiles = [[Tile::ZERO; 4]; 3];
            for (from, to) in [sums, a, b].into_iter().zip(&mut tiles) {
                for (from, to) in from.into_iter().zip(to) {
                    from.store(to);
                }
            }
            // One, two and three rows of each lane, between rows that stay as they are.
            let [sums, a, b] = tiles.each_ref().map(|tiles| tiles.each_ref());
            for eight in 0..W / LANES {
                let mut rows = vec![[0.0; 4]; LANES * 8];
                let mut halves = vec![[0; 4]; LANES * 8];
                R::Eight::store_rows([sums], eight, &mut rows, 8, 0);
                R::Eight::store_rows([a, b], eight, &mut rows, 8, 2);
                R::Eight::store_rows([b, sums, a], eight, &mut rows, 8, 5);
                R::Eight::store_half_rows([sums], eight, &mut halves, 8, 7);
                R::Eight::store_half_rows([a, b], eight, &mut halves, 8, 5);
                R::Eight::store_half_rows([b, sums, a], eight, &mut halves, 8, 1);
                self.out
                    .extend(rows.as_flattened().iter().map(|v| v.to_bits()));
                let halves = halves.as_flattened().iter();
                self.out.extend(halves.map(|h| u32::from(*h)));
            }
            a_of(&tiles[1])
        }
    }

    /// Numbers from memory.
    #[inline(always)]
    fn a_of<R: Rows<W>, const W: usize>(tiles: &[Tile<W>; 4]) -> [R; 4] {
        let [x, y, z, w] = tiles;
        [R::load(&x.0), R::load(&y.0), R::load(&z.0), R::load(&w.0)]
    }

    impl WideKernel for Everything<'_, WIDE> {
        #[inline(always)]
        fn run<R: Rows<WIDE>>(mut self) {
            self.rows::<R>();
        }
    }

    impl Kernel for Everything<'_, LANES> {
        #[inline(always)]
        fn run<L: Lanes>(mut self) {
            let [x, y, z, q] = self.rows::<L>();
            let mut blended = [0; LANES];
            let (before, after) = (
                self.floats[0].map(half::half_from_f32),
                self.floats[1].map(half::half_from_f32),
            );
            let halves_of = |row: [u16; 4]| std::array::from_fn(|i| row[i % 4]);
            L::lerp_halves(
                &halves_of(before),
                &halves_of(after),
                self.weights[0],
                &mut blended,
            );
            let mask = L::both(x.less(y), z.at_most(q));
            let picked = [x.min(y), z.max(q), y.sub(z).abs(), L::select(mask, x, z)];
            let mut more = [Tile::ZERO; 4];
            for (picked, more) in picked.into_iter().zip(&mut more) {
                picked.store(more);
            }
            self.out.push(u32::from(L::bits(mask)));
            let more = more.iter().flat_map(|m| &m.0);
            self.out.extend(more.map(|v| v.to_bits()));
            self.out.extend(blended.map(u32::from));
        }
    }

    proptest! {
        #[test]
        fn every_backend_gives_the_same_bits(
            floats in prop::array::uniform32(prop::array::uniform4(-9.0f32..9.0)),
            shorts in prop::array::uniform32(prop::array::uniform4(1i16..i16::MAX)),
            weights in prop::array::uniform16(0.0f32..1.0),
        ) {
            let (floats, shorts) = (&floats, &shorts);
            let eight = weights.as_chunks().0[0];
            let run = |backend| {
                let mut out = Vec::new();
                dispatch(backend, Everything { floats, shorts, weights: eight, out: &mut out });
                out
            };
            let wide = |backend| {
                let mut out = Vec::new();
                dispatch_wide(backend, Everything { floats, shorts, weights, out: &mut out });
                out
            };
            let plain = run(Backend::Scalar);
            let plain_wide = wide(Backend::Scalar);
            for backend in Backend::ALL.into_iter().filter(|b| b.is_available()) {
                prop_assert_eq!(&run(backend), &plain, "{}", backend);
                prop_assert_eq!(&wide(backend), &plain_wide, "{}", backend);
            }
            // And the plain ones by hand: lane 3 of eight and 13 of sixteen, third component.
            for (out, lane, after) in [(&plain, 3, 8), (&plain_wide, 13, 16)] {
                let (a, b) = (floats[lane][2], floats[lane + after][2]);
                let z = a + (b - a) * weights[lane];
                // Behind the rows and half floats of the first eight lanes.
                let row = &out[lane / LANES * LANES * 64 + lane % LANES * 32..];
                prop_assert_eq!(f32::from_bits(row[2]), (z * z + 0.5).sqrt());
                prop_assert_eq!(f32::from_bits(row[2 * 4 + 2]), z);
                prop_assert_eq!(&row[7 * 4..][..4], &row[2 * 4..][..4]);
                prop_assert_eq!(&row[6 * 4..][..4], &row[..4]);
                prop_assert_eq!(&row[4..][..4], &[0; 4]);
                let halves = &out[(lane / LANES * 2 + 1) * LANES * 32 + lane % LANES * 32..];
                for (half, of) in [(7, 0), (5, 2), (6, 3), (1, 3), (2, 0), (3, 2)] {
                    for c in 0..4 {
                        let number = f32::from_bits(row[of * 4 + c]);
                        prop_assert_eq!(halves[half * 4 + c], u32::from(half::half_from_f32(number)));
                    }
                }
                prop_assert_eq!(&halves[..4], &[0; 4]);
            }
        }
    }

    /// Comparisons of numbers that are none, or equal.
    struct Odd<'a>(&'a mut Vec<u32>);

    impl Kernel for Odd<'_> {
        #[inline(always)]
        fn run<L: Lanes>(self) {
            let nan = f32::NAN;
            let a = L::load(&[nan, 1.0, nan, 2.0, 0.0, -0.0, f32::INFINITY, 3.0]);
            let b = L::load(&[1.0, nan, nan, 2.0, -0.0, 0.0, f32::INFINITY, -3.0]);
            let mut tiles = [Tile::ZERO; 3];
            let picked = [a.min(b), a.max(b), L::select(a.less(b), a, b)];
            let mut any = Tile::ZERO;
            a.if_nonzero(b, L::splat(7.0)).store(&mut any);
            for (picked, tile) in picked.into_iter().zip(&mut tiles) {
                picked.store(tile);
            }
            self.0
                .extend(tiles.iter().flat_map(|t| t.0.map(f32::to_bits)));
            self.0
                .extend([a.less(b), a.at_most(b)].map(|m| u32::from(L::bits(m))));
            self.0.extend(any.0.map(f32::to_bits));
        }
    }

    #[test]
    fn what_is_no_number_is_neither_less_nor_equal() {
        for backend in Backend::ALL.into_iter().filter(|b| b.is_available()) {
            let mut out = Vec::new();
            dispatch(backend, Odd(&mut out));
            let second = [1.0, f32::NAN, f32::NAN, 2.0, -0.0, 0.0, f32::INFINITY];
            for (first, lesser) in [(0, -3.0), (8, 3.0), (16, -3.0)] {
                let found = &out[first..first + 8];
                let expected = second.iter().chain([&lesser]).map(|v| v.to_bits());
                assert!(found.iter().copied().eq(expected), "{backend}: {found:?}");
            }
            assert_eq!(out[24..26], [0, 0b0111_1000], "{backend}");
            // The two zeros are none, whatever their sign.
            let any = [1.0, f32::NAN, f32::NAN, 2.0, 7.0, 7.0, f32::INFINITY, -3.0];
            assert!(
                out[26..].iter().copied().eq(any.map(f32::to_bits)),
                "{backend}"
            );
        }
    }

    /// Eight half floats blended with themselves, and eight numbers as half floats.
    struct HalfFloats<'a>(Halves, [f32; LANES], &'a mut Vec<u16>);

    impl Kernel for HalfFloats<'_> {
        #[inline(always)]
        fn run<L: Lanes>(self) {
            let mut blended = [0; LANES];
            L::lerp_halves(&self.0, &self.0, 0.25, &mut blended);
            let mut rows = [[0; 4]; LANES];
            let tiles = [Tile(self.1); 4];
            L::store_half_rows([tiles.each_ref()], 0, &mut rows, 1, 0);
            self.2.extend(blended.iter().chain(rows.as_flattened()));
        }
    }

    #[test]
    fn every_half_and_what_lies_between_is_the_same_on_every_backend() {
        let available = || Backend::ALL.into_iter().filter(|b| b.is_available());
        let tie = |h: u16| {
            let [here, next] = [h, h.wrapping_add(1)].map(half::f32_from_half);
            // The least number that becomes infinite.
            let largest = 65520f32.copysign(here);
            if next.is_infinite() {
                largest
            } else {
                here.midpoint(next)
            }
        };
        let halves: Vec<u16> = (0..=u16::MAX).collect();
        for eight in halves.as_chunks::<LANES>().0 {
            for by in [-1, 0, 1] {
                let near = |h: u16| f32::from_bits(tie(h).to_bits().wrapping_add_signed(by));
                let numbers = eight.map(near);
                let run = |backend| {
                    let mut out = Vec::new();
                    dispatch(backend, HalfFloats(*eight, numbers, &mut out));
                    out
                };
                let plain = run(Backend::Scalar);
                for backend in available() {
                    assert_eq!(run(backend), plain, "{backend}: {eight:x?} {numbers:?}");
                }
            }
        }
    }

    #[test]
    fn names_lead_back() {
        for backend in Backend::ALL {
            assert_eq!(backend.to_string().parse(), Ok(backend));
        }
        assert!(Backend::best().is_available());
    }
}
