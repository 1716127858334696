//! Contacts of hands with the own body: on hips, thighs, chest or head, and with each other.
//!
//! Directions alone do not keep them on a body of other proportions. Here a hand that is near a part
//! of the source's body, and moves with it, comes to the same place on the target's: at the same
//! share of the part's length, in the same direction from it, at the distance in proportion to the
//! size. Two hands that come near each other keep their offset. Weights are continuous in distance
//! and speed, so nothing jumps.

use super::planted::{Planted, averaged};
use super::pose::Pose;
use super::side::Side;
use super::transfer::Transfer;
use articula_core::Libm;
use glam::Vec3;

/// Distances from a part of the body, in leg lengths, below which a hand rests on it and above which
/// it does not.
const NEAR: [f32; 2] = [0.28, 0.5];
/// Distances of the wrists from each other, likewise.
const TOGETHER: [f32; 2] = [0.2, 0.45];
/// Speeds of a hand relative to the part, in leg lengths per second, likewise.
const STILL: [f32; 2] = [0.15, 0.6];
/// Time over which weights and speeds are smoothed.
const SMOOTH_SECS: f32 = 0.2;

/// A part of the body between two joints; it turns with the first.
#[derive(Debug, Clone, Copy)]
struct Part {
    source: [usize; 2],
    target: [usize; 2],
    /// Size of the target's part over that of the source.
    scale: f32,
}

/// Where a hand rests on a part at a frame.
#[derive(Debug, Clone, Copy, Default)]
struct Touch {
    /// Share of the part's length.
    share: f32,
    /// Offset from there to the wrist, in the frame of the body, in lengths of the target.
    offset: Vec3,
    weight: f32,
}

/// Contacts of both hands with the body, frame by frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Touches {
    parts: Vec<Part>,
    /// For each hand, each part, each frame.
    touches: [Vec<Vec<Touch>>; 2],
    /// Offset from the left wrist to the right one in the target's world, and its weight.
    together: Vec<(Vec3, f32)>,
}

impl Touches {
    /// Finds the contacts in the source's motion.
    pub(super) fn new(transfer: &Transfer<'_>) -> Self {
        let (source, target) = (transfer.source, transfer.target);
        let wrists = ['l', 'r'].map(|side| source.rest.sided(side, "wrist"));
        let parts = parts(source, target, transfer.plan.scale);
        let of_hand = |wrist: Option<usize>| -> Vec<Vec<Touch>> {
            let Some(wrist) = wrist else {
                return Vec::new();
            };
            let track = |part: &Part| touches(transfer, part, wrist);
            parts.iter().map(track).collect()
        };
        let touches = wrists.map(of_hand);
        let together = match wrists {
            [Some(left), Some(right)] => together(transfer, left, right),
            _ => Vec::new(),
        };
        Self {
            parts,
            touches,
            together,
        }
    }

    /// Brings the hands of a pose to where they rest.
    pub(super) fn apply(
        &self,
        transfer: &Transfer<'_>,
        limbs: &[Planted],
        frame: usize,
        pose: &mut Pose,
    ) {
        let target = transfer.target;
        let arms: [Option<&Planted>; 2] = ['l', 'r'].map(|side| {
            let wrist = target.rest.sided(side, "wrist")?;
            limbs.iter().find(|l| !l.is_leg && l.limb.end == wrist)
        });
        let mut goals: [Option<Vec3>; 2] = [None; 2];
        for (hand, arm) in arms.iter().enumerate() {
            let Some(arm) = arm else { continue };
            let own = pose.positions[arm.limb.end];
            goals[hand] = Some(self.on_body(target, hand, frame, pose, own));
        }
        if let ([Some(left), Some(right)], Some((offset, weight))) =
            (goals, self.together.get(frame))
        {
            let middle = 0.5 * (left + right);
            goals = [
                Some(left.lerp(middle - 0.5 * *offset, *weight)),
                Some(right.lerp(middle + 0.5 * *offset, *weight)),
            ];
        }
        for (arm, goal) in arms.iter().zip(goals) {
            if let Some((arm, goal)) = arm.zip(goal)
                && goal.distance_squared(pose.positions[arm.limb.end]) > 0.0
            {
                arm.limb.reach(pose, goal);
            }
        }
        let root = pose.positions[target.body.root];
        pose.place(transfer.plan, target, root);
    }

    /// Where a hand rests on the parts of the body, `own` where it does not.
    fn on_body(&self, target: &Side, hand: usize, frame: usize, pose: &Pose, own: Vec3) -> Vec3 {
        let (mut sum, mut total, mut most) = (Vec3::ZERO, 0.0, 0.0f32);
        for (part, track) in self.parts.iter().zip(&self.touches[hand]) {
            let Some(touch) = track.get(frame).filter(|t| t.weight > 0.0) else {
                continue;
            };
            let [from, to] = part.target.map(|joint| pose.positions[joint]);
            let turn = pose.deltas[part.target[0]] * target.body.axes;
            let place = from.lerp(to, touch.share) + turn * touch.offset;
            let weight = touch.weight * touch.weight;
            sum += weight * place;
            total += weight;
            most = most.max(touch.weight);
        }
        if total > 0.0 {
            own.lerp(sum / total, most)
        } else {
            own
        }
    }
}

/// The parts that both bodies have.
fn parts(source: &Side, target: &Side, scale: f32) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut add = |names: [&str; 2], scale: f32| {
        let find = |side: &Side| -> Option<[usize; 2]> {
            Some([side.rest.find(names[0])?, side.rest.find(names[1])?])
        };
        if let Some((source, target)) = find(source).zip(find(target)) {
            parts.push(Part {
                source,
                target,
                scale,
            });
        }
    };
    let across = |side: &Side, name: &str| {
        let [left, right] = ['l', 'r'].map(|s| side.rest.sided(s, name));
        left.zip(right).map(|(l, r)| side.rest.way(l, r).length())
    };
    // A broad trunk keeps hands farther from its middle.
    let broad = |name: &str| {
        let widths = across(target, name).zip(across(source, name));
        widths.map_or(scale, |(t, s)| if s > 1e-6 { t / s } else { scale })
    };
    for top in ["vc7", "vc4", "skullbase"] {
        if source.rest.find(top).is_some() && target.rest.find(top).is_some() {
            add(["humanoid_root", top], broad("shoulder"));
            break;
        }
    }
    add(["l_hip", "r_hip"], broad("hip").max(scale));
    add(["l_hip", "l_knee"], scale);
    add(["r_hip", "r_knee"], scale);
    add(["skullbase", "vc4"], scale);
    parts
}

/// Where a wrist rests on a part, frame by frame.
fn touches(transfer: &Transfer<'_>, part: &Part, wrist: usize) -> Vec<Touch> {
    let (motion, source) = (transfer.motion, transfer.source);
    let leg = source.body.leg_metres;
    let mut found = Vec::with_capacity(motion.frames());
    let mut near = Vec::with_capacity(motion.frames());
    for frame in 0..motion.frames() {
        let at = motion.positions(frame);
        let [from, to] = part.source.map(|joint| at[joint]);
        let way = to - from;
        let along = (at[wrist] - from).dot(way) / way.length_squared().max(1e-12);
        let share = along.clamp(0.0, 1.0);
        let offset = at[wrist] - from.lerp(to, share);
        near.push(1.0 - smooth(offset.length() / leg, NEAR));
        let turn = motion.deltas(frame)[part.source[0]] * source.body.axes;
        found.push(Touch {
            share,
            offset: part.scale * (turn.inverse() * offset),
            weight: 0.0,
        });
    }
    // Speed against the part, over a short time.
    let reach = ((0.5 * SMOOTH_SECS * motion.rate_hz).round() as usize).max(1);
    let last = found.len().saturating_sub(1);
    let length = source.rest.way(part.source[0], part.source[1]).length();
    let weights: Vec<f32> = (0..found.len())
        .map(|frame| {
            let (a, b) = (frame.saturating_sub(reach), (frame + reach).min(last));
            let moved = (found[b].offset - found[a].offset) / part.scale.max(1e-6);
            let slid = length * (found[b].share - found[a].share);
            let secs = (b - a).max(1) as f32 / motion.rate_hz;
            let speed = moved.length().libm_hypot(slid) / (secs * leg);
            near[frame] * (1.0 - smooth(speed, STILL))
        })
        .collect();
    for (touch, weight) in found.iter_mut().zip(averaged(&weights, reach)) {
        touch.weight = weight;
    }
    found
}

/// Offset between the wrists and its weight, frame by frame.
fn together(transfer: &Transfer<'_>, left: usize, right: usize) -> Vec<(Vec3, f32)> {
    let (motion, plan) = (transfer.motion, transfer.plan);
    let leg = transfer.source.body.leg_metres;
    let offset = |frame: usize| {
        let at = motion.positions(frame);
        at[right] - at[left]
    };
    (0..motion.frames())
        .map(|frame| {
            let way = offset(frame);
            let weight = 1.0 - smooth(way.length() / leg, TOGETHER);
            (plan.world * (plan.scale * way), weight)
        })
        .collect()
}

/// 0 below the first limit, 1 above the second, smooth between.
fn smooth(value: f32, [low, high]: [f32; 2]) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
