//! Knees and elbows as hinges: twist of the upper limb so that the lower one points in its
//! direction.
//!
//! BAP lets a knee or an elbow bend and twist, but not lean sideways. On a rig with another hinge
//! axis, the ankle would be off by the lean angle times the length of the shank. Twisting the upper
//! limb about its own axis moves no joint but aligns the hinge: feet and hands reach their
//! positions, and only the twist of the upper limb is wrong.

use super::bap_split::nearest_two;
use super::bap_table;
use articula_core::hanim_table::{JOINTS, find};
use articula_core::{Libm, LibmQuat};
use glam::{DQuat, DVec3};

/// Cost of a twist of the upper limb relative to a lean of the lower one, both in radians squared:
/// it keeps a straight limb, whose twist moves nothing, from spinning.
const TWIST_COST: f64 = 0.03;
/// Twists that are tried on either side of zero: number of steps, and radians per step.
const TRIES: (i32, f64) = (12, 0.1);
/// Number of halvings of the step around the best of them.
const HALVINGS: usize = 14;
/// Upper joint, hinge, and the end of the lower limb.
const LIMBS: [[&str; 3]; 4] = [
    ["l_hip", "l_knee", "l_ankle"],
    ["r_hip", "r_knee", "r_ankle"],
    ["l_shoulder", "l_elbow", "l_wrist"],
    ["r_shoulder", "r_elbow", "r_wrist"],
];

/// A limb of the standard humanoid at rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limb {
    /// Joint above the upper limb.
    pub(super) upper: usize,
    /// Joint of the hinge.
    pub(super) hinge: usize,
    /// Unit vector from the upper joint to the hinge.
    along_upper: DVec3,
    /// Unit vector from the hinge to the end.
    along_lower: DVec3,
    /// Axes of the hinge: bend, then twist.
    bend: DVec3,
    twist: DVec3,
}

/// Returns the four limbs.
pub(super) fn limbs() -> Vec<Limb> {
    let limb = |names: &[&str; 3]| {
        let [upper, hinge, end] = names.map(find);
        let (upper, hinge, end) = (upper?, hinge?, end?);
        let way = |from: usize, to: usize| {
            let way = JOINTS[to].center - JOINTS[from].center;
            way.as_dvec3().normalize()
        };
        let turns = bap_table::turns(JOINTS[hinge].name);
        let [(_, bend), (_, twist)] = turns[..] else {
            return None;
        };
        Some(Limb {
            upper,
            hinge,
            along_upper: way(upper, hinge),
            along_lower: way(hinge, end),
            bend: bend.as_dvec3(),
            twist: twist.as_dvec3(),
        })
    };
    LIMBS.iter().filter_map(limb).collect()
}

impl Limb {
    /// Returns the upper limb's rotation since rest, twisted so that its hinge can point the lower
    /// one in the direction given by `lower`. A direction that the hinge already reaches changes
    /// nothing.
    pub(super) fn aimed(&self, upper: DQuat, lower: DQuat) -> DQuat {
        let target = upper.inverse() * lower;
        let about = |twist: f64| DQuat::libm_axis_angle(self.along_upper, twist);
        let cost = |twist: f64| {
            let missed = self.missed(about(-twist) * target);
            missed * missed + TWIST_COST * twist * twist
        };
        upper * about(least(cost))
    }

    /// Returns the angle between the lower limb that the hinge can produce and the one given by the
    /// hinge's total rotation.
    fn missed(&self, target: DQuat) -> f64 {
        let [_, twist] = nearest_two(target, self.bend, self.twist);
        let bend = self.bend_angle(target, twist);
        let about = DQuat::libm_axis_angle;
        let reached = about(self.bend, bend) * about(self.twist, twist) * self.along_lower;
        // Computed from the distance of unit vectors, which is precise for small angles.
        let apart = reached.distance(target * self.along_lower);
        2.0 * (0.5 * apart).min(1.0).libm_asin()
    }

    /// Returns the bend for which the lower limb, twisted by `twist`, points as closely as possible
    /// in the direction given by `target`, the hinge's total rotation.
    pub(super) fn bend_angle(&self, target: DQuat, twist: f64) -> f64 {
        let from = DQuat::libm_axis_angle(self.twist, twist) * self.along_lower;
        let to = target * self.along_lower;
        let (a, b) = (from.reject_from(self.bend), to.reject_from(self.bend));
        a.cross(b).dot(self.bend).libm_atan2(a.dot(b))
    }
}

/// Returns the twist of least cost; zero if none is better.
fn least(cost: impl Fn(f64) -> f64) -> f64 {
    let (tries, mut step) = TRIES;
    let mut best = (0.0, cost(0.0));
    let consider = |twist: f64, best: &mut (f64, f64)| {
        let cost = cost(twist);
        if cost < best.1 {
            *best = (twist, cost);
        }
    };
    for n in 1..=tries {
        for side in [-1.0, 1.0] {
            consider(side * f64::from(n) * step, &mut best);
        }
    }
    for _ in 0..HALVINGS {
        step *= 0.5;
        let middle = best.0;
        consider(middle - step, &mut best);
        consider(middle + step, &mut best);
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leaning_shank_is_reached_by_a_twist_of_the_thigh() {
        for limb in limbs() {
            let upper = DQuat::from_rotation_z(0.2);
            // Bent by a radian about an axis 20 degrees off the hinge's.
            let off = DQuat::from_rotation_y(0.35);
            let bent = DQuat::from_axis_angle(off * limb.bend, 1.0);
            let lower = upper * bent;
            let aimed = limb.aimed(upper, lower);
            let along = |q: DQuat| q * limb.along_upper;
            assert!(
                along(aimed).distance(along(upper)) < 1e-12,
                "the hinge stays"
            );
            let target = aimed.inverse() * lower;
            let [_, twist] = nearest_two(target, limb.bend, limb.twist);
            let bend = limb.bend_angle(target, twist);
            let about = DQuat::from_axis_angle;
            let hinge = about(limb.bend, bend) * about(limb.twist, twist);
            let reached = aimed * hinge * limb.along_lower;
            let plain = limb.bend_angle(bent, 0.0);
            let plain = upper * DQuat::from_axis_angle(limb.bend, plain) * limb.along_lower;
            let wanted = lower * limb.along_lower;
            let (near, far) = (reached.angle_between(wanted), plain.angle_between(wanted));
            assert!(near < 0.1 * far && far > 0.2, "{near} {far}");
        }
    }

    #[test]
    fn a_straight_limb_does_not_spin() {
        for limb in limbs() {
            for lean in [0.01, -0.1, 0.3] {
                let sideways = DQuat::from_rotation_z(lean);
                let aimed = limb.aimed(DQuat::IDENTITY, sideways);
                let spun = aimed.angle_between(DQuat::IDENTITY);
                assert!(spun < 6.0 * lean.abs(), "{lean}: {spun}");
            }
        }
    }
}
