//! Target joint for the skin of each merged joint, for near and far levels.
//!
//! A near level contains the ancestors of its joints; a far level need not. Both keep a prefix of a
//! joint order, and a merged joint moves with its nearest kept ancestor.

use articula_core::{JointLods, LocalPose, Rig};
use glam::DAffine3;

/// Levels as prefixes of a joint order, and the mean pose.
#[derive(Debug, Clone)]
pub(super) struct Prefixes<'a> {
    rig: &'a Rig,
    joints: Vec<u16>,
    places: Vec<usize>,
    kept: Vec<usize>,
    /// Model-from-joint matrices of the mean pose.
    pub(super) mean: Vec<DAffine3>,
}

impl<'a> Prefixes<'a> {
    pub(super) fn new(rig: &'a Rig, joints: &[u16], kept: &[u16], mean: &LocalPose) -> Self {
        let mut places = vec![0; rig.len()];
        for (place, joint) in joints.iter().enumerate() {
            places[usize::from(*joint)] = place;
        }
        let mut models: Vec<DAffine3> = Vec::with_capacity(rig.len());
        for joint in 0..rig.len() {
            let t = mean.get(joint);
            let local = DAffine3::from_scale_rotation_translation(
                t.scale.as_dvec3(),
                t.rotation.as_dquat().normalize(),
                t.translation.as_dvec3(),
            );
            let above = rig.parent(joint).map_or(DAffine3::IDENTITY, |p| models[p]);
            models.push(above * local);
        }
        Self {
            rig,
            joints: joints.to_vec(),
            places,
            kept: kept.iter().map(|n| usize::from(*n)).collect(),
            mean: models,
        }
    }

    pub(super) fn of(rig: &'a Rig, joint_lods: &JointLods) -> Self {
        let kept: Vec<u16> = (0..joint_lods.levels())
            .map(|l| joint_lods.joint_count(l) as u16)
            .collect();
        let at = |j: usize| joint_lods.mean()[joint_lods.place(j)];
        let mean: LocalPose = (0..rig.len()).map(at).collect();
        Self::new(rig, joint_lods.joints(), &kept, &mean)
    }

    pub(super) fn levels(&self) -> usize {
        self.kept.len()
    }

    pub(super) fn joint_count(&self, level: usize) -> usize {
        self.kept[level]
    }

    /// Whether a level keeps every joint.
    pub(super) fn is_whole(&self, level: usize) -> bool {
        self.kept[level] == self.rig.len()
    }

    pub(super) fn place(&self, joint: usize) -> usize {
        self.places[joint]
    }

    /// Joint that moves the skin of `joint` at a level: its nearest kept ancestor, or the first
    /// joint of the order if there is none.
    pub(super) fn target(&self, joint: usize, level: usize) -> u16 {
        let mut at = Some(joint);
        while let Some(j) = at {
            if self.places[j] < self.kept[level] {
                return j as u16;
            }
            at = self.rig.parent(j);
        }
        self.joints[0]
    }

    /// The nearest ancestor that outlasts a joint.
    pub(super) fn far_parent(&self, joint: usize) -> Option<usize> {
        let mut at = self.rig.parent(joint);
        while let Some(j) = at.filter(|j| self.places[*j] > self.places[joint]) {
            at = self.rig.parent(j);
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_figures::rig;
    use super::*;
    use glam::DVec3;

    #[test]
    fn skin_goes_to_the_nearest_kept_ancestor() {
        // 0 ─ 1 ─ 2 and 0 ─ 3.
        let rig = rig(&[None, Some(0), Some(1), Some(0)]);
        let near = Prefixes::new(&rig, &[0, 3, 1, 2], &[4, 3, 2], rig.rest_pose());
        let targets =
            |prefixes: &Prefixes<'_>, level| [0, 1, 2, 3].map(|j| prefixes.target(j, level));
        assert_eq!(targets(&near, 0), [0, 1, 2, 3]);
        assert_eq!(targets(&near, 1), [0, 1, 1, 3]);
        assert_eq!(targets(&near, 2), [0, 0, 0, 3]);
        assert_eq!(
            (near.levels(), near.joint_count(1), near.place(3)),
            (3, 3, 1)
        );
        assert_eq!([0, 1, 2].map(|l| near.is_whole(l)), [true, false, false]);
        let heights: Vec<DVec3> = near.mean.iter().map(|m| m.translation).collect();
        assert_eq!(heights, [0.0, 1.0, 2.0, 1.0].map(|y| DVec3::Y * y));
        // A far level may keep a joint without those above it; the rest goes to the first one.
        let far = Prefixes::new(&rig, &[2, 0, 1, 3], &[4, 2, 1], rig.rest_pose());
        assert_eq!(targets(&far, 1), [0, 0, 2, 0]);
        assert_eq!(targets(&far, 2), [2, 2, 2, 2]);
        let parents = [0, 1, 2, 3].map(|j| far.far_parent(j));
        assert_eq!(parents, [None, Some(0), None, Some(0)]);
    }
}
