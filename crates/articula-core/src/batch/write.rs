//! Palettes of a batch: matrices, or rotations and translations, of one character after the other.

use super::joint::Joint;
use super::lane_math::{bound, eight_of, moved, product, splat3, splat4, store4};
use crate::palette::{Bind, Entry, PaletteForm};
use crate::simd::{LANES, Lanes, Piece, Row, Rows, Tile, prefetch_to_write};
use std::ops::Range;

/// Output of the kernel.
pub(super) enum Out<'a> {
    Tile,
    Float(&'a mut [Row]),
    Half(&'a mut [[u16; 4]]),
}

/// Number type of a palette.
pub(super) trait Number: Sized {
    fn store<L: Lanes, const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [[Self; 4]],
        stride: usize,
        at: usize,
    );
}

impl Number for f32 {
    #[inline(always)]
    fn store<L: Lanes, const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [Row],
        stride: usize,
        at: usize,
    ) {
        L::store_rows(rows, eight, out, stride, at);
    }
}

impl Number for u16 {
    #[inline(always)]
    fn store<L: Lanes, const W: usize, const R: usize>(
        rows: [[&Tile<W>; 4]; R],
        eight: usize,
        out: &mut [[u16; 4]],
        stride: usize,
        at: usize,
    ) {
        L::store_half_rows(rows, eight, out, stride, at);
    }
}

/// Lanes of eight that are bound at once.
type PieceOf<L> = <L as Rows<LANES>>::Piece;

/// Entries of a palette that are written together.
pub(super) struct Part<'a, const W: usize> {
    pub(super) joints: &'a [Joint<W>],
    pub(super) entries: &'a [Entry],
    pub(super) range: Range<usize>,
}

// Eight characters at a time whatever the backend has: a palette has the rows of a character together,
// and vectors of 512 bits are slow to take apart.
impl<const W: usize> Part<'_, W> {
    /// Writes matrices.
    #[inline(always)]
    pub(super) fn matrices<L: Lanes, N: Number>(&self, out: &mut [[N; 4]]) {
        let stride = self.entries.len() * 3;
        for eight in 0..W / LANES {
            let out = &mut out[eight * LANES * stride..][..LANES * stride];
            let range = self.range.clone();
            for (at, entry) in range.clone().zip(&self.entries[range]) {
                let [x, y, z] = &self.joints[usize::from(entry.place)].matrix;
                let at = at * 3;
                let Some(Bind { rows: b, .. }) = &entry.bind else {
                    let rows = [together(x), together(y), together(z)];
                    N::store::<L, W, _>(rows, eight, out, stride, at);
                    continue;
                };
                let mut bones = [[Tile::ZERO; 4]; 3];
                for piece in 0..<PieceOf<L>>::COUNT {
                    bind_rows::<PieceOf<L>, W>([x, y, z], (eight, piece), b, &mut bones);
                }
                let [x, y, z] = &bones;
                let rows = [together(x), together(y), together(z)];
                N::store::<L, LANES, _>(rows, 0, out, stride, at);
            }
        }
    }

    /// Writes rotations and translations of joints without scale.
    #[inline(always)]
    pub(super) fn rigid<L: Lanes, N: Number>(&self, out: &mut [[N; 4]]) {
        let stride = self.entries.len() * 2;
        let one = Tile([1.0; W]);
        for eight in 0..W / LANES {
            let out = &mut out[eight * LANES * stride..][..LANES * stride];
            let range = self.range.clone();
            for (at, entry) in range.clone().zip(&self.entries[range]) {
                let joint = &self.joints[usize::from(entry.place)];
                let [x, y, z] = &joint.matrix;
                let at = at * 2;
                let Some(bind) = &entry.bind else {
                    let rows = [together(&joint.rotation), [&x[3], &y[3], &z[3], &one]];
                    N::store::<L, W, _>(rows, eight, out, stride, at);
                    continue;
                };
                let rotation = eight_of::<L, W>(&joint.rotation, eight, 0);
                let rows = [
                    eight_of(x, eight, 0),
                    eight_of(y, eight, 0),
                    eight_of(z, eight, 0),
                ];
                let [x, y, z] = moved(&rows, splat3(bind.translation));
                let mut bone = [[Tile::ZERO; 4]; 2];
                store4(
                    product(rotation, splat4(bind.rotation.to_array())),
                    &mut bone[0],
                    0,
                );
                store4([x, y, z, L::splat(1.0)], &mut bone[1], 0);
                let [rotation, translation] = &bone;
                let rows = [together(rotation), together(translation)];
                N::store::<L, LANES, _>(rows, 0, out, stride, at);
            }
        }
    }
}

/// Rows of matrices times a bind matrix, of a piece of eight lanes.
#[inline(always)]
fn bind_rows<P: Piece<LANES>, const W: usize>(
    [x, y, z]: [&[Tile<W>; 4]; 3],
    (eight, piece): (usize, usize),
    bind: &[Row; 3],
    out: &mut [[Tile; 4]; 3],
) {
    store4(
        bound::<P>(eight_of(x, eight, piece), bind),
        &mut out[0],
        piece,
    );
    store4(
        bound::<P>(eight_of(y, eight, piece), bind),
        &mut out[1],
        piece,
    );
    store4(
        bound::<P>(eight_of(z, eight, piece), bind),
        &mut out[2],
        piece,
    );
}

#[inline(always)]
fn together<const W: usize>([a, b, c, d]: &[Tile<W>; 4]) -> [&Tile<W>; 4] {
    [a, b, c, d]
}

/// Bytes that processors read and write at once.
const CACHE_LINE: usize = 64;

/// Where palettes lie, to prefetch the cache lines that are written after a block: stores that miss
/// the cache would stop the block after it.
pub(super) struct Lines {
    /// Address of the first palette.
    start: usize,
    entry_bytes: usize,
    palette_bytes: usize,
    /// Cache lines that a block writes of one palette.
    of_block: usize,
}

impl Lines {
    pub(super) fn of(out: &Out<'_>, form: PaletteForm, entries: usize, block: usize) -> Self {
        let (start, row_bytes) = match out {
            Out::Tile => (0, 0),
            Out::Float(rows) => (rows.as_ptr().addr(), size_of::<Row>()),
            Out::Half(rows) => (rows.as_ptr().addr(), size_of::<[u16; 4]>()),
        };
        let entry_bytes = row_bytes * form.rows();
        // One more, as the first byte may be the last of its line.
        let lines = block * entry_bytes / CACHE_LINE + 1;
        Self {
            start,
            entry_bytes,
            palette_bytes: entry_bytes * entries,
            of_block: if row_bytes == 0 { 0 } else { lines },
        }
    }

    /// Prefetches a block of entries from `entry` on.
    #[inline(always)]
    pub(super) fn prefetch(&self, lanes: Range<usize>, entry: usize) {
        for lane in lanes {
            let first = lane * self.palette_bytes + entry * self.entry_bytes;
            for line in 0..self.of_block {
                prefetch_to_write(self.start + first + line * CACHE_LINE);
            }
        }
    }
}
