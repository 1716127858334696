//! The kernel of the floor with AVX2 intrinsics, with fused multiplications and additions or without;
//! the same steps as [`super::arrays`].

use super::{Batch, Channel, Columns, LANES, Lanes, Link, Out, Rows, Tile};
use std::arch::x86_64::*;
use std::array::from_fn;

/// One number for each of eight characters.
type Wide = __m256;

/// Rotation and translation of a joint, for each of eight characters.
type Place = ([Wide; 4], [Wide; 3]);

/// Samples a batch, applies the hierarchy and writes the matrices.
pub(super) fn evaluate<const FUSED: bool>(
    clip: &Rows,
    at: &Batch,
    chain: &mut [Link],
    out: Out<'_>,
) {
    match out {
        // SAFETY: a floor with this kernel is only made on machines with AVX2 and FMA.
        Out::Stored(out) => unsafe { run::<true, FUSED>(clip, at, chain, &mut [], out) },
        // SAFETY: as above.
        Out::Tile(tile) => unsafe {
            run::<false, FUSED>(clip, at, chain, tile, Default::default())
        },
    }
}

/// Writes into `out` if `STORED`, else into `tile`; the unused one is empty. A closure instead
/// would not be inlined into the loop.
#[target_feature(enable = "avx2,fma")]
fn run<const STORED: bool, const FUSED: bool>(
    clip: &Rows,
    at: &Batch,
    chain: &mut [Link],
    tile: &mut [Tile],
    mut out: [&mut [[f32; 12]]; LANES],
) {
    let joints = clip.joints.len();
    let chain = &mut chain[..joints];
    let tile = &mut tile[..if STORED { 0 } else { joints }];
    for out in &mut out {
        let whole = std::mem::take(out);
        *out = &mut whole[..if STORED { joints } else { 0 }];
    }
    let blend: [Wide; 4] = from_fn(|i| {
        let (low, high) = (_mm_set1_ps(at.blend[i]), _mm_set1_ps(at.blend[i + 4]));
        _mm256_set_m128(high, low)
    });
    let rotations = Span::new(&clip.rotations, at);
    let translations = Span::new(&clip.translations, at);
    for (index, joint) in clip.joints.iter().enumerate() {
        let rotation = match joint.rotation {
            Channel::Still(still) => still.map(|c| _mm256_set1_ps(c)),
            Channel::Moving(column) => {
                normalised::<FUSED>(blended::<FUSED>(&rotations, column, &blend))
            }
        };
        let [x, y, z, _] = match joint.translation {
            Channel::Still(still) => still.map(|c| _mm256_set1_ps(c)),
            Channel::Moving(column) => blended::<FUSED>(&translations, column, &blend),
        };
        let mut place = (rotation, [x, y, z]);
        if joint.parent < joints {
            place = below::<FUSED>(load_link(&chain[joint.parent]), place);
        }
        store_link(&mut chain[index], &place);
        let matrix = matrix(&place);
        if STORED {
            for row in 0..3 {
                let rows = transposed(from_fn(|c| matrix[4 * row + c]));
                for (i, wide) in rows.into_iter().enumerate() {
                    let low = _mm256_castps256_ps128(wide);
                    let high = _mm256_extractf128_ps::<1>(wide);
                    // SAFETY: all eight slices were cut to the number of joints above.
                    let place = unsafe { out[i].get_unchecked_mut(index) };
                    store_quarter(place, row, low);
                    // SAFETY: as above.
                    let place = unsafe { out[i + 4].get_unchecked_mut(index) };
                    store_quarter(place, row, high);
                }
            }
        } else {
            for (place, wide) in tile[index].0.iter_mut().zip(matrix) {
                store(place, wide);
            }
        }
    }
}

/// Rows of each character's frame and the next one, all of the same length.
struct Span<'a> {
    width: usize,
    before: [&'a [[f32; 4]]; LANES],
    after: [&'a [[f32; 4]]; LANES],
}

impl<'a> Span<'a> {
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn new(Columns { width, rows }: &'a Columns, at: &Batch) -> Self {
        let mut span = Self {
            width: *width,
            before: [&[]; LANES],
            after: [&[]; LANES],
        };
        for (lane, frame) in at.frame.into_iter().enumerate() {
            span.before[lane] = &rows[frame * width..][..*width];
            span.after[lane] = &rows[(frame + 1) * width..][..*width];
        }
        span
    }
}

/// One column at the time of each character. Two characters share a register, so that a
/// transposition within its halves is sufficient.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn blended<const FUSED: bool>(span: &Span<'_>, column: usize, blend: &[Wide; 4]) -> [Wide; 4] {
    assert!(column < span.width, "a column of the clip");
    let pair = |rows: &[&[[f32; 4]]; LANES], i: usize| {
        // SAFETY: the column was just checked, and every row of a span has `width` of them.
        let at = |i: usize| unsafe { rows[i].get_unchecked(column) };
        _mm256_set_m128(load_quarter(at(i + 4)), load_quarter(at(i)))
    };
    transposed(from_fn(|i| {
        let (before, after) = (pair(&span.before, i), pair(&span.after, i));
        fma::<FUSED>(_mm256_sub_ps(after, before), blend[i], before)
    }))
}

/// Transposes the 4x4 numbers in each half.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn transposed(v: [Wide; 4]) -> [Wide; 4] {
    let (a, b) = (
        _mm256_unpacklo_ps(v[0], v[1]),
        _mm256_unpackhi_ps(v[0], v[1]),
    );
    let (c, d) = (
        _mm256_unpacklo_ps(v[2], v[3]),
        _mm256_unpackhi_ps(v[2], v[3]),
    );
    [
        _mm256_shuffle_ps::<0x44>(a, c),
        _mm256_shuffle_ps::<0xee>(a, c),
        _mm256_shuffle_ps::<0x44>(b, d),
        _mm256_shuffle_ps::<0xee>(b, d),
    ]
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn normalised<const FUSED: bool>([x, y, z, w]: [Wide; 4]) -> [Wide; 4] {
    let squared = fma::<FUSED>(x, x, fma::<FUSED>(y, y, fma::<FUSED>(z, z, mul(w, w))));
    let inverse = _mm256_div_ps(_mm256_set1_ps(1.0), _mm256_sqrt_ps(squared));
    [
        mul(x, inverse),
        mul(y, inverse),
        mul(z, inverse),
        mul(w, inverse),
    ]
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn below<const FUSED: bool>(parent: Place, local: Place) -> Place {
    let ([px, py, pz, pw], [ax, ay, az]) = parent;
    let ([x, y, z, w], [tx, ty, tz]) = local;
    let rotation = [
        fma::<FUSED>(
            pw,
            x,
            fma::<FUSED>(px, w, minus::<FUSED>(pz, y, mul(py, z))),
        ),
        fma::<FUSED>(
            pw,
            y,
            fma::<FUSED>(py, w, minus::<FUSED>(px, z, mul(pz, x))),
        ),
        fma::<FUSED>(
            pw,
            z,
            fma::<FUSED>(pz, w, minus::<FUSED>(py, x, mul(px, y))),
        ),
        minus::<FUSED>(
            px,
            x,
            minus::<FUSED>(py, y, minus::<FUSED>(pz, z, mul(pw, w))),
        ),
    ];
    let cx = twice(minus::<FUSED>(pz, ty, mul(py, tz)));
    let cy = twice(minus::<FUSED>(px, tz, mul(pz, tx)));
    let cz = twice(minus::<FUSED>(py, tx, mul(px, ty)));
    let translation = [
        fma::<FUSED>(
            pw,
            cx,
            minus::<FUSED>(pz, cy, fma::<FUSED>(py, cz, _mm256_add_ps(tx, ax))),
        ),
        fma::<FUSED>(
            pw,
            cy,
            minus::<FUSED>(px, cz, fma::<FUSED>(pz, cx, _mm256_add_ps(ty, ay))),
        ),
        fma::<FUSED>(
            pw,
            cz,
            minus::<FUSED>(py, cx, fma::<FUSED>(px, cy, _mm256_add_ps(tz, az))),
        ),
    ];
    (rotation, translation)
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn matrix((rotation, [tx, ty, tz]): &Place) -> [Wide; 12] {
    let [x, y, z, w] = *rotation;
    let (x2, y2, z2) = (twice(x), twice(y), twice(z));
    let (xx, yy, zz) = (mul(x, x2), mul(y, y2), mul(z, z2));
    let (xy, xz, yz) = (mul(x, y2), mul(x, z2), mul(y, z2));
    let (wx, wy, wz) = (mul(w, x2), mul(w, y2), mul(w, z2));
    let (add, sub) = (|a, b| _mm256_add_ps(a, b), |a, b| _mm256_sub_ps(a, b));
    let one = _mm256_set1_ps(1.0);
    [
        sub(sub(one, yy), zz),
        sub(xy, wz),
        add(xz, wy),
        *tx,
        add(xy, wz),
        sub(sub(one, xx), zz),
        sub(yz, wx),
        *ty,
        sub(xz, wy),
        add(yz, wx),
        sub(sub(one, xx), yy),
        *tz,
    ]
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn mul(a: Wide, b: Wide) -> Wide {
    _mm256_mul_ps(a, b)
}

/// `a b + c`.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn fma<const FUSED: bool>(a: Wide, b: Wide, c: Wide) -> Wide {
    match FUSED {
        true => _mm256_fmadd_ps(a, b, c),
        false => _mm256_add_ps(_mm256_mul_ps(a, b), c),
    }
}

/// `c - a b`.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn minus<const FUSED: bool>(a: Wide, b: Wide, c: Wide) -> Wide {
    match FUSED {
        true => _mm256_fnmadd_ps(a, b, c),
        false => _mm256_sub_ps(c, _mm256_mul_ps(a, b)),
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn twice(a: Wide) -> Wide {
    _mm256_add_ps(a, a)
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_link(link: &Link) -> Place {
    (
        link.rotation.each_ref().map(|l| load(l)),
        link.translation.each_ref().map(|l| load(l)),
    )
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn store_link(link: &mut Link, (rotation, translation): &Place) {
    for (place, wide) in link.rotation.iter_mut().zip(rotation) {
        store(place, *wide);
    }
    for (place, wide) in link.translation.iter_mut().zip(translation) {
        store(place, *wide);
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load(from: &Lanes) -> Wide {
    // SAFETY: the reference covers eight floats, and the load requires no alignment.
    unsafe { _mm256_loadu_ps(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn store(to: &mut Lanes, wide: Wide) {
    // SAFETY: the reference covers eight floats, and the store requires no alignment.
    unsafe { _mm256_storeu_ps(to.as_mut_ptr(), wide) }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_quarter(from: &[f32; 4]) -> __m128 {
    // SAFETY: the reference covers four floats, and the load requires no alignment.
    unsafe { _mm_loadu_ps(from.as_ptr()) }
}

/// Writes row 0, 1 or 2 of a matrix.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn store_quarter(to: &mut [f32; 12], row: usize, quarter: __m128) {
    let place = &mut to.as_chunks_mut::<4>().0[row];
    // SAFETY: a quarter has four floats within the array, and the store requires no alignment.
    unsafe { _mm_storeu_ps(place.as_mut_ptr(), quarter) }
}
