//! How far each track moves each point of the skin, and the steps that follow from it.
//!
//! Form: `docs/methods/motion-stream.md`, parts 2 and 3.

use super::skin_points::SkinPoints;
use crate::abp2::pose_unit::MOST_EXPONENT;
use articula_core::Libm;
use articula_core::{LocalPose, ModelPose, Rig, local_to_model};
use glam::Vec3;

/// Lever of a rotation that moves no point farther, in metres.
pub(super) const FLOOR_METRES: f64 = 0.005;
/// Rounds of the optimisation of shares.
const ROUNDS: usize = 300;

/// Metres that each point moves by a change of a track of 1 radian, metre, unit of scale or weight:
/// for each track (point, metres).
pub(super) type Levers = Vec<Vec<(u32, f64)>>;

/// What a track moves, for [`levers`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mover {
    /// The rotation of a joint, whose children take back its error if they turn themselves.
    Rotation(usize),
    /// The same without compensation by children.
    AloneRotation(usize),
    Translation(usize),
    Scale(usize),
    Morph(usize),
}

/// The points at rest.
pub(super) struct Rest {
    model: ModelPose,
    points: Vec<Vec3>,
    /// Metres per unit of each joint's translation.
    scales: Vec<f64>,
}

impl Rest {
    pub(super) fn new(rig: &Rig, points: &SkinPoints, weights: &[f32]) -> Self {
        let mut posed = points.posed(rig);
        posed.local = LocalPose::clone(rig.rest_pose());
        points.skin(rig, weights, &mut posed);
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, rig.rest_pose(), &mut model);
        let scale = |j: usize| {
            let above = rig
                .parent(j)
                .map(|p| model.matrices[p].matrix3.determinant().abs());
            f64::from(above.unwrap_or(1.0).libm_cbrt())
        };
        Self {
            scales: (0..rig.len()).map(scale).collect(),
            points: posed.points,
            model,
        }
    }

    /// Returns `e` such that 2^-e of the unit of a joint's translation is about a metre.
    pub(super) fn metres_exponent(&self, joint: usize) -> i32 {
        let most = f64::from(MOST_EXPONENT);
        self.scales[joint]
            .max(1e-30)
            .libm_log2()
            .round()
            .clamp(-most, most) as i32
    }

    fn distance(&self, joint: usize, to: Vec3) -> f64 {
        f64::from(self.model.position(joint).distance(to))
    }
}

/// Computes the levers of tracks; `turns` tells of each joint whether its rotation moves.
pub(super) fn levers(
    rig: &Rig,
    points: &SkinPoints,
    rest: &Rest,
    movers: &[Mover],
    turns: &[bool],
) -> Levers {
    let mut levers: Levers = vec![Vec::new(); movers.len()];
    let mut of_joint: Vec<Vec<(usize, Mover)>> = vec![Vec::new(); rig.len()];
    let mut of_slot: Vec<(usize, usize)> = Vec::new();
    for (track, mover) in movers.iter().enumerate() {
        match *mover {
            Mover::Morph(slot) => of_slot.push((slot, track)),
            Mover::Rotation(joint)
            | Mover::AloneRotation(joint)
            | Mover::Translation(joint)
            | Mover::Scale(joint) => of_joint[joint].push((track, *mover)),
        }
    }
    let mut sums = vec![0.0; movers.len()];
    for point in 0..points.len() {
        let here = rest.points[point];
        let mut touched = Vec::new();
        for (joint, weight) in points.joints(point) {
            let weight = f64::from(weight);
            // Where the chain below the joint at hand is corrected: at the next that turns.
            let mut corrected = here;
            let mut above = Some(joint);
            while let Some(j) = above {
                for (track, mover) in &of_joint[j] {
                    let metres = match mover {
                        Mover::Rotation(_) => rest.distance(j, corrected),
                        Mover::AloneRotation(_) | Mover::Scale(_) => rest.distance(j, here),
                        Mover::Translation(_) => rest.scales[j],
                        Mover::Morph(_) => 0.0,
                    };
                    if sums[*track] == 0.0 {
                        touched.push(*track);
                    }
                    sums[*track] += weight * metres;
                }
                if turns[j] {
                    corrected = rest.model.position(j);
                }
                above = rig.parent(j);
            }
        }
        for (slot, offset) in points.offsets(point) {
            let found = of_slot.iter().find(|(s, _)| s == &usize::from(*slot));
            if let Some((_, track)) = found {
                touched.push(*track);
                sums[*track] += f64::from(offset.length());
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for track in touched {
            let metres = std::mem::take(&mut sums[track]);
            levers[track].push((point as u32, metres));
        }
    }
    levers
}

/// Returns the greatest lever of each track.
pub(super) fn greatest(levers: &Levers) -> Vec<f64> {
    let most = |lever: &Vec<(u32, f64)>| lever.iter().map(|(_, d)| *d).fold(0.0, f64::max);
    levers
        .iter()
        .map(most)
        .map(|d| d.max(FLOOR_METRES))
        .collect()
}

/// Returns for each track the step, per metre of tolerance, with which the tracks together move no
/// point by much more than the tolerance and cost the fewest bits: the product of the steps is
/// greatest under a sum of squares at every point.
pub(super) fn shares(levers: &Levers, points: usize) -> Vec<f64> {
    let most = greatest(levers);
    // A track that moves no point has one of its own.
    let alone = levers.iter().filter(|lever| lever.is_empty()).count();
    let squares: Vec<Vec<(u32, f64)>> = {
        let mut next = points as u32;
        let mut own = || {
            next += 1;
            vec![(next - 1, FLOOR_METRES * FLOOR_METRES)]
        };
        let square = |lever: &Vec<(u32, f64)>| -> Vec<(u32, f64)> {
            let floor = FLOOR_METRES * FLOOR_METRES * 1e-4;
            lever
                .iter()
                .map(|(p, d)| (*p, (d * d).max(floor)))
                .collect()
        };
        levers
            .iter()
            .map(|lever| {
                if lever.is_empty() {
                    own()
                } else {
                    square(lever)
                }
            })
            .collect()
    };
    let points = points + alone;
    let mut multipliers = vec![1.0 / points.max(1) as f64; points];
    let mut sizes = vec![0.0; levers.len()];
    let mut loads = vec![0.0; points];
    for _ in 0..ROUNDS {
        loads.fill(0.0);
        for (size, squares) in sizes.iter_mut().zip(&squares) {
            let sum: f64 = squares
                .iter()
                .map(|(p, d)| multipliers[*p as usize] * d)
                .sum();
            *size = 1.0 / sum.max(1e-300);
            for (p, d) in squares {
                loads[*p as usize] += d * *size;
            }
        }
        let top = loads.iter().copied().fold(1e-300, f64::max);
        for (multiplier, load) in multipliers.iter_mut().zip(&loads) {
            *multiplier *= (load / top + 1e-6).sqrt();
        }
        let sum: f64 = multipliers.iter().sum();
        multipliers.iter_mut().for_each(|m| *m /= sum);
    }
    let top = loads.iter().copied().fold(1e-300, f64::max);
    let share = |(size, most): (&f64, &f64)| (size / top).sqrt().min(1.0 / most);
    sizes.iter().zip(&most).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_chain_by_hand() {
        // One point: two tracks with levers of 1 and 0.5 m each get half of the square.
        let levers = vec![vec![(0, 1.0)], vec![(0, 0.5)]];
        let found = shares(&levers, 1);
        assert!((found[0] - 0.5_f64.sqrt()).abs() < 1e-3, "{found:?}");
        assert!((found[1] - 2.0 * 0.5_f64.sqrt()).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn no_point_is_overloaded_and_none_is_idle_for_free() {
        // Track 0 moves both points, 1 and 2 move one each.
        let levers = vec![vec![(0, 1.0), (1, 1.0)], vec![(0, 1.0)], vec![(1, 1.0)]];
        let found = shares(&levers, 2);
        let loads = [
            found[0].powi(2) + found[1].powi(2),
            found[0].powi(2) + found[2].powi(2),
        ];
        assert!(loads.iter().all(|load| *load < 1.0 + 1e-6), "{loads:?}");
        // log x0 + 2 log(1 - x0) is greatest at a third.
        assert!((found[0].powi(2) - 1.0 / 3.0).abs() < 1e-2, "{found:?}");
    }

    #[test]
    fn a_track_that_moves_nothing_has_the_least_lever() {
        let found = shares(&vec![vec![], vec![(0, 1.0)]], 1);
        assert!((found[0] - 1.0 / FLOOR_METRES).abs() < 1e-6, "{found:?}");
        assert!((found[1] - 1.0).abs() < 1e-3, "{found:?}");
    }
}
