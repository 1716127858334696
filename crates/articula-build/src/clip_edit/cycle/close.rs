//! Closes a loop: makes the last pose of a clip equal its first.
//!
//! The difference of a channel at the seam is split between its two ends and fades out from there
//! (smoothly, so that velocities at the seam stay as they are): rotations turn by a part of the
//! missing rotation, all other properties move by a part of the missing difference.
//!
//! Travel over the ground is not part of that difference. The joint that travels (the hips in most
//! files, a root above them in others) ends where it ended, as upright as it began: its last pose
//! is its first, moved by the travel of the clip. A turn about the vertical is kept likewise if it
//! is greater than [`TURN_RADIANS`]; a smaller one counts as drift and is removed.

use super::super::channel;
use super::super::grid::grid;
use super::super::heading::yaw;
use super::super::similarity::Similarity;
use super::super::subject::{EditSubject, Posed};
use crate::clip::steps_at;
use crate::key_times::SAME_SECS;
use crate::sampling_rate::source_rate_hz;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{Libm, LibmQuat};
use articula_core::{Mismatch, angle_between, same_hemisphere};
use glam::{Quat, Vec3};

/// A clip that turns by more than this follows a curve and is to continue along it.
pub(super) const TURN_RADIANS: f32 = 0.26;

/// Minimum key rate where a channel is bent towards its other end.
const BENT_HZ: f32 = 30.0;

/// Options of closing a loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CloseOptions {
    /// Length in seconds, at either end, over which the seam is blended; `None` uses half of the
    /// clip.
    pub window_secs: Option<f32>,
}

/// A closed loop and measurements of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedLoop {
    /// The closed clip.
    pub clip: RawClip,
    /// Length in seconds, at either end, over which the seam was blended.
    pub window_secs: f32,
    /// Maximum distance in metres by which closing moved any joint, at any time.
    pub moved_metres: f32,
    /// Turn of the figure about the vertical in one cycle, radians.
    pub turn_radians: f32,
    /// Distance that the figure travels over the ground in one cycle, metres.
    pub travel_metres: f32,
    /// Maximum angle between the first and the last local rotation of any joint, without the kept
    /// turn, radians.
    pub seam_radians: f32,
}

/// Makes the last pose of a clip equal its first, except for travel over the ground.
///
/// # Errors
/// A [`Mismatch`] if the clip does not belong to this character or is longer than can be verified.
pub fn close_loop(
    subject: &EditSubject<'_>,
    clip: &RawClip,
    opts: &CloseOptions,
) -> Result<ClosedLoop, Mismatch> {
    subject.check(clip)?;
    let end = clip.duration_secs;
    steps_at(clip, end, crate::clip_edit::grid::VERIFIED_HZ, 1)?;
    let window_secs = opts.window_secs.unwrap_or(end).min(0.5 * end).max(0.0);
    let round = Round::of(subject, clip);
    let bend = Bend {
        window_secs,
        end_secs: end,
        key_secs: 1.0 / source_rate_hz(clip).clamp(BENT_HZ, 120.0),
    };
    let mut out = clip.clone();
    if window_secs > 10.0 * SAME_SECS {
        for channel in out.channels.iter_mut().filter(|c| c.times_secs.len() > 1) {
            bend.close(channel, round.step(channel));
        }
    }
    let (mut a, mut b) = (subject.rest(), subject.rest());
    let (mut before, mut after) = (subject.sampler(clip), subject.sampler(&out));
    let mut moved_metres = 0.0f32;
    for secs in grid([clip, &out], end) {
        subject.next_pose(&mut before, secs, &mut a);
        subject.next_pose(&mut after, secs, &mut b);
        for j in 0..subject.rig.len() {
            moved_metres = moved_metres.max(a.model.position(j).distance(b.model.position(j)));
        }
    }
    subject.pose(&out, 0.0, &mut a);
    subject.pose(&out, end, &mut b);
    Ok(ClosedLoop {
        clip: out,
        window_secs,
        moved_metres,
        turn_radians: round.yaw,
        travel_metres: round.travel,
        seam_radians: round.seam(&a, &b),
    })
}

/// The motion of the whole figure in one cycle of a loop.
struct Round {
    /// Joints that take the travel: the one that makes it, and its siblings that move along (such
    /// as targets for feet).
    carried: Vec<usize>,
    /// Joints that take the turn.
    turned: Vec<usize>,
    /// The motion of one cycle, in the space of their parent.
    step: Similarity,
    yaw: f32,
    travel: f32,
}

impl Round {
    fn of(subject: &EditSubject<'_>, clip: &RawClip) -> Self {
        let (mut first, mut last) = (subject.rest(), subject.rest());
        subject.pose(clip, 0.0, &mut first);
        subject.pose(clip, clip.duration_secs, &mut last);
        let joint = traveller(subject, clip, &first, &last);
        let parent = placed(subject, joint, &first);
        let place = |posed: &Posed| parent * Similarity::of(posed.local.get(joint));
        let (from, to) = (place(&first), place(&last));
        let turn = yaw((to.rotation * from.rotation.conjugate()).as_quat());
        let yaw = if turn.abs() > TURN_RADIANS { turn } else { 0.0 };
        let on_ground = Similarity::on_ground(f64::from(yaw), from.translation, to.translation);
        let step = parent.inverse() * on_ground * parent;
        let goes_along = |j: &usize| {
            let [s, e] = [&first, &last].map(|p| p.local.translations[*j]);
            let taken = step.point(s.as_dvec3()).as_vec3();
            *j == joint || e.distance(taken) < e.distance(s)
        };
        let turns_along = |j: &usize| {
            let [s, e] = [&first, &last].map(|p| p.local.rotations[*j]);
            let taken = step.rotation.as_quat() * s;
            *j == joint || angle_between(e, taken) < angle_between(e, s)
        };
        let beside = subject.rig.parent(joint);
        let beside = (0..subject.rig.len()).filter(|j| subject.rig.parent(*j) == beside);
        let way = to.translation - from.translation;
        Self {
            carried: beside.clone().filter(goes_along).collect(),
            turned: beside.filter(turns_along).collect(),
            step,
            yaw,
            travel: way.x.libm_hypot(way.z) as f32,
        }
    }

    /// The transform from a channel's first value to the last one that it should have.
    fn step(&self, channel: &Channel) -> Similarity {
        let taken = match channel.property {
            Property::Translation => self.carried.contains(&channel.target),
            Property::Rotation => self.turned.contains(&channel.target),
            _ => false,
        };
        if taken {
            self.step
        } else {
            Similarity::IDENTITY
        }
    }

    fn seam(&self, first: &Posed, last: &Posed) -> f32 {
        let turn = self.step.rotation.as_quat();
        let apart = (0..first.local.rotations.len()).map(|j| {
            let [a, b] = [first, last].map(|p| p.local.rotations[j]);
            let turned = self.turned.contains(&j);
            angle_between(if turned { turn * a } else { a }, b)
        });
        apart.fold(0.0, f32::max)
    }
}

/// The joint, from the hips upwards, that travels farthest over the ground by itself; the topmost
/// moving joint if none travels.
fn traveller(subject: &EditSubject<'_>, clip: &RawClip, first: &Posed, last: &Posed) -> usize {
    let hips = subject.hips();
    let up = std::iter::successors(Some(hips), |j| subject.rig.parent(*j));
    let moves = |j: &usize| {
        let of_joint = |c: &&Channel| c.property.is_of_joint() && c.target == *j;
        let mut channels = clip.channels.iter().filter(of_joint);
        channels.any(|c| c.times_secs.len() > 1)
    };
    let way = |j: usize| {
        let parent = placed(subject, j, first);
        let [a, b] = [first, last].map(|p| p.local.translations[j].as_dvec3());
        let way = parent.point(b) - parent.point(a);
        way.x.libm_hypot(way.z)
    };
    let mut best = (hips, 0.0);
    for joint in up.filter(moves) {
        // Where two hardly differ, the upper one is taken.
        if way(joint) >= best.1 - MIN_WAY {
            best = (joint, way(joint).max(best.1));
        }
    }
    best.0
}

/// Travel distances that differ by less than this count as equal.
const MIN_WAY: f64 = 1e-3;

/// Model-from-parent of a joint.
fn placed(subject: &EditSubject<'_>, joint: usize, posed: &Posed) -> Similarity {
    let above = std::iter::successors(subject.rig.parent(joint), |j| subject.rig.parent(*j));
    above.fold(Similarity::IDENTITY, |below, j| {
        Similarity::of(posed.local.get(j)) * below
    })
}

/// Bends both ends of a channel towards each other.
struct Bend {
    window_secs: f32,
    end_secs: f32,
    /// Time between keys where a channel is bent.
    key_secs: f32,
}

impl Bend {
    /// Share of the difference that is added at a time, from -1/2 at the start to 1/2 at the end,
    /// and its rate of change.
    fn share(&self, secs: f32) -> (f32, f32) {
        let (w, from_end) = (self.window_secs, self.end_secs - secs);
        let smooth = |u: f32| (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / w);
        if secs < w {
            let (share, rate) = smooth(1.0 - secs / w);
            (-0.5 * share, 0.5 * rate)
        } else if from_end < w {
            let (share, rate) = smooth(1.0 - from_end / w);
            (0.5 * share, 0.5 * rate)
        } else {
            (0.0, 0.0)
        }
    }

    fn close(&self, channel: &mut Channel, step: Similarity) {
        channel::put_key(channel, 0.0);
        channel::put_key(channel, self.end_secs);
        let lack = Lack::of(channel, step);
        if channel.interpolation != Interpolation::Step {
            if channel.interpolation == Interpolation::Linear && lack.shows() {
                self.put_keys(channel);
            }
            let range = range(channel);
            for key in 0..channel.times_secs.len() {
                let (share, rate) = self.share(channel.times_secs[key]);
                lack.give(channel, key, share, rate);
                clamp(channel, key, &range);
            }
        }
        // Exact to the last bit, in spite of rounding.
        let last = channel.times_secs.len() - 1;
        let mut end = lack.end(channel::key_value(channel, 0));
        let shown = channel::key_value_mut(channel, last);
        let dot: f32 = shown.iter().zip(&end).map(|(a, b)| a * b).sum();
        if channel.property == Property::Rotation && dot < 0.0 {
            // The same rotation, in the hemisphere of the keys before it.
            end.iter_mut().for_each(|v| *v = -*v);
        }
        channel::key_value_mut(channel, last).copy_from_slice(&end);
    }

    /// Inserts keys within the windows, so that straight pieces follow the bend.
    fn put_keys(&self, channel: &mut Channel) {
        let count = (self.window_secs / self.key_secs).ceil() as usize;
        let steps = (1..=count).map(|i| self.window_secs * i as f32 / count as f32);
        for into in steps {
            for secs in [into, self.end_secs - into] {
                let times = &channel.times_secs;
                let after = times.partition_point(|t| *t < secs);
                let near = times[after.saturating_sub(1)..times.len().min(after + 1)].iter();
                let nearest = near.map(|t| (t - secs).abs()).fold(f32::INFINITY, f32::min);
                if nearest > 0.75 * self.key_secs {
                    channel::put_key(channel, secs);
                }
            }
        }
    }
}

/// The difference between a channel's end and its start.
enum Lack {
    /// Rotations: the turn of one cycle, and what remains, multiplied on the right.
    Turn { step: Quat, lack: Quat },
    /// Translations: the motion of one cycle, and what remains.
    Way { step: Similarity, lack: Vec3 },
    /// All other properties.
    Difference(Vec<f32>),
}

impl Lack {
    fn of(channel: &Channel, step: Similarity) -> Self {
        let first = channel::key_value(channel, 0);
        let last = channel::key_value(channel, channel.times_secs.len() - 1);
        match channel.property {
            Property::Rotation => {
                let step = step.rotation.as_quat();
                let [a, b] = [first, last].map(|v| Quat::from_slice(v).normalize());
                let lack = same_hemisphere(Quat::IDENTITY, b.conjugate() * step * a);
                Self::Turn { step, lack }
            }
            Property::Translation => {
                let end = step.point(Vec3::from_slice(first).as_dvec3()).as_vec3();
                let lack = end - Vec3::from_slice(last);
                Self::Way { step, lack }
            }
            _ => Self::Difference(first.iter().zip(last).map(|(a, b)| a - b).collect()),
        }
    }

    /// Whether it is more than rounding.
    fn shows(&self) -> bool {
        match self {
            Self::Turn { lack, .. } => angle_between(Quat::IDENTITY, *lack) > 1e-5,
            Self::Way { lack, step } => {
                f64::from(lack.length()) > 1e-6 * step.translation.length().max(1.0)
            }
            Self::Difference(lack) => lack.iter().any(|v| v.abs() > 1e-5),
        }
    }

    /// The last value that belongs to a first one.
    fn end(&self, first: &[f32]) -> Vec<f32> {
        match self {
            Self::Turn { step, .. } => (*step * Quat::from_slice(first)).to_array().to_vec(),
            Self::Way { step, .. } => {
                let end = step.point(Vec3::from_slice(first).as_dvec3());
                end.as_vec3().to_array().to_vec()
            }
            Self::Difference(_) => first.to_vec(),
        }
    }

    /// Adds a share of the difference to a key, and the rate of the share to its tangents.
    fn give(&self, channel: &mut Channel, key: usize, share: f32, rate: f32) {
        let width = channel::width(channel);
        let parts = channel::parts(channel.interpolation);
        let at = key * parts * width;
        let floats = &mut channel.values[at..at + parts * width];
        let middle = parts / 2;
        match self {
            Self::Turn { lack, .. } => {
                let turn = Quat::IDENTITY.libm_slerp(*lack, share.abs());
                let turn = if share < 0.0 { turn.conjugate() } else { turn };
                let half = Quat::from_vec4((0.5 * lack.libm_to_scaled_axis()).extend(0.0));
                let value = Quat::from_slice(&floats[middle * width..]) * turn;
                for (part, floats) in floats.chunks_mut(width).enumerate() {
                    let given = if part == middle {
                        value.normalize()
                    } else {
                        Quat::from_slice(floats) * turn + value * half * rate
                    };
                    floats.copy_from_slice(&given.to_array());
                }
            }
            Self::Way { lack, step } => {
                // At the start it is applied in the figure's own direction there.
                let back = step.rotation.as_quat().conjugate();
                let lack = if share < 0.0 { back * *lack } else { *lack };
                add(floats, &lack.to_array(), middle, share, rate);
            }
            Self::Difference(lack) => add(floats, lack, middle, share, rate),
        }
    }
}

fn add(floats: &mut [f32], lack: &[f32], middle: usize, share: f32, rate: f32) {
    for (part, floats) in floats.chunks_mut(lack.len()).enumerate() {
        let share = if part == middle { share } else { rate };
        floats
            .iter_mut()
            .zip(lack)
            .for_each(|(f, l)| *f += share * l);
    }
}

/// Range of weights and expressions, which are undefined outside of it.
fn range(channel: &Channel) -> Option<(f32, f32)> {
    if channel.property.is_of_joint() {
        return None;
    }
    let keys = (0..channel.times_secs.len()).flat_map(|k| channel::key_value(channel, k));
    Some(keys.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v))))
}

fn clamp(channel: &mut Channel, key: usize, range: &Option<(f32, f32)>) {
    if let Some((low, high)) = range {
        for v in channel::key_value_mut(channel, key) {
            *v = v.clamp(*low, *high);
        }
    }
}
