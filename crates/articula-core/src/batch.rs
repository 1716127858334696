//! One pose for each of eight characters: sampling, forward kinematics and palette in one pass.
//!
//! From cursors ([`ClipSet::cursor`]) to palettes ([`PaletteMap`]). Source: `spec/runtime.md`
//! part 3. The plain path is [`sample`](crate::sample), [`blend`](crate::blend) and
//! [`hierarchy`](crate::hierarchy); a property test holds every backend to it.
//!
//! Each character is a lane, so no joint waits for another lane's parent. Rigs without scale
//! chain quaternions; rigs with scale chain matrices, as glTF defines them.

use crate::Mismatch;
use crate::clip_set::{ClipSet, Cursor, Rows};
use crate::palette::{Bind, Entry, PaletteForm, PaletteMap, PaletteRows};
use crate::simd::{Backend, Kernel, LANES, Lanes, Row, Tile, dispatch};
use glam::{Quat, Vec3};

/// What one character of a batch shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// The clip that it plays.
    pub from: Cursor,
    /// The clip that it fades to, or the same.
    pub to: Cursor,
    /// 0 shows `from`, 1 shows `to`.
    pub fade: f32,
}

impl From<Cursor> for Shown {
    fn from(cursor: Cursor) -> Self {
        Self {
            from: cursor,
            to: cursor,
            fade: 0.0,
        }
    }
}

/// Where the matrices of a joint stand while a batch is worked on.
#[derive(Debug, Clone, Copy)]
struct Joint {
    /// Rows of the 3x4 model-from-joint matrix.
    matrix: [[Tile; 4]; 3],
    /// Rotation of that matrix; not kept for rigs with scale.
    rotation: [Tile; 4],
}

impl Joint {
    const ZERO: Self = Self {
        matrix: [[Tile::ZERO; 4]; 3],
        rotation: [Tile::ZERO; 4],
    };
}

/// Working memory of one thread: as much as fits the level-one cache.
#[derive(Debug, Clone)]
pub struct Scratch {
    joints: Vec<Joint>,
    floats: Vec<Row>,
    halves: Vec<[u16; 4]>,
}

/// Evaluates batches of one clip set into one kind of palette.
#[derive(Debug, Clone, Copy)]
pub struct BatchEvaluator<'a> {
    clips: &'a ClipSet,
    map: &'a PaletteMap,
    form: PaletteForm,
    backend: Backend,
}

impl<'a> BatchEvaluator<'a> {
    /// Pairs clips, palette, form and backend.
    ///
    /// # Errors
    /// A [`Mismatch`] if the palette is of a ladder with other levels, or a rigid form is asked
    /// of a rig with scale or of bind matrices that are not rigid.
    pub fn new(
        clips: &'a ClipSet,
        map: &'a PaletteMap,
        form: PaletteForm,
        backend: Backend,
    ) -> Result<Self, Mismatch> {
        let (levels, beyond) = (clips.ladder().levels(), clips.ladder().len());
        if map.levels() != levels || map.places().any(|p| p >= beyond) {
            let what = "the palette was made for another ladder";
            return Err(Mismatch::new("map", what));
        }
        if form.is_rigid() && (clips.is_scaled() || !map.is_rigid()) {
            let what = "rotation and translation cannot hold scale; take a matrix form";
            return Err(Mismatch::new("form", what));
        }
        Ok(Self {
            clips,
            map,
            form,
            backend,
        })
    }

    /// Working memory for one thread.
    pub fn scratch(&self) -> Scratch {
        let tail = LANES * self.map.len(0) * self.form.rows();
        let half = self.form.is_half();
        Scratch {
            joints: vec![Joint::ZERO; self.clips.ladder().len()],
            floats: vec![[0.0; 4]; if half { 0 } else { tail }],
            halves: vec![[0; 4]; if half { tail } else { 0 }],
        }
    }

    /// Rows that the palette of one character takes at a level.
    pub fn rows(&self, level: usize) -> usize {
        self.map.len(level) * self.form.rows()
    }

    /// Writes the palettes of one to eight characters, one after the other.
    ///
    /// O(kept joints); does not allocate. All backends give the same bits.
    ///
    /// # Panics
    /// If there are no characters or more than eight, `out` is not as long as their palettes or
    /// of the other kind of floats, or `scratch` is of another evaluator.
    pub fn evaluate(
        &self,
        level: usize,
        shown: &[Shown],
        out: PaletteRows<'_>,
        scratch: &mut Scratch,
    ) {
        assert!(
            (1..=LANES).contains(&shown.len()),
            "1 to {LANES} characters"
        );
        let used = shown.len() * self.rows(level);
        assert_eq!(out.len(), used, "room for each palette");
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
            _ => panic!("the rows are not of the form's kind of floats"),
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
        shown: &[Shown],
        scratch: &'s mut Scratch,
    ) -> JointTiles<'s> {
        assert!(
            (1..=LANES).contains(&shown.len()),
            "1 to {LANES} characters"
        );
        self.run(level, shown, Out::Tile, &mut scratch.joints);
        JointTiles {
            joints: &scratch.joints[..self.clips.ladder().kept(level)],
        }
    }

    fn run(&self, level: usize, shown: &[Shown], out: Out<'_>, joints: &mut [Joint]) {
        let last = shown[shown.len() - 1];
        let lane = |i: usize| *shown.get(i).unwrap_or(&last);
        let shown: [Shown; LANES] = std::array::from_fn(lane);
        let kernel = Batch {
            clips: self.clips,
            form: self.form,
            entries: self.map.entries(level),
            kept: self.clips.ladder().kept(level),
            from: shown.map(|s| s.from),
            fade: shown
                .iter()
                .any(|s| s.fade != 0.0)
                .then(|| (shown.map(|s| s.to), shown.map(|s| s.fade))),
            joints,
            out,
        };
        dispatch(self.backend, kernel);
    }
}

/// Matrices of a batch, eight characters side by side; places in ladder order.
#[derive(Debug, Clone, Copy)]
pub struct JointTiles<'a> {
    joints: &'a [Joint],
}

impl JointTiles<'_> {
    /// Number of joints that the level keeps.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// Never true: a level keeps at least one joint.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Rows of the 3x4 matrix of the joint at a place, each number for eight characters.
    pub fn matrix(&self, place: usize) -> &[[Tile; 4]; 3] {
        &self.joints[place].matrix
    }
}

/// Where the kernel writes.
enum Out<'a> {
    Tile,
    Float(&'a mut [Row]),
    Half(&'a mut [[u16; 4]]),
}

impl Out<'_> {
    #[inline(always)]
    fn store<L: Lanes>(&mut self, row: [L; 4], stride: usize, at: usize) {
        match self {
            Self::Tile => {}
            Self::Float(out) => L::store_rows(row, out, stride, at),
            Self::Half(out) => L::store_half_rows(row, out, stride, at),
        }
    }
}

/// One batch of eight lanes, written once for all backends.
struct Batch<'a> {
    clips: &'a ClipSet,
    form: PaletteForm,
    entries: &'a [Entry],
    kept: usize,
    from: [Cursor; LANES],
    fade: Option<([Cursor; LANES], [f32; LANES])>,
    joints: &'a mut [Joint],
    out: Out<'a>,
}

impl Kernel for Batch<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        match (self.clips.rows(), self.clips.is_scaled()) {
            (Rows::Float(rows), false) => self.walk::<L, _, false>(FloatFrames(rows)),
            (Rows::Float(rows), true) => self.walk::<L, _, true>(FloatFrames(rows)),
            (Rows::Short(rows), false) => self.walk::<L, _, false>(ShortFrames(rows)),
            (Rows::Short(rows), true) => self.walk::<L, _, true>(ShortFrames(rows)),
        }
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

/// The two frames between which each lane stands.
struct Span<'a, L: Lanes, N> {
    before: [&'a [[N; 4]]; LANES],
    after: [&'a [[N; 4]]; LANES],
    weights: L::Weights,
    cursors: &'a [Cursor; LANES],
}

impl<'a, L: Lanes, N> Span<'a, L, N> {
    #[inline(always)]
    fn new(rows: &'a [[N; 4]], cursors: &'a [Cursor; LANES], slots: usize) -> Self {
        Self {
            before: std::array::from_fn(|i| &rows[cursors[i].before as usize..][..slots]),
            after: std::array::from_fn(|i| &rows[cursors[i].after as usize..][..slots]),
            weights: L::weights(&cursors.map(|c| c.blend)),
            cursors,
        }
    }

    /// The four numbers of a slot at this time, for every lane.
    #[inline(always)]
    fn slot<F: Frames<Number = N>>(&self, clips: &ClipSet, slot: u32) -> [L; 4] {
        let at = slot as usize;
        let weights = if clips.is_held_somewhere(slot) {
            self.weights_of_held(clips, slot)
        } else {
            self.weights
        };
        F::lerp(
            std::array::from_fn(|i| &self.before[i][at]),
            std::array::from_fn(|i| &self.after[i][at]),
            weights,
        )
    }

    #[cold]
    fn weights_of_held(&self, clips: &ClipSet, slot: u32) -> L::Weights {
        L::weights(&self.cursors.map(|c| match clips.is_held(c.clip, slot) {
            true => 0.0,
            false => c.blend,
        }))
    }
}

impl Batch<'_> {
    /// Joints in ladder order, parents before children.
    #[inline(always)]
    fn walk<L: Lanes, F: Frames, const SCALED: bool>(mut self, frames: F) {
        let (clips, slots) = (self.clips, self.clips.slots());
        let from = Span::<L, _>::new(frames.all(), &self.from, slots);
        let to_cursors = self.fade.map_or(self.from, |(to, _)| to);
        let to = Span::<L, _>::new(frames.all(), &to_cursors, slots);
        let fade = self.fade.map(|(_, fade)| L::load(&Tile(fade)));
        let stride = self.entries.len() * self.form.rows();
        let mut entry = 0;
        for place in 0..self.kept {
            let source = clips.sources()[place];
            let constant = clips.constants()[place];
            let mut rotation = match source[0] {
                Some(slot) => normalised(from.slot::<F>(clips, slot)),
                None => splat4(constant.rotation),
            };
            let mut translation = vector::<L, F>(clips, &from, source[1], constant.translation);
            if let Some(fade) = fade {
                if let Some(slot) = source[0] {
                    let other = normalised(to.slot::<F>(clips, slot));
                    rotation = faded(rotation, other, fade);
                }
                if source[1].is_some() {
                    let other = vector::<L, F>(clips, &to, source[1], constant.translation);
                    translation = lerp3(translation, other, fade);
                }
            }
            let parent = clips.ladder().parents()[place].map(usize::from);
            let parent = parent.map(|p| &self.joints[p]);
            let (rows, rotation) = if SCALED {
                let mut scale = vector::<L, F>(clips, &from, source[2], constant.scale);
                if let (Some(fade), Some(_)) = (fade, source[2]) {
                    let other = vector::<L, F>(clips, &to, source[2], constant.scale);
                    scale = lerp3(scale, other, fade);
                }
                (matrix_chain(parent, rotation, translation, scale), rotation)
            } else {
                quaternion_chain(parent, rotation, translation)
            };
            let joint = &mut self.joints[place];
            for (tiles, row) in joint.matrix.iter_mut().zip(rows) {
                store4(row, tiles);
            }
            if !SCALED {
                store4(rotation, &mut joint.rotation);
            }
            while let Some(e) = self
                .entries
                .get(entry)
                .filter(|e| usize::from(e.place) == place)
            {
                let at = entry * self.form.rows();
                write(
                    &mut self.out,
                    self.form,
                    rows,
                    rotation,
                    e.bind.as_ref(),
                    (stride, at),
                );
                entry += 1;
            }
        }
    }
}

#[inline(always)]
fn splat4<L: Lanes>(q: Quat) -> [L; 4] {
    q.to_array().map(L::splat)
}

#[inline(always)]
fn splat3<L: Lanes>(v: Vec3) -> [L; 3] {
    v.to_array().map(L::splat)
}

#[inline(always)]
fn load4<L: Lanes>(tiles: &[Tile; 4]) -> [L; 4] {
    std::array::from_fn(|i| L::load(&tiles[i]))
}

#[inline(always)]
fn store4<L: Lanes>(lanes: [L; 4], tiles: &mut [Tile; 4]) {
    for (lane, tile) in lanes.into_iter().zip(tiles) {
        lane.store(tile);
    }
}

#[inline(always)]
fn dot4<L: Lanes>(a: [L; 4], b: [L; 4]) -> L {
    let low = a[0].mul(b[0]).add(a[1].mul(b[1]));
    low.add(a[2].mul(b[2])).add(a[3].mul(b[3]))
}

#[inline(always)]
fn normalised<L: Lanes>(q: [L; 4]) -> [L; 4] {
    let scale = L::splat(1.0).div(dot4(q, q).sqrt());
    q.map(|c| c.mul(scale))
}

/// Normalised linear blend on the short way.
#[inline(always)]
fn faded<L: Lanes>(a: [L; 4], b: [L; 4], weight: L) -> [L; 4] {
    let towards = weight.mul(dot4(a, b).sign());
    let rest = L::splat(1.0).sub(weight);
    let blend: [L; 4] = std::array::from_fn(|i| a[i].mul(rest).add(b[i].mul(towards)));
    normalised(blend)
}

#[inline(always)]
fn lerp3<L: Lanes>(a: [L; 3], b: [L; 3], weight: L) -> [L; 3] {
    std::array::from_fn(|i| a[i].add(b[i].sub(a[i]).mul(weight)))
}

/// Translation or scale: a constant, or a slot brought back from its range.
#[inline(always)]
fn vector<L: Lanes, F: Frames>(
    clips: &ClipSet,
    span: &Span<'_, L, F::Number>,
    slot: Option<u32>,
    constant: Vec3,
) -> [L; 3] {
    let Some(slot) = slot else {
        return splat3(constant);
    };
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

/// Hamilton product.
#[inline(always)]
fn product<L: Lanes>(a: [L; 4], b: [L; 4]) -> [L; 4] {
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
fn matrix_of<L: Lanes>(q: [L; 4]) -> [[L; 3]; 3] {
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
fn along<L: Lanes>(row: [L; 4], v: [L; 3]) -> L {
    let xy = row[0].mul(v[0]).add(row[1].mul(v[1]));
    xy.add(row[2].mul(v[2]))
}

/// A rig without scale: model-space quaternions, and the matrix of each.
#[inline(always)]
fn quaternion_chain<L: Lanes>(
    parent: Option<&Joint>,
    rotation: [L; 4],
    translation: [L; 3],
) -> ([[L; 4]; 3], [L; 4]) {
    let (rotation, translation) = match parent {
        None => (rotation, translation),
        Some(parent) => {
            let rows = parent.matrix.each_ref().map(load4::<L>);
            let moved = rows.map(|row| along(row, translation).add(row[3]));
            (product(load4(&parent.rotation), rotation), moved)
        }
    };
    let [x, y, z] = matrix_of(rotation);
    let [tx, ty, tz] = translation;
    let rows = [
        [x[0], x[1], x[2], tx],
        [y[0], y[1], y[2], ty],
        [z[0], z[1], z[2], tz],
    ];
    (rows, rotation)
}

/// A rig with scale: matrices all the way, so that children inherit shear as glTF has it.
#[inline(always)]
fn matrix_chain<L: Lanes>(
    parent: Option<&Joint>,
    rotation: [L; 4],
    translation: [L; 3],
    scale: [L; 3],
) -> [[L; 4]; 3] {
    let local =
        matrix_of(rotation).map(|r| [r[0].mul(scale[0]), r[1].mul(scale[1]), r[2].mul(scale[2])]);
    match parent {
        None => std::array::from_fn(|r| {
            let [a, b, c] = local[r];
            [a, b, c, translation[r]]
        }),
        Some(parent) => {
            let column = |c: usize| [local[0][c], local[1][c], local[2][c]];
            let (a, b, c) = (column(0), column(1), column(2));
            parent.matrix.each_ref().map(|row| {
                let row = load4::<L>(row);
                let t = along(row, translation).add(row[3]);
                [along(row, a), along(row, b), along(row, c), t]
            })
        }
    }
}

/// Writes one entry for all lanes.
#[inline(always)]
fn write<L: Lanes>(
    out: &mut Out<'_>,
    form: PaletteForm,
    rows: [[L; 4]; 3],
    rotation: [L; 4],
    bind: Option<&Bind>,
    (stride, at): (usize, usize),
) {
    if matches!(out, Out::Tile) {
        return;
    }
    if form.is_rigid() {
        let (rotation, translation) = match bind {
            None => (rotation, rows.map(|r| r[3])),
            Some(bind) => {
                let by = splat3::<L>(bind.translation);
                let moved = rows.map(|row| along(row, by).add(row[3]));
                (product(rotation, splat4(bind.rotation)), moved)
            }
        };
        let [x, y, z] = translation;
        out.store(rotation, stride, at);
        out.store([x, y, z, L::splat(1.0)], stride, at + 1);
        return;
    }
    for (r, row) in rows.into_iter().enumerate() {
        let row = match bind {
            None => row,
            Some(bind) => {
                let [x, y, z] = bind.rows.map(|b| b.map(L::splat));
                let column = |c: usize| along(row, [x[c], y[c], z[c]]);
                [column(0), column(1), column(2), column(3).add(row[3])]
            }
        };
        out.store(row, stride, at + r);
    }
}
