//! The kernel of a batch: sampling, forward kinematics and writing, block by block.

use super::Poses;
use super::frames::{FloatFrames, Frames, ShortFrames, Span, faded_vector};
use super::joint::Joint;
use super::lane_math::{
    faded, load4, matrix_of, moved, normalised, product, splat3, splat4, store4, times, turned,
};
use super::write::{Lines, Out, Part};
use crate::clip_set::{self, ClipSet};
use crate::palette::{Entry, PaletteForm};
use crate::simd::{Kernel, LANES, Lanes, Piece, Rows, WIDE, WideKernel};

/// One batch, written once for all backends.
pub(super) struct Batch<'a, const W: usize> {
    pub(super) clips: &'a ClipSet,
    pub(super) form: PaletteForm,
    pub(super) entries: &'a [Entry],
    pub(super) kept: usize,
    pub(super) poses: &'a Poses<W>,
    pub(super) joints: &'a mut [Joint<W>],
    pub(super) out: Out<'a>,
    pub(super) next: Next,
}

/// Moving channels that are sampled next, and the entry that is written next.
#[derive(Default)]
pub(super) struct Next {
    rotation: usize,
    translation: usize,
    scale: usize,
    entry: usize,
}

impl Kernel for Batch<'_, LANES> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.evaluate::<L>();
    }
}

impl WideKernel for Batch<'_, WIDE> {
    #[inline(always)]
    fn run<L: Rows<WIDE>>(self) {
        self.evaluate::<L>();
    }
}

/// Joints that are sampled together, then chained, then written. A step for one joint at a time does
/// not fit the registers; a step for all at once leaves the memory idle until the first entry is
/// written.
const BLOCK: usize = 8;

// Each step loads what the one before has stored, and yet takes less time than one loop for chaining and
// writing, of which the compiler keeps half on the stack.
impl<const W: usize> Batch<'_, W> {
    #[inline(always)]
    fn evaluate<L: Rows<W>>(self) {
        match self.clips.rows() {
            clip_set::Rows::Float(rows) => self.walk::<L, _>(FloatFrames(rows)),
            clip_set::Rows::Short(rows) => self.walk::<L, _>(ShortFrames(rows)),
        }
    }

    #[inline(always)]
    fn walk<L: Rows<W>, F: Frames>(mut self, frames: F) {
        let (clips, poses) = (self.clips, self.poses);
        let from = Span::<L, _, W>::new(frames.all(), &poses.from, clips.slots());
        let to = poses.is_blended.then(|| {
            let to = Span::<L, _, W>::new(frames.all(), &poses.to, clips.slots());
            (to, L::load(&poses.fade))
        });
        // What sixteen characters read and write in a whole block takes too much of the L1 cache.
        let block = match self.out {
            Out::Float(_) | Out::Half(_) if W > LANES => BLOCK / 2,
            _ => BLOCK,
        };
        let lines = Lines::of(&self.out, self.form, self.entries.len(), block);
        for first in (0..self.kept).step_by(block) {
            let end = self.kept.min(first + block);
            self.sample::<L, F>(&from, to.as_ref(), end);
            for place in first..end {
                let lanes = (place - first) * (W / block)..(place - first + 1) * (W / block);
                lines.prefetch(lanes, self.next.entry);
                for piece in 0..<L::Piece>::COUNT {
                    self.chain::<L::Piece>(place, piece);
                }
            }
            self.write::<L>(end);
        }
    }

    /// Samples local rotations, translations and scales of the moving channels of joints before
    /// `end` into the fields that [`Batch::chain`] reads, blended with those of a second clip if there
    /// is one.
    #[inline(always)]
    fn sample<L: Rows<W>, F: Frames>(
        &mut self,
        from: &Span<'_, L, F::Number, W>,
        to: Option<&(Span<'_, L, F::Number, W>, L)>,
        end: usize,
    ) {
        let clips = self.clips;
        let next = &mut self.next;
        let places = clips.rotations();
        while let Some(place) = before(end, places, next.rotation) {
            let slot = next.rotation;
            let mut rotation = normalised(from.slot::<F>(clips, slot));
            if let Some((to, fade)) = to {
                rotation = faded(rotation, normalised(to.slot::<F>(clips, slot)), *fade);
            }
            store4(rotation, &mut self.joints[place].rotation, 0);
            next.rotation += 1;
        }
        let (places, first) = clips.translations();
        while let Some(place) = before(end, places, next.translation) {
            let v = faded_vector::<L, F, W>(clips, from, to, first + next.translation);
            self.joints[place].set_translation(v);
            next.translation += 1;
        }
        let (places, first) = clips.scales();
        while let Some(place) = before(end, places, next.scale) {
            let v = faded_vector::<L, F, W>(clips, from, to, first + next.scale);
            self.joints[place].set_scale(v);
            next.scale += 1;
        }
    }

    /// Computes the model-space matrix of one joint from that of its parent, of a piece of the lanes.
    #[inline(always)]
    fn chain<P: Piece<W>>(&mut self, place: usize, piece: usize) {
        let clips = self.clips;
        let (above, joint) = self.joints.split_at_mut(place);
        let joint = &mut joint[0];
        let parent = clips.joint_lods().parents()[place].map(|p| &above[usize::from(p)]);
        // Nothing below reads the rotation then, unless it is written.
        if let (Some(parent), Some(local)) = (parent, clips.still(place))
            && !self.form.is_rigid()
        {
            joint.set_rows(times::<P>(&parent.rows(piece), local), piece);
            return;
        }
        let (source, constant) = (&clips.sources()[place], &clips.constants()[place]);
        let rotation = match source[0] {
            Some(_) => load4(&joint.rotation, piece),
            None => splat4(constant.rotation.to_array()),
        };
        let translation = match source[1] {
            Some(_) => joint.translation(piece),
            None => splat3(constant.translation),
        };
        if clips.scaled()[place] {
            let scale = match source[2] {
                Some(_) => joint.scale(piece),
                None => splat3(constant.scale),
            };
            joint.set_rows(
                matrix_chain::<P, W>((parent, piece), rotation, translation, scale),
                piece,
            );
        } else {
            let (rows, rotation) = quaternion_chain::<P, W>((parent, piece), rotation, translation);
            joint.set_rows(rows, piece);
            store4(rotation, &mut joint.rotation, piece);
        }
    }

    /// Writes the entries of the joints before `end`.
    #[inline(always)]
    fn write<L: Rows<W>>(&mut self, end: usize) {
        let first = self.next.entry;
        let below = |e: &Entry| usize::from(e.place) < end;
        while self.entries.get(self.next.entry).is_some_and(below) {
            self.next.entry += 1;
        }
        let part = Part {
            joints: &*self.joints,
            entries: self.entries,
            range: first..self.next.entry,
        };
        match (&mut self.out, self.form.is_rigid()) {
            (Out::Tile, _) => {}
            (Out::Float(out), false) => part.matrices::<L::Eight, _>(out),
            (Out::Half(out), false) => part.matrices::<L::Eight, _>(out),
            (Out::Float(out), true) => part.rigid::<L::Eight, _>(out),
            (Out::Half(out), true) => part.rigid::<L::Eight, _>(out),
        }
    }
}

/// The place at an index, if it is before `end`.
#[inline(always)]
fn before(end: usize, places: &[u16], index: usize) -> Option<usize> {
    let place = usize::from(*places.get(index)?);
    (place < end).then_some(place)
}

/// Model-space matrix and rotation of a joint without scale.
#[inline(always)]
fn quaternion_chain<P: Piece<W>, const W: usize>(
    (parent, piece): (Option<&Joint<W>>, usize),
    rotation: [P; 4],
    translation: [P; 3],
) -> ([[P; 4]; 3], [P; 4]) {
    let (rotation, [tx, ty, tz]) = match parent {
        None => (rotation, translation),
        Some(parent) => (
            product(load4(&parent.rotation, piece), rotation),
            moved(&parent.rows(piece), translation),
        ),
    };
    let [x, y, z] = matrix_of(rotation);
    let rows = [
        [x[0], x[1], x[2], tx],
        [y[0], y[1], y[2], ty],
        [z[0], z[1], z[2], tz],
    ];
    (rows, rotation)
}

/// Model-space matrix of a joint with scale, by products of matrices, so that children inherit
/// shear as in glTF.
#[inline(always)]
fn matrix_chain<P: Piece<W>, const W: usize>(
    (parent, piece): (Option<&Joint<W>>, usize),
    rotation: [P; 4],
    translation: [P; 3],
    scale: [P; 3],
) -> [[P; 4]; 3] {
    let [x, y, z] = matrix_of(rotation);
    let column = [
        [x[0].mul(scale[0]), y[0].mul(scale[0]), z[0].mul(scale[0])],
        [x[1].mul(scale[1]), y[1].mul(scale[1]), z[1].mul(scale[1])],
        [x[2].mul(scale[2]), y[2].mul(scale[2]), z[2].mul(scale[2])],
    ];
    let [a, b, c, d] = match parent {
        None => [column[0], column[1], column[2], translation],
        Some(parent) => {
            let rows = parent.rows(piece);
            [
                turned(&rows, column[0]),
                turned(&rows, column[1]),
                turned(&rows, column[2]),
                moved(&rows, translation),
            ]
        }
    };
    [
        [a[0], b[0], c[0], d[0]],
        [a[1], b[1], c[1], d[1]],
        [a[2], b[2], c[2], d[2]],
    ]
}
