//! Work of evaluating poses, and the time that it takes.

use std::ops::{Add, AddAssign};

/// Nanoseconds for each character, sampled joint, joint of forward kinematics and matrix. The sums are
/// those of the batched floor of `docs/methods/runtime.md` part 1 (8 joints 22 ns, 67 joints 179 ns);
/// how a joint's 2.7 ns divide is an estimate. [`Budget`](super::Budget) scales them by measured times.
const UNIT_NS: [f64; 4] = [0.7, 1.3, 0.9, 0.5];

/// Amount of each kind of evaluation work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Workload {
    /// Number of poses evaluated.
    pub characters: u64,
    /// Number of joints whose channels were sampled.
    pub sampled_joints: u64,
    /// Number of joints whose model transforms were computed.
    pub fk_joints: u64,
    /// Number of matrices written.
    pub matrices: u64,
}

impl Workload {
    /// Expected time in nanoseconds on the machine of `docs/methods/runtime.md` part 1.
    pub fn cost_ns(&self) -> f64 {
        let amounts = [
            self.characters,
            self.sampled_joints,
            self.fk_joints,
            self.matrices,
        ];
        let parts = amounts.iter().zip(UNIT_NS);
        parts.map(|(amount, ns)| ns * *amount as f64).sum()
    }
}

impl Add for Workload {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            characters: self.characters + other.characters,
            sampled_joints: self.sampled_joints + other.sampled_joints,
            fk_joints: self.fk_joints + other.fk_joints,
            matrices: self.matrices + other.matrices,
        }
    }
}

impl AddAssign for Workload {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_those_of_the_batched_floor() {
        let joints = |count| Workload {
            characters: 1,
            sampled_joints: count,
            fk_joints: count,
            matrices: count,
        };
        for (count, measured_ns) in [(8, 22.0), (67, 179.0)] {
            let ns = joints(count).cost_ns();
            assert!((ns / measured_ns - 1.0).abs() < 0.05, "{count}: {ns} ns");
        }
        let mut sum = joints(8);
        sum += joints(67);
        assert_eq!(
            sum,
            Workload {
                characters: 2,
                ..joints(75)
            }
        );
    }
}
