//! How far frames of a rate, blended as in playback, are from the keys of a clip.

use super::{ON_GRID_FRAMES, USUAL_RATES_HZ, exact_rate, frame_time};
use crate::key_times::rising;
use crate::split_mix::SplitMix;
use articula_core::source::evaluate::{self, Sampler};
use articula_core::source::{Channel, Interpolation, JUMP_SECS, Property, RawClip, Skeleton};
use articula_core::{LocalPose, angle_between, nlerp, same_hemisphere};
use glam::{Affine3A, Quat, Vec3, Vec3A};

/// Share of the stated bounds that the measured times may show: between them blends lag a little more.
const SHARE: f32 = 0.7;
/// Maximum displacement of skin, 0.1 mm, in figures beyond 2 m as a share of their extent, and of a joint's rotation against its parent, 0.05 degrees.
const SKIN_METRES: f32 = SHARE * 1e-4;
const EXTENT_SHARE: f32 = SHARE * 5e-5;
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
    /// Which channels change at once.
    jumps: Vec<bool>,
    jump_times: Vec<f32>,
    times: Vec<f32>,
    wanted: Posed,
    shown: Posed,
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
        Self {
            clip,
            skeleton,
            sampler: Sampler::new(clip, skeleton),
            reaches: reaches(skeleton),
            skin_metres: SKIN_METRES.max(EXTENT_SHARE * extent(skeleton)),
            jumps: channels.map(|c| c.jump_times().next().is_some()).collect(),
            jump_times: rising(all_jumps.collect()),
            times: times(clip),
            wanted: rest(),
            shown: rest(),
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
        let usual = rates.iter().filter(|r| USUAL_RATES_HZ.contains(r));
        let measured: Vec<(f32, f32)> = usual
            .map(|rate| (*rate, self.deviation(*rate, f32::INFINITY)))
            .collect();
        let least = measured.iter().map(|m| m.1).fold(f32::INFINITY, f32::min);
        let good = measured.iter().find(|m| m.1 <= AS_GOOD * least);
        good.map(|m| m.0)
    }

    /// The greatest deviation at any measured time, as a multiple of its bound; some value beyond
    /// `enough` if it is greater than that.
    fn deviation(&mut self, rate_hz: f32, enough: f32) -> f32 {
        let frames = Frames::new(self.clip.duration_secs, rate_hz);
        let mut greatest: f32 = 0.0;
        for i in 0..self.times.len() {
            let time = self.times[i];
            if self.is_in_jump(time, frames.rate_hz) {
                continue;
            }
            self.sampler.pose(time, &mut self.wanted.local);
            let weights = self.show(time, frames);
            greatest = greatest.max(weights).max(self.apart());
            if greatest > enough {
                // Of the next rate too this is the most doubtful time.
                self.times.swap(0, i);
                break;
            }
        }
        greatest
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
        let held = frames.held(time);
        let mut greatest: f32 = 0.0;
        for (channel, jumps) in self.clip.channels.iter().zip(&self.jumps) {
            let secs = |frame| frame_time(channel, *jumps, frames.time(frame), frames.rate_hz);
            let (from, to, blend) = match channel.interpolation {
                Interpolation::Step => (secs(held), secs(held), 0.0),
                _ => (secs(before), secs(after), blend),
            };
            let local = &mut self.shown.local;
            match channel.property {
                Property::Rotation => {
                    let [a, b] = [from, to].map(|t| Quat::from_array(value(channel, t)));
                    local.rotations[channel.target] = nlerp(a, same_hemisphere(a, b), blend);
                }
                Property::Translation | Property::Scale => {
                    let [a, b] = [from, to].map(|t| Vec3::from_array(value(channel, t)));
                    let to = if channel.property == Property::Scale {
                        &mut local.scales
                    } else {
                        &mut local.translations
                    };
                    to[channel.target] = a.lerp(b, blend);
                }
                Property::Weights | Property::Expression => {
                    greatest = greatest.max(weights_apart(channel, [from, to, time], blend));
                }
            }
        }
        greatest
    }

    /// The deviation of the shown pose from the wanted one.
    fn apart(&mut self) -> f32 {
        self.wanted.place(self.skeleton);
        self.shown.place(self.skeleton);
        let mut greatest: f32 = 0.0;
        for j in 0..self.skeleton.joints.len() {
            let turned = angle_between(
                self.wanted.local.rotations[j],
                self.shown.local.rotations[j],
            );
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

fn value<const N: usize>(channel: &Channel, time: f32) -> [f32; N] {
    let mut out = [0.0; N];
    evaluate::channel(channel, time, &mut out);
    out
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
