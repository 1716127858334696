//! Clip editing, with measurements of each edit.
//!
//! The order is fixed: trim, loop, root motion, rate, then (after the reduction to a selection of
//! joints) keys. The error bound of key reduction refers to the clip just before it.

use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, Format};
use crate::resampling::played_mm;
use crate::work::Executor;
use articula_build::clip_edit::{self, EditSubject};
use articula_build::clip_edit::{CloseOptions, LoopCycle};
use articula_build::clip_edit::{ReduceOptions, ReducedClip};
use articula_build::clip_edit::{RootMotionMode, RootMotionOptions, TrajectoryKey};
use articula_core::Libm;
use articula_core::source::{Character, RawClip};
use serde::{Serialize, Serializer};

/// Edits applied to every clip of a character; the default is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClipEdits {
    /// Part of the clip that is kept.
    pub trim: Option<ClipPart>,
    /// Options for closing loops: only the part that loops best is kept, and its ends are joined; a
    /// clip without a loop is unchanged.
    pub close_loop: Option<CloseOptions>,
    /// Treatment of root motion: the horizontal movement of the hips and their heading.
    pub root_motion: Option<RootMotionOptions>,
    /// Number of keys per second in every channel.
    pub rate_hz: Option<f32>,
    /// Error bound of key reduction.
    pub reduce_keys: Option<ReduceOptions>,
}

/// A part of a clip; a missing bound is its start or end.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClipPart {
    /// Start of the part, in seconds.
    pub from_secs: Option<f32>,
    /// End of the part, in seconds.
    pub to_secs: Option<f32>,
}

/// Report of the edits of one clip; `None` for edits that were not requested.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClipEdited {
    /// The clip's name.
    pub clip: String,
    /// The part that was kept.
    pub trim: Option<Trimmed>,
    /// Result of the loop search.
    #[serde(rename = "loop")]
    pub looped: Option<Looped>,
    /// Result of the root motion edit.
    pub root_motion: Option<RootMotionEdited>,
    /// Result of resampling.
    pub rate: Option<Resampled>,
    /// Result of key reduction.
    pub reduce_keys: Option<KeysReduced>,
}

/// The part of a clip that was kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trimmed {
    /// Start of the part, in seconds.
    pub from_secs: f32,
    /// End of the part, in seconds.
    pub to_secs: f32,
    /// Duration of the trimmed clip, in seconds.
    pub duration_secs: f32,
}

/// Result of the loop search; the clip is unchanged unless a loop was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Looped {
    /// Whether it is a loop.
    pub is_loop: bool,
    /// Whether the whole clip is the loop.
    pub is_whole: bool,
    /// The part that loops best; `None` if the clip is too short or too static to repeat.
    pub part: Option<LoopPart>,
    /// Minimum score of a loop.
    pub min_score: f32,
    /// Result of closing, if a loop was found.
    pub closed: Option<LoopClosed>,
}

/// A part of a clip, and the discontinuity from its end to its start before closing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopPart {
    /// Start of the part, in seconds.
    pub start_secs: f32,
    /// End of the part, in seconds.
    pub end_secs: f32,
    /// Duration of the part, in seconds.
    pub period_secs: f32,
    /// Maximum distance of a joint between end and start, in metres.
    pub seam_m: f32,
    /// Root mean square distance of the joints between end and start, in metres.
    pub seam_rms_m: f32,
    /// Root mean square difference of the joints' velocities, in metres per second.
    pub seam_m_per_sec: f32,
    /// 1 for a perfect loop, 0 for a jump as between two arbitrary times of the clip.
    pub score: f32,
}

/// Result of closing a loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopClosed {
    /// Duration at either end over which the discontinuity was distributed, in seconds.
    pub window_secs: f32,
    /// Maximum distance that closing moved any joint, in metres.
    pub moved_m: f32,
    /// Horizontal distance travelled per cycle, in metres.
    pub travel_m: f32,
    /// Turn per cycle, in degrees.
    pub turn_deg: f32,
    /// Maximum remaining angle between the first and the last pose, in degrees.
    pub seam_deg: f32,
}

/// Root motion of a clip and how it was edited.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RootMotionEdited {
    /// The requested mode.
    #[serde(serialize_with = "mode_name")]
    pub mode: RootMotionMode,
    /// Name of the joint whose motion it is.
    pub hips: String,
    /// Name of the joint above the hips that can carry root motion; `None` if there is none.
    pub carrier: Option<String>,
    /// Distance from the first frame to the last, in metres.
    pub travel_m: f32,
    /// Length of the trajectory, in metres.
    pub path_m: f32,
    /// Turn from the first frame to the last, in degrees.
    pub turn_deg: f32,
    /// Maximum distance of any joint from its source after adding the trajectory back, in metres.
    pub worst_m: f32,
    /// The trajectory, key by key.
    pub trajectory: Vec<TrajectoryPlace>,
}

/// Horizontal position and heading of the hips relative to the first frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrajectoryPlace {
    /// Time in seconds.
    pub secs: f32,
    /// Displacement along +X, in metres.
    pub x_m: f32,
    /// Displacement along +Z, in metres.
    pub z_m: f32,
    /// Heading in degrees, from +Z towards +X.
    pub yaw_deg: f32,
}

/// Result of resampling a clip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resampled {
    /// Keys per second.
    pub rate_hz: f32,
    /// Greatest displacement of the skin from the clip before in millimetres; of joints where there is
    /// no mesh.
    pub resampling_mm: f64,
    /// Number of keys in all channels before.
    pub keys_before: usize,
    /// Number of keys in all channels after.
    pub keys_after: usize,
}

/// Result of key reduction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KeysReduced {
    /// The error bound, in metres.
    pub bound_m: f32,
    /// Maximum distance of any joint or skin point from the clip before, in metres.
    pub worst_m: f32,
    /// Number of times at which the error was measured, between keys too.
    pub times_verified: usize,
    /// Number of channels before.
    pub channels_before: usize,
    /// Number of channels after.
    pub channels_after: usize,
    /// Number of keys before.
    pub keys_before: usize,
    /// Number of keys after.
    pub keys_after: usize,
    /// Size of times and values as 32-bit floats before, in bytes.
    pub animation_bytes_before: usize,
    /// Size of times and values as 32-bit floats after, in bytes.
    pub animation_bytes_after: usize,
}

impl ClipEdits {
    /// Checks that a format can represent clips edited in this way.
    ///
    /// # Errors
    /// [`Error::Argument`] that names the edit and an alternative.
    pub fn check(&self, to: Format) -> Result<()> {
        if self.reduce_keys.is_some() && to.holds_one_clip() {
            return Err(Error::argument(format!(
                "a .{} file stores every joint in every frame, so keys cannot be reduced; write \
                 .glb or do not reduce keys",
                to.name()
            )));
        }
        let extracts = |root: RootMotionOptions| root.mode == RootMotionMode::Extract;
        if self.root_motion.is_some_and(extracts) && to == Format::Vrma {
            return Err(Error::argument(
                "a .vrma file cannot store a root joint above the hips; use in-place root motion",
            ));
        }
        Ok(())
    }

    /// Returns whether any edit is requested.
    pub fn asks(&self) -> bool {
        *self != Self::default()
    }

    /// Applies all edits except key reduction; returns one report per clip, or none if no edit is
    /// requested.
    pub(super) fn apply(
        &self,
        opened: &mut CharacterFile,
        work: &Executor<'_>,
    ) -> Result<Vec<ClipEdited>> {
        if !self.asks() {
            return Ok(Vec::new());
        }
        let place = opened.name().to_owned();
        let subject = subject(opened).with_context(|| &place)?;
        let character = opened.character();
        let edit = |clip: &RawClip| {
            let mut clip = clip.clone();
            let edited = self.edit(character, &subject, &mut clip);
            Ok((clip, edited.with_context(|| &place)?))
        };
        let clips = opened.character().clips.iter().collect();
        let done = work.map("editing clips", clips, edit)?;
        let (clips, edits) = done.into_iter().unzip();
        opened.set_clips(clips);
        Ok(edits)
    }

    fn edit(
        &self,
        character: &Character,
        subject: &EditSubject<'_>,
        clip: &mut RawClip,
    ) -> Result<ClipEdited> {
        Ok(ClipEdited {
            clip: clip.name.clone(),
            trim: self.trim.map(|part| part.trim(clip)).transpose()?,
            looped: self
                .close_loop
                .map(|options| looped(subject, clip, &options))
                .transpose()?,
            root_motion: self
                .root_motion
                .map(|options| root_motion(subject, clip, &options))
                .transpose()?,
            rate: self
                .rate_hz
                .map(|rate| resample(character, clip, rate))
                .transpose()?,
            reduce_keys: None,
        })
    }

    /// Applies key reduction, after everything else.
    pub(super) fn reduce_keys(
        &self,
        opened: &mut CharacterFile,
        edits: &mut [ClipEdited],
        work: &Executor<'_>,
    ) -> Result<()> {
        let Some(options) = self.reduce_keys else {
            return Ok(());
        };
        let place = opened.name().to_owned();
        let subject = subject(opened).with_context(|| &place)?;
        let one = |(clip, edited): (&RawClip, &mut ClipEdited)| {
            let out = clip_edit::reduce_keys(&subject, clip, &options);
            let out = out.with_context(|| &place)?;
            edited.reduce_keys = Some(KeysReduced::new(options.bound_metres, &out));
            Ok(out.clip)
        };
        let clips = opened.character().clips.iter().zip(edits).collect();
        let reduced = work.map("reducing keys", clips, one)?;
        opened.set_clips(reduced);
        Ok(())
    }
}

fn subject(opened: &CharacterFile) -> Result<EditSubject<'_>> {
    let articulation = opened.articulation();
    Ok(EditSubject::new(
        opened.character(),
        articulation,
        opened.end_sites(),
    )?)
}

/// Cuts a clip to its loop and closes it, if it has one.
fn looped(subject: &EditSubject<'_>, clip: &mut RawClip, options: &CloseOptions) -> Result<Looped> {
    let part = clip_edit::find_loop(subject, clip)?;
    let is_loop = part.is_some_and(|p| p.is_loop);
    let mut closed = None;
    if let Some(part) = part.filter(|_| is_loop) {
        *clip = clip_edit::trim(clip, part.start_secs..=part.end_secs)?;
        let out = clip_edit::close_loop(subject, clip, options)?;
        *clip = out.clip;
        closed = Some(LoopClosed {
            window_secs: out.window_secs,
            moved_m: out.moved_metres,
            travel_m: out.travel_metres,
            turn_deg: out.turn_radians.to_degrees(),
            seam_deg: out.seam_radians.to_degrees(),
        });
    }
    let told = |part: LoopCycle| LoopPart {
        start_secs: part.start_secs,
        end_secs: part.end_secs,
        period_secs: part.end_secs - part.start_secs,
        seam_m: part.seam_metres,
        seam_rms_m: part.seam_rms_metres,
        seam_m_per_sec: part.seam_metres_per_sec,
        score: part.score,
    };
    Ok(Looped {
        is_loop,
        is_whole: part.is_some_and(|p| p.is_whole),
        part: part.map(told),
        min_score: clip_edit::MIN_SCORE,
        closed,
    })
}

fn root_motion(
    subject: &EditSubject<'_>,
    clip: &mut RawClip,
    options: &RootMotionOptions,
) -> Result<RootMotionEdited> {
    let out = clip_edit::split_root_motion(subject, clip, options)?;
    *clip = out.clip;
    let way = |a: &TrajectoryKey, b: &TrajectoryKey| {
        (a.x_metres - b.x_metres).libm_hypot(a.z_metres - b.z_metres)
    };
    let last = out.trajectory.last().copied().unwrap_or_default();
    let place = |key: &TrajectoryKey| TrajectoryPlace {
        secs: key.secs,
        x_m: key.x_metres,
        z_m: key.z_metres,
        yaw_deg: key.yaw_radians.to_degrees(),
    };
    Ok(RootMotionEdited {
        mode: options.mode,
        hips: subject.joint_name(out.hips).to_owned(),
        carrier: out.carrier.map(|j| subject.joint_name(j).to_owned()),
        travel_m: way(&last, &TrajectoryKey::default()),
        path_m: out.trajectory.windows(2).map(|w| way(&w[1], &w[0])).sum(),
        turn_deg: last.yaw_radians.to_degrees(),
        worst_m: out.worst_metres,
        trajectory: out.trajectory.iter().map(place).collect(),
    })
}

fn keys(clip: &RawClip) -> usize {
    clip.channels.iter().map(|c| c.times_secs.len()).sum()
}

fn resample(character: &Character, clip: &mut RawClip, rate_hz: f32) -> Result<Resampled> {
    let keys_before = keys(clip);
    let before = clip.clone();
    *clip = clip_edit::resample_keys(clip, rate_hz)?;
    Ok(Resampled {
        rate_hz,
        resampling_mm: played_mm(character, &before, clip, rate_hz)?,
        keys_before,
        keys_after: keys(clip),
    })
}

impl ClipPart {
    fn trim(self, clip: &mut RawClip) -> Result<Trimmed> {
        let from_secs = self.from_secs.unwrap_or(0.0);
        let to_secs = self.to_secs.unwrap_or(clip.duration_secs);
        *clip = clip_edit::trim(clip, from_secs..=to_secs).context("trim")?;
        Ok(Trimmed {
            from_secs,
            to_secs,
            duration_secs: clip.duration_secs,
        })
    }
}

impl KeysReduced {
    fn new(bound_metres: f32, out: &ReducedClip) -> Self {
        let (before, after) = (out.before, out.after);
        Self {
            bound_m: bound_metres,
            worst_m: out.worst_metres,
            times_verified: out.times,
            channels_before: before.channels,
            channels_after: after.channels,
            keys_before: before.keys,
            keys_after: after.keys,
            animation_bytes_before: before.bytes,
            animation_bytes_after: after.bytes,
        }
    }
}

fn mode_name<S: Serializer>(mode: &RootMotionMode, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(match mode {
        RootMotionMode::Keep => "keep",
        RootMotionMode::Extract => "extract",
        RootMotionMode::InPlace => "in-place",
    })
}
