//! A clip whose level of articulation changes over time, read from JSON and reported.
//!
//! Source: thesis 5.1 and 5.2; `docs/formats/lod-schedule.md`.

use crate::camera_path::{ensure, malformed};
use crate::error::{Error, Result};
use articula_build::evaluate::{
    ClipEvaluator, LevelSchedule, RequestedLevel, ScheduleFrame, ScheduledLevel, play_schedule,
};
use articula_core::joint_state::{Ease, TransitionOptions};
use articula_core::loa::LoaExpression;
use articula_core::{Complexity, Rig};
use serde::{Deserialize, Serialize};

/// Maximum number of changes, and of display frames.
const MAX_CHANGES: usize = 1000;
const MAX_FRAMES: f64 = 36_000.0;

/// Seconds played after the last change and its transition.
const TAIL_SECS: f64 = 1.0;

/// A change of level as written in files.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduleEntry {
    /// Time in seconds from the start.
    pub t: f64,
    /// Expression of the joints that may move from then on.
    #[serde(default)]
    pub loa: Option<String>,
    /// Number of the named level from then on, 0 (`loa(VeryHigh)`) to 6 (`loa(None)`).
    #[serde(default)]
    pub level: Option<usize>,
}

/// Reads a schedule from a JSON list of entries with `t` and either `loa` or `level`.
///
/// # Errors
/// An [`Error`] that names the line or entry that is wrong.
pub fn read_lod_schedule(bytes: &[u8]) -> Result<Vec<ScheduleEntry>> {
    let entries: Vec<ScheduleEntry> = serde_json::from_slice(bytes).map_err(|e| {
        let form = "expected a list of {\"t\": seconds, \"loa\": \"EXPR\"} or {\"t\": seconds, \"level\": 0 to 6}";
        malformed(&e, form)
    })?;
    ensure(!entries.is_empty() && entries.len() <= MAX_CHANGES, || {
        let count = entries.len();
        format!("{count} changes; give 1 to {MAX_CHANGES}")
    })?;
    let mut before = 0.0;
    for (i, entry) in entries.iter().enumerate() {
        let t = entry.t;
        ensure(t.is_finite() && t >= before, || {
            format!("[{i}].t: {t} must be finite and not before {before}; sort the changes by time")
        })?;
        before = t;
        ensure(entry.loa.is_some() != entry.level.is_some(), || {
            format!("[{i}]: give either \"loa\" or \"level\"")
        })?;
        let levels = Complexity::ALL.len();
        ensure(entry.level.is_none_or(|level| level < levels), || {
            format!("[{i}].level: levels are 0 to {}", levels - 1)
        })?;
    }
    Ok(entries)
}

/// How a schedule is played.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduleOptions {
    /// The finest named level that the device allows, `h(d)`, at which play starts: 0 allows all.
    pub finest_level: usize,
    /// Frames per second of the display.
    pub display_hz: f64,
    /// Distance of the camera to the root in metres.
    pub distance_m: f32,
    /// Duration of transitions and pose of passive joints; the curve is that of the report's first
    /// transition.
    pub transition: TransitionOptions,
}

/// A schedule played with one kind of transition.
#[derive(Debug, Clone, Serialize)]
pub struct ScheduleReport {
    /// `smooth`, `linear` or `none`.
    pub transition: &'static str,
    /// Duration of a transition in milliseconds.
    pub transition_ms: f32,
    /// One row for each change.
    pub changes: Vec<ScheduleChange>,
    /// One row for each display frame.
    pub frames: Vec<ScheduleRow>,
}

/// What a change of level does.
#[derive(Debug, Clone, Serialize)]
pub struct ScheduleChange {
    /// Time in seconds.
    pub t: f64,
    /// The level as written in the schedule.
    pub level: String,
    /// Joints of the figure that may move from then on.
    pub joints: usize,
    /// Error in pixels in the frame before, in the first frame, and after the transition.
    pub error_px: ChangeError,
    /// Largest rotation of a joint from one frame to the next, up to the end of the transition,
    /// beyond its motion in the clip, in degrees.
    pub jump_deg: f32,
    /// Largest angle between the shown and the true rotation of a joint in that time, in degrees.
    pub gap_deg: f32,
}

/// Error in pixels around a change.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ChangeError {
    /// In the frame before the change.
    pub before: f32,
    /// In the first frame of the change.
    pub at: f32,
    /// When the transition is over.
    pub after: f32,
}

/// One display frame.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ScheduleRow {
    /// Time in seconds.
    pub t: f64,
    /// Error in pixels: 95th percentile over the skin at the worst azimuth.
    pub error_px: f32,
    /// Joints that may move.
    pub joints: usize,
    /// Joints sampled, of those that move in the clip.
    pub joints_sampled: usize,
    /// Joints in transition.
    pub in_transition: usize,
    /// Largest rotation of a joint beyond its motion in the clip, in degrees.
    pub jump_deg: f32,
}

/// Plays a schedule with the transition of the options, with the other curve, and without any.
///
/// # Errors
/// [`Error::Unsupported`] for an expression that does not fit the rig, or a schedule that is too
/// long.
pub fn play_lod_schedule(
    stage: &ClipEvaluator<'_>,
    entries: &[ScheduleEntry],
    options: &ScheduleOptions,
) -> Result<Vec<ScheduleReport>> {
    let rig = &stage.asset.rig;
    let schedule = LevelSchedule {
        changes: changes(rig, entries)?,
        finest_allowed: options.finest_level,
        display_hz: options.display_hz,
        tail_secs: f64::from(options.transition.secs) + TAIL_SECS,
        distance_m: options.distance_m,
    };
    let last = entries.last().map_or(0.0, |e| e.t) + schedule.tail_secs;
    ensure(last * options.display_hz <= MAX_FRAMES, || {
        format!("the schedule has more than {MAX_FRAMES} frames; shorten it")
    })?;
    let other = match options.transition.ease {
        Ease::Linear => Ease::Smoothstep,
        Ease::Smoothstep => Ease::Linear,
    };
    let secs = options.transition.secs;
    let kinds = [(options.transition.ease, secs), (other, secs), (other, 0.0)];
    let played = kinds.into_iter().map(|(ease, secs)| {
        let transition = TransitionOptions {
            ease,
            secs,
            ..options.transition
        };
        let frames = play_schedule(stage, &schedule, transition);
        report(rig, entries, transition, &frames)
    });
    Ok(played.collect())
}

fn changes(rig: &Rig, entries: &[ScheduleEntry]) -> Result<Vec<ScheduledLevel>> {
    let change = |(i, entry): (usize, &ScheduleEntry)| {
        let wrong = |e: &dyn std::fmt::Display| Error::unsuited(format!("[{i}].loa: {e}"));
        let level = match &entry.loa {
            Some(text) => {
                let parsed: LoaExpression = text.parse().map_err(|e| wrong(&e))?;
                RequestedLevel::Joints(parsed.joints(rig).map_err(|e| wrong(&e))?)
            }
            None => RequestedLevel::Level(entry.level.unwrap_or(0)),
        };
        Ok(ScheduledLevel {
            secs: entry.t,
            level,
        })
    };
    entries.iter().enumerate().map(change).collect()
}

fn report(
    rig: &Rig,
    entries: &[ScheduleEntry],
    transition: TransitionOptions,
    frames: &[ScheduleFrame],
) -> ScheduleReport {
    let joints = |frame: &ScheduleFrame| frame.articulation.intersection(rig.skin_joints()).len();
    let change = |entry: &ScheduleEntry| {
        let at = frames.partition_point(|f| f.secs + 1e-9 < entry.t);
        let at = at.min(frames.len() - 1);
        let end = entry.t + f64::from(transition.secs);
        let over = frames.partition_point(|f| f.secs < end).max(at);
        let over = over.min(frames.len() - 1);
        let greatest = |of: fn(&ScheduleFrame) -> f32| {
            frames[at..=over]
                .iter()
                .map(of)
                .fold(0.0f32, f32::max)
                .to_degrees()
        };
        let named = || {
            let level = entry.level.unwrap_or(0);
            let finest_first = Complexity::ALL.into_iter().rev().nth(level);
            finest_first.map_or(String::new(), |c| format!("{level}: loa({c})"))
        };
        ScheduleChange {
            t: entry.t,
            level: entry.loa.clone().unwrap_or_else(named),
            joints: joints(&frames[at]),
            error_px: ChangeError {
                before: frames[at.saturating_sub(1)].error_px,
                at: frames[at].error_px,
                after: frames[over].error_px,
            },
            jump_deg: greatest(|f| f.jump_radians),
            gap_deg: greatest(|f| f.gap_radians),
        }
    };
    ScheduleReport {
        transition: match (transition.secs > 0.0, transition.ease) {
            (false, _) => "none",
            (true, Ease::Linear) => "linear",
            (true, Ease::Smoothstep) => "smooth",
        },
        transition_ms: 1000.0 * transition.secs,
        changes: entries.iter().map(change).collect(),
        frames: frames
            .iter()
            .map(|f| ScheduleRow {
                t: f.secs,
                error_px: f.error_px,
                joints: joints(f),
                joints_sampled: f.sampled,
                in_transition: f.in_transition,
                jump_deg: f.jump_radians.to_degrees(),
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules_are_checked_at_the_door() {
        let why = |text: &str| read_lod_schedule(text.as_bytes()).unwrap_err().to_string();
        assert!(why("[]").contains("1 to 1000"));
        assert!(why("{}").contains("line 1"));
        assert!(why(r#"[{"t": 0}]"#).contains("either"));
        assert!(why(r#"[{"t": 0, "loa": "loa(Low)", "level": 1}]"#).contains("either"));
        assert!(why(r#"[{"t": 1, "level": 0}, {"t": 0.5, "level": 1}]"#).contains("[1].t"));
        assert!(why(r#"[{"t": -1, "level": 0}]"#).contains("[0].t"));
        assert!(why(r#"[{"t": 0, "level": 7}]"#).contains("0 to 6"));
        assert!(why(r#"[{"t": 0, "lao": "x"}]"#).contains("lao"));
        let two = r#"[{"t": 0.5, "loa": "loa(Low)"}, {"t": 0.5, "level": 6}]"#;
        assert_eq!(read_lod_schedule(two.as_bytes()).unwrap().len(), 2);
    }
}
