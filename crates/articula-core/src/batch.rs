//! Batched evaluation of up to eight or sixteen characters: sampling, forward kinematics and
//! palettes.
//!
//! Input: cursors ([`ClipSet::cursor`]). Output: palettes ([`PaletteMap`]). Source:
//! `docs/methods/runtime.md` part 3. The plain path is [`sample`](crate::sample()),
//! [`blend`](crate::blend()) and [`local_to_model`](crate::local_to_model); a property test
//! compares every backend with it.
//!
//! Each character is one SIMD lane, so lanes do not depend on each other. Joints without scale, in
//! themselves or above, concatenate quaternions; from a scaled joint downwards matrices are
//! concatenated, as glTF defines, and so are those that no clip moves, nor any joint below them.

mod frames;
mod joint;
mod kernel;
mod lane_math;
mod write;

use crate::Mismatch;
pub use crate::clip_set::ClipCursor;
use crate::clip_set::ClipSet;
use crate::palette::{PaletteForm, PaletteMap, PaletteRows};
use crate::simd::{Backend, LANES, Row, Tile, WIDE, dispatch, dispatch_wide};
use joint::Joint;
use kernel::{Batch, Next};
use write::Out;

/// Greatest number of characters of a batch on any backend; see [`BatchEvaluator::lanes`].
pub const MAX_LANES: usize = WIDE;

/// Pose of one character of a batch: two cursors and the blend between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchPose {
    /// Cursor of the current clip.
    pub from: ClipCursor,
    /// Cursor of the clip faded to, or the same as `from`.
    pub to: ClipCursor,
    /// Blend from 0, which shows `from`, to 1, which shows `to`.
    pub fade: f32,
}

impl From<ClipCursor> for BatchPose {
    fn from(cursor: ClipCursor) -> Self {
        Self {
            from: cursor,
            to: cursor,
            fade: 0.0,
        }
    }
}

/// Working memory of one thread, small enough for its L1 cache; for sixteen lanes, its L2 cache.
#[derive(Debug, Clone)]
pub struct Scratch {
    joints: Vec<Joint<LANES>>,
    wide: Vec<Joint<WIDE>>,
    floats: Vec<Row>,
    halves: Vec<[u16; 4]>,
}

/// Whether batches of sixteen are compiled: no other processor has vectors for them, and modules for web pages are
/// smaller without.
const HAS_WIDE: bool = cfg!(target_arch = "x86_64");

/// Evaluator of batches: one clip set, one palette map and format, one backend.
#[derive(Debug, Clone, Copy)]
pub struct BatchEvaluator<'a> {
    clips: &'a ClipSet,
    map: &'a PaletteMap,
    form: PaletteForm,
    backend: Backend,
}

impl<'a> BatchEvaluator<'a> {
    /// Combines clips, palette, form and backend.
    ///
    /// # Errors
    /// A [`Mismatch`] if the palette was made for other joint LODs, or a rigid form is requested
    /// for joints with scale, in themselves or above, or for bind matrices that are not rigid.
    pub fn new(
        clips: &'a ClipSet,
        map: &'a PaletteMap,
        form: PaletteForm,
        backend: Backend,
    ) -> Result<Self, Mismatch> {
        let (levels, beyond) = (
            clips.joint_lods().levels(),
            clips.joint_lods().joints().len(),
        );
        if map.levels() != levels || map.places().any(|p| p >= beyond) {
            let what = "the palette was built for other joint LODs than the clip set";
            return Err(Mismatch::new("map", what));
        }
        let scaled = map.places().any(|place| clips.scaled()[place]);
        if form.is_rigid() && (scaled || !map.is_rigid()) {
            let what = "rotation and translation cannot store scale; choose a matrix form";
            return Err(Mismatch::new("form", what));
        }
        Ok(Self {
            clips,
            map,
            form,
            backend,
        })
    }

    /// Combines parts that were checked before.
    pub(crate) fn checked(
        clips: &'a ClipSet,
        map: &'a PaletteMap,
        form: PaletteForm,
        backend: Backend,
    ) -> Self {
        Self {
            clips,
            map,
            form,
            backend,
        }
    }

    /// Greatest number of characters of one batch: 16 on [`Backend::Avx512`] of x86-64 processors, else 8.
    pub fn lanes(&self) -> usize {
        if HAS_WIDE && self.backend == Backend::Avx512 {
            WIDE
        } else {
            LANES
        }
    }

    /// Allocates working memory for one thread.
    pub fn scratch(&self) -> Scratch {
        let joints = self.clips.joint_lods().joints().len();
        let tail = self.lanes() * self.map.len(0) * self.form.rows();
        let half = self.form.is_half();
        let is_wide = self.lanes() == WIDE;
        Scratch {
            joints: vec![Joint::ZERO; joints],
            wide: vec![Joint::ZERO; if is_wide { joints } else { 0 }],
            floats: vec![[0.0; 4]; if half { 0 } else { tail }],
            halves: vec![[0; 4]; if half { tail } else { 0 }],
        }
    }

    /// Number of rows of four numbers of one character's palette at a level.
    pub fn rows(&self, level: usize) -> usize {
        self.map.len(level) * self.form.rows()
    }

    /// Writes the palettes of one to [`lanes`](Self::lanes) characters, one after the other.
    ///
    /// O(kept joints); does not allocate. All backends give the same bits.
    ///
    /// # Panics
    /// If there are no characters or too many, `out` does not have the length of their palettes and
    /// the kind of floats of the form, or `scratch` is of another evaluator.
    pub fn evaluate(
        &self,
        level: usize,
        shown: &[BatchPose],
        mut out: PaletteRows<'_>,
        scratch: &mut Scratch,
    ) {
        let lanes = self.check(shown);
        let used = shown.len() * self.rows(level);
        assert_eq!(out.len(), used, "the output must hold every palette");
        // Two clips of sixteen characters lie in more places than the processor prefetches from.
        if lanes == WIDE && shown.iter().any(|s| s.fade != 0.0) {
            let (first, second) = shown.split_at(LANES);
            let middle = LANES * self.rows(level);
            self.evaluate(level, first, out.part(0..middle), scratch);
            self.evaluate(level, second, out.part(middle..used), scratch);
            return;
        }
        let Scratch {
            joints,
            wide,
            floats,
            halves,
        } = scratch;
        let mut run = |out: Out<'_>| {
            if HAS_WIDE && lanes == WIDE {
                let poses = Poses::new(shown);
                dispatch_wide(self.backend, self.batch(level, &poses, out, wide));
            } else {
                let poses = Poses::new(shown);
                dispatch(self.backend, self.batch(level, &poses, out, joints));
            }
        };
        let whole = shown.len() == lanes;
        let all = lanes * self.rows(level);
        match (out, self.form.is_half()) {
            (PaletteRows::Float(out), false) if whole => run(Out::Float(out)),
            (PaletteRows::Half(out), true) if whole => run(Out::Half(out)),
            // The lanes beyond the last character repeat it; their rows are not copied out.
            (PaletteRows::Float(out), false) => {
                run(Out::Float(&mut floats[..all]));
                out.copy_from_slice(&floats[..used]);
            }
            (PaletteRows::Half(out), true) => {
                run(Out::Half(&mut halves[..all]));
                out.copy_from_slice(&halves[..used]);
            }
            _ => panic!("the float type of the rows must match the palette form"),
        }
    }

    /// Evaluates one to [`lanes`](Self::lanes) characters and leaves the model-from-joint matrices
    /// side by side, for callers that consume a batch at once instead of storing it. The palette's
    /// bind matrices are not applied.
    ///
    /// # Panics
    /// If there are no characters or too many, or `scratch` is of another evaluator.
    pub fn tile<'s>(
        &self,
        level: usize,
        shown: &[BatchPose],
        scratch: &'s mut Scratch,
    ) -> JointTiles<'s> {
        let kept = self.clips.joint_lods().joint_count(level);
        let Scratch { joints, wide, .. } = scratch;
        let lanes = self.check(shown);
        if HAS_WIDE && lanes == WIDE {
            let poses = Poses::new(shown);
            dispatch_wide(self.backend, self.batch(level, &poses, Out::Tile, wide));
            JointTiles(Tiles::Sixteen(&wide[..kept]))
        } else {
            let poses = Poses::new(shown);
            dispatch(self.backend, self.batch(level, &poses, Out::Tile, joints));
            JointTiles(Tiles::Eight(&joints[..kept]))
        }
    }

    /// Number of lanes for these characters.
    fn check(&self, shown: &[BatchPose]) -> usize {
        let most = self.lanes();
        assert!(
            (1..=most).contains(&shown.len()),
            "a batch holds 1 to {most} characters"
        );
        if shown.len() <= LANES { LANES } else { WIDE }
    }

    fn batch<'b, const W: usize>(
        &self,
        level: usize,
        poses: &'b Poses<W>,
        out: Out<'b>,
        joints: &'b mut [Joint<W>],
    ) -> Batch<'b, W>
    where
        'a: 'b,
    {
        Batch {
            clips: self.clips,
            form: self.form,
            entries: self.map.entries(level),
            kept: self.clips.joint_lods().joint_count(level),
            poses,
            joints,
            out,
            next: Next::default(),
        }
    }
}

/// Poses of a batch, lane by lane.
struct Poses<const W: usize> {
    from: [ClipCursor; W],
    to: [ClipCursor; W],
    fade: [f32; W],
    is_blended: bool,
}

impl<const W: usize> Poses<W> {
    /// The lanes beyond the last pose repeat it.
    #[inline]
    fn new(shown: &[BatchPose]) -> Self {
        let last = &shown[shown.len() - 1];
        let of = |lane: usize| shown.get(lane).unwrap_or(last);
        Self {
            from: std::array::from_fn(|lane| of(lane).from),
            to: std::array::from_fn(|lane| of(lane).to),
            fade: std::array::from_fn(|lane| of(lane).fade),
            is_blended: shown.iter().any(|s| s.fade != 0.0),
        }
    }
}

/// Model-from-joint matrices of a batch, its characters side by side, in LOD order.
#[derive(Debug, Clone, Copy)]
pub struct JointTiles<'a>(Tiles<'a>);

#[derive(Debug, Clone, Copy)]
enum Tiles<'a> {
    Eight(&'a [Joint<LANES>]),
    Sixteen(&'a [Joint<WIDE>]),
}

impl JointTiles<'_> {
    /// Rows of the 3x4 matrix of the joint at a place of the LOD order
    /// ([`JointLods::place`](crate::JointLods::place)): each number as a slice with that of every
    /// character. The slices are longer than the batch, unless it has 8 or 16 characters.
    ///
    /// # Panics
    /// If the level does not keep that joint.
    pub fn matrix(&self, place: usize) -> [[&[f32]; 4]; 3] {
        match self.0 {
            Tiles::Eight(joints) => lanes_of(&joints[place].matrix),
            Tiles::Sixteen(joints) => lanes_of(&joints[place].matrix),
        }
    }
}

fn lanes_of<const W: usize>(rows: &[[Tile<W>; 4]; 3]) -> [[&[f32]; 4]; 3] {
    rows.each_ref()
        .map(|row| row.each_ref().map(|tile| tile.0.as_slice()))
}
