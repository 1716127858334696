//! Batched evaluation of up to eight characters: sampling, forward kinematics and palettes.
//!
//! Input: cursors ([`ClipSet::cursor`]). Output: palettes ([`PaletteMap`]). Source:
//! `docs/methods/runtime.md` part 3. The plain path is [`sample`](crate::sample()),
//! [`blend`](crate::blend()) and [`local_to_model`](crate::local_to_model); a property test
//! compares every backend with it.
//!
//! Each character is one SIMD lane, so lanes do not depend on each other. Joints without scale, in
//! themselves or above, concatenate quaternions; from a scaled joint downwards matrices are
//! concatenated, as glTF defines.

mod lane_math;

use crate::Mismatch;
pub use crate::clip_set::ClipCursor;
use crate::clip_set::{ClipSet, Rows};
use crate::palette::{Bind, Entry, PaletteForm, PaletteMap, PaletteRows};
use crate::simd::{Backend, Eight, Kernel, Lanes, Row, dispatch};
pub use crate::simd::{LANES, Tile};
use lane_math::{
    bound, faded, lerp3, load4, matrix_of, moved, normalised, product, splat3, splat4, store4,
    turned,
};
use std::ops::Range;

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

/// Working memory of one joint of a batch.
#[derive(Debug, Clone, Copy)]
struct Joint {
    /// Rows of the 3x4 model-from-joint matrix.
    matrix: [[Tile; 4]; 3],
    /// Rotation of that matrix; undefined at and below a scaled joint.
    rotation: [Tile; 4],
}

impl Joint {
    const ZERO: Self = Self {
        matrix: [[Tile::ZERO; 4]; 3],
        rotation: [Tile::ZERO; 4],
    };
}

/// Working memory of one thread, small enough for its L1 cache.
#[derive(Debug, Clone)]
pub struct Scratch {
    joints: Vec<Joint>,
    floats: Vec<Row>,
    halves: Vec<[u16; 4]>,
}

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

    /// Allocates working memory for one thread.
    pub fn scratch(&self) -> Scratch {
        let tail = LANES * self.map.len(0) * self.form.rows();
        let half = self.form.is_half();
        Scratch {
            joints: vec![Joint::ZERO; self.clips.joint_lods().joints().len()],
            floats: vec![[0.0; 4]; if half { 0 } else { tail }],
            halves: vec![[0; 4]; if half { tail } else { 0 }],
        }
    }

    /// Number of rows of four numbers of one character's palette at a level.
    pub fn rows(&self, level: usize) -> usize {
        self.map.len(level) * self.form.rows()
    }

    /// Writes the palettes of one to eight characters, one after the other.
    ///
    /// O(kept joints); does not allocate. All backends give the same bits.
    ///
    /// # Panics
    /// If there are no characters or more than eight, `out` does not have the length of their
    /// palettes and the kind of floats of the form, or `scratch` is of another evaluator.
    pub fn evaluate(
        &self,
        level: usize,
        shown: &[BatchPose],
        out: PaletteRows<'_>,
        scratch: &mut Scratch,
    ) {
        assert!(
            (1..=LANES).contains(&shown.len()),
            "a batch holds 1 to {LANES} characters"
        );
        let used = shown.len() * self.rows(level);
        assert_eq!(out.len(), used, "the output must hold every palette");
        let Scratch {
            joints,
            floats,
            halves,
        } = scratch;
        let whole = shown.len() == LANES;
        match (out, self.form.is_half()) {
            (PaletteRows::Float(out), false) if whole => {
                self.run(level, shown, Out::Float(out), joints);
            }
            (PaletteRows::Half(out), true) if whole => {
                self.run(level, shown, Out::Half(out), joints);
            }
            // The lanes beyond the last character repeat it; their rows are not copied out.
            (PaletteRows::Float(out), false) => {
                self.run(level, shown, Out::Float(floats), joints);
                out.copy_from_slice(&floats[..used]);
            }
            (PaletteRows::Half(out), true) => {
                self.run(level, shown, Out::Half(halves), joints);
                out.copy_from_slice(&halves[..used]);
            }
            _ => panic!("the float type of the rows must match the palette form"),
        }
    }

    /// Evaluates one to eight characters and leaves the model-from-joint matrices in lanes, for
    /// callers that consume a batch at once instead of storing it. The palette's bind matrices
    /// are not applied.
    ///
    /// # Panics
    /// If there are no characters or more than eight, or `scratch` is of another evaluator.
    pub fn tile<'s>(
        &self,
        level: usize,
        shown: &[BatchPose],
        scratch: &'s mut Scratch,
    ) -> JointTiles<'s> {
        assert!(
            (1..=LANES).contains(&shown.len()),
            "a batch holds 1 to {LANES} characters"
        );
        self.run(level, shown, Out::Tile, &mut scratch.joints);
        JointTiles {
            joints: &scratch.joints[..self.clips.joint_lods().joint_count(level)],
        }
    }

    fn run(&self, level: usize, shown: &[BatchPose], out: Out<'_>, joints: &mut [Joint]) {
        let last = shown[shown.len() - 1];
        let lane = |i: usize| *shown.get(i).unwrap_or(&last);
        let shown: [BatchPose; LANES] = std::array::from_fn(lane);
        let kernel = Batch {
            clips: self.clips,
            form: self.form,
            entries: self.map.entries(level),
            kept: self.clips.joint_lods().joint_count(level),
            from: shown.map(|s| s.from),
            fade: shown
                .iter()
                .any(|s| s.fade != 0.0)
                .then(|| (shown.map(|s| s.to), shown.map(|s| s.fade))),
            joints,
            out,
            next: Next::default(),
        };
        dispatch(self.backend, kernel);
    }
}

/// Model-from-joint matrices of a batch, eight characters side by side, in LOD order.
#[derive(Debug, Clone, Copy)]
pub struct JointTiles<'a> {
    joints: &'a [Joint],
}

impl JointTiles<'_> {
    /// Rows of the 3x4 matrix of the joint at a place of the LOD order
    /// ([`JointLods::place`](crate::JointLods::place)), each number for eight characters.
    ///
    /// # Panics
    /// If the level does not keep that joint.
    pub fn matrix(&self, place: usize) -> &[[Tile; 4]; 3] {
        &self.joints[place].matrix
    }
}

/// Output of the kernel.
enum Out<'a> {
    Tile,
    Float(&'a mut [Row]),
    Half(&'a mut [[u16; 4]]),
}

/// One batch of eight lanes, written once for all backends.
struct Batch<'a> {
    clips: &'a ClipSet,
    form: PaletteForm,
    entries: &'a [Entry],
    kept: usize,
    from: [ClipCursor; LANES],
    fade: Option<([ClipCursor; LANES], [f32; LANES])>,
    joints: &'a mut [Joint],
    out: Out<'a>,
    next: Next,
}

/// Moving channels that are sampled next, and the entry that is written next.
#[derive(Default)]
struct Next {
    rotation: usize,
    translation: usize,
    scale: usize,
    entry: usize,
}

impl Kernel for Batch<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        match self.clips.rows() {
            Rows::Float(rows) => self.walk::<L, _>(FloatFrames(rows)),
            Rows::Short(rows) => self.walk::<L, _>(ShortFrames(rows)),
        }
    }
}

/// Number type of a palette.
trait Number: Sized {
    fn store<L: Lanes>(row: [L; 4], out: &mut [[Self; 4]], stride: usize, at: usize);
}

impl Number for f32 {
    #[inline(always)]
    fn store<L: Lanes>(row: [L; 4], out: &mut [Row], stride: usize, at: usize) {
        L::store_rows(row, out, stride, at);
    }
}

impl Number for u16 {
    #[inline(always)]
    fn store<L: Lanes>(row: [L; 4], out: &mut [[u16; 4]], stride: usize, at: usize) {
        L::store_half_rows(row, out, stride, at);
    }
}

/// Rows of one storage, read for eight lanes.
trait Frames: Copy {
    type Number: 'static;
    fn all(&self) -> &[[Self::Number; 4]];
    fn lerp<L: Lanes>(
        before: [&[Self::Number; 4]; LANES],
        after: [&[Self::Number; 4]; LANES],
        weights: L::Weights,
    ) -> [L; 4];
}

#[derive(Clone, Copy)]
struct FloatFrames<'a>(&'a [Row]);

impl Frames for FloatFrames<'_> {
    type Number = f32;

    #[inline(always)]
    fn all(&self) -> &[Row] {
        self.0
    }

    #[inline(always)]
    fn lerp<L: Lanes>(before: [&Row; LANES], after: [&Row; LANES], weights: L::Weights) -> [L; 4] {
        L::lerp_rows(before, after, weights)
    }
}

#[derive(Clone, Copy)]
struct ShortFrames<'a>(&'a [[i16; 4]]);

impl Frames for ShortFrames<'_> {
    type Number = i16;

    #[inline(always)]
    fn all(&self) -> &[[i16; 4]] {
        self.0
    }

    #[inline(always)]
    fn lerp<L: Lanes>(
        before: [&[i16; 4]; LANES],
        after: [&[i16; 4]; LANES],
        weights: L::Weights,
    ) -> [L; 4] {
        L::lerp_short_rows(before, after, weights)
    }
}

/// The two frames that each lane blends.
struct Span<'a, L: Lanes, N> {
    before: Eight<'a, [N; 4]>,
    after: Eight<'a, [N; 4]>,
    weights: L::Weights,
    cursors: &'a [ClipCursor; LANES],
}

impl<'a, L: Lanes, N> Span<'a, L, N> {
    #[inline(always)]
    fn new(rows: &'a [[N; 4]], cursors: &'a [ClipCursor; LANES], slots: usize) -> Self {
        Self {
            before: Eight::new(rows, cursors.map(|c| c.before as usize), slots),
            after: Eight::new(rows, cursors.map(|c| c.after as usize), slots),
            weights: L::weights(&cursors.map(|c| c.blend)),
            cursors,
        }
    }

    /// The four numbers of a slot at this time, for every lane.
    #[inline(always)]
    fn slot<F: Frames<Number = N>>(&self, clips: &ClipSet, at: usize) -> [L; 4] {
        let slot = at as u32;
        let weights = if clips.is_held_somewhere(slot) {
            self.weights_of_held(clips, slot)
        } else {
            self.weights
        };
        F::lerp(self.before.at(at), self.after.at(at), weights)
    }

    #[cold]
    fn weights_of_held(&self, clips: &ClipSet, slot: u32) -> L::Weights {
        L::weights(&self.cursors.map(|c| match clips.is_held(c.clip, slot) {
            true => 0.0,
            false => c.blend,
        }))
    }
}

/// Joints that are sampled together, then chained, then written. A step for one joint at a time does
/// not fit the registers; a step for all at once leaves the memory idle until the first entry is
/// written.
const BLOCK: usize = 8;

// Each step loads what the one before has stored, and yet takes less time than one loop for chaining and
// writing, of which the compiler keeps half on the stack.
impl Batch<'_> {
    #[inline(always)]
    fn walk<L: Lanes, F: Frames>(mut self, frames: F) {
        let (clips, cursors, fade) = (self.clips, self.from, self.fade);
        let from = Span::<L, _>::new(frames.all(), &cursors, clips.slots());
        let to = fade.as_ref().map(|(cursors, fade)| {
            let to = Span::<L, _>::new(frames.all(), cursors, clips.slots());
            (to, L::load(&Tile(*fade)))
        });
        for first in (0..self.kept).step_by(BLOCK) {
            let end = self.kept.min(first + BLOCK);
            self.sample::<L, F>(&from, to.as_ref(), end);
            for place in first..end {
                self.chain::<L>(place);
            }
            self.write::<L>(end);
        }
    }

    /// Samples local rotations, translations and scales of the moving channels of joints before
    /// `end` into the fields that [`Batch::chain`] reads, blended with those of a second clip if there
    /// is one.
    #[inline(always)]
    fn sample<L: Lanes, F: Frames>(
        &mut self,
        from: &Span<'_, L, F::Number>,
        to: Option<&(Span<'_, L, F::Number>, L)>,
        end: usize,
    ) {
        let clips = self.clips;
        let next = &mut self.next;
        let places = clips.rotations(end);
        while next.rotation < places.len() {
            let slot = next.rotation;
            let mut rotation = normalised(from.slot::<F>(clips, slot));
            if let Some((to, fade)) = to {
                rotation = faded(rotation, normalised(to.slot::<F>(clips, slot)), *fade);
            }
            store4(
                rotation,
                &mut self.joints[usize::from(places[slot])].rotation,
            );
            next.rotation += 1;
        }
        let (places, first) = clips.translations(end);
        while next.translation < places.len() {
            let v = faded_vector::<L, F>(clips, from, to, first + next.translation);
            let place = usize::from(places[next.translation]);
            self.joints[place].set_translation(v);
            next.translation += 1;
        }
        let (places, first) = clips.scales(end);
        while next.scale < places.len() {
            let v = faded_vector::<L, F>(clips, from, to, first + next.scale);
            let place = usize::from(places[next.scale]);
            self.joints[place].set_scale(v);
            next.scale += 1;
        }
    }

    /// Computes the model-space matrix of one joint from that of its parent.
    #[inline(always)]
    fn chain<L: Lanes>(&mut self, place: usize) {
        let clips = self.clips;
        let (above, joint) = self.joints.split_at_mut(place);
        let joint = &mut joint[0];
        let (source, constant) = (&clips.sources()[place], &clips.constants()[place]);
        let rotation = match source[0] {
            Some(_) => load4(&joint.rotation),
            None => splat4(constant.rotation.to_array()),
        };
        let translation = match source[1] {
            Some(_) => joint.translation(),
            None => splat3(constant.translation),
        };
        let parent = clips.joint_lods().parents()[place].map(|p| &above[usize::from(p)]);
        if clips.scaled()[place] {
            let scale = match source[2] {
                Some(_) => joint.scale(),
                None => splat3(constant.scale),
            };
            joint.set_rows(matrix_chain::<L>(parent, rotation, translation, scale));
        } else {
            let (rows, rotation) = quaternion_chain::<L>(parent, rotation, translation);
            joint.set_rows(rows);
            store4(rotation, &mut joint.rotation);
        }
    }

    /// Writes the entries of the joints before `end`.
    #[inline(always)]
    fn write<L: Lanes>(&mut self, end: usize) {
        let first = self.next.entry;
        let below = |e: &Entry| usize::from(e.place) < end;
        while self.entries.get(self.next.entry).is_some_and(below) {
            self.next.entry += 1;
        }
        let (joints, entries) = (&*self.joints, self.entries);
        let range = first..self.next.entry;
        match (&mut self.out, self.form.is_rigid()) {
            (Out::Tile, _) => {}
            (Out::Float(out), false) => write_matrices::<L, _>(joints, entries, range, out),
            (Out::Half(out), false) => write_matrices::<L, _>(joints, entries, range, out),
            (Out::Float(out), true) => write_rigid::<L, _>(joints, entries, range, out),
            (Out::Half(out), true) => write_rigid::<L, _>(joints, entries, range, out),
        }
    }
}

/// Writes a range of the entries as matrices.
#[inline(always)]
fn write_matrices<L: Lanes, N: Number>(
    joints: &[Joint],
    entries: &[Entry],
    range: Range<usize>,
    out: &mut [[N; 4]],
) {
    let stride = entries.len() * 3;
    for (at, entry) in range.clone().zip(&entries[range]) {
        let rows = joints[usize::from(entry.place)].rows::<L>();
        let [x, y, z] = match &entry.bind {
            None => rows,
            Some(Bind { rows: b, .. }) => [bound(rows[0], b), bound(rows[1], b), bound(rows[2], b)],
        };
        N::store(x, out, stride, at * 3);
        N::store(y, out, stride, at * 3 + 1);
        N::store(z, out, stride, at * 3 + 2);
    }
}

/// Writes a range of the entries, all of joints without scale, as rotations and translations.
#[inline(always)]
fn write_rigid<L: Lanes, N: Number>(
    joints: &[Joint],
    entries: &[Entry],
    range: Range<usize>,
    out: &mut [[N; 4]],
) {
    let stride = entries.len() * 2;
    for (at, entry) in range.clone().zip(&entries[range]) {
        let joint = &joints[usize::from(entry.place)];
        let rotation = load4::<L>(&joint.rotation);
        let (rotation, t) = match &entry.bind {
            None => (rotation, joint.translation()),
            Some(bind) => (
                product(rotation, splat4(bind.rotation.to_array())),
                moved(&joint.rows(), splat3(bind.translation)),
            ),
        };
        N::store(rotation, out, stride, at * 2);
        let last = [t[0], t[1], t[2], L::splat(1.0)];
        N::store(last, out, stride, at * 2 + 1);
    }
}

impl Joint {
    #[inline(always)]
    fn rows<L: Lanes>(&self) -> [[L; 4]; 3] {
        let [x, y, z] = &self.matrix;
        [load4(x), load4(y), load4(z)]
    }

    #[inline(always)]
    fn set_rows<L: Lanes>(&mut self, rows: [[L; 4]; 3]) {
        let [x, y, z] = &mut self.matrix;
        store4(rows[0], x);
        store4(rows[1], y);
        store4(rows[2], z);
    }

    /// The last column: the local translation before [`Batch::chain`], the model-space position
    /// after it.
    #[inline(always)]
    fn translation<L: Lanes>(&self) -> [L; 3] {
        let [x, y, z] = &self.matrix;
        [L::load(&x[3]), L::load(&y[3]), L::load(&z[3])]
    }

    #[inline(always)]
    fn set_translation<L: Lanes>(&mut self, v: [L; 3]) {
        let [x, y, z] = &mut self.matrix;
        v[0].store(&mut x[3]);
        v[1].store(&mut y[3]);
        v[2].store(&mut z[3]);
    }

    /// The first row, which holds the scale before [`Batch::chain`].
    #[inline(always)]
    fn scale<L: Lanes>(&self) -> [L; 3] {
        let [x, y, z, _] = &self.matrix[0];
        [L::load(x), L::load(y), L::load(z)]
    }

    #[inline(always)]
    fn set_scale<L: Lanes>(&mut self, v: [L; 3]) {
        let [x, y, z, _] = &mut self.matrix[0];
        v[0].store(x);
        v[1].store(y);
        v[2].store(z);
    }
}

/// A translation or scale, decoded by the range of its slot.
#[inline(always)]
fn vector<L: Lanes, F: Frames>(
    clips: &ClipSet,
    span: &Span<'_, L, F::Number>,
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
fn faded_vector<L: Lanes, F: Frames>(
    clips: &ClipSet,
    from: &Span<'_, L, F::Number>,
    to: Option<&(Span<'_, L, F::Number>, L)>,
    slot: usize,
) -> [L; 3] {
    let value = vector::<L, F>(clips, from, slot);
    match to {
        None => value,
        Some((to, fade)) => lerp3(value, vector::<L, F>(clips, to, slot), *fade),
    }
}

/// Model-space matrix and rotation of a joint without scale.
#[inline(always)]
fn quaternion_chain<L: Lanes>(
    parent: Option<&Joint>,
    rotation: [L; 4],
    translation: [L; 3],
) -> ([[L; 4]; 3], [L; 4]) {
    let (rotation, [tx, ty, tz]) = match parent {
        None => (rotation, translation),
        Some(parent) => (
            product(load4(&parent.rotation), rotation),
            moved(&parent.rows(), translation),
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
fn matrix_chain<L: Lanes>(
    parent: Option<&Joint>,
    rotation: [L; 4],
    translation: [L; 3],
    scale: [L; 3],
) -> [[L; 4]; 3] {
    let [x, y, z] = matrix_of(rotation);
    let column = [
        [x[0].mul(scale[0]), y[0].mul(scale[0]), z[0].mul(scale[0])],
        [x[1].mul(scale[1]), y[1].mul(scale[1]), z[1].mul(scale[1])],
        [x[2].mul(scale[2]), y[2].mul(scale[2]), z[2].mul(scale[2])],
    ];
    let [a, b, c, d] = match parent {
        None => [column[0], column[1], column[2], translation],
        Some(parent) => {
            let rows = parent.rows();
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
