//! Clips made clean, and what that did in numbers.
//!
//! The order is fixed: trim, loop, root motion, rate, then (after the reduction to a selection of
//! joints) keys. The bound of the keys is against what they stood for just before.

use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, Format};
use crate::work::Executor;
use articula_build::clip_edit::{self, EditSubject};
use articula_build::clip_edit::{CloseOptions, LoopCycle};
use articula_build::clip_edit::{ReduceOptions, ReducedClip};
use articula_build::clip_edit::{RootMotionMode, RootMotionOptions, TrajectoryKey};
use articula_core::source::RawClip;
use serde::{Serialize, Serializer};

/// What is done with every clip of a character; the default is nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClipEdits {
    /// The part that is kept.
    pub trim: Option<ClipPart>,
    /// How the ends are made to meet of the part that loops best, which alone is kept; a clip
    /// without a loop stays as it is.
    pub close_loop: Option<CloseOptions>,
    /// What becomes of the way of the hips over the ground and of their heading.
    pub root_motion: Option<RootMotionOptions>,
    /// Keys of every channel a second.
    pub rate_hz: Option<f32>,
    /// How far anything may move when keys are dropped.
    pub reduce_keys: Option<ReduceOptions>,
}

/// A part of a clip; without a bound, from its start or to its end.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClipPart {
    /// Where it starts.
    pub from_secs: Option<f32>,
    /// Where it ends.
    pub to_secs: Option<f32>,
}

/// What was done with one clip; `None` what was not asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClipEdited {
    /// The clip's name.
    pub clip: String,
    /// The part that was kept.
    pub trim: Option<Trimmed>,
    /// The loop that was looked for.
    #[serde(rename = "loop")]
    pub looped: Option<Looped>,
    /// What became of root motion.
    pub root_motion: Option<RootMotionEdited>,
    /// The new rate.
    pub rate: Option<Resampled>,
    /// The keys that were dropped.
    pub reduce_keys: Option<KeysReduced>,
}

/// The part of a clip that was kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trimmed {
    /// Where it started.
    pub from_secs: f32,
    /// Where it ended.
    pub to_secs: f32,
    /// Its length as it is now.
    pub duration_secs: f32,
}

/// The part of a clip that loops best; unless it is a loop, the clip stayed as it was.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Looped {
    /// Whether it is a loop.
    pub is_loop: bool,
    /// Whether it is the whole clip, whose ends met from the start.
    pub is_whole: bool,
    /// `None` for a clip that is too short or too still to repeat anything.
    pub part: Option<LoopPart>,
    /// The lowest score of a loop.
    pub score_least: f32,
    /// How it was closed, if it is a loop.
    pub closed: Option<LoopClosed>,
}

/// A part of a clip, and how its end goes over into its start before it is closed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopPart {
    /// Where it starts.
    pub start_secs: f32,
    /// Where it ends.
    pub end_secs: f32,
    /// Its length.
    pub period_secs: f32,
    /// Greatest jump of a joint from the end to the start, metres.
    pub seam_m: f32,
    /// Root mean square of the joints' jumps, metres.
    pub seam_rms_m: f32,
    /// Root mean square of the jumps of their velocities.
    pub seam_m_per_sec: f32,
    /// 1 for a perfect loop, 0 for one that jumps as between any two moments of the clip.
    pub score: f32,
}

/// A loop that was closed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopClosed {
    /// Time at either end over which the seam was shared.
    pub window_secs: f32,
    /// Greatest distance that any joint was moved by closing, metres.
    pub moved_m: f32,
    /// Way of one round over the ground, metres.
    pub travel_m: f32,
    /// Turn of one round, degrees.
    pub turn_deg: f32,
    /// Greatest angle that is left between the first and the last pose, degrees.
    pub seam_deg: f32,
}

/// The way of the hips over the ground, and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RootMotionEdited {
    /// What was asked for.
    #[serde(serialize_with = "mode_name")]
    pub mode: RootMotionMode,
    /// Name of the joint whose way it is.
    pub hips: String,
    /// The joint above the hips that can carry it; `None` if none can.
    pub carrier: Option<String>,
    /// Distance from the first frame to the last, metres.
    pub travel_m: f32,
    /// Length of the way itself, metres.
    pub path_m: f32,
    /// Turn from the first frame to the last, degrees.
    pub turn_deg: f32,
    /// Greatest distance of any joint from its source, the trajectory put back, metres.
    pub worst_m: f32,
    /// The way, key by key.
    pub trajectory: Vec<TrajectoryPlace>,
}

/// Where the hips are over the ground, against the first frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrajectoryPlace {
    /// When.
    pub secs: f32,
    /// Along +X, metres.
    pub x_m: f32,
    /// Along +Z, metres.
    pub z_m: f32,
    /// Heading, degrees from +Z towards +X.
    pub yaw_deg: f32,
}

/// A clip keyed at a rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resampled {
    /// The rate.
    pub rate_hz: f32,
    /// Keys of all channels as it was.
    pub keys_before: usize,
    /// Keys of all channels as it is.
    pub keys_after: usize,
}

/// A clip with fewer keys.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KeysReduced {
    /// The bound that was given, metres.
    pub bound_m: f32,
    /// Greatest distance of any joint or skin from where the clip had it, metres.
    pub worst_m: f32,
    /// Times at which that was measured, between keys too.
    pub times_verified: usize,
    /// Channels as it was.
    pub channels_before: usize,
    /// Channels as it is.
    pub channels_after: usize,
    /// Keys as it was.
    pub keys_before: usize,
    /// Keys as it is.
    pub keys_after: usize,
    /// Times and values as 32-bit floats, as it was.
    pub animation_bytes_before: usize,
    /// The same as it is.
    pub animation_bytes_after: usize,
}

impl ClipEdits {
    /// Whether clips edited so can be shown in a format.
    ///
    /// # Errors
    /// [`Error::Argument`] that says which cannot, and what would do.
    pub fn check(&self, to: Format) -> Result<()> {
        if self.reduce_keys.is_some() && to.holds_one_clip() {
            return Err(Error::argument(format!(
                "a .{} file stores every joint in every frame; write .glb, or leave it out",
                to.name()
            )));
        }
        let extracts = |root: RootMotionOptions| root.mode == RootMotionMode::Extract;
        if self.root_motion.is_some_and(extracts) && to == Format::Vrma {
            return Err(Error::argument(
                "a .vrma file moves the bones of a humanoid alone, and the hips are the first of them; use in-place",
            ));
        }
        Ok(())
    }

    /// Whether anything is to be done.
    pub fn asks(&self) -> bool {
        *self != Self::default()
    }

    /// Does all but the keys; gives one entry for each clip, or none if nothing is asked for.
    pub(super) fn apply(
        &self,
        opened: &mut CharacterFile,
        work: &Executor<'_>,
    ) -> Result<Vec<ClipEdited>> {
        if !self.asks() {
            return Ok(Vec::new());
        }
        let place = opened.name.clone();
        let subject = subject(opened).with_context(|| &place)?;
        let edit = |clip: &RawClip| {
            let mut clip = clip.clone();
            let edited = self.edit(&subject, &mut clip);
            Ok((clip, edited.with_context(|| &place)?))
        };
        let clips = opened.character.clips.iter().collect();
        let done = work.map("editing clips", clips, edit)?;
        let (clips, edits) = done.into_iter().unzip();
        let edits: Vec<ClipEdited> = edits;
        opened.character.clips = clips;
        opened.clips_changed |= !edits.is_empty();
        Ok(edits)
    }

    fn edit(&self, subject: &EditSubject<'_>, clip: &mut RawClip) -> Result<ClipEdited> {
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
            rate: self.rate_hz.map(|rate| resample(clip, rate)).transpose()?,
            reduce_keys: None,
        })
    }

    /// Drops keys, after everything else.
    pub(super) fn reduce_keys(
        &self,
        opened: &mut CharacterFile,
        edits: &mut [ClipEdited],
        work: &Executor<'_>,
    ) -> Result<()> {
        let Some(options) = self.reduce_keys else {
            return Ok(());
        };
        let place = opened.name.clone();
        let subject = subject(opened).with_context(|| &place)?;
        let one = |(clip, edited): (&RawClip, &mut ClipEdited)| {
            let out = clip_edit::reduce_keys(&subject, clip, &options);
            let out = out.with_context(|| &place)?;
            edited.reduce_keys = Some(KeysReduced::new(options.bound_metres, &out));
            Ok(out.clip)
        };
        let clips = opened.character.clips.iter().zip(edits).collect();
        opened.character.clips = work.map("reducing keys", clips, one)?;
        Ok(())
    }
}

impl CharacterFile {
    /// Edits all clips of the character; gives one entry for each, or none if nothing is asked
    /// for. Jobs are the clips.
    ///
    /// # Errors
    /// An [`Error`] that names the file, and the clip or joint that does not fit.
    pub fn edit_clips(
        &mut self,
        edits: &ClipEdits,
        work: &Executor<'_>,
    ) -> Result<Vec<ClipEdited>> {
        let mut edited = edits.apply(self, work)?;
        edits.reduce_keys(self, &mut edited, work)?;
        Ok(edited)
    }
}

fn subject(opened: &CharacterFile) -> Result<EditSubject<'_>> {
    let articulation = opened.articulation();
    Ok(EditSubject::new(
        &opened.character,
        articulation,
        &opened.end_sites,
    )?)
}

/// Cuts a clip to its loop and closes it, if it has one.
fn looped(subject: &EditSubject<'_>, clip: &mut RawClip, options: &CloseOptions) -> Result<Looped> {
    let part = clip_edit::find(subject, clip)?;
    let is_loop = part.is_some_and(|p| p.is_loop);
    let mut closed = None;
    if let Some(part) = part.filter(|_| is_loop) {
        *clip = clip_edit::trim(clip, part.start_secs..=part.end_secs)?;
        let out = clip_edit::close(subject, clip, options)?;
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
        score_least: clip_edit::MIN_SCORE,
        closed,
    })
}

fn root_motion(
    subject: &EditSubject<'_>,
    clip: &mut RawClip,
    options: &RootMotionOptions,
) -> Result<RootMotionEdited> {
    let out = clip_edit::split(subject, clip, options)?;
    *clip = out.clip;
    let way = |a: &TrajectoryKey, b: &TrajectoryKey| {
        (a.x_metres - b.x_metres).hypot(a.z_metres - b.z_metres)
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

fn resample(clip: &mut RawClip, rate_hz: f32) -> Result<Resampled> {
    let keys_before = keys(clip);
    *clip = clip_edit::resample(clip, rate_hz)?;
    Ok(Resampled {
        rate_hz,
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
