//! Clip set: all clips of a rig in LOD order, laid out for batched sampling.
//!
//! Source: `docs/methods/runtime.md` part 3. One frame is one row of four-number slots: first the
//! rotations that move in any clip, then translations, then scales, each in LOD order, so a level
//! reads a prefix of each. Channels that no clip moves are constants and take no slot. A slot holds
//! the four numbers of one joint rather than one component of eight joints: a batch then transposes
//! two rows of every character into lanes once, and characters that play different clips share a
//! batch.

use crate::Mismatch;
use crate::clip::{Clip, Track};
use crate::joint_lods::JointLods;
use crate::math::{Transform, normalised, same_hemisphere};
use crate::palette::rows_of;
use crate::pose::LocalPose;
use crate::rig::Rig;
use crate::simd::Row;
use glam::{Quat, Vec3, Vec4};

/// Tolerance for the noise of constant channels in files: a channel whose numbers stay within this
/// of their first ones is a constant, and a scale this near to one is one. For translations, a share
/// of the figure's extent.
const STILL: f32 = 2e-6;

/// Storage format of the numbers of a [`ClipSet`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum ClipStorage {
    /// Four `f32` per slot, 16 bytes.
    #[default]
    Float,
    /// Four 16-bit integers per slot, 8 bytes: rotations within 6.2e-5 rad, translations and scales
    /// within 1/65534 of the range that the slot covers in all clips.
    Short,
}

/// Rows of all clips, one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rows {
    Float(Vec<Row>),
    Short(Vec<[i16; 4]>),
}

/// Slots of a joint's rotation, translation and scale; `None` for a constant.
pub(crate) type TrackSlots = [Option<u32>; 3];

/// Range of a slot of 16-bit integers: `middle + step * stored`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SlotRange {
    pub(crate) middle: Vec3,
    pub(crate) step: Vec3,
}

/// One clip within the rows.
#[derive(Debug, Clone, PartialEq)]
struct Segment {
    first: u32,
    frames: u32,
    rate_hz: f32,
    /// Slots whose values hold until the next frame, rising.
    held: Vec<u32>,
}

/// A time in a clip of a [`ClipSet`], resolved to storage slots of two neighbouring frames and the
/// blend between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipCursor {
    /// First slot of the frame at or before the time.
    pub(crate) before: u32,
    /// First slot of the frame after it.
    pub(crate) after: u32,
    /// Blend between the two, 0 to 1.
    pub(crate) blend: f32,
    /// Index of the clip.
    pub(crate) clip: u32,
}

/// All clips of one rig, laid out for batches of characters.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipSet {
    joint_lods: JointLods,
    constants: Vec<Transform>,
    sources: Vec<TrackSlots>,
    moving: [Vec<u16>; 3],
    ranges: Vec<SlotRange>,
    first_range: usize,
    rows: Rows,
    slots: usize,
    segments: Vec<Segment>,
    held: Vec<u32>,
    /// Whether each joint or one above it is scaled, in LOD order.
    scaled: Vec<bool>,
    /// Rows of the constant local matrix of each joint that no clip moves, nor any joint below it, in
    /// LOD order.
    still: Vec<Option<[Row; 3]>>,
}

impl ClipSet {
    /// Lays out clips in the LOD order of `joint_lods`. A rig without clips gets one that is its
    /// rest pose, so there is always a clip.
    ///
    /// # Errors
    /// A [`Mismatch`] if the joint LODs or a clip are of another rig, a value is not finite, a
    /// rotation is not of unit length within 1e-3, or all clips together exceed 2^32 slots.
    pub fn new(
        rig: &Rig,
        joint_lods: JointLods,
        clips: &[Clip],
        storage: ClipStorage,
    ) -> Result<Self, Mismatch> {
        if joint_lods.joints().len() != rig.len() {
            let what = format!(
                "{} joints, the rig has {}",
                joint_lods.joints().len(),
                rig.len()
            );
            return Err(Mismatch::new("joint_lods", what));
        }
        for (c, clip) in clips.iter().enumerate() {
            check(clip, rig.len())
                .map_err(|e| Mismatch::new(format!("clips[{c}].{}", e.at), e.what))?;
        }
        let frames: Vec<Frames<'_>> = match clips {
            [] => vec![Frames::new(rig, None)],
            clips => clips.iter().map(|c| Frames::new(rig, Some(c))).collect(),
        };
        let rates_hz: Vec<f32> = match clips {
            [] => vec![1.0],
            clips => clips.iter().map(Clip::rate_hz).collect(),
        };
        let joints = joint_lods.joints().iter();
        let constants: Vec<Transform> = joints
            .map(|&j| {
                let mut first = frames[0].at(usize::from(j), 0);
                if first.scale.abs_diff_eq(Vec3::ONE, STILL) {
                    first.scale = Vec3::ONE;
                }
                first
            })
            .collect();
        let (sources, slots) = layout(rig, &joint_lods, &constants, &frames);
        let all: usize = frames.iter().map(Frames::len).sum();
        if all.saturating_mul(slots) > u32::MAX as usize {
            let what = format!("{all} frames of {slots} slots each exceed 2^32 values");
            return Err(Mismatch::new("clips", what));
        }
        let (rows, segments) = written(&rates_hz, &frames, &joint_lods, &sources, slots);
        let first_range = sources.iter().filter(|s| s[0].is_some()).count();
        let (rows, ranges) = match storage {
            ClipStorage::Float => (Rows::Float(rows), Vec::new()),
            ClipStorage::Short => shortened(&rows, slots, first_range),
        };
        let mut held: Vec<u32> = segments.iter().flat_map(|s| s.held.clone()).collect();
        held.sort_unstable();
        held.dedup();
        let mut scaled = vec![false; joint_lods.joints().len()];
        for (place, parent) in joint_lods.parents().iter().enumerate() {
            let own = sources[place][2].is_some() || constants[place].scale != Vec3::ONE;
            scaled[place] = own || parent.is_some_and(|p| scaled[usize::from(p)]);
        }
        let moving = std::array::from_fn(|channel| {
            let places = (0..joint_lods.joints().len()).filter(|&p| sources[p][channel].is_some());
            places.map(|p| p as u16).collect()
        });
        let still = still(&joint_lods, &constants, &sources);
        Ok(Self {
            still,
            scaled,
            moving,
            joint_lods,
            constants,
            sources,
            ranges,
            first_range,
            rows,
            slots,
            segments,
            held,
        })
    }

    /// The joint order and the number of joints of each level.
    pub fn joint_lods(&self) -> &JointLods {
        &self.joint_lods
    }

    /// Number of clips, at least 1.
    pub fn clips(&self) -> usize {
        self.segments.len()
    }

    /// Duration of a clip in seconds, the time of its last frame; 0 for a single pose.
    pub fn duration_secs(&self, clip: usize) -> f32 {
        let segment = &self.segments[clip];
        (segment.frames - 1) as f32 / segment.rate_hz
    }

    /// Whether any joint is scaled, at rest or by a clip.
    pub fn is_scaled(&self) -> bool {
        self.scaled.contains(&true)
    }

    /// Size of the frames of all clips in bytes.
    pub fn bytes(&self) -> usize {
        match &self.rows {
            Rows::Float(rows) => size_of_val(rows.as_slice()),
            Rows::Short(rows) => size_of_val(rows.as_slice()),
        }
    }

    /// Number of slots of one frame: channels that some clip moves.
    pub(crate) fn slots(&self) -> usize {
        self.slots
    }

    /// Returns the two frames around a time of a clip and the blend between them. Times before the
    /// first or after the last frame give that frame; NaN counts as 0.
    ///
    /// # Panics
    /// If there is no such clip.
    #[inline]
    pub fn cursor(&self, clip: usize, time_secs: f32) -> ClipCursor {
        let segment = &self.segments[clip];
        let last = segment.frames - 1;
        // NaN falls through `max` to 0.
        let at = (time_secs * segment.rate_hz).max(0.0).min(last as f32);
        let before = (at as u32).min(last);
        let after = (before + 1).min(last);
        let slots = self.slots as u32;
        ClipCursor {
            before: segment.first + before * slots,
            after: segment.first + after * slots,
            blend: at - before as f32,
            clip: clip as u32,
        }
    }

    /// Local transform of one joint at a cursor, computed without SIMD.
    pub(crate) fn local(&self, at: &ClipCursor, place: usize) -> Transform {
        let source = self.sources[place];
        let constant = self.constants[place];
        let slot = |slot: u32| {
            let blend = if self.is_held(at.clip, slot) {
                0.0
            } else {
                at.blend
            };
            let row = |frame: u32| {
                let at = (frame + slot) as usize;
                match &self.rows {
                    Rows::Float(rows) => Vec4::from_array(rows[at]),
                    Rows::Short(rows) => Vec4::from_array(rows[at].map(f32::from)),
                }
            };
            let (before, after) = (row(at.before), row(at.after));
            before + (after - before) * blend
        };
        let vector = |s: u32| match self.range(s as usize) {
            None => slot(s).truncate(),
            Some(range) => range.middle + slot(s).truncate() * range.step,
        };
        Transform {
            rotation: source[0].map_or(constant.rotation, |s| normalised(Quat::from_vec4(slot(s)))),
            translation: source[1].map_or(constant.translation, vector),
            scale: source[2].map_or(constant.scale, vector),
        }
    }

    /// Whether each joint or one above it is scaled, in LOD order.
    pub(crate) fn scaled(&self) -> &[bool] {
        &self.scaled
    }

    pub(crate) fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Slots of each joint's rotation, translation and scale, in LOD order.
    pub(crate) fn sources(&self) -> &[TrackSlots] {
        &self.sources
    }

    /// Places whose rotations take slots, ascending; these slots are numbered from 0.
    pub(crate) fn rotations(&self) -> &[u16] {
        &self.moving[0]
    }

    /// Places whose translations take slots, ascending, and the first of these slots.
    pub(crate) fn translations(&self) -> (&[u16], usize) {
        (&self.moving[1], self.moving[0].len())
    }

    /// Places whose scales take slots, ascending, and the first of these slots.
    pub(crate) fn scales(&self) -> (&[u16], usize) {
        let first = self.moving[0].len() + self.moving[1].len();
        (&self.moving[2], first)
    }

    /// Rows of the constant local matrix of a joint that no clip moves, nor any joint below it.
    pub(crate) fn still(&self, place: usize) -> Option<&[Row; 3]> {
        self.still[place].as_ref()
    }

    pub(crate) fn constants(&self) -> &[Transform] {
        &self.constants
    }

    /// Range of a translation or scale slot; `None` where numbers are stored as they are.
    pub(crate) fn range(&self, slot: usize) -> Option<&SlotRange> {
        self.ranges.get(slot.wrapping_sub(self.first_range))
    }

    /// Whether any clip holds the values of a slot until the next frame.
    pub(crate) fn is_held_somewhere(&self, slot: u32) -> bool {
        !self.held.is_empty() && self.held.binary_search(&slot).is_ok()
    }

    /// Whether a clip holds the values of a slot until the next frame.
    pub(crate) fn is_held(&self, clip: u32, slot: u32) -> bool {
        self.segments[clip as usize]
            .held
            .binary_search(&slot)
            .is_ok()
    }
}

/// Local matrices of the joints that are constant with all joints below them.
fn still(
    joint_lods: &JointLods,
    constants: &[Transform],
    sources: &[TrackSlots],
) -> Vec<Option<[Row; 3]>> {
    let mut moves: Vec<bool> = sources
        .iter()
        .map(|slots| slots.iter().any(Option::is_some))
        .collect();
    // Joints come after their parents.
    for (place, parent) in joint_lods.parents().iter().enumerate().rev() {
        if let Some(parent) = parent {
            moves[usize::from(*parent)] |= moves[place];
        }
    }
    let rows = |constant: &Transform| rows_of(&constant.to_affine());
    let each = constants.iter().zip(moves);
    each.map(|(constant, moves)| (!moves).then(|| rows(constant)))
        .collect()
}

fn check(clip: &Clip, joints: usize) -> Result<(), Mismatch> {
    if clip.joints() != joints {
        let what = format!(
            "the clip has {} joints, the rig has {joints}",
            clip.joints()
        );
        return Err(Mismatch::new("joints", what));
    }
    let not_finite = |which: &str| Mismatch::new(which, "every value must be finite");
    let vectors = |tracks: &[Track<Vec3>]| {
        let mut values = tracks.iter().flat_map(|t| &t.values);
        values.all(|v| v.is_finite())
    };
    if !vectors(&clip.tracks().translations) {
        return Err(not_finite("translations"));
    }
    if !vectors(&clip.tracks().scales) {
        return Err(not_finite("scales"));
    }
    let mut rotations = clip.tracks().rotations.iter().flat_map(|t| &t.values);
    // A NaN length fails too.
    if !rotations.all(|q| (q.length() - 1.0).abs() <= 1e-3) {
        return Err(Mismatch::new(
            "rotations",
            "every rotation must be of unit length",
        ));
    }
    Ok(())
}

/// Frames of one clip as transforms, joints without a track at rest.
struct Frames<'a> {
    rest: &'a LocalPose,
    clip: Option<&'a Clip>,
    rotations: Vec<Option<&'a Track<Quat>>>,
    translations: Vec<Option<&'a Track<Vec3>>>,
    scales: Vec<Option<&'a Track<Vec3>>>,
}

impl<'a> Frames<'a> {
    fn new(rig: &'a Rig, clip: Option<&'a Clip>) -> Self {
        fn by_joint<T>(tracks: &[Track<T>], joints: usize) -> Vec<Option<&Track<T>>> {
            let mut found = vec![None; joints];
            for track in tracks {
                found[usize::from(track.target)] = Some(track);
            }
            found
        }
        let n = rig.len();
        Self {
            rest: rig.rest_pose(),
            clip,
            rotations: by_joint(clip.map_or(&[], |c| &c.tracks().rotations), n),
            translations: by_joint(clip.map_or(&[], |c| &c.tracks().translations), n),
            scales: by_joint(clip.map_or(&[], |c| &c.tracks().scales), n),
        }
    }

    fn len(&self) -> usize {
        self.clip.map_or(1, Clip::frames)
    }

    fn at(&self, joint: usize, frame: usize) -> Transform {
        fn value<T: Copy>(track: Option<&Track<T>>, frame: usize, rest: T) -> T {
            track.map_or(rest, |t| t.values[frame.min(t.values.len() - 1)])
        }
        let rest = self.rest.get(joint);
        Transform {
            translation: value(self.translations[joint], frame, rest.translation),
            rotation: value(self.rotations[joint], frame, rest.rotation),
            scale: value(self.scales[joint], frame, rest.scale),
        }
    }

    /// Values of the channels of a joint in the frames of the clip; the last of each stays.
    fn channels<'s>(&'s self, joint: usize, rest: &'s Transform) -> Channels<'s> {
        fn values<'s, T>(track: Option<&'s Track<T>>, frames: usize, rest: &'s T) -> &'s [T] {
            track.map_or(std::slice::from_ref(rest), |track| {
                &track.values[..track.values.len().min(frames)]
            })
        }
        Channels {
            rotations: values(self.rotations[joint], self.len(), &rest.rotation),
            translations: values(self.translations[joint], self.len(), &rest.translation),
            scales: values(self.scales[joint], self.len(), &rest.scale),
        }
    }

    /// Whether a channel of a joint holds its values instead of blending them.
    fn holds(&self, joint: usize) -> [bool; 3] {
        fn step<T>(track: Option<&Track<T>>) -> bool {
            track.is_some_and(|t| t.step && t.values.len() > 1)
        }
        [
            step(self.rotations[joint]),
            step(self.translations[joint]),
            step(self.scales[joint]),
        ]
    }
}

/// Values of the channels of a joint in one clip, at least one of each.
struct Channels<'a> {
    rotations: &'a [Quat],
    translations: &'a [Vec3],
    scales: &'a [Vec3],
}

/// Values in as many frames, of which the last stays.
fn in_frames<T: Copy>(values: &[T], frames: usize) -> impl Iterator<Item = T> + '_ {
    let last = values.len() - 1;
    (0..frames).map(move |frame| values[frame.min(last)])
}

/// Assigns a slot to every channel that some frame moves away from its constant: rotations first,
/// then translations, then scales.
fn layout(
    rig: &Rig,
    joint_lods: &JointLods,
    constants: &[Transform],
    clips: &[Frames<'_>],
) -> (Vec<TrackSlots>, usize) {
    let extents = rig.local_extents();
    let mut moves = vec![[false; 3]; joint_lods.joints().len()];
    for (place, moves) in moves.iter_mut().enumerate() {
        let (joint, constant) = (usize::from(joint_lods.joints()[place]), constants[place]);
        let still = STILL * extents[joint];
        let rest = rig.rest_pose().get(joint);
        let turns = |q: &Quat| {
            let turned = (*q - constant.rotation).to_array();
            turned.iter().any(|c| c.abs() > STILL)
        };
        for clip in clips {
            let of = clip.channels(joint, &rest);
            let leaves = |v: &Vec3| !v.abs_diff_eq(constant.translation, still);
            let grows = |v: &Vec3| !v.abs_diff_eq(constant.scale, STILL);
            moves[0] = moves[0] || of.rotations.iter().any(turns);
            moves[1] = moves[1] || of.translations.iter().any(leaves);
            moves[2] = moves[2] || of.scales.iter().any(grows);
        }
    }
    let mut sources = vec![TrackSlots::default(); joint_lods.joints().len()];
    let mut next = 0u32;
    for channel in 0..3 {
        for (source, moves) in sources.iter_mut().zip(&moves) {
            if moves[channel] {
                source[channel] = Some(next);
                next += 1;
            }
        }
    }
    (sources, next as usize)
}

/// All clips as rows, and the segment of each.
fn written(
    rates_hz: &[f32],
    frames: &[Frames<'_>],
    joint_lods: &JointLods,
    sources: &[TrackSlots],
    slots: usize,
) -> (Vec<Row>, Vec<Segment>) {
    let mut rows: Vec<Row> = Vec::new();
    let mut segments = Vec::new();
    for (clip, rate_hz) in frames.iter().zip(rates_hz) {
        let first = rows.len();
        let count = clip.len();
        rows.resize(first + count * slots, [0.0; 4]);
        let rows_of = |slot: u32| {
            let from = first + slot as usize;
            (from..).step_by(slots.max(1))
        };
        for (place, source) in sources.iter().enumerate() {
            let joint = usize::from(joint_lods.joints()[place]);
            let rest = clip.rest.get(joint);
            let of = clip.channels(joint, &rest);
            if let Some(slot) = source[0] {
                let mut before = None;
                for (at, q) in rows_of(slot).zip(in_frames(of.rotations, count)) {
                    // In the hemisphere of the frame before, so that a linear blend takes the
                    // shorter arc.
                    let q = before.map_or(q, |before| same_hemisphere(before, q));
                    rows[at] = q.to_array();
                    before = Some(q);
                }
            }
            for (slot, values) in [(source[1], of.translations), (source[2], of.scales)] {
                let Some(slot) = slot else { continue };
                for (at, v) in rows_of(slot).zip(in_frames(values, count)) {
                    rows[at] = v.extend(0.0).to_array();
                }
            }
        }
        let mut held: Vec<u32> = sources
            .iter()
            .enumerate()
            .flat_map(|(place, source)| {
                let holds = clip.holds(usize::from(joint_lods.joints()[place]));
                (0..3).filter_map(move |c| source[c].filter(|_| holds[c]))
            })
            .collect();
        held.sort_unstable();
        segments.push(Segment {
            first: first as u32,
            frames: clip.len() as u32,
            rate_hz: *rate_hz,
            held,
        });
    }
    (rows, segments)
}

/// The rows as 16-bit integers, and the ranges of the translation and scale slots.
fn shortened(rows: &[Row], slots: usize, first_range: usize) -> (Rows, Vec<SlotRange>) {
    const LARGEST: f32 = i16::MAX as f32;
    let ranges: Vec<SlotRange> = (first_range..slots)
        .map(|slot| {
            let mut values = rows.iter().skip(slot).step_by(slots).map(vector);
            let first = values.next().unwrap_or(Vec3::ZERO);
            let (low, high) = values.fold((first, first), |(l, h), v| (l.min(v), h.max(v)));
            SlotRange {
                middle: (low + high) * 0.5,
                step: (high - low) * (0.5 / LARGEST),
            }
        })
        .collect();
    let short =
        rows.iter().enumerate().map(
            |(i, row)| match (i % slots.max(1)).checked_sub(first_range) {
                None => row.map(|v| (v * LARGEST).round() as i16),
                Some(range) => {
                    let SlotRange { middle, step } = ranges[range];
                    let steps = (vector(row) - middle) / step.max(Vec3::splat(f32::MIN_POSITIVE));
                    steps.extend(0.0).to_array().map(|v| v.round() as i16)
                }
            },
        );
    (Rows::Short(short.collect()), ranges)
}

fn vector(row: &Row) -> Vec3 {
    Vec3::new(row[0], row[1], row[2])
}
