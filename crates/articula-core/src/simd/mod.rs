//! Eight SIMD lanes: the only module that names instruction sets, and the only `unsafe` code.
//!
//! A kernel is written once over [`Lanes`] and run by [`dispatch`] on the chosen [`Backend`]. No
//! backend fuses multiply and add or estimates a root, so all of them give the same bits; the plain
//! arrays of [`scalar`] are the oracle. Source: `docs/methods/runtime.md` part 3. Transposes are
//! written as intrinsics, since compilers turn plain loops into single inserts (measured: 417
//! against 222 ns for a figure of 67 joints).

mod eight;
pub(crate) mod half;
#[cfg(target_arch = "aarch64")]
mod neon;
pub(crate) mod scalar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use eight::Eight;

use crate::Mismatch;
use std::fmt;
use std::str::FromStr;

/// Number of characters in a batch.
pub const LANES: usize = 8;

/// One row of a matrix or one quaternion.
pub(crate) type Row = [f32; 4];

/// Eight half floats, as bits.
pub(crate) type Halves = [u16; LANES];

/// Eight lanes in memory, aligned for the widest load.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub struct Tile(pub [f32; LANES]);

impl Tile {
    /// Zero in every lane.
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
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
    /// 128-bit vectors of WebAssembly; chosen when the module is compiled for them.
    Simd128,
    /// 128-bit vectors of every AArch64 processor, with half floats.
    Neon,
}

impl Backend {
    /// All backends, the slowest first.
    pub const ALL: [Self; 5] = [
        Self::Scalar,
        Self::Sse2,
        Self::Avx2,
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
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => false,
            Self::Simd128 => cfg!(all(target_arch = "wasm32", target_feature = "simd128")),
            Self::Neon => cfg!(target_arch = "aarch64"),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
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

/// Eight numbers, one for each character of a batch.
pub(crate) trait Lanes: Copy {
    /// A weight for each lane, laid out for [`Lanes::lerp_rows`].
    type Weights: Copy;
    /// Truth of a comparison in each lane.
    type Mask: Copy;

    fn splat(value: f32) -> Self;
    fn load(from: &Tile) -> Self;
    fn store(self, to: &mut Tile);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    /// One with the sign of each lane.
    fn sign(self) -> Self;
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
    fn weights(weights: &[f32; LANES]) -> Self::Weights;
    /// `before + (after - before) * weight`, row by row, transposed so that each of the four
    /// results holds one component of all lanes.
    fn lerp_rows(before: [&Row; LANES], after: [&Row; LANES], weights: Self::Weights) -> [Self; 4];
    /// The same from 16-bit integers, not scaled.
    fn lerp_short_rows(
        before: [&[i16; 4]; LANES],
        after: [&[i16; 4]; LANES],
        weights: Self::Weights,
    ) -> [Self; 4];
    /// Four components of all lanes, transposed back to one row for each lane: row `at` of every
    /// `stride` rows. `out` has at least `7 * stride + at + 1` rows.
    fn store_rows(components: [Self; 4], out: &mut [Row], stride: usize, at: usize);
    /// The same as half floats, rounded to the nearest, ties to even.
    fn store_half_rows(components: [Self; 4], out: &mut [[u16; 4]], stride: usize, at: usize);
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

/// Work that runs on lanes. `run` must be `#[inline(always)]`, else it is compiled without the
/// instructions of the backend.
pub(crate) trait Kernel {
    fn run<L: Lanes>(self);
}

/// Runs a kernel on a backend, or on plain arrays where this machine lacks it.
pub(crate) fn dispatch<K: Kernel>(backend: Backend, kernel: K) {
    match backend {
        #[cfg(target_arch = "x86_64")]
        Backend::Avx2 if backend.is_available() => x86::run_avx2(kernel),
        #[cfg(target_arch = "x86_64")]
        Backend::Sse2 => x86::run_sse2(kernel),
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        Backend::Simd128 => wasm::run(kernel),
        #[cfg(target_arch = "aarch64")]
        Backend::Neon => neon::run(kernel),
        _ => kernel.run::<scalar::Plain>(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every operation once, on one set of inputs.
    struct Everything<'a> {
        floats: &'a [Row; 16],
        shorts: &'a [[i16; 4]; 16],
        weights: [f32; LANES],
        out: &'a mut Vec<u32>,
    }

    impl Kernel for Everything<'_> {
        #[inline(always)]
        fn run<L: Lanes>(self) {
            let w = L::weights(&self.weights);
            let a = L::lerp_rows(
                std::array::from_fn(|i| &self.floats[i]),
                std::array::from_fn(|i| &self.floats[i + 8]),
                w,
            );
            let b = L::lerp_short_rows(
                std::array::from_fn(|i| &self.shorts[i]),
                std::array::from_fn(|i| &self.shorts[i + 8]),
                w,
            );
            let [x, y, z, q] = a;
            let sums = [
                x.add(y).mul(b[0]),
                y.sub(z).div(b[1]),
                z.mul(z).add(L::splat(0.5)).sqrt(),
                q.sign(),
            ];
            let mut rows = vec![[0.0; 4]; LANES * 2];
            let mut halves = vec![[0; 4]; LANES * 2];
            L::store_rows(sums, &mut rows, 2, 1);
            L::store_half_rows(sums, &mut halves, 2, 0);
            L::store_rows(b, &mut rows, 2, 0);
            let mut tile = Tile::ZERO;
            L::load(&Tile(self.weights)).store(&mut tile);
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
            let numbers = rows.iter().flatten().chain(&tile.0);
            self.out.extend(numbers.map(|v| v.to_bits()));
            self.out.push(u32::from(L::bits(mask)));
            let more = more.iter().flat_map(|m| &m.0);
            self.out.extend(more.map(|v| v.to_bits()));
            self.out
                .extend(halves.iter().flatten().map(|h| u32::from(*h)));
            self.out.extend(blended.map(u32::from));
        }
    }

    proptest! {
        #[test]
        fn every_backend_gives_the_same_bits(
            floats in prop::array::uniform16(prop::array::uniform4(-9.0f32..9.0)),
            shorts in prop::array::uniform16(prop::array::uniform4(1i16..i16::MAX)),
            weights in prop::array::uniform8(0.0f32..1.0),
        ) {
            let run = |backend| {
                let mut out = Vec::new();
                dispatch(backend, Everything { floats: &floats, shorts: &shorts, weights, out: &mut out });
                out
            };
            let plain = run(Backend::Scalar);
            for backend in Backend::ALL.into_iter().filter(|b| b.is_available()) {
                prop_assert_eq!(&run(backend), &plain, "{}", backend);
            }
            // And the plain one by hand: lane 3, third component.
            let (a, b) = (floats[3][2], floats[11][2]);
            let z = a + (b - a) * weights[3];
            let row = &plain[(3 * 2 + 1) * 4..];
            prop_assert_eq!(f32::from_bits(row[2]), (z * z + 0.5).sqrt());
        }
    }

    /// Comparisons of numbers that are none, or equal.
    struct Odd<'a>(&'a mut Vec<u32>);

    impl Kernel for Odd<'_> {
        #[inline(always)]
        fn run<L: Lanes>(self) {
            let nan = f32::NAN;
            let a = L::load(&Tile([nan, 1.0, nan, 2.0, 0.0, -0.0, f32::INFINITY, 3.0]));
            let b = L::load(&Tile([1.0, nan, nan, 2.0, -0.0, 0.0, f32::INFINITY, -3.0]));
            let mut tiles = [Tile::ZERO; 3];
            let picked = [a.min(b), a.max(b), L::select(a.less(b), a, b)];
            for (picked, tile) in picked.into_iter().zip(&mut tiles) {
                picked.store(tile);
            }
            self.0
                .extend(tiles.iter().flat_map(|t| t.0.map(f32::to_bits)));
            self.0
                .extend([a.less(b), a.at_most(b)].map(|m| u32::from(L::bits(m))));
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
            assert_eq!(out[24..], [0, 0b0111_1000], "{backend}");
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
            L::store_half_rows([L::load(&Tile(self.1)); 4], &mut rows, 1, 0);
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
