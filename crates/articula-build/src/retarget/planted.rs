//! Bends limbs and lowers the hips so that pinned feet and hands stay in place.

use super::contacts::Contact;
use super::limb::Limb;
use super::pin::{Goal, Path, goals};
use super::pose::Pose;
use super::steps::{Sole, rest_floor, soles};
use super::transfer::Transfer;
use glam::Vec3;

/// Maximum distance by which the hips sink so that both feet reach the floor, in leg lengths.
const MAX_SINK: f32 = 0.12;
/// Maximum distance by which the hips rise so that folded legs have room, in leg lengths.
const MAX_RISE: f32 = 0.4;
/// Time over which the hips sink or rise, and return.
const SINK_SECS: f32 = 0.2;
/// Share of its length to which a leg may extend before the hips sink.
const STRETCH: f32 = 0.999;

/// Ends of limbs that are pinned while those of the source rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactPinning {
    /// No limb is pinned.
    Nothing,
    /// The feet, which are also kept above the floor.
    #[default]
    Feet,
    /// The feet, and hands that rest on something.
    FeetAndHands,
}

/// One limb with the points of its end that may rest.
#[derive(Debug, Clone)]
pub(super) struct Planted {
    pub(super) limb: Limb,
    pub(super) points: Vec<(Sole, Vec<Contact>)>,
    pub(super) is_leg: bool,
}

/// The limbs of the target, legs first.
pub(super) fn limbs(transfer: &Transfer<'_>) -> Vec<Planted> {
    let (target, steps) = (transfer.target, transfer.steps);
    let mut limbs = Vec::new();
    for (i, (leg, foot)) in target.body.legs.iter().zip(&steps.feet).enumerate() {
        if let Some((limb, [heel, toe])) = Limb::leg(target, i).zip(soles(target, leg)) {
            limbs.push(Planted {
                limb,
                points: vec![(heel, foot.heel.clone()), (toe, foot.toe.clone())],
                is_leg: true,
            });
        }
    }
    for (i, contacts) in steps.hands.iter().enumerate() {
        if let Some(limb) = Limb::arm(target, i) {
            limbs.push(Planted {
                limb,
                points: vec![(Sole::default(), contacts.clone())],
                is_leg: false,
            });
        }
    }
    limbs
}

/// Targets of the limb ends and vertical displacement of the hips, frame by frame.
#[derive(Debug, Clone)]
pub(super) struct Goals {
    /// One entry per pinned limb: its index in the list of limbs, targets of its end.
    ends: Vec<(usize, Vec<Goal>)>,
    sinks: Vec<f32>,
    rises: Vec<f32>,
    floor: f32,
}

impl Goals {
    /// Computes the targets for a whole clip.
    pub(super) fn new(transfer: &Transfer<'_>, limbs: &[Planted], pinning: ContactPinning) -> Self {
        let frames = transfer.motion.frames();
        let rate_hz = transfer.motion.rate_hz;
        let floor = rest_floor(transfer.target);
        let pins = |l: &Planted| match pinning {
            ContactPinning::Nothing => false,
            ContactPinning::Feet => l.is_leg,
            ContactPinning::FeetAndHands => true,
        };
        let chosen: Vec<usize> = (0..limbs.len()).filter(|l| pins(&limbs[*l])).collect();
        let mut paths = vec![Path::default(); chosen.len()];
        let mut starts = vec![Vec::with_capacity(frames); chosen.len()];
        let mut pose = Pose::new(transfer.target);
        if !chosen.is_empty() {
            for frame in 0..frames {
                transfer.pose(frame, &mut pose);
                for (i, l) in chosen.iter().enumerate() {
                    let limb = &limbs[*l].limb;
                    paths[i].places.push(pose.positions[limb.end]);
                    paths[i].deltas.push(pose.deltas[limb.end]);
                    starts[i].push(pose.positions[limb.upper]);
                }
            }
        }
        let mut plan = Self {
            ends: Vec::new(),
            sinks: vec![0.0; frames],
            rises: vec![0.0; frames],
            floor,
        };
        for (i, l) in chosen.iter().enumerate() {
            let planted = &limbs[*l];
            let points: Vec<(Sole, &[Contact])> = planted
                .points
                .iter()
                .map(|(sole, contacts)| (*sole, contacts.as_slice()))
                .collect();
            let mut ends = goals(&paths[i], &points, floor, rate_hz);
            if planted.is_leg {
                plan.above_floor(&paths[i], planted, &mut ends);
                plan.lift(&starts[i], &ends, planted.limb.span());
            }
            plan.ends.push((*l, ends));
        }
        let leg = transfer.target.body.leg_metres;
        let reach = (SINK_SECS * rate_hz) as usize;
        smoothed(&mut plan.sinks, reach, MAX_SINK * leg);
        smoothed(&mut plan.rises, reach, MAX_RISE * leg);
        plan
    }

    /// Lifts a foot whose sole would be below the floor.
    fn above_floor(&self, path: &Path, planted: &Planted, ends: &mut [Goal]) {
        for (f, end) in ends.iter_mut().enumerate() {
            let delta = end.turn * path.deltas[f];
            let low = |(sole, _): &(Sole, Vec<Contact>)| sole.at(end.place, delta).y;
            let lowest = planted.points.iter().map(low).fold(f32::MAX, f32::min);
            end.place.y += (self.floor - lowest).max(0.0);
        }
    }

    /// Records by how much the hips are too high or too low for a leg.
    fn lift(&mut self, starts: &[Vec3], ends: &[Goal], [least, most]: [f32; 2]) {
        for (f, (start, end)) in starts.iter().zip(ends).enumerate() {
            let way = *start - end.place;
            let flat = Vec3::new(way.x, 0.0, way.z).length();
            let height = |reach: f32| (reach * reach - flat * flat).max(0.0).sqrt();
            self.sinks[f] = self.sinks[f].max(way.y - height(STRETCH * most));
            self.rises[f] = self.rises[f].max(height(least) - way.y);
        }
    }

    /// Bends the limbs of a transferred pose to their targets.
    pub(super) fn apply(
        &self,
        transfer: &Transfer<'_>,
        limbs: &[Planted],
        frame: usize,
        pose: &mut Pose,
    ) {
        if self.ends.is_empty() {
            return;
        }
        let (plan, target) = (transfer.plan, transfer.target);
        let root =
            pose.positions[target.body.root] + Vec3::Y * (self.rises[frame] - self.sinks[frame]);
        pose.place(plan, target, root);
        for (l, ends) in &self.ends {
            let goal = ends[frame];
            limbs[*l].limb.reach(pose, goal.place);
            limbs[*l].limb.turn_end(pose, goal.turn);
        }
        pose.place(plan, target, root);
    }
}

/// For each frame the mean of the values at most `reach` frames away.
pub(super) fn averaged(values: &[f32], reach: usize) -> Vec<f32> {
    let mean = |f: usize| {
        let around = &values[f.saturating_sub(reach)..(f + reach + 1).min(values.len())];
        around.iter().sum::<f32>() / around.len() as f32
    };
    (0..values.len()).map(mean).collect()
}

/// Extends each displacement to its neighbourhood and smooths it, so that the hips move gently.
fn smoothed(sinks: &mut [f32], reach: usize, most: f32) {
    let reach = reach.max(1);
    let window = |f: usize| f.saturating_sub(reach)..(f + reach + 1).min(sinks.len());
    let widest: Vec<f32> = (0..sinks.len())
        .map(|f| {
            sinks[window(f)]
                .iter()
                .copied()
                .fold(0.0, f32::max)
                .min(most)
        })
        .collect();
    // The mean over the same window is nowhere below the displacement that its middle frame needs.
    sinks.copy_from_slice(&averaged(&widest, reach));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hips_sink_gently_and_far_enough() {
        let mut sinks = vec![0.0; 40];
        sinks[20] = 0.05;
        smoothed(&mut sinks, 5, 1.0);
        assert!((sinks[20] - 0.05).abs() < 1e-6, "what is needed is met");
        assert!(sinks[9] == 0.0 && sinks[31] == 0.0);
        let steepest = sinks.windows(2).map(|w| (w[1] - w[0]).abs());
        assert!(steepest.fold(0.0, f32::max) < 0.006);
    }
}
