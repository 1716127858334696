//! Vector arithmetic of a batch of characters at once: quaternions, points and matrix rows in lanes.

use crate::simd::{LANES, Piece, Row, Tile, Vector};
use glam::Vec3;

// No closures and no iterators over lanes below: they would be compiled without the backend's
// instructions, and then not be inlined into the kernel (measured: eighteen times slower).

#[inline(always)]
pub(super) fn splat4<L: Vector>(v: [f32; 4]) -> [L; 4] {
    [
        L::splat(v[0]),
        L::splat(v[1]),
        L::splat(v[2]),
        L::splat(v[3]),
    ]
}

#[inline(always)]
pub(super) fn splat3<L: Vector>(v: Vec3) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

#[inline(always)]
pub(super) fn load4<P: Piece<W>, const W: usize>(tiles: &[Tile<W>; 4], piece: usize) -> [P; 4] {
    let [a, b, c, d] = tiles;
    [
        P::load_piece(&a.0, piece),
        P::load_piece(&b.0, piece),
        P::load_piece(&c.0, piece),
        P::load_piece(&d.0, piece),
    ]
}

/// A piece of the lanes from `8 * eight` on.
#[inline(always)]
pub(super) fn eight_of<P: Piece<LANES>, const W: usize>(
    tiles: &[Tile<W>; 4],
    eight: usize,
    piece: usize,
) -> [P; 4] {
    let [a, b, c, d] = tiles;
    [
        P::load_piece(a.eight(eight), piece),
        P::load_piece(b.eight(eight), piece),
        P::load_piece(c.eight(eight), piece),
        P::load_piece(d.eight(eight), piece),
    ]
}

#[inline(always)]
pub(super) fn store4<P: Piece<W>, const W: usize>(
    lanes: [P; 4],
    tiles: &mut [Tile<W>; 4],
    piece: usize,
) {
    for i in 0..4 {
        lanes[i].store_piece(&mut tiles[i], piece);
    }
}

#[inline(always)]
fn dot4<L: Vector>(a: [L; 4], b: [L; 4]) -> L {
    let low = a[0].mul(b[0]).add(a[1].mul(b[1]));
    low.add(a[2].mul(b[2])).add(a[3].mul(b[3]))
}

#[inline(always)]
pub(super) fn normalised<L: Vector>(q: [L; 4]) -> [L; 4] {
    let scale = L::splat(1.0).div(dot4(q, q).sqrt());
    [
        q[0].mul(scale),
        q[1].mul(scale),
        q[2].mul(scale),
        q[3].mul(scale),
    ]
}

/// Normalised linear blend along the shorter arc. Where the weight is 0 it is exactly `a`, so that a
/// pose does not depend on whether others of its batch are blended.
#[inline(always)]
pub(super) fn faded<L: Vector>(a: [L; 4], b: [L; 4], weight: L) -> [L; 4] {
    let towards = weight.mul(dot4(a, b).sign());
    let rest = L::splat(1.0).sub(weight);
    let [x, y, z, w] = normalised([
        a[0].mul(rest).add(b[0].mul(towards)),
        a[1].mul(rest).add(b[1].mul(towards)),
        a[2].mul(rest).add(b[2].mul(towards)),
        a[3].mul(rest).add(b[3].mul(towards)),
    ]);
    [
        weight.if_nonzero(x, a[0]),
        weight.if_nonzero(y, a[1]),
        weight.if_nonzero(z, a[2]),
        weight.if_nonzero(w, a[3]),
    ]
}

/// Linear blend, exactly `a` where the weight is 0.
#[inline(always)]
pub(super) fn lerp3<L: Vector>(a: [L; 3], b: [L; 3], weight: L) -> [L; 3] {
    [
        weight.if_nonzero(a[0].add(b[0].sub(a[0]).mul(weight)), a[0]),
        weight.if_nonzero(a[1].add(b[1].sub(a[1]).mul(weight)), a[1]),
        weight.if_nonzero(a[2].add(b[2].sub(a[2]).mul(weight)), a[2]),
    ]
}

/// Hamilton product.
#[inline(always)]
pub(super) fn product<L: Vector>(a: [L; 4], b: [L; 4]) -> [L; 4] {
    let [ax, ay, az, aw] = a;
    let [bx, by, bz, bw] = b;
    [
        aw.mul(bx).add(ax.mul(bw)).add(ay.mul(bz)).sub(az.mul(by)),
        aw.mul(by).sub(ax.mul(bz)).add(ay.mul(bw)).add(az.mul(bx)),
        aw.mul(bz).add(ax.mul(by)).sub(ay.mul(bx)).add(az.mul(bw)),
        aw.mul(bw).sub(ax.mul(bx)).sub(ay.mul(by)).sub(az.mul(bz)),
    ]
}

/// Rows of the rotation matrix of a unit quaternion.
#[inline(always)]
pub(super) fn matrix_of<L: Vector>(q: [L; 4]) -> [[L; 3]; 3] {
    let [x, y, z, w] = q;
    let one = L::splat(1.0);
    let (x2, y2, z2) = (x.add(x), y.add(y), z.add(z));
    let (xx, yy, zz) = (x.mul(x2), y.mul(y2), z.mul(z2));
    let (xy, xz, yz) = (x.mul(y2), x.mul(z2), y.mul(z2));
    let (wx, wy, wz) = (w.mul(x2), w.mul(y2), w.mul(z2));
    [
        [one.sub(yy.add(zz)), xy.sub(wz), xz.add(wy)],
        [xy.add(wz), one.sub(xx.add(zz)), yz.sub(wx)],
        [xz.sub(wy), yz.add(wx), one.sub(xx.add(yy))],
    ]
}

#[inline(always)]
fn along<L: Vector>(row: [L; 4], v: [L; 3]) -> L {
    let xy = row[0].mul(v[0]).add(row[1].mul(v[1]));
    xy.add(row[2].mul(v[2]))
}

/// Transforms a point by a parent's rows.
#[inline(always)]
pub(super) fn moved<L: Vector>(rows: &[[L; 4]; 3], point: [L; 3]) -> [L; 3] {
    [
        along(rows[0], point).add(rows[0][3]),
        along(rows[1], point).add(rows[1][3]),
        along(rows[2], point).add(rows[2][3]),
    ]
}

/// Transforms a direction by a parent's rows.
#[inline(always)]
pub(super) fn turned<L: Vector>(rows: &[[L; 4]; 3], v: [L; 3]) -> [L; 3] {
    [along(rows[0], v), along(rows[1], v), along(rows[2], v)]
}

/// A parent's rows times a constant matrix.
#[inline(always)]
pub(super) fn times<L: Vector>(rows: &[[L; 4]; 3], local: &[Row; 3]) -> [[L; 4]; 3] {
    [
        bound(rows[0], local),
        bound(rows[1], local),
        bound(rows[2], local),
    ]
}

/// One row of a matrix times a bind matrix.
#[inline(always)]
pub(super) fn bound<L: Vector>(row: [L; 4], bind: &[Row; 3]) -> [L; 4] {
    let (x, y, z) = (
        splat4::<L>(bind[0]),
        splat4::<L>(bind[1]),
        splat4::<L>(bind[2]),
    );
    [
        along(row, [x[0], y[0], z[0]]),
        along(row, [x[1], y[1], z[1]]),
        along(row, [x[2], y[2], z[2]]),
        along(row, [x[3], y[3], z[3]]).add(row[3]),
    ]
}
