//! Pose cache: whole palettes at key times, shared by all characters of a rig and blended each
//! frame.
//!
//! Source: `docs/methods/motion-lod.md` part 6 and `docs/methods/runtime.md` 4.1. Linear blend
//! skinning is linear in the palette, so between two cached palettes every vertex moves on a
//! straight line; keys are chosen (by `articula-build`) so that this line stays near the motion. A
//! character then costs one look-up per frame, of the two keys around its time
//! ([`PoseCache::locate`]). The palettes are blended by the CPU ([`PoseCache::blend`]) or by a
//! vertex shader ([`BlendRecord`]). Where palettes at equal distances in time are cached too, the
//! nearest is shown as it is ([`PoseCache::nearest`]): nothing is blended, and nothing is written. A
//! vertex shader blends any two, so its record names two of these where they are closer to the motion
//! than the keys are ([`PoseCache::record`]).
//!
//! A character holds no key and no cursor. Its record is computed each frame from clip, level and
//! time, so a change of clip or level needs no notification, and keys of different clips or levels
//! cannot be mixed. The two ends of a clip are never blended with each other.

use crate::Mismatch;
use crate::blend_record::BlendRecord;
use crate::clip_set::ClipSet;
use crate::palette::{PaletteForm, PaletteMap, PaletteRows};
use crate::simd::{Backend, Kernel, LANES, Lanes, Row, dispatch};

/// Maximum number of buckets per key in the table that finds keys by time.
const BUCKETS_PER_KEY: usize = 8;

/// Keys of one clip at one level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CachedKeys {
    /// Times of the keys in seconds: rising, the first 0, the last the clip's end.
    pub times_secs: Vec<f32>,
    /// Index of the first matrix of the first key's palette. Palettes of further keys follow
    /// without gaps.
    pub first_matrix: u32,
    /// Distance in metres between the skin blended from the keys and that of the same level
    /// evaluated: per frame the 95th percentile over vertices, then the maximum over frames.
    pub error_metres: f32,
}

/// Palettes of one clip at one level at equal distances in time, each to be shown as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CachedSteps {
    /// Number of palettes: the first at 0, the last at the clip's end, one if that is 0.
    pub count: u32,
    /// Index of the first matrix of the first palette. Further palettes follow without gaps.
    pub first_matrix: u32,
    /// Distance in metres between the skin of the nearest palette and that of the same level
    /// evaluated, as of [`CachedKeys::error_metres`].
    pub error_metres: f32,
    /// The same with a blend of the two palettes around a time; `None` if it was not measured.
    pub blend_error_metres: Option<f32>,
}

/// Matrices of all cached palettes, three rows each.
#[derive(Debug, Clone, PartialEq)]
pub enum CachedRows {
    /// [`PaletteForm::Matrix`].
    Float(Vec<[f32; 4]>),
    /// [`PaletteForm::HalfMatrix`], as bits.
    Half(Vec<[u16; 4]>),
}

impl CachedRows {
    /// Format of each matrix.
    pub(crate) fn form(&self) -> PaletteForm {
        match self {
            Self::Float(_) => PaletteForm::Matrix,
            Self::Half(_) => PaletteForm::HalfMatrix,
        }
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Float(rows) => rows.len(),
            Self::Half(rows) => rows.len(),
        }
    }
}

/// One key, or the end of a list of them at an infinite time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    time_secs: f32,
    /// One over the time to the next key, 0 at the last.
    per_sec: f32,
}

/// Keys of one clip at one level, with the table that finds them by time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    /// First of the keys; a key at an infinite time follows the last.
    first_key: u32,
    /// Index of the last key, counted from the first.
    last: u32,
    /// First of the buckets.
    first_bucket: u32,
    last_bucket: u32,
    buckets_per_sec: f32,
    first_matrix: u32,
    /// Matrices from one palette to the next.
    matrices: u32,
    error_metres: f32,
}

/// Palettes of one clip at one level at equal distances in time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Steps {
    per_sec: f32,
    last: u32,
    first_matrix: u32,
    /// Matrices from one palette to the next.
    matrices: u32,
    error_metres: f32,
    blend_error_metres: Option<f32>,
}

/// Cached palettes of one rig at key times, by clip and level, shared by all characters.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseCache {
    levels: usize,
    /// Number of matrices of a palette, by level.
    entries: Vec<usize>,
    /// By clip, then level; `None` where poses must be evaluated.
    segments: Vec<Option<Segment>>,
    /// The same of palettes that are shown as they are; empty if there are none.
    steps: Vec<Option<Steps>>,
    keys: Vec<Key>,
    /// For each bucket the last key of an earlier bucket, counted from the first key of the
    /// segment, or 0: it is at or before every time of the bucket.
    buckets: Vec<u32>,
    rows: CachedRows,
}

impl PoseCache {
    /// Combines keys and palettes. `keys` has one entry for each clip, and in it one for each
    /// level; `None` means that this clip is evaluated at this level. Palettes may be in any order.
    /// Levels of a clip with the same first matrix share palettes: those of the finest of them, of
    /// which coarser ones are the first matrices.
    ///
    /// # Errors
    /// A [`Mismatch`] if the palette is of other joint LODs, an entry is missing, times do not rise
    /// from 0 to the clip's end, an error is negative or not finite, palettes reach beyond the
    /// rows, or there are more than 2^32 matrices.
    pub fn new(
        clips: &ClipSet,
        map: &PaletteMap,
        keys: &[Vec<Option<CachedKeys>>],
        rows: CachedRows,
    ) -> Result<Self, Mismatch> {
        let (joint_lods, levels) = (clips.joint_lods(), clips.joint_lods().levels());
        if map.levels() != levels || map.places().any(|p| p >= joint_lods.joints().len()) {
            let what = "the palette was built for other joint LODs than the clip set";
            return Err(Mismatch::new("map", what));
        }
        if keys.len() != clips.clips() {
            let what = format!("{} entries for {} clips", keys.len(), clips.clips());
            return Err(Mismatch::new("keys", what));
        }
        if !rows.len().is_multiple_of(3) || rows.len() / 3 > u32::MAX as usize {
            let what = format!(
                "{} rows, expected three for each of at most 2^32 matrices",
                rows.len()
            );
            return Err(Mismatch::new("rows", what));
        }
        let mut cache = Self {
            levels,
            entries: (0..levels).map(|l| map.len(l)).collect(),
            segments: Vec::with_capacity(keys.len() * levels),
            steps: Vec::new(),
            keys: Vec::new(),
            buckets: Vec::new(),
            rows,
        };
        for (c, of_clip) in keys.iter().enumerate() {
            if of_clip.len() != levels {
                let what = format!("{} entries for {levels} levels", of_clip.len());
                return Err(Mismatch::new(format!("keys[{c}]"), what));
            }
            let firsts: Vec<_> = of_clip
                .iter()
                .map(|keys| Some(keys.as_ref()?.first_matrix))
                .collect();
            for (level, keys) in of_clip.iter().enumerate() {
                let Some(keys) = keys else {
                    cache.segments.push(None);
                    continue;
                };
                let owner = owner(&firsts, level);
                let stride = cache.entries[owner].max(cache.entries[level]);
                cache
                    .check(keys, (level, stride), clips.duration_secs(c))
                    .map_err(|e| Mismatch::new(format!("keys[{c}][{level}].{}", e.at), e.what))?;
                let shared = of_clip[owner].as_ref().filter(|_| owner < level);
                let segment = match cache.segments.get(c * levels + owner) {
                    Some(Some(of_owner))
                        if shared.is_some_and(|s| s.times_secs == keys.times_secs) =>
                    {
                        Segment {
                            error_metres: keys.error_metres,
                            ..*of_owner
                        }
                    }
                    _ => cache.add(keys, stride),
                };
                cache.segments.push(Some(segment));
            }
        }
        Ok(cache)
    }

    fn check(&self, keys: &CachedKeys, of: (usize, usize), end_secs: f32) -> Result<(), Mismatch> {
        let times = &keys.times_secs;
        let ends = times.first() == Some(&0.0) && times.last() == Some(&end_secs);
        if !ends || !times.windows(2).all(|w| w[0] < w[1]) {
            let what = format!("must rise from 0 to the clip's end at {end_secs} s");
            return Err(Mismatch::new("times_secs", what));
        }
        self.check_palettes(times.len(), keys.first_matrix, keys.error_metres, of)
    }

    /// Checks the error of so many palettes of a level, which are so many matrices apart, and that they
    /// are stored.
    fn check_palettes(
        &self,
        count: usize,
        first_matrix: u32,
        error_metres: f32,
        (level, stride): (usize, usize),
    ) -> Result<(), Mismatch> {
        if !error_metres.is_finite() || error_metres < 0.0 {
            let what = "must be finite and not negative";
            return Err(Mismatch::new("error_metres", what));
        }
        let matrices = self.rows.len() / 3;
        let before = count.saturating_sub(1).saturating_mul(stride);
        let needed = before.saturating_add(self.entries[level]);
        if needed.saturating_add(first_matrix as usize) > matrices {
            let what = format!(
                "{needed} matrices from index {first_matrix} exceed the {matrices} that are stored"
            );
            return Err(Mismatch::new("first_matrix", what));
        }
        Ok(())
    }

    /// Adds palettes that are shown as they are. `steps` has an entry for each clip, and in it one
    /// for each level; `None` means that no palette is. Levels share palettes as those of keys do.
    ///
    /// # Errors
    /// A [`Mismatch`] if `clips` are others than those of the cache, an entry is missing, there are
    /// no palettes or a single one for a clip that takes time, an error is negative or not finite,
    /// or palettes reach beyond the rows.
    pub fn with_steps(
        mut self,
        clips: &ClipSet,
        steps: &[Vec<Option<CachedSteps>>],
    ) -> Result<Self, Mismatch> {
        if clips.clips() != self.clips() || steps.len() != self.clips() {
            let what = format!("{} entries for {} clips", steps.len(), self.clips());
            return Err(Mismatch::new("steps", what));
        }
        let mut all = Vec::with_capacity(self.segments.len());
        for (c, of_clip) in steps.iter().enumerate() {
            if of_clip.len() != self.levels {
                let what = format!("{} entries for {} levels", of_clip.len(), self.levels);
                return Err(Mismatch::new(format!("steps[{c}]"), what));
            }
            let firsts: Vec<_> = of_clip
                .iter()
                .map(|s| Some(s.as_ref()?.first_matrix))
                .collect();
            for (level, steps) in of_clip.iter().enumerate() {
                let stride = self.entries[owner(&firsts, level)].max(self.entries[level]);
                let of = (level, stride);
                let made = steps.map(|s| self.placed(s, of, clips.duration_secs(c)));
                let made = made
                    .transpose()
                    .map_err(|e| Mismatch::new(format!("steps[{c}][{level}].{}", e.at), e.what))?;
                all.push(made);
            }
        }
        self.steps = all;
        Ok(self)
    }

    fn placed(
        &self,
        steps: CachedSteps,
        of: (usize, usize),
        end_secs: f32,
    ) -> Result<Steps, Mismatch> {
        let CachedSteps {
            count,
            first_matrix,
            error_metres,
            blend_error_metres,
        } = steps;
        if count == 0 || count == 1 && end_secs > 0.0 {
            let what =
                format!("{count} palettes for {end_secs} s, from the first to the last time");
            return Err(Mismatch::new("count", what));
        }
        for error_metres in blend_error_metres.into_iter().chain([error_metres]) {
            self.check_palettes(count as usize, first_matrix, error_metres, of)?;
        }
        let per_sec = (count - 1) as f32 / end_secs;
        Ok(Steps {
            // A clip of almost no duration shows the first palette.
            per_sec: if per_sec.is_finite() { per_sec } else { 0.0 },
            last: count - 1,
            first_matrix,
            matrices: of.1 as u32,
            error_metres,
            blend_error_metres,
        })
    }

    /// Adds checked keys, whose palettes are so many matrices apart, and the table that finds them.
    fn add(&mut self, keys: &CachedKeys, stride: usize) -> Segment {
        let times = &keys.times_secs;
        let last = times.len() - 1;
        let least = times
            .windows(2)
            .map(|w| w[1] - w[0])
            .fold(f32::MAX, f32::min);
        // Enough buckets that none is longer than the shortest span, up to a limit.
        let wanted = (times[last] / least).ceil() as usize;
        let count = wanted.clamp(1, BUCKETS_PER_KEY * times.len());
        let mut segment = Segment {
            first_key: self.keys.len() as u32,
            last: last as u32,
            first_bucket: self.buckets.len() as u32,
            last_bucket: count as u32 - 1,
            buckets_per_sec: if last == 0 {
                0.0
            } else {
                count as f32 / times[last]
            },
            first_matrix: keys.first_matrix,
            matrices: stride as u32,
            error_metres: keys.error_metres,
        };
        if !segment.buckets_per_sec.is_finite() {
            // A clip of almost no duration: every time is in the only bucket.
            segment.buckets_per_sec = 0.0;
        }
        for (k, time) in times.iter().enumerate() {
            let next = times.get(k + 1);
            self.keys.push(Key {
                time_secs: *time,
                per_sec: next.map_or(0.0, |next| 1.0 / (next - time)),
            });
        }
        self.keys.push(Key {
            time_secs: f32::INFINITY,
            per_sec: 0.0,
        });
        // A key of an earlier bucket lies before every time of a later one, however times are
        // rounded, because the bucket never falls as the time rises.
        let mut behind = 0;
        for bucket in 0..count as u32 {
            while behind < last && segment.bucket(times[behind + 1]) < bucket {
                behind += 1;
            }
            self.buckets.push(behind as u32);
        }
        segment
    }

    /// Number of clips.
    pub(crate) fn clips(&self) -> usize {
        self.segments.len() / self.levels
    }

    /// Number of joint LODs, whether cached or not.
    pub(crate) fn levels(&self) -> usize {
        self.levels
    }

    /// Format of the palettes.
    pub fn form(&self) -> PaletteForm {
        self.rows.form()
    }

    /// All cached palettes, for upload: three rows per matrix.
    pub fn rows(&self) -> &CachedRows {
        &self.rows
    }

    /// Number of matrices of one palette of a level.
    pub fn matrices(&self, level: usize) -> usize {
        self.entries[level]
    }

    /// Size of palettes, keys and tables in bytes.
    pub fn bytes(&self) -> usize {
        self.rows.len() / 3 * self.form().bytes()
            + size_of_val(self.keys.as_slice())
            + size_of_val(self.buckets.as_slice())
            + size_of_val(self.segments.as_slice())
            + size_of_val(self.steps.as_slice())
    }

    /// Error in metres that blending adds to the level's own; `None` if poses of this clip and
    /// level must be evaluated.
    ///
    /// # Panics
    /// If there is no such clip or level.
    #[inline]
    pub fn error_metres(&self, clip: usize, level: usize) -> Option<f32> {
        self.segment(clip, level).map(|s| s.error_metres)
    }

    /// Error in metres that showing the [nearest](PoseCache::nearest) palette as it is adds to the
    /// level's own; `None` if no palette of this clip and level is.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn step_error_metres(&self, clip: usize, level: usize) -> Option<f32> {
        self.steps_of(clip, level).map(|s| s.error_metres)
    }

    /// Error in metres that the blend of a [record](PoseCache::record) adds to the level's own; `None` if
    /// poses of this clip and level must be evaluated.
    ///
    /// # Panics
    /// If there is no such clip or level.
    #[inline]
    pub fn record_error_metres(&self, clip: usize, level: usize) -> Option<f32> {
        let of_keys = self.error_metres(clip, level);
        let of_steps = self.step_blend_error_metres(clip, level);
        of_keys.into_iter().chain(of_steps).reduce(f32::min)
    }

    /// Times of the keys of a clip at a level in seconds; `None` as in [`PoseCache::error_metres`].
    ///
    /// # Panics
    /// If there is no such clip or level.
    pub fn times_secs(
        &self,
        clip: usize,
        level: usize,
    ) -> Option<impl ExactSizeIterator<Item = f32> + '_> {
        self.segment(clip, level).map(|s| {
            let first = s.first_key as usize;
            let keys = &self.keys[first..=first + s.last as usize];
            keys.iter().map(|k| k.time_secs)
        })
    }

    /// Finds the two cached palettes around a time of a clip at a level, and the blend between
    /// them, for character 0; `None` if the pose must be evaluated.
    ///
    /// Times before the first or after the last key show that key; NaN counts as 0. The key is
    /// found through a table: O(1) while the shortest span is at least an eighth of the mean, a few
    /// more steps otherwise. Does not allocate.
    ///
    /// # Panics
    /// If there is no such clip or level.
    #[inline]
    pub fn locate(&self, clip: usize, level: usize, time_secs: f32) -> Option<BlendRecord> {
        let segment = self.segment(clip, level)?;
        let first = segment.first_key as usize;
        let keys = &self.keys[first..=first + segment.last as usize + 1];
        // NaN falls through `max` to 0.
        let time = time_secs
            .max(0.0)
            .min(keys[segment.last as usize].time_secs);
        let bucket = segment.first_bucket + segment.bucket(time);
        let mut key = self.buckets[bucket as usize] as usize;
        while keys[key + 1].time_secs <= time {
            key += 1;
        }
        let Key { time_secs, per_sec } = keys[key];
        let before = segment.first_matrix + key as u32 * segment.matrices;
        let is_last = key as u32 == segment.last;
        Some(BlendRecord {
            before,
            after: if is_last {
                before
            } else {
                before + segment.matrices
            },
            blend: ((time - time_secs) * per_sec).min(1.0),
            character: 0,
        })
    }

    /// Index of the first matrix of the palette that is shown as it is at a time of a clip at a level:
    /// the nearest, half-way between two the later one; `None` if none is.
    ///
    /// Times before the first or after the last show that palette; NaN counts as 0. O(1), does not
    /// allocate.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn nearest(&self, clip: usize, level: usize, time_secs: f32) -> Option<u32> {
        let steps = self.steps_of(clip, level)?;
        // The conversion saturates, and makes 0 of NaN.
        let step = (time_secs * steps.per_sec + 0.5) as u32;
        Some(steps.first_matrix + step.min(steps.last) * steps.matrices)
    }

    /// Finds the two palettes at equal distances in time around a time of a clip at a level, and the
    /// blend between them, for character 0; `None` if there are none.
    ///
    /// Times before the first or after the last show that palette; NaN counts as 0. O(1), does not
    /// allocate.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn between_steps(&self, clip: usize, level: usize, time_secs: f32) -> Option<BlendRecord> {
        let steps = self.steps_of(clip, level)?;
        // NaN falls through `max` to 0.
        let at = (time_secs * steps.per_sec).max(0.0).min(steps.last as f32);
        let step = at as u32;
        let before = steps.first_matrix + step * steps.matrices;
        let is_last = step == steps.last;
        Some(BlendRecord {
            before,
            after: if is_last {
                before
            } else {
                before + steps.matrices
            },
            blend: at - step as f32,
            character: 0,
        })
    }

    /// Finds the two cached palettes around a time of a clip at a level whose blend is closer to the
    /// motion, those of keys or those at equal distances in time, and the blend between them, for
    /// character 0; `None` if the pose must be evaluated. Otherwise as [`PoseCache::locate`].
    ///
    /// # Panics
    /// If there is no such clip or level.
    #[inline]
    pub fn record(&self, clip: usize, level: usize, time_secs: f32) -> Option<BlendRecord> {
        let of_keys = self.error_metres(clip, level).unwrap_or(f32::INFINITY);
        let of_steps = self.step_blend_error_metres(clip, level);
        match of_steps {
            Some(of_steps) if of_steps < of_keys => self.between_steps(clip, level, time_secs),
            _ => self.locate(clip, level, time_secs),
        }
    }

    #[inline]
    fn step_blend_error_metres(&self, clip: usize, level: usize) -> Option<f32> {
        self.steps_of(clip, level)?.blend_error_metres
    }

    #[inline]
    fn steps_of(&self, clip: usize, level: usize) -> Option<&Steps> {
        assert!(level < self.levels, "the level is out of range");
        self.steps.get(clip * self.levels + level)?.as_ref()
    }

    #[inline]
    fn segment(&self, clip: usize, level: usize) -> Option<&Segment> {
        assert!(level < self.levels, "the level is out of range");
        self.segments[clip * self.levels + level].as_ref()
    }

    /// Writes the palettes of characters at one level, one after the other: each the linear blend
    /// of the two in its record, and at a key exactly the palette of the key.
    ///
    /// O(matrices); does not allocate. All backends give the same bits.
    ///
    /// # Panics
    /// If `out` does not have the length of these palettes and the kind of floats of the cache, or
    /// a record is of another cache or level.
    pub fn blend(
        &self,
        level: usize,
        records: &[BlendRecord],
        backend: Backend,
        out: PaletteRows<'_>,
    ) {
        let stride = self.entries[level] * 3;
        assert_eq!(
            out.len(),
            records.len() * stride,
            "the output must hold every palette"
        );
        match (&self.rows, out) {
            (CachedRows::Float(rows), PaletteRows::Float(out)) => dispatch(
                backend,
                Blend {
                    rows,
                    stride,
                    records,
                    out,
                },
            ),
            (CachedRows::Half(rows), PaletteRows::Half(out)) => dispatch(
                backend,
                Blend {
                    rows,
                    stride,
                    records,
                    out,
                },
            ),
            _ => panic!("the float type of the rows must match the palette form"),
        }
    }
}

/// The finest level of a clip with the same first matrix as a level.
fn owner(firsts: &[Option<u32>], level: usize) -> usize {
    let same = |first: &Option<u32>| first.is_some() && *first == firsts[level];
    firsts.iter().position(same).unwrap_or(level)
}

impl Segment {
    /// Bucket of a non-negative time; never falls as the time rises.
    #[inline]
    fn bucket(&self, time_secs: f32) -> u32 {
        ((time_secs * self.buckets_per_sec) as u32).min(self.last_bucket)
    }
}

/// Kernel that blends palettes of one kind of floats.
struct Blend<'a, R> {
    rows: &'a [R],
    /// Rows of a palette.
    stride: usize,
    records: &'a [BlendRecord],
    out: &'a mut [R],
}

// No closures around lanes: they would be compiled without the backend's instructions.

impl<'a, R: Copy> Blend<'a, R> {
    /// The two palettes of a record; `None` if the first is shown as it is.
    #[inline(always)]
    fn palettes(&self, record: &BlendRecord) -> (&'a [R], Option<&'a [R]>) {
        let before = &self.rows[record.before as usize * 3..][..self.stride];
        if record.blend == 0.0 || record.before == record.after {
            return (before, None);
        }
        let after = &self.rows[record.after as usize * 3..][..self.stride];
        (before, Some(after))
    }
}

impl Kernel for Blend<'_, Row> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (i, record) in self.records.iter().enumerate() {
            let (before, after) = self.palettes(record);
            let out = &mut self.out[i * self.stride..][..self.stride];
            match after {
                None => out.copy_from_slice(before),
                Some(after) => blend_floats(before, after, record.blend, out),
            }
        }
    }
}

#[inline(always)]
fn blend_floats(before: &[Row], after: &[Row], weight: f32, out: &mut [Row]) {
    let ends = before.as_flattened().iter().zip(after.as_flattened());
    for (out, (a, b)) in out.as_flattened_mut().iter_mut().zip(ends) {
        *out = a + (b - a) * weight;
    }
}

impl Kernel for Blend<'_, [u16; 4]> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (i, record) in self.records.iter().enumerate() {
            let (before, after) = self.palettes(record);
            let out = &mut self.out[i * self.stride..][..self.stride];
            match after {
                None => out.copy_from_slice(before),
                Some(after) => blend_halves::<L>(before, after, record.blend, out),
            }
        }
    }
}

#[inline(always)]
fn blend_halves<L: Lanes>(a: &[[u16; 4]], b: &[[u16; 4]], weight: f32, out: &mut [[u16; 4]]) {
    let (a, a_rest) = a.as_flattened().as_chunks::<LANES>();
    let (b, b_rest) = b.as_flattened().as_chunks::<LANES>();
    let (out, out_rest) = out.as_flattened_mut().as_chunks_mut::<LANES>();
    for (out, (a, b)) in out.iter_mut().zip(a.iter().zip(b)) {
        L::lerp_halves(a, b, weight, out);
    }
    // Half a chunk is left of palettes with an odd number of rows.
    if !out_rest.is_empty() {
        let mut blended = [0; LANES];
        L::lerp_halves(&filled(a_rest), &filled(b_rest), weight, &mut blended);
        out_rest.copy_from_slice(&blended[..out_rest.len()]);
    }
}

/// The numbers, padded with zeros.
#[inline(always)]
fn filled(halves: &[u16]) -> [u16; LANES] {
    let mut filled = [0; LANES];
    filled[..halves.len()].copy_from_slice(halves);
    filled
}

#[cfg(test)]
mod tests;
