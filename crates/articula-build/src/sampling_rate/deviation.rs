//! How far frames of a rate, blended as in playback, are from the keys of a clip.

use super::{ON_GRID_FRAMES, USUAL_RATES_HZ, exact_rate, frame_time};
use crate::key_times::rising;
use crate::split_mix::SplitMix;
use articula_core::source::evaluate::{self, ChannelSampler, Sampler};
use articula_core::source::{Channel, Interpolation, JUMP_SECS, Property, RawClip, Skeleton};
use articula_core::{LocalPose, angle_between, nlerp, same_hemisphere};
use glam::{Affine3A, Quat, Vec3, Vec3A};

/// Share of the stated bounds that the measured times may show: between them blends lag a little more.
const SHARE: f32 = 0.7;
/// Maximum displacement of skin, in figures beyond 2 m as a share of their extent, and of a joint's rotation
/// against its parent, 0.05 degrees.
const SKIN_METRES: f32 = 1e-4;
const EXTENT_SHARE: f32 = 5e-5;
const TURN_RADIANS: f32 = SHARE * 0.05 * std::f32::consts::PI / 180.0;
/// Of weights of morph targets and expressions: a target that moves skin by 5 cm stays within 0.1 mm.
const WEIGHT: f32 = SHARE * 2e-3;

/// Least distance of a joint's farthest skin, as a share of the figure's extent: a head or a foot is
/// larger than its bones.
const SKIN_SHARE: f32 = 0.15;

/// Least rate at which a jump between two keys may take a frame.
const JUMP_HZ: f32 = 120.0;

/// Number of random times, and the maximum number of others.
const RANDOM_TIMES: usize = 512;
const MAX_TIMES: usize = 8192;
/// Number of times at which rates are compared of which none follows the clip.
const FEW_TIMES: usize = 1024;
const SEED: u64 = 0x5a_3717;

/// Number of joints of frames that are kept: 20 MB.
const KEPT_JOINTS: usize = 1 << 19;

/// A rate counts as good as the best one if its deviation is at most this many times as large.
const AS_GOOD: f32 = 1.25;

/// Measures frames of a clip at different rates.
pub(super) struct Follower<'a> {
    clip: &'a RawClip,
    skeleton: &'a Skeleton,
    sampler: Sampler<'a>,
    /// Distance of the farthest skin of each joint, in its own space.
    reaches: Vec<f32>,
    skin_metres: f32,
    /// Channels that change.
    moving: Vec<Moving<'a>>,
    /// Which joints turn.
    turning: Vec<bool>,
    jump_times: Vec<f32>,
    times: Vec<f32>,
    wanted: Posed,
    shown: Posed,
    kept: KeptFrames,
}

struct Moving<'a> {
    channel: &'a Channel,
    /// Whether it changes at once.
    jumps: bool,
    /// Evaluates frames.
    sampler: ChannelSampler<'a>,
}

/// Frames of one rate that were evaluated, each in one slot of few.
struct KeptFrames {
    most_joints: usize,
    frames: Vec<Option<usize>>,
    poses: Vec<LocalPose>,
}

struct Posed {
    local: LocalPose,
    model: Vec<Affine3A>,
}

/// Frames of a clip.
#[derive(Clone, Copy)]
struct Frames {
    rate_hz: f32,
    steps: usize,
    duration_secs: f32,
}

impl<'a> Follower<'a> {
    pub(super) fn new(clip: &'a RawClip, skeleton: &'a Skeleton) -> Self {
        let rest = || Posed {
            local: skeleton.joints.iter().map(|j| j.rest).collect(),
            model: skeleton.model_rest(),
        };
        let channels = clip.channels.iter();
        let all_jumps = channels.clone().flat_map(Channel::jump_times);
        let moving = channels.map(|channel| Moving {
            channel,
            jumps: channel.jump_times().next().is_some(),
            sampler: ChannelSampler::new(channel),
        });
        let moving: Vec<Moving<'_>> = moving.filter(|m| m.sampler.still().is_none()).collect();
        let mut turning = vec![false; skeleton.joints.len()];
        for m in &moving {
            if m.channel.property == Property::Rotation {
                turning[m.channel.target] = true;
            }
        }
        let mut sampler = Sampler::new(clip, skeleton);
        let mut shown = rest();
        // Of what does not move this stays.
        sampler.pose(0.0, &mut shown.local);
        Self {
            clip,
            skeleton,
            sampler,
            reaches: reaches(skeleton),
            skin_metres: SHARE * sampling_bound_metres(skeleton),
            moving,
            turning,
            jump_times: rising(all_jumps.collect()),
            times: times(clip),
            wanted: rest(),
            shown,
            kept: KeptFrames {
                most_joints: KEPT_JOINTS,
                frames: Vec::new(),
                poses: Vec::new(),
            },
        }
    }

    /// Whether frames of a rate stay within the bounds at all measured times.
    pub(super) fn follows(&mut self, rate_hz: f32) -> bool {
        self.deviation(rate_hz, 1.0) <= 1.0
    }

    /// The lowest of rising rates that follows the clip, or else the lowest usual one that comes about
    /// as close as any does.
    pub(super) fn best(&mut self, rates: &[f32]) -> Option<f32> {
        if let Some(rate) = rates.iter().find(|r| self.follows(**r)) {
            return Some(*rate);
        }
        self.times.truncate(FEW_TIMES);
        // The highest first: of one that is not good, it suffices to know that.
        let usual = rates.iter().rev().filter(|r| USUAL_RATES_HZ.contains(r));
        let (mut measured, mut least) = (Vec::new(), f32::INFINITY);
        for rate in usual {
            let deviation = self.deviation(*rate, AS_GOOD * least);
            least = least.min(deviation);
            measured.push((*rate, deviation));
        }
        let good = measured.iter().rev().find(|m| m.1 <= AS_GOOD * least);
        good.map(|m| m.0)
    }

    /// The greatest deviation at any measured time, as a multiple of its bound; some value beyond
    /// `enough` if it is greater than that.
    fn deviation(&mut self, rate_hz: f32, enough: f32) -> f32 {
        let frames = Frames::new(self.clip.duration_secs, rate_hz);
        self.kept.forget(frames.steps, self.skeleton);
        let (mut greatest, mut known): (f32, usize) = (0.0, 0);
        let mut order: Vec<usize> = Vec::new();
        while known < self.times.len() {
            // More and more at once, in the order of time: neighbours share keys and frames.
            let end = (2 * known + 1).min(self.times.len());
            order.clear();
            order.extend(known..end);
            order.sort_unstable_by(|a, b| self.times[*a].total_cmp(&self.times[*b]));
            let mut found = vec![0.0; end - known];
            for i in &order {
                found[i - known] = self.deviation_at(self.times[*i], frames);
            }
            for (i, found) in (known..end).zip(found) {
                greatest = greatest.max(found);
                if greatest > enough {
                    // Of the next rate too this is the most doubtful time.
                    self.times.swap(0, i);
                    return greatest;
                }
            }
            known = end;
        }
        greatest
    }

    /// The deviation at a time, as a multiple of its bound; 0 in a jump.
    fn deviation_at(&mut self, time: f32, frames: Frames) -> f32 {
        if self.is_in_jump(time, frames.rate_hz) {
            return 0.0;
        }
        self.sampler.pose(time, &mut self.wanted.local);
        let weights = self.show(time, frames);
        weights.max(self.apart())
    }

    /// Whether a time is within a frame of a jump, at a rate at which a jump may take a frame.
    fn is_in_jump(&self, time: f32, rate_hz: f32) -> bool {
        if rate_hz < JUMP_HZ * 0.999 {
            return false;
        }
        let near = 1.001 / rate_hz;
        let next = self.jump_times.partition_point(|t| *t < time - near);
        self.jump_times.get(next).is_some_and(|t| *t <= time + near)
    }

    /// Blends the frames around a time into the shown pose; returns the deviation of weights.
    fn show(&mut self, time: f32, frames: Frames) -> f32 {
        let (before, after, blend) = frames.around(time);
        // One of the two.
        let held = frames.held(time);
        let slots = [before, after, held].map(|frame| self.keep(frame, frames));
        let [before_pose, after_pose, held_pose] = slots.map(|slot| &self.kept.poses[slot]);
        let mut greatest: f32 = 0.0;
        for Moving { channel, jumps, .. } in &self.moving {
            let (from, to, blend) = match channel.interpolation {
                Interpolation::Step => (held_pose, held_pose, 0.0),
                _ => (before_pose, after_pose, blend),
            };
            let (local, target) = (&mut self.shown.local, channel.target);
            match channel.property {
                Property::Rotation => {
                    let [a, b] = [from, to].map(|pose| pose.rotations[target]);
                    local.rotations[target] = nlerp(a, same_hemisphere(a, b), blend);
                }
                Property::Translation => {
                    let [a, b] = [from, to].map(|pose| pose.translations[target]);
                    local.translations[target] = a.lerp(b, blend);
                }
                Property::Scale => {
                    let [a, b] = [from, to].map(|pose| pose.scales[target]);
                    local.scales[target] = a.lerp(b, blend);
                }
                Property::Weights | Property::Expression => {
                    let [from, to] = match channel.interpolation {
                        Interpolation::Step => [held, held],
                        _ => [before, after],
                    };
                    let secs = [from, to].map(|frame| frames.time_of(frame, channel, *jumps));
                    greatest =
                        greatest.max(weights_apart(channel, [secs[0], secs[1], time], blend));
                }
            }
        }
        greatest
    }

    /// Evaluates the joints of a frame, unless they are kept; returns its slot.
    fn keep(&mut self, frame: usize, frames: Frames) -> usize {
        let slot = frame % self.kept.frames.len();
        if self.kept.frames[slot] == Some(frame) {
            return slot;
        }
        self.kept.frames[slot] = Some(frame);
        let pose = &mut self.kept.poses[slot];
        for m in &mut self.moving {
            let target = m.channel.target;
            if !m.channel.property.is_of_joint() {
                continue;
            }
            let value = m.sampler.value(frames.time_of(frame, m.channel, m.jumps));
            match m.channel.property {
                Property::Translation => pose.translations[target] = Vec3::from_slice(&value),
                Property::Scale => pose.scales[target] = Vec3::from_slice(&value),
                _ => pose.rotations[target] = Quat::from_array(value),
            }
        }
        slot
    }

    /// The deviation of the shown pose from the wanted one.
    fn apart(&mut self) -> f32 {
        self.wanted.place(self.skeleton);
        self.shown.place(self.skeleton);
        let mut greatest: f32 = 0.0;
        for j in 0..self.skeleton.joints.len() {
            let [a, b] = [&self.wanted, &self.shown].map(|pose| pose.local.rotations[j]);
            let turned = match self.turning[j] {
                true => angle_between(a, b),
                false => 0.0,
            };
            let (a, b) = (&self.wanted.model[j], &self.shown.model[j]);
            let axes = [
                b.matrix3.x_axis - a.matrix3.x_axis,
                b.matrix3.y_axis - a.matrix3.y_axis,
                b.matrix3.z_axis - a.matrix3.z_axis,
            ];
            // A turn by an angle moves two of three axes by it, each point by at most its length
            // times it.
            let squares: f32 = axes.iter().map(|axis: &Vec3A| axis.length_squared()).sum();
            let moved =
                (b.translation - a.translation).length() + (0.5 * squares).sqrt() * self.reaches[j];
            greatest = greatest
                .max(turned / TURN_RADIANS)
                .max(moved / self.skin_metres);
        }
        greatest
    }
}

impl KeptFrames {
    /// Makes room for the frames of a rate; neighbours do not share a slot.
    fn forget(&mut self, steps: usize, skeleton: &Skeleton) {
        let joints = skeleton.joints.len().max(1);
        let slots = (steps + 1).min(self.most_joints / joints).max(2);
        self.frames.clear();
        self.frames.resize(slots, None);
        let rest = || skeleton.joints.iter().map(|j| j.rest).collect();
        self.poses.resize_with(slots, rest);
    }
}

impl Posed {
    fn place(&mut self, skeleton: &Skeleton) {
        for (j, joint) in skeleton.joints.iter().enumerate() {
            let local = self.local.get(j).to_affine();
            let above = joint.parent.filter(|p| *p < j);
            self.model[j] = above.map_or(local, |p| self.model[p] * local);
        }
    }
}

impl Frames {
    fn new(duration: f32, wanted: f32) -> Self {
        let duration_secs = if duration.is_finite() {
            duration.max(0.0)
        } else {
            0.0
        };
        let steps = (f64::from(duration_secs) * f64::from(wanted)).round() as usize;
        let rate_hz = if steps == 0 {
            wanted
        } else {
            exact_rate(steps, duration_secs, wanted)
        };
        Self {
            rate_hz,
            steps,
            duration_secs,
        }
    }

    fn time(&self, frame: usize) -> f32 {
        if frame >= self.steps {
            self.duration_secs
        } else {
            frame as f32 / self.rate_hz
        }
    }

    /// The time at which a channel shows a frame.
    fn time_of(&self, frame: usize, channel: &Channel, jumps: bool) -> f32 {
        frame_time(channel, jumps, self.time(frame), self.rate_hz)
    }

    /// The frames before and after a time, and the blend factor between them.
    fn around(&self, time: f32) -> (usize, usize, f32) {
        let at = f64::from(time) * f64::from(self.rate_hz);
        let at = at.clamp(0.0, self.steps as f64);
        let before = at as usize;
        let after = (before + 1).min(self.steps);
        (before, after, (at - before as f64) as f32)
    }

    /// The frame that steps show at a time: a key that differs from a frame by rounding is that frame.
    fn held(&self, time: f32) -> usize {
        let at = f64::from(time) * f64::from(self.rate_hz);
        ((at + ON_GRID_FRAMES) as usize).min(self.steps)
    }
}

/// Key times, midpoints between neighbouring ones, and random times.
fn times(clip: &RawClip) -> Vec<f32> {
    let mut random = SplitMix(SEED);
    let keys = clip
        .channels
        .iter()
        .flat_map(|c| c.times_secs.iter().copied());
    let mut times: Vec<f32> = keys.filter(|t| t.is_finite()).collect();
    times.sort_by(f32::total_cmp);
    times.dedup();
    let middles: Vec<f32> = times
        .windows(2)
        .filter(|w| w[1] - w[0] > 2.0 * JUMP_SECS)
        .map(|w| 0.5 * (w[0] + w[1]))
        .collect();
    times.extend(middles);
    // Random order: a rate that does not follow is noticed early.
    for i in 0..times.len().min(MAX_TIMES) {
        let other = i + random.below(times.len() - i);
        times.swap(i, other);
    }
    times.truncate(MAX_TIMES);
    let steps = 1 << 20;
    let secs = |_| clip.duration_secs * (random.below(steps) as f32 / steps as f32);
    times.extend((0..RANDOM_TIMES).map(secs));
    times
}

/// The figure's extent at rest, in metres: that of a root is in no other space.
/// Returns the displacement of the skin in metres within which frames at the rate of
/// [`sampling_rate_hz`](crate::sampling_rate_hz) follow keys of no regular interval: 0.1 mm, and in figures beyond 2 m a
/// share of their extent.
pub fn sampling_bound_metres(skeleton: &Skeleton) -> f32 {
    SKIN_METRES.max(EXTENT_SHARE * extent(skeleton))
}

fn extent(skeleton: &Skeleton) -> f32 {
    let joints = skeleton.joints.iter().zip(skeleton.local_extents());
    let roots = joints.filter(|(joint, _)| joint.parent.is_none());
    roots.map(|(_, extent)| extent).fold(0.0, f32::max)
}

/// Distance of the farthest skin of each joint in its own space: to its children, and at least a
/// share of the figure.
fn reaches(skeleton: &Skeleton) -> Vec<f32> {
    let model = skeleton.model_rest();
    let extents = skeleton.local_extents();
    let mut metres = vec![0.0f32; model.len()];
    let scale = |j: usize| {
        let axes = &model[j].matrix3;
        let longest = axes.x_axis.length().max(axes.y_axis.length());
        longest.max(axes.z_axis.length())
    };
    for (j, joint) in skeleton.joints.iter().enumerate() {
        let above = joint.parent.filter(|p| *p < j);
        // The extent is in units of the parent's space.
        let extent = extents[j] * above.map_or(1.0, scale);
        metres[j] = metres[j].max(SKIN_SHARE * extent);
        if let Some(p) = above {
            let bone = model[j].translation.distance(model[p].translation);
            metres[p] = metres[p].max(bone.min(extent));
        }
    }
    let local = |j: usize| metres[j] / scale(j).max(1e-12);
    (0..model.len()).map(local).collect()
}

/// The deviation of a blend between weights at two times from those at a third.
fn weights_apart(channel: &Channel, [from, to, time]: [f32; 3], blend: f32) -> f32 {
    let parts = match channel.interpolation {
        Interpolation::CubicSpline => 3,
        _ => 1,
    };
    let width = channel.values.len() / (parts * channel.times_secs.len());
    let at = |time| {
        let mut out = vec![0.0; width];
        evaluate::channel(channel, time, &mut out);
        out
    };
    let (a, b, wanted) = (at(from), at(to), at(time));
    let apart = |i: usize| (a[i] + (b[i] - a[i]) * blend - wanted[i]).abs();
    (0..width).map(apart).fold(0.0, f32::max) / WEIGHT
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::Joint;

    fn channel(target: usize, property: Property, keys: &[(f32, [f32; 4])]) -> Channel {
        let width = if property == Property::Rotation { 4 } else { 3 };
        Channel {
            target,
            property,
            interpolation: Interpolation::Linear,
            times_secs: keys.iter().map(|k| k.0).collect(),
            values: keys.iter().flat_map(|k| k.1[..width].to_vec()).collect(),
        }
    }

    /// A chain of three joints: one turns and jumps, one steps and has a channel that is still, one bends.
    fn chain() -> (RawClip, Skeleton) {
        let turn = |angle: f32| Quat::from_rotation_z(angle).to_array();
        let turns: Vec<_> = (0..40_u16)
            .map(|i| (f32::from(i) / 37.0, turn(0.3 * f32::from(i * i % 7))))
            .collect();
        let jump = [
            (0.0, [0.0; 4]),
            (0.5, [0.1, 0.0, 0.0, 0.0]),
            (0.5 + 0.5 * JUMP_SECS, [0.4, 0.2, 0.0, 0.0]),
            (1.05, [0.4, 0.0, 0.3, 0.0]),
        ];
        let steps = [(0.0, [1.0; 4]), (0.3, [1.2; 4]), (0.8, [0.9; 4])];
        let bend = [0.0, 0.7, 0.0, 0.5].map(turn);
        let spline = Channel {
            interpolation: Interpolation::CubicSpline,
            times_secs: vec![0.1, 0.9],
            values: [[0.0; 4], bend[0], [0.1; 4], [-0.2; 4], bend[1], [0.0; 4]].concat(),
            ..channel(2, Property::Rotation, &[])
        };
        let stepped = Channel {
            interpolation: Interpolation::Step,
            ..channel(1, Property::Scale, &steps)
        };
        let still = [(0.0, turn(0.4)), (1.0, turn(0.4))];
        let clip = RawClip {
            duration_secs: 1.05,
            channels: vec![
                channel(0, Property::Rotation, &turns),
                channel(0, Property::Translation, &jump),
                stepped,
                channel(1, Property::Rotation, &still),
                spline,
            ],
            ..RawClip::default()
        };
        let joint = |parent: Option<usize>| Joint {
            name: String::new(),
            parent,
            rest: Transform::from_translation(0.3 * Vec3::Y),
            in_skin: true,
        };
        let joints = vec![joint(None), joint(Some(0)), joint(Some(1))];
        (clip, Skeleton { joints })
    }

    #[test]
    fn neither_the_order_of_times_nor_kept_frames_change_a_deviation() {
        let (clip, skeleton) = chain();
        for rate_hz in [10.0, 24.0, 37.0, 60.0, 120.0] {
            let mut whole = Follower::new(&clip, &skeleton);
            let all = whole.deviation(rate_hz, f32::INFINITY);
            whole.kept.most_joints = 0;
            assert_eq!(whole.deviation(rate_hz, f32::INFINITY), all);
            let frames = Frames::new(clip.duration_secs, rate_hz);
            let alone = |time: &f32| {
                let mut fresh = Follower::new(&clip, &skeleton);
                fresh.kept.forget(frames.steps, &skeleton);
                fresh.deviation_at(*time, frames)
            };
            let each: Vec<f32> = whole.times.iter().map(alone).collect();
            assert_eq!(each.iter().fold(0.0f32, |a, b| a.max(*b)), all);
            // With a bound the first time beyond it is told, in the order of the list, and comes first from then on.
            let enough = 0.5 * all;
            let first = each.iter().position(|d| *d > enough).unwrap();
            let doubtful = whole.times[first];
            let told = whole.deviation(rate_hz, enough);
            assert_eq!(told, each[..=first].iter().fold(0.0f32, |a, b| a.max(*b)));
            assert_eq!(whole.times[0], doubtful);
        }
    }
}
