//! A motion of one skeleton put onto another.
//!
//! Stands on the PREPARE line: a source clip and two figures give a source clip for the second
//! figure. In the order of the work:
//!
//! - `rest`, `body`, `frames`: what two rest poses say of two bodies, told from joint positions
//! - `chain`, `plan`: which source joint turns which target joint
//! - `motion`: the source's poses
//! - `pose`, `tracks`: the target's poses, and their keys
//!
//! Source: M. Gleicher, Retargetting Motion to New Characters, SIGGRAPH 1998, for what must be
//! kept; the method is another: anatomical frames instead of constraints on one skeleton.

mod body;
mod chain;
mod frames;
mod motion;
mod plan;
mod pose;
mod report;
mod rest;
mod tracks;

pub use report::{JointReport, Origin, RetargetReport};

use articula_core::Mismatch;
use articula_core::articulation::Articulation;
use articula_core::source::{Clip, Skeleton};
use glam::Vec3;
use motion::Motion;
use plan::{Plan, Side};
use pose::Pose;
use tracks::Tracks;

/// A skeleton and what its joints are.
#[derive(Debug, Clone, Copy)]
pub struct Figure<'a> {
    /// The joints at rest.
    pub skeleton: &'a Skeleton,
    /// Their twins in the standard, one entry for each joint.
    pub articulation: &'a Articulation,
}

/// How a motion is put onto another figure.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RetargetOptions {
    /// Frames per second of the result; `None` takes the rate of the source's keys.
    pub rate_hz: Option<f32>,
}

/// A motion of the target, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Retargeted {
    /// Channels for the target's skeleton: linear, at one rate, times from 0 to the end.
    pub clip: Clip,
    /// Where each joint's motion comes from, and numbers of quality.
    pub report: RetargetReport,
}

/// Two figures that were compared once, for any number of clips.
#[derive(Debug, Clone)]
pub struct Retargeter<'a> {
    figure: Figure<'a>,
    source: Side,
    target: Side,
    plan: Plan,
}

impl<'a> Retargeter<'a> {
    /// Compares two figures.
    ///
    /// # Errors
    /// A [`Mismatch`] if a figure's map is not of its skeleton, if no joint stands for the root
    /// or a hip, or if a rest transform is not finite.
    pub fn new(source: Figure<'a>, target: Figure<'_>) -> Result<Self, Mismatch> {
        let figure = source;
        let source = Side::new(&source, "source")?;
        let target = Side::new(&target, "target")?;
        let plan = Plan::new(&source, &target);
        Ok(Self {
            figure,
            source,
            target,
            plan,
        })
    }

    /// Puts one clip of the source onto the target.
    ///
    /// # Errors
    /// A [`Mismatch`] if a channel names a joint that is not there or lacks values, if a pose
    /// is not finite, or if the clip has more frames than memory should hold.
    pub fn retarget(&self, clip: &Clip, options: &RetargetOptions) -> Result<Retargeted, Mismatch> {
        let (source, target, plan) = (&self.source, &self.target, &self.plan);
        let motion = Motion::new(clip, self.figure.skeleton, &source.rest, options.rate_hz)?;
        let mut tracks = Tracks::new(plan, target, &[], motion.frames());
        let mut pose = Pose::new(target);
        let floor = floor(source, &motion);
        for frame in 0..motion.frames() {
            pose.turn(plan, source, target, (&motion, frame));
            let root = target.rest.positions[target.body.root];
            pose.place(plan, target, root);
            let wanted = self.middle(motion.positions(frame), floor);
            let root = root + wanted - target.body.middle(&pose.positions);
            pose.place(plan, target, root);
            tracks.push(target, &pose);
        }
        let fastest = tracks.fastest(motion.rate_hz);
        Ok(Retargeted {
            clip: tracks.clip(&clip.name, &motion.times_secs),
            report: report::report(source, target, plan, fastest),
        })
    }

    /// Where the middle between the target's hips belongs.
    fn middle(&self, positions: &[Vec3], floor: f32) -> Vec3 {
        let (source, target) = (&self.source, &self.target);
        let scale = self.plan.scale;
        let rest = source.body.middle(&source.rest.positions);
        let now = source.body.middle(positions);
        let home = target.body.middle(&target.rest.positions);
        let along = self.plan.world * (scale * (now - rest));
        let above = now.y - floor - source.body.ankle_height;
        let height = scale * above + target.body.ankle_height + floor_of(target);
        Vec3::new(home.x + along.x, height, home.z + along.z)
    }
}

/// Puts one clip onto another figure; for several clips keep a [`Retargeter`].
///
/// # Errors
/// See [`Retargeter::new`] and [`Retargeter::retarget`].
pub fn retarget(
    source: Figure<'_>,
    target: Figure<'_>,
    clip: &Clip,
    options: &RetargetOptions,
) -> Result<Retargeted, Mismatch> {
    Retargeter::new(source, target)?.retarget(clip, options)
}

/// Height of the floor under a figure at rest.
fn floor_of(side: &Side) -> f32 {
    if side.body.stands_on_floor {
        return 0.0;
    }
    let joints = side.body.legs.iter().filter_map(|l| l.ankle);
    let lowest = joints.map(|j| side.rest.positions[j].y).reduce(f32::min);
    lowest.unwrap_or(0.0) - side.body.ankle_height
}

/// Height of the floor under a motion: that of the rest pose if it stands on one, otherwise
/// where the feet are when they are lowest.
fn floor(source: &Side, motion: &Motion) -> f32 {
    if source.body.stands_on_floor {
        return 0.0;
    }
    let mut lows: Vec<f32> = (0..motion.frames())
        .filter_map(|f| {
            let at = motion.positions(f);
            let body = &source.body;
            let low = |joint: Option<usize>, height: f32| joint.map(|j| at[j].y - height);
            let legs = body.legs.iter();
            legs.flat_map(|l| [low(l.ankle, body.ankle_height), low(l.toe, body.toe_height)])
                .flatten()
                .reduce(f32::min)
        })
        .collect();
    lows.sort_by(f32::total_cmp);
    // A twentieth of the frames may lie lower: noise, and feet that dip into the floor.
    lows.get(lows.len() / 20).copied().unwrap_or(0.0)
}
