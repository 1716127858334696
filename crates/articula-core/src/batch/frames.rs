//! Frames of clips, read and blended for every character of a batch.

use super::lane_math::{lerp3, splat3};
use crate::clip_set::{ClipCursor, ClipSet};
use crate::simd::{Parts, Row, Rows};

/// Rows of one storage, read for every lane.
pub(super) trait Frames: Copy {
    type Number: 'static;
    fn all(&self) -> &[[Self::Number; 4]];
    fn lerp<L: Rows<W>, const W: usize>(
        before: [&[Self::Number; 4]; W],
        after: [&[Self::Number; 4]; W],
        weights: L::Weights,
    ) -> [L; 4];
}

#[derive(Clone, Copy)]
pub(super) struct FloatFrames<'a>(pub(super) &'a [Row]);

impl Frames for FloatFrames<'_> {
    type Number = f32;

    #[inline(always)]
    fn all(&self) -> &[Row] {
        self.0
    }

    #[inline(always)]
    fn lerp<L: Rows<W>, const W: usize>(
        before: [&Row; W],
        after: [&Row; W],
        weights: L::Weights,
    ) -> [L; 4] {
        L::lerp_rows(before, after, weights)
    }
}

#[derive(Clone, Copy)]
pub(super) struct ShortFrames<'a>(pub(super) &'a [[i16; 4]]);

impl Frames for ShortFrames<'_> {
    type Number = i16;

    #[inline(always)]
    fn all(&self) -> &[[i16; 4]] {
        self.0
    }

    #[inline(always)]
    fn lerp<L: Rows<W>, const W: usize>(
        before: [&[i16; 4]; W],
        after: [&[i16; 4]; W],
        weights: L::Weights,
    ) -> [L; 4] {
        L::lerp_short_rows(before, after, weights)
    }
}

/// The two frames that each lane blends.
pub(super) struct Span<'a, L: Rows<W>, N, const W: usize> {
    before: Parts<'a, [N; 4], W>,
    after: Parts<'a, [N; 4], W>,
    weights: L::Weights,
    cursors: &'a [ClipCursor; W],
}

impl<'a, L: Rows<W>, N, const W: usize> Span<'a, L, N, W> {
    #[inline(always)]
    pub(super) fn new(rows: &'a [[N; 4]], cursors: &'a [ClipCursor; W], slots: usize) -> Self {
        Self {
            before: Parts::new(rows, cursors.map(|c| c.before as usize), slots),
            after: Parts::new(rows, cursors.map(|c| c.after as usize), slots),
            weights: L::weights(&cursors.map(|c| c.blend)),
            cursors,
        }
    }

    /// The four numbers of a slot at this time, for every lane.
    #[inline(always)]
    pub(super) fn slot<F: Frames<Number = N>>(&self, clips: &ClipSet, at: usize) -> [L; 4] {
        let slot = at as u32;
        let weights = if clips.is_held_somewhere(slot) {
            self.weights_of_held(clips, slot)
        } else {
            self.weights
        };
        F::lerp::<L, W>(self.before.at(at), self.after.at(at), weights)
    }

    #[cold]
    fn weights_of_held(&self, clips: &ClipSet, slot: u32) -> L::Weights {
        L::weights(&self.cursors.map(|c| match clips.is_held(c.clip, slot) {
            true => 0.0,
            false => c.blend,
        }))
    }
}

/// A translation or scale, decoded by the range of its slot.
#[inline(always)]
fn vector<L: Rows<W>, F: Frames, const W: usize>(
    clips: &ClipSet,
    span: &Span<'_, L, F::Number, W>,
    slot: usize,
) -> [L; 3] {
    let [x, y, z, _] = span.slot::<F>(clips, slot);
    match clips.range(slot) {
        None => [x, y, z],
        Some(range) => {
            let (middle, step) = (splat3::<L>(range.middle), splat3::<L>(range.step));
            [
                middle[0].add(x.mul(step[0])),
                middle[1].add(y.mul(step[1])),
                middle[2].add(z.mul(step[2])),
            ]
        }
    }
}

/// A translation or scale, blended with that of a second clip if there is one.
#[inline(always)]
pub(super) fn faded_vector<L: Rows<W>, F: Frames, const W: usize>(
    clips: &ClipSet,
    from: &Span<'_, L, F::Number, W>,
    to: Option<&(Span<'_, L, F::Number, W>, L)>,
    slot: usize,
) -> [L; 3] {
    let value = vector::<L, F, W>(clips, from, slot);
    match to {
        None => value,
        Some((to, fade)) => lerp3(value, vector::<L, F, W>(clips, to, slot), *fade),
    }
}
