//! Playback of a clip whose level of articulation changes over time.
//!
//! Source: thesis 5.1 (Refine and Simplify below the cap of the device) and 5.2 (transitions);
//! `docs/methods/motion-lod.md` part 2.

use super::stage::ClipEvaluator;
use super::statistics::across;
use articula_core::crowd::ClipState;
use articula_core::joint_state::{LoaRange, TransitionOptions};
use articula_core::playback::{FigureModel, FigurePlayer, FigureViews, FullDetail, LoaController};
use articula_core::{JointSet, LocalPose, Wrap, angle_between, percentile, sample};

/// What a change of level asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RequestedLevel {
    /// A named level, counted from the finest, 0 (`loa(VeryHigh)`).
    Level(usize),
    /// Any set of joints, of which those of the finest allowed level move.
    Joints(JointSet),
}

/// A change of level at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduledLevel {
    /// Time in seconds from the start.
    pub secs: f64,
    /// The level from then on.
    pub level: RequestedLevel,
}

/// A schedule and how it is played.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelSchedule {
    /// Changes in the order of their times.
    pub changes: Vec<ScheduledLevel>,
    /// The finest named level that the device allows, `h(d)`, at which play starts.
    pub finest_allowed: usize,
    /// Frames per second of the display.
    pub display_hz: f64,
    /// Seconds played after the last change.
    pub tail_secs: f64,
    /// Distance of the camera to the root in metres; weak perspective.
    pub distance_m: f32,
}

/// Measurements of one display frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduleFrame {
    /// Time in seconds.
    pub secs: f64,
    /// Joints that may move.
    pub articulation: JointSet,
    /// Joints sampled, of those that move in the clip.
    pub sampled: usize,
    /// Joints in transition.
    pub in_transition: usize,
    /// 95th percentile over the sampled vertices of the projected distance between shown and true
    /// skin, at the worst azimuth, pixels.
    pub error_px: f32,
    /// Largest rotation of a joint since the frame before, beyond its own motion in the clip,
    /// radians.
    pub jump_radians: f32,
    /// Largest angle between the held and the true rotation of a joint, radians.
    pub gap_radians: f32,
}

/// Plays a looping clip while its level changes.
///
/// # Panics
/// Never: the clip belongs to the rig.
pub fn play_schedule(
    stage: &ClipEvaluator<'_>,
    schedule: &LevelSchedule,
    transition: TransitionOptions,
) -> Vec<ScheduleFrame> {
    let (rig, clip) = (&stage.asset.rig, &stage.clip);
    let range = LoaRange::named(rig, schedule.finest_allowed);
    let finest = *range.joints();
    let mut control = LoaController::new(rig, range, transition, FullDetail::default());
    control.set_key_pose(&stage.key_pose());
    let model =
        FigureModel::new(rig.clone(), [clip.clone()]).expect("the clip must belong to the rig");
    let start = ClipState::new(&model, 0);
    let mut player = FigurePlayer::new(model, &[]);
    player.play(start);
    let scale = stage.setup.viewport.pixels_per_metre(schedule.distance_m);
    let end = schedule.changes.last().map_or(0.0, |c| c.secs) + schedule.tail_secs;
    let count = (end * schedule.display_hz).floor() as usize;
    let mut due = schedule.changes.iter().peekable();
    let mut truth = rig.rest_pose().clone();
    let (mut last_truth, mut last_shown) = (truth.clone(), truth.clone());
    let mut frames = Vec::with_capacity(count + 1);
    for i in 0..=count {
        let secs = i as f64 / schedule.display_hz;
        while let Some(change) = due.next_if(|change| change.secs <= secs + 1e-9) {
            match change.level {
                RequestedLevel::Level(level) => {
                    control.request(level);
                }
                RequestedLevel::Joints(joints) => control.articulate(joints.intersection(&finest)),
            }
        }
        let duration = f64::from(clip.duration_secs());
        let wrapped = if duration > 0.0 {
            secs.rem_euclid(duration)
        } else {
            0.0
        };
        player.advance_to(secs, wrapped as f32);
        let views = FigureViews::Parallel {
            pixels_per_metre: scale,
            distance_metres: schedule.distance_m,
            directions: &[],
        };
        let report = *player.control(&mut control, views);
        sample(clip, secs, Wrap::Loop, &rig.all(), &mut truth);
        let shown = player.pose();
        let jump = stage.moving.iter().map(|j| {
            let of = |before: &LocalPose, now: &LocalPose| {
                angle_between(before.rotations[j], now.rotations[j])
            };
            of(&last_shown, shown) - of(&last_truth, &truth)
        });
        let gaps = stage.moving.iter().map(|j| {
            let held = shown.rotations[j];
            angle_between(held, truth.rotations[j])
        });
        frames.push(ScheduleFrame {
            secs,
            articulation: *control.articulation(),
            sampled: report.sampled.intersection(&stage.moving).len(),
            in_transition: report.in_transition.len(),
            error_px: scale * stage.worst_view_metres(shown, &truth, wrapped),
            jump_radians: if i > 0 { jump.fold(0.0, f32::max) } else { 0.0 },
            gap_radians: gaps.fold(0.0, f32::max),
        });
        last_truth.copy_from(&truth);
        last_shown.copy_from(shown);
    }
    frames
}

impl ClipEvaluator<'_> {
    /// 95th percentile over the sampled vertices of the distance between two poses projected along
    /// each view, at the worst of them, metres.
    fn worst_view_metres(&self, shown: &LocalPose, truth: &LocalPose, secs: f64) -> f32 {
        let shown = self.points_at(shown, secs);
        let truth = self.points_at(truth, secs);
        let seen = self.view_directions().map(|view| {
            let offsets = shown.iter().zip(&truth).map(|(s, t)| *s - *t);
            let mut lengths: Vec<f32> = offsets.map(|d| across(d, view)).collect();
            percentile(&mut lengths, 0.95)
        });
        seen.fold(0.0, f32::max)
    }
}
