//! Joint LODs: levels of a rig as prefixes of one joint order, with merged joints that move with an
//! ancestor.
//!
//! Source: `docs/methods/motion-lod.md` part 8 and `docs/methods/runtime.md` part 3. Level 0 has
//! every joint; each further level keeps no more. A joint that a level does not keep is *merged*:
//! it has the rig's mean pose relative to its nearest kept ancestor and moves with it. Kept joints
//! have their true transforms, because every level contains the ancestors of its joints.
//! `articula-build` decides from the character's motion which joints are dropped first.

use crate::Mismatch;
use crate::joint_set::JointSet;
use crate::math::Transform;
use crate::pose::LocalPose;
use crate::rig::Rig;

/// Joint order of a rig, and the number of its joints that each level keeps.
///
/// Levels may keep the same joints and differ in what else belongs to a level: the mesh, or the
/// influences of its vertices.
///
/// A *place* is an index into this order, the LOD order. Parents have smaller places than their
/// children.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLods {
    joints: Vec<u16>,
    places: Vec<u16>,
    parents: Vec<Option<u16>>,
    kept: Vec<u16>,
    mean: Vec<Transform>,
}

impl JointLods {
    /// Maximum number of levels: a level fits in four bits.
    pub const MAX_LEVELS: usize = 16;

    /// Combines an order of all joints of a rig, the number of joints that each level keeps and the
    /// mean pose of merged joints.
    ///
    /// # Errors
    /// A [`Mismatch`] if `joints` is not a permutation of the rig's joints with parents first,
    /// `kept` rises, does not begin with all joints, ends below 1 or has more than
    /// [`JointLods::MAX_LEVELS`] entries, or the mean pose is of another rig or not finite.
    pub fn new(
        rig: &Rig,
        joints: Vec<u16>,
        kept: Vec<u16>,
        mean: &LocalPose,
    ) -> Result<Self, Mismatch> {
        let places = places_of(rig, &joints)?;
        if mean.rotations.len() != rig.len() {
            let what = format!("{} joints, the rig has {}", mean.rotations.len(), rig.len());
            return Err(Mismatch::new("mean", what));
        }
        if let Some(j) = (0..rig.len()).find(|&j| !mean.get(j).is_finite()) {
            let what = "the mean transform must be finite";
            return Err(Mismatch::new(format!("mean[{j}]"), what));
        }
        let falls = kept.windows(2).all(|w| w[0] >= w[1]);
        let whole = kept.first().is_some_and(|n| usize::from(*n) == rig.len());
        if !whole || !falls || kept.last() == Some(&0) || kept.len() > Self::MAX_LEVELS {
            let what = format!(
                "{kept:?} must begin at {}, never rise, stay at least 1 and have at most {} levels",
                rig.len(),
                Self::MAX_LEVELS
            );
            return Err(Mismatch::new("kept", what));
        }
        let parents = joints
            .iter()
            .map(|&j| rig.parent(usize::from(j)).map(|p| places[p]))
            .collect();
        Ok(Self {
            mean: joints.iter().map(|&j| mean.get(usize::from(j))).collect(),
            joints,
            places,
            parents,
            kept,
        })
    }

    /// Makes one level that keeps every joint, in breadth-first order.
    ///
    /// # Errors
    /// Does not occur: the breadth-first order of a rig is valid.
    pub fn whole(rig: &Rig) -> Result<Self, Mismatch> {
        let kept = vec![rig.len() as u16];
        Self::new(rig, breadth_first(rig), kept, rig.rest_pose())
    }

    /// Makes levels that keep given joint sets, such as named levels of articulation; ancestors of
    /// kept joints are kept too. The full rig is added in front if it is missing, and an empty set
    /// keeps the first joint.
    ///
    /// # Errors
    /// A [`Mismatch`] if a set is not within the one before, once closed over ancestors.
    pub fn of_sets(rig: &Rig, sets: &[JointSet], mean: &LocalPose) -> Result<Self, Mismatch> {
        let mut closed = vec![rig.all()];
        for (s, set) in sets.iter().enumerate() {
            let set = with_ancestors(rig, set);
            let last = closed[closed.len() - 1];
            if set.iter().any(|j| !last.contains(j)) {
                let what = "keeps a joint that the previous level merges";
                return Err(Mismatch::new(format!("sets[{s}]"), what));
            }
            if set != last {
                closed.push(set);
            }
        }
        let order = breadth_first(rig);
        let level_of = |j: usize| closed.iter().rposition(|set| set.contains(j)).unwrap_or(0);
        let mut joints = order;
        // Stable: breadth first within what a level adds.
        joints.sort_by_key(|&j| std::cmp::Reverse(level_of(usize::from(j))));
        let kept = closed.iter().map(|set| set.len() as u16).collect();
        Self::new(rig, joints, kept, mean)
    }

    /// Number of levels, at least 1.
    pub fn levels(&self) -> usize {
        self.kept.len()
    }

    /// Number of joints that a level keeps: the first ones of the order.
    pub fn joint_count(&self, level: usize) -> usize {
        usize::from(self.kept[level])
    }

    /// Joint of the rig at each place; all joints of the rig.
    pub fn joints(&self) -> &[u16] {
        &self.joints
    }

    /// Place of a joint of the rig.
    pub fn place(&self, joint: usize) -> usize {
        usize::from(self.places[joint])
    }

    /// Place of the parent of the joint at each place, always smaller than its own.
    pub fn parents(&self) -> &[Option<u16>] {
        &self.parents
    }

    /// Local transform in the mean pose, by place.
    pub fn mean(&self) -> &[Transform] {
        &self.mean
    }
}

fn places_of(rig: &Rig, joints: &[u16]) -> Result<Vec<u16>, Mismatch> {
    let unset = u16::MAX;
    let mut places = vec![unset; rig.len()];
    for (place, &joint) in joints.iter().enumerate() {
        let joint = usize::from(joint);
        let at = || format!("joints[{place}]");
        if places.get(joint).is_none_or(|p| *p != unset) {
            let what = format!(
                "joint {joint} is out of range (the rig has {} joints) or listed twice",
                rig.len()
            );
            return Err(Mismatch::new(at(), what));
        }
        if rig.parent(joint).is_some_and(|p| places[p] == unset) {
            return Err(Mismatch::new(at(), "a parent must come before its child"));
        }
        places[joint] = place as u16;
    }
    if joints.len() != rig.len() {
        let what = format!("{} joints, the rig has {}", joints.len(), rig.len());
        return Err(Mismatch::new("joints", what));
    }
    Ok(places)
}

fn breadth_first(rig: &Rig) -> Vec<u16> {
    let mut depth = vec![0u16; rig.len()];
    for j in 0..rig.len() {
        depth[j] = rig.parent(j).map_or(0, |p| depth[p] + 1);
    }
    let mut order: Vec<u16> = (0..rig.len() as u16).collect();
    order.sort_by_key(|&j| depth[usize::from(j)]);
    order
}

fn with_ancestors(rig: &Rig, set: &JointSet) -> JointSet {
    let mut closed = JointSet::EMPTY;
    for joint in set.iter().filter(|j| *j < rig.len()) {
        let mut at = Some(joint);
        while let Some(j) = at.filter(|j| !closed.contains(*j)) {
            closed.insert(j);
            at = rig.parent(j);
        }
    }
    if closed.is_empty() {
        closed.insert(0);
    }
    closed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::tests::rig_of;
    use glam::Vec3;

    /// 0 ─ 1 ─ 2 ─ 3 and 1 ─ 4.
    fn rig() -> Rig {
        rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::Y, 0),
            (Some(1), Vec3::Y, 1),
            (Some(2), Vec3::Y, 5),
            (Some(1), Vec3::X, 2),
        ])
    }

    #[test]
    fn merged_joints_move_with_the_nearest_kept_ancestor() {
        let rig = rig();
        let sets = [
            JointSet::from_iter([1, 2]),
            JointSet::from_iter([1]),
            JointSet::EMPTY,
        ];
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        // Closed over ancestors: {0,1,2}, {0,1}, {0}; joints dropped first come last.
        assert_eq!(joint_lods.joints(), [0, 1, 2, 4, 3]);
        let kept: Vec<usize> = (0..joint_lods.levels())
            .map(|l| joint_lods.joint_count(l))
            .collect();
        assert_eq!(kept, [5, 3, 2, 1]);
        let target = |joint, level| {
            let mut place = joint_lods.place(joint);
            while place >= joint_lods.joint_count(level) {
                place = usize::from(joint_lods.parents()[place]?);
            }
            Some(place)
        };
        assert_eq!(target(3, 0), Some(4));
        assert_eq!(target(3, 1), Some(2));
        assert_eq!(target(4, 1), Some(1));
        assert_eq!(target(3, 3), Some(0));
        assert_eq!(joint_lods.joints()[..joint_lods.joint_count(2)], [0, 1]);
        assert_eq!(joint_lods.parents()[4], Some(2));
    }

    #[test]
    fn the_mean_pose_is_by_place_and_joints_of_no_rig_are_left_out() {
        let rig = rig();
        let mut mean = rig.rest_pose().clone();
        mean.translations[4] = Vec3::Z;
        let sets = [JointSet::from_iter([4, 5])];
        let joint_lods = JointLods::of_sets(&rig, &sets, &mean).unwrap();
        // Those of the coarser level first: 4 with its ancestors.
        assert_eq!(joint_lods.joints(), [0, 1, 4, 2, 3]);
        let translations = joint_lods.mean().iter().map(|t| t.translation);
        let expected = [Vec3::ZERO, Vec3::Y, Vec3::Z, Vec3::Y, Vec3::Y];
        assert_eq!(translations.collect::<Vec<_>>(), expected);
        let whole = JointLods::whole(&rig).unwrap();
        assert_eq!((whole.levels(), whole.joint_count(0)), (1, 5));
        assert_eq!(whole.joints(), [0, 1, 2, 4, 3]);
        assert_eq!(whole.place(3), 4);
        assert_eq!(whole.parents(), [None, Some(0), Some(1), Some(1), Some(2)]);
    }

    #[test]
    fn refuses_what_is_no_order_or_no_ladder() {
        let rig = rig();
        let rest = rig.rest_pose();
        let new = |joints: &[u16], kept: &[u16]| {
            JointLods::new(&rig, joints.to_vec(), kept.to_vec(), rest)
                .map_err(|e| e.at)
                .err()
        };
        let order = [0, 1, 2, 3, 4];
        assert_eq!(new(&order, &[5, 2]), None);
        assert_eq!(new(&[0, 2, 1, 3, 4], &[5]).unwrap(), "joints[1]");
        assert_eq!(new(&[0, 1, 1, 3, 4], &[5]).unwrap(), "joints[2]");
        assert_eq!(new(&[0, 1, 2, 3, 9], &[5]).unwrap(), "joints[4]");
        assert_eq!(new(&order[..4], &[5]).unwrap(), "joints");
        assert_eq!(new(&order, &[4]).unwrap(), "kept");
        assert_eq!(new(&order, &[5, 5]), None, "levels of the same joints");
        assert_eq!(new(&order, &[5, 2, 3]).unwrap(), "kept");
        assert_eq!(new(&order, &[5, 0]).unwrap(), "kept");
        assert_eq!(new(&order, &[]).unwrap(), "kept");
        let sets = [JointSet::from_iter([3]), JointSet::from_iter([4])];
        let grown = JointLods::of_sets(&rig, &sets, rest).unwrap_err();
        assert_eq!(grown.at, "sets[1]");
    }
}
