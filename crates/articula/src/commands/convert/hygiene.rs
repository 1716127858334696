//! `convert --trim --loop --root-motion --rate --reduce-keys`: clips made clean, and what that did
//! in numbers.
//!
//! The order is fixed, whatever the order of the flags: trim, loop, root motion, rate, then (after
//! the level of articulation) keys. The bound of the keys is against what they stood for just
//! before.

use crate::load::{Format, Loaded};
use crate::prepared::articulation_of;
use crate::{arguments, fault};
use anyhow::Context;
use articula_build::clip_edit::{self, Subject};
use articula_build::clip_edit::{CloseOptions, FindOptions};
use articula_build::clip_edit::{ReduceOptions, Reduced};
use articula_build::clip_edit::{RootMotionMode, RootMotionOptions, TrajectoryKey};
use articula_core::source::Clip;
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use serde::Serialize;

/// What is to be done with the clips.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct HygieneArgs {
    /// Keep a part of each clip, in seconds: 1.5..3, ..3 or 2..
    #[arg(long, value_name = "FROM..TO", value_parser = part)]
    trim: Option<Part>,
    /// Keep the part of each clip that loops best, and make its ends meet
    #[arg(long = "loop")]
    looped: bool,
    /// With --loop: share what is missing over so much of either end [default: half of the loop]
    #[arg(long, value_name = "SECS", value_parser = arguments::positive, requires = "looped")]
    loop_window: Option<f32>,
    /// What becomes of the hips' way over the ground and their heading: told, given to a joint
    /// above them, or taken away
    #[arg(long, value_name = "MODE", value_enum)]
    root_motion: Option<RootMode>,
    /// With --root-motion: leave sway that is shorter than this to the hips
    #[arg(long, value_name = "SECS", value_parser = arguments::positive, requires = "root_motion")]
    root_smooth: Option<f32>,
    /// Key every channel at this rate
    #[arg(long, value_name = "HZ", value_parser = arguments::positive)]
    rate: Option<f32>,
    /// Drop keys as long as no joint and no skin moves by more than this: 0.001, 1mm or 0.1cm
    #[arg(long, value_name = "METRES", value_parser = metres)]
    reduce_keys: Option<f32>,
    /// With --reduce-keys: drop channels that show the rest pose, too
    #[arg(long, requires = "reduce_keys")]
    drop_rest: bool,
}

/// What becomes of root motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum RootMode {
    /// It stays; the report tells the trajectory
    Keep,
    /// The joint above the hips carries it
    Extract,
    /// It is taken away
    InPlace,
}

/// A part of a clip; without a bound, from its start or to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    from: Option<f32>,
    to: Option<f32>,
}

/// What was done with one clip; null what was not asked for.
#[derive(Debug, Serialize)]
pub(super) struct Edits {
    clip: String,
    trim: Option<Trimmed>,
    #[serde(rename = "loop")]
    looped: Option<Looped>,
    root_motion: Option<RootMotionDone>,
    rate: Option<Resampled>,
    reduce_keys: Option<KeysReduced>,
}

#[derive(Debug, Serialize)]
struct Trimmed {
    from_secs: f32,
    to_secs: f32,
    duration_secs: f32,
}

/// The best part of a clip; unless it is a loop, the clip stays as it is.
#[derive(Debug, Serialize)]
struct Looped {
    is_loop: bool,
    /// Whether it is the whole clip, whose ends met from the start.
    is_whole: bool,
    /// Null for a clip that is too short or too still to repeat anything.
    part: Option<LoopPart>,
    /// The lowest score of a loop.
    score_least: f32,
    closed: Option<ClosedDone>,
}

#[derive(Debug, Serialize)]
struct LoopPart {
    start_secs: f32,
    end_secs: f32,
    period_secs: f32,
    /// Greatest jump of a joint from the end to the start, before it was closed.
    seam_m: f32,
    seam_rms_m: f32,
    seam_m_per_sec: f32,
    score: f32,
}

#[derive(Debug, Serialize)]
struct ClosedDone {
    window_secs: f32,
    /// Greatest distance that any joint was moved by closing.
    moved_m: f32,
    /// Of one round, over the ground.
    travel_m: f32,
    turn_deg: f32,
    /// Greatest angle that is left between the first and the last pose.
    seam_deg: f32,
}

#[derive(Debug, Serialize)]
struct RootMotionDone {
    mode: RootMode,
    hips: String,
    /// The joint above the hips that can carry the trajectory; null if none can.
    carrier: Option<String>,
    /// From the first frame to the last, over the ground.
    travel_m: f32,
    /// The way itself.
    path_m: f32,
    turn_deg: f32,
    /// Greatest distance of any joint from its source, the trajectory put back.
    worst_m: f32,
    trajectory: Vec<Place>,
}

/// Against the first frame.
#[derive(Debug, Serialize)]
struct Place {
    secs: f32,
    x_m: f32,
    z_m: f32,
    yaw_deg: f32,
}

#[derive(Debug, Serialize)]
struct Resampled {
    rate_hz: f32,
    keys_before: usize,
    keys_after: usize,
}

#[derive(Debug, Serialize)]
struct KeysReduced {
    bound_m: f32,
    /// Greatest distance of any joint or skin from where the clip had it.
    worst_m: f32,
    /// Times at which that was measured, between keys too.
    times_verified: usize,
    channels_before: usize,
    channels_after: usize,
    keys_before: usize,
    keys_after: usize,
    animation_bytes_before: usize,
    animation_bytes_after: usize,
}

impl HygieneArgs {
    /// Refuses what the format of the output cannot show.
    pub(super) fn check(&self, out: Format) -> anyhow::Result<()> {
        if self.reduce_keys.is_some() && super::written::holds_frames(out) {
            return Err(fault::usage(format!(
                "--reduce-keys: a .{} file stores every joint in every frame; write .glb, or leave it out",
                out.name()
            )));
        }
        if self.root_motion == Some(RootMode::Extract) && out == Format::Vrma {
            return Err(fault::usage(
                "--root-motion extract: a .vrma file moves the bones of a humanoid alone, and the hips are the first of them; use in-place",
            ));
        }
        Ok(())
    }

    /// Whether anything is to be done.
    pub(super) fn asks(&self) -> bool {
        self.trim.is_some()
            || self.looped
            || self.root_motion.is_some()
            || self.rate.is_some()
            || self.reduce_keys.is_some()
    }

    /// Does all but the keys; gives one entry for each clip, or none if nothing is asked for.
    pub(super) fn apply(&self, loaded: &mut Loaded) -> anyhow::Result<Vec<Edits>> {
        if !self.asks() {
            return Ok(Vec::new());
        }
        let place = loaded.place();
        let subject = subject(loaded).with_context(|| place.clone())?;
        let edit = |clip: &Clip| {
            let mut clip = clip.clone();
            let edits = self.edit(&subject, &mut clip);
            Ok((clip, edits.with_context(|| place.clone())?))
        };
        let done = loaded.character.clips.par_iter().map(edit);
        let done = done.collect::<anyhow::Result<Vec<(Clip, Edits)>>>()?;
        let (clips, edits) = done.into_iter().unzip();
        loaded.character.clips = clips;
        Ok(edits)
    }

    fn edit(&self, subject: &Subject<'_>, clip: &mut Clip) -> anyhow::Result<Edits> {
        Ok(Edits {
            clip: clip.name.clone(),
            trim: self.trim.map(|part| part.trim(clip)).transpose()?,
            looped: match self.looped {
                true => Some(looped(subject, clip, self.loop_window)?),
                false => None,
            },
            root_motion: self
                .root_motion
                .map(|mode| root_motion(subject, clip, mode, self.root_smooth))
                .transpose()?,
            rate: self.rate.map(|rate| resample(clip, rate)).transpose()?,
            reduce_keys: None,
        })
    }

    /// Drops keys, after everything else.
    pub(super) fn reduce_keys(
        &self,
        loaded: &mut Loaded,
        edits: &mut [Edits],
    ) -> anyhow::Result<()> {
        let Some(bound_metres) = self.reduce_keys else {
            return Ok(());
        };
        let opts = ReduceOptions {
            bound_metres,
            drop_rest: self.drop_rest,
        };
        let place = loaded.place();
        let subject = subject(loaded).with_context(|| place.clone())?;
        let one = |(clip, edits): (&Clip, &mut Edits)| {
            let out = clip_edit::reduce_keys(&subject, clip, &opts);
            let out = out.with_context(|| place.clone())?;
            edits.reduce_keys = Some(KeysReduced::new(bound_metres, &out));
            Ok(out.clip)
        };
        let clips = loaded.character.clips.par_iter().zip(edits).map(one);
        let clips = clips.collect::<anyhow::Result<Vec<Clip>>>()?;
        loaded.character.clips = clips;
        Ok(())
    }
}

fn subject(loaded: &Loaded) -> anyhow::Result<Subject<'_>> {
    let articulation = articulation_of(loaded);
    Ok(Subject::new(
        &loaded.character,
        articulation,
        &loaded.end_sites,
    )?)
}

/// Cuts a clip to its loop and closes it, if it has one.
fn looped(
    subject: &Subject<'_>,
    clip: &mut Clip,
    window_secs: Option<f32>,
) -> anyhow::Result<Looped> {
    let found = clip_edit::find(subject, clip, &FindOptions::default())?;
    let is_loop = found.is_some_and(|f| f.is_loop);
    let part = found.map(|f| f.cycle);
    let mut closed = None;
    if let Some(part) = part.filter(|_| is_loop) {
        *clip = clip_edit::trim(clip, part.start_secs..=part.end_secs)?;
        let out = clip_edit::close(subject, clip, &CloseOptions { window_secs })?;
        *clip = out.clip;
        closed = Some(ClosedDone {
            window_secs: out.window_secs,
            moved_m: out.moved_metres,
            travel_m: out.travel_metres,
            turn_deg: out.turn_radians.to_degrees(),
            seam_deg: out.seam_radians.to_degrees(),
        });
    }
    Ok(Looped {
        is_loop,
        is_whole: found.is_some_and(|f| f.is_whole),
        part: part.map(|part| LoopPart {
            start_secs: part.start_secs,
            end_secs: part.end_secs,
            period_secs: part.end_secs - part.start_secs,
            seam_m: part.seam_metres,
            seam_rms_m: part.seam_rms_metres,
            seam_m_per_sec: part.seam_metres_per_sec,
            score: part.score,
        }),
        score_least: clip_edit::LEAST_SCORE,
        closed,
    })
}

fn root_motion(
    subject: &Subject<'_>,
    clip: &mut Clip,
    mode: RootMode,
    smooth_secs: Option<f32>,
) -> anyhow::Result<RootMotionDone> {
    let opts = RootMotionOptions {
        mode: match mode {
            RootMode::Keep => RootMotionMode::Keep,
            RootMode::Extract => RootMotionMode::Extract,
            RootMode::InPlace => RootMotionMode::InPlace,
        },
        smooth_secs: smooth_secs.unwrap_or(0.0),
    };
    let out = clip_edit::split(subject, clip, &opts)?;
    *clip = out.clip;
    let way = |a: &TrajectoryKey, b: &TrajectoryKey| {
        (a.x_metres - b.x_metres).hypot(a.z_metres - b.z_metres)
    };
    let last = out.trajectory.last().copied().unwrap_or_default();
    let place = |key: &TrajectoryKey| Place {
        secs: key.secs,
        x_m: key.x_metres,
        z_m: key.z_metres,
        yaw_deg: key.yaw_radians.to_degrees(),
    };
    Ok(RootMotionDone {
        mode,
        hips: subject.joint_name(out.hips).to_owned(),
        carrier: out.carrier.map(|j| subject.joint_name(j).to_owned()),
        travel_m: way(&last, &TrajectoryKey::default()),
        path_m: out.trajectory.windows(2).map(|w| way(&w[1], &w[0])).sum(),
        turn_deg: last.yaw_radians.to_degrees(),
        worst_m: out.worst_metres,
        trajectory: out.trajectory.iter().map(place).collect(),
    })
}

fn named(name: &str) -> String {
    if name.is_empty() {
        "without a name".into()
    } else {
        format!("\"{}\"", fault::clean(name))
    }
}

fn keys(clip: &Clip) -> usize {
    clip.channels.iter().map(|c| c.times_secs.len()).sum()
}

fn resample(clip: &mut Clip, rate_hz: f32) -> anyhow::Result<Resampled> {
    let keys_before = keys(clip);
    *clip = clip_edit::resample(clip, rate_hz)?;
    Ok(Resampled {
        rate_hz,
        keys_before,
        keys_after: keys(clip),
    })
}

impl Part {
    fn trim(self, clip: &mut Clip) -> anyhow::Result<Trimmed> {
        let from_secs = self.from.unwrap_or(0.0);
        let to_secs = self.to.unwrap_or(clip.duration_secs);
        *clip = clip_edit::trim(clip, from_secs..=to_secs)
            .context("--trim (--clip NAME chooses one clip)")?;
        Ok(Trimmed {
            from_secs,
            to_secs,
            duration_secs: clip.duration_secs,
        })
    }
}

impl Edits {
    /// What was done, for people; one line for the clip and one for each thing that was done.
    pub(super) fn text(&self) -> String {
        let mut text = format!("clip \"{}\"\n", fault::clean(&self.clip));
        if let Some(t) = &self.trim {
            text.push_str(&format!(
                "  trimmed to {:.3} .. {:.3} s: {:.3} s long\n",
                t.from_secs, t.to_secs, t.duration_secs
            ));
        }
        if let Some(looped) = &self.looped {
            text.push_str(&looped.text());
        }
        if let Some(root) = &self.root_motion {
            text.push_str(&root.text());
        }
        if let Some(r) = &self.rate {
            text.push_str(&format!(
                "  keyed at {} Hz: {} -> {} keys\n",
                r.rate_hz, r.keys_before, r.keys_after
            ));
        }
        if let Some(k) = &self.reduce_keys {
            text.push_str(&k.text());
        }
        text
    }
}

impl Looped {
    fn text(&self) -> String {
        let Some(p) = &self.part else {
            return "  no loop: too short or too still to repeat anything\n".into();
        };
        let part = format!(
            "{:.3} .. {:.3} s, {:.3} s long, seam {:.1} mm, score {:.3}",
            p.start_secs,
            p.end_secs,
            p.period_secs,
            1e3 * p.seam_m,
            p.score
        );
        match &self.closed {
            Some(c) => format!(
                "  {}: {part}; closing moved joints by up to {:.1} mm; a round goes {:.3} m, {:.1} degrees\n",
                if self.is_whole {
                    "a loop as it is"
                } else {
                    "loop found"
                },
                1e3 * c.moved_m,
                c.travel_m,
                c.turn_deg,
            ),
            None => format!(
                "  no loop, left as it was: the best part ({part}) is below a score of {}\n",
                self.score_least
            ),
        }
    }
}

impl RootMotionDone {
    fn text(&self) -> String {
        let hips = named(&self.hips);
        let off = format!(
            "every joint within {:.3} mm of its source",
            1e3 * self.worst_m
        );
        let what = match (self.mode, &self.carrier) {
            (RootMode::Keep, _) => "kept".to_owned(),
            (RootMode::Extract, Some(carrier)) => {
                format!("now of the joint {}, {off}", named(carrier))
            }
            (RootMode::Extract, None) => "left there, since no joint above can carry it (--json tells the trajectory, in-place takes it away)".to_owned(),
            (RootMode::InPlace, _) => format!("taken away; with it, {off}"),
        };
        format!(
            "  root motion of the hips {hips}: {:.3} m on a way of {:.3} m, {:.1} degrees; {what}\n",
            self.travel_m, self.path_m, self.turn_deg,
        )
    }
}

impl KeysReduced {
    fn new(bound_metres: f32, out: &Reduced) -> Self {
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

    fn text(&self) -> String {
        let (before, after) = (self.animation_bytes_before, self.animation_bytes_after);
        format!(
            "  keys reduced: {} -> {} keys, {} -> {} channels, {before} -> {after} bytes ({:.1}% saved); \
             nothing moved by more than {:.3} mm (verified at {} times)\n",
            self.keys_before,
            self.keys_after,
            self.channels_before,
            self.channels_after,
            100.0 * (1.0 - after as f64 / before.max(1) as f64),
            1e3 * self.worst_m,
            self.times_verified,
        )
    }
}

/// Reads `FROM..TO`, either end open.
fn part(text: &str) -> Result<Part, String> {
    let wrong = || "expected seconds as FROM..TO, ..TO or FROM.., FROM before TO".to_owned();
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let number = |t: &str| match t.trim() {
        "" => Ok(None),
        t => arguments::not_negative(t).map(Some).map_err(|_| wrong()),
    };
    let part = Part {
        from: number(from)?,
        to: number(to)?,
    };
    match part {
        Part {
            from: None,
            to: None,
        } => Err(wrong()),
        Part { from, to: Some(to) } if from.unwrap_or(0.0) >= to => Err(wrong()),
        part => Ok(part),
    }
}

/// Reads a length in metres, or with the unit m, cm or mm.
fn metres(text: &str) -> Result<f32, String> {
    let text = text.trim();
    let (number, unit) = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)]
        .iter()
        .find_map(|(name, unit)| Some((text.strip_suffix(name)?, *unit)))
        .unwrap_or((text, 1.0));
    let metres = number
        .trim_end()
        .parse::<f64>()
        .ok()
        .map(|n| (n * unit) as f32);
    let metres = metres.filter(|m| m.is_finite() && *m > 0.0);
    metres.ok_or_else(|| "expected a length above 0, such as 0.001, 1mm or 0.1cm".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units() {
        assert_eq!(metres("0.001"), Ok(0.001));
        assert_eq!(metres("1mm"), Ok(0.001));
        assert_eq!(metres("0.1 cm"), Ok(0.001));
        assert_eq!(metres("2m"), Ok(2.0));
        for bad in ["", "mm", "0", "-1mm", "1km", "NaN", "inf", "1e99m"] {
            assert!(metres(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn parts_may_be_open() {
        let of = |from, to| Ok(Part { from, to });
        assert_eq!(part("1.5..3"), of(Some(1.5), Some(3.0)));
        assert_eq!(part("..3"), of(None, Some(3.0)));
        assert_eq!(part("2.."), of(Some(2.0), None));
        for bad in ["", "..", "3", "3..3", "3..1", "-1..2", "a..b", "1..NaN"] {
            assert!(part(bad).is_err(), "{bad}");
        }
    }
}
