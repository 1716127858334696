//! A source clip as rotations from rest and positions in model space, frame by frame.

use super::rest::Rest;
use crate::clip::MAX_NUMBERS;
use crate::sampling_rate::{frame_times, keyed_rate, source_rate_hz};
use articula_core::source::evaluate::Sampler;
use articula_core::source::{Interpolation, Property, RawClip, Skeleton};
use articula_core::{LocalPose, Mismatch, Transform, angle_between};
use glam::{Affine3A, Quat, Vec3};

/// Maximum number of frames of one clip.
const MAX_FRAMES: f64 = 1e6;

/// Minimum number of steps of a motion whose first one is judged, and the least angle of a jump: a
/// fixed one, and a multiple of the greatest step among 99 % of the others.
const JUMP_STEPS: usize = 5;
pub(super) const JUMP_RADIANS: f32 = 0.2;
const JUMP_FACTOR: f32 = 3.0;

/// A motion in model space.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) rate_hz: f32,
    pub(super) times_secs: Vec<f32>,
    joints: usize,
    /// Rotation of each joint from its rest orientation, in model space; frame by frame.
    deltas: Vec<Quat>,
    /// Position of each joint in model space, metres; frame by frame.
    positions: Vec<Vec3>,
}

impl Motion {
    /// Samples a clip at a rate; `None` uses one that follows its keys.
    pub(super) fn new(
        clip: &RawClip,
        skeleton: &Skeleton,
        rest: &Rest,
        rate_hz: Option<f32>,
    ) -> Result<Self, Mismatch> {
        check(clip, skeleton.joints.len())?;
        let (rate_hz, times_secs) = times(clip, skeleton, rate_hz)?;
        let motion = Self::at(clip, skeleton, rest, times_secs)?;
        Ok(Self { rate_hz, ..motion })
    }

    /// Samples a clip at times; its rate is that of its keys.
    pub(super) fn at(
        clip: &RawClip,
        skeleton: &Skeleton,
        rest: &Rest,
        times_secs: Vec<f32>,
    ) -> Result<Self, Mismatch> {
        check(clip, skeleton.joints.len())?;
        let mut pose: LocalPose = (0..rest.len()).map(|_| Transform::IDENTITY).collect();
        let mut motion = Self {
            rate_hz: source_rate_hz(clip),
            joints: rest.len(),
            deltas: Vec::with_capacity(times_secs.len() * rest.len()),
            positions: Vec::with_capacity(times_secs.len() * rest.len()),
            times_secs,
        };
        let mut matrices = vec![Affine3A::IDENTITY; rest.len()];
        let mut sampler = Sampler::new(clip, skeleton);
        for frame in 0..motion.frames() {
            sampler.pose(motion.times_secs[frame], &mut pose);
            motion.push(rest, &pose, &mut matrices);
        }
        if motion.positions.iter().any(|p| !p.is_finite()) {
            let at = format!("clip \"{}\"", clip.name);
            return Err(Mismatch::new(at, "its poses are not finite"));
        }
        Ok(motion)
    }

    fn push(&mut self, rest: &Rest, pose: &LocalPose, matrices: &mut [Affine3A]) {
        let first = self.deltas.len();
        for j in 0..self.joints {
            let local = pose.get(j).to_affine();
            let turn = pose.rotations[j] * rest.locals[j].0.inverse();
            let parent = rest.parents[j];
            let around = rest.parent_rotation(j);
            let above = parent.map_or(Quat::IDENTITY, |p| self.deltas[first + p]);
            matrices[j] = parent.map_or(local, |p| matrices[p] * local);
            let delta = above * around * turn * around.inverse();
            self.deltas.push(delta.normalize());
            self.positions.push(matrices[j].translation.into());
        }
    }

    /// The rest pose as a motion of one frame.
    pub(super) fn still(rest: &Rest) -> Self {
        Self {
            rate_hz: 1.0,
            times_secs: vec![0.0],
            joints: rest.len(),
            deltas: vec![Quat::IDENTITY; rest.len()],
            positions: rest.positions.clone(),
        }
    }

    /// Appends the frames of another motion of the same figure at the same rate.
    pub(super) fn append(&mut self, next: Self) {
        let start = self
            .times_secs
            .last()
            .map_or(0.0, |t| t + 1.0 / self.rate_hz);
        self.times_secs
            .extend(next.times_secs.iter().map(|t| start + t));
        self.deltas.extend(next.deltas);
        self.positions.extend(next.positions);
    }

    /// The same motion with rotations from another pose of the figure, which is given by its
    /// rotations from rest.
    pub(super) fn relative_to(mut self, turns: &[Quat]) -> Self {
        let inverse: Vec<Quat> = turns.iter().map(|turn| turn.inverse()).collect();
        for frame in self.deltas.chunks_exact_mut(self.joints.max(1)) {
            for (delta, turn) in frame.iter_mut().zip(&inverse) {
                *delta = (*delta * *turn).normalize();
            }
        }
        self
    }

    pub(super) fn frames(&self) -> usize {
        self.times_secs.len()
    }

    /// Rotations from rest at a frame.
    pub(super) fn deltas(&self, frame: usize) -> &[Quat] {
        &self.deltas[frame * self.joints..][..self.joints]
    }

    /// Angle by which a joint turns against its parent from a frame to the next.
    pub(super) fn step(&self, rest: &Rest, frame: usize, joint: usize) -> f32 {
        self.turned(rest, [frame, frame + 1], joint)
    }

    /// Angle by which a joint turns against its parent from one frame to another.
    pub(super) fn turned(&self, rest: &Rest, frames: [usize; 2], joint: usize) -> f32 {
        let local = |frame: usize| {
            let deltas = self.deltas(frame);
            let above = rest.parents[joint].map_or(Quat::IDENTITY, |p| deltas[p]);
            above.inverse() * deltas[joint]
        };
        angle_between(local(frames[0]), local(frames[1]))
    }

    /// Maximum rotation speed of a mapped joint relative to its parent between two frames: joint,
    /// radians per second.
    pub(super) fn fastest(&self, rest: &Rest) -> Option<(usize, f32)> {
        let mapped = (0..self.joints).filter(|j| rest.hanim[*j].is_some());
        let speed = |j: usize| {
            let steps = (1..self.frames()).map(|f| self.step(rest, f - 1, j));
            (j, self.rate_hz * steps.fold(0.0, f32::max))
        };
        mapped.map(speed).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The mapped joint that turns the farthest between the first two frames, if it turns much
    /// farther than any joint does between others: captures often begin with a frame of the rest
    /// pose. Joint, radians.
    pub(super) fn first_frame_jump(&self, rest: &Rest) -> Option<(usize, f32)> {
        let mapped: Vec<usize> = (0..self.joints)
            .filter(|j| rest.hanim[*j].is_some())
            .collect();
        let farthest = |frame: usize| {
            let turns = mapped.iter().map(|j| (*j, self.step(rest, frame, *j)));
            turns.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let steps = self.frames().saturating_sub(1);
        if steps < JUMP_STEPS {
            return None;
        }
        let first = farthest(0)?;
        let mut others: Vec<f32> = (1..steps).filter_map(farthest).map(|step| step.1).collect();
        others.sort_by(f32::total_cmp);
        let usual = others[(0.99 * others.len() as f32) as usize];
        (first.1 > JUMP_RADIANS && first.1 > JUMP_FACTOR * usual).then_some(first)
    }

    /// Positions at a frame.
    pub(super) fn positions(&self, frame: usize) -> &[Vec3] {
        &self.positions[frame * self.joints..][..self.joints]
    }
}

fn check(clip: &RawClip, joints: usize) -> Result<(), Mismatch> {
    for (c, channel) in clip.channels.iter().enumerate() {
        let at = || format!("clip \"{}\".channels[{c}]", clip.name);
        let width = match channel.property {
            Property::Rotation => 4,
            Property::Translation | Property::Scale => 3,
            Property::Weights | Property::Expression => continue,
        };
        if channel.target >= joints {
            let what = format!(
                "joint {} is out of range: the skeleton has {joints} joints",
                channel.target
            );
            return Err(Mismatch::new(at(), what));
        }
        let floats = match channel.interpolation {
            Interpolation::CubicSpline => 3 * width,
            _ => width,
        };
        let keys = channel.times_secs.len();
        if keys == 0 || channel.values.len() < keys * floats {
            let what = format!("{} values for {keys} keys", channel.values.len());
            return Err(Mismatch::new(at(), what));
        }
    }
    Ok(())
}

/// Times from 0 to the clip's end, and their rate.
fn times(
    clip: &RawClip,
    skeleton: &Skeleton,
    rate_hz: Option<f32>,
) -> Result<(f32, Vec<f32>), Mismatch> {
    let at = || format!("clip \"{}\"", clip.name);
    let duration = clip.duration_secs;
    let wanted = rate_hz.unwrap_or_else(|| source_rate_hz(clip));
    if !(wanted.is_finite() && wanted > 0.0 && duration.is_finite() && duration >= 0.0) {
        let what = format!(
            "{duration} s at {wanted} Hz: the duration must be finite and at least 0, the rate \
             positive"
        );
        return Err(Mismatch::new(at(), what));
    }
    let joints = skeleton.joints.len();
    let steps_at = |rate: f32| (f64::from(duration) * f64::from(rate)).round();
    let fits = |rate| {
        let steps = steps_at(rate);
        steps <= MAX_FRAMES && steps * (joints as f64) * 7.0 <= MAX_NUMBERS as f64
    };
    if !fits(wanted) {
        let what = format!(
            "{duration} s at {wanted} Hz for {joints} joints exceed the limit of frames; lower \
             the rate or trim the clip"
        );
        return Err(Mismatch::new(at(), what));
    }
    let wanted = rate_hz.unwrap_or_else(|| keyed_rate(clip, skeleton, &fits).rate_hz);
    Ok(frame_times(clip, wanted, steps_at(wanted) as usize))
}
