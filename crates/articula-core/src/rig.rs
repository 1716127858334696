//! The read-only joint tree: parents first, validated once when it is built.

use crate::Mismatch;
use crate::articulation::Articulation;
use crate::joint_set::{JointSet, MAX_JOINTS};
use crate::local_extent::{RestJoint, local_extents};
use crate::pose::LocalPose;
use crate::source::Skeleton;

/// A joint tree with its rest pose, H-Anim articulation and skin joints.
///
/// Joints have the order of the source skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    names: Vec<String>,
    parents: Vec<Option<u16>>,
    depths: Vec<u16>,
    rest: LocalPose,
    articulation: Articulation,
    in_skin: JointSet,
    root: usize,
}

impl Rig {
    /// Builds a rig from a skeleton and its articulation, checking both.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no joint, more than [`MAX_JOINTS`], a parent that does not come
    /// before its child, a rest transform that is not finite, or an articulation of another length.
    pub fn new(skeleton: &Skeleton, articulation: Articulation) -> Result<Self, Mismatch> {
        let joints = &skeleton.joints;
        if joints.is_empty() {
            return Err(Mismatch::new("joints", "a rig needs at least one joint"));
        }
        if joints.len() > MAX_JOINTS {
            let what = format!(
                "{} joints, at most {MAX_JOINTS} are supported",
                joints.len()
            );
            return Err(Mismatch::new("joints", what));
        }
        if articulation.joints.len() != joints.len() {
            let (found, expected) = (articulation.joints.len(), joints.len());
            let what = format!("{found} entries, the skeleton has {expected} joints");
            return Err(Mismatch::new("articulation.joints", what));
        }
        for (j, joint) in joints.iter().enumerate() {
            if joint.parent.is_some_and(|p| p >= j) {
                let what = "a parent must come before its child";
                return Err(Mismatch::new(format!("joints[{j}].parent"), what));
            }
            if !joint.rest.is_finite() {
                let what = "the rest transform must be finite";
                return Err(Mismatch::new(format!("joints[{j}].rest"), what));
            }
        }
        let parents: Vec<Option<u16>> = joints.iter().map(|j| j.parent.map(|p| p as u16)).collect();
        let in_skin = (0..joints.len()).filter(|&j| joints[j].in_skin).collect();
        Ok(Self {
            names: joints.iter().map(|j| j.name.clone()).collect(),
            depths: depths(&parents, &in_skin),
            rest: joints.iter().map(|j| j.rest).collect(),
            root: in_skin.iter().next().unwrap_or(0),
            parents,
            articulation,
            in_skin,
        })
    }

    /// Returns the number of joints.
    pub fn len(&self) -> usize {
        self.parents.len()
    }

    /// Always false: a rig has at least one joint.
    pub fn is_empty(&self) -> bool {
        self.parents.is_empty()
    }

    /// Returns the name of a joint as stored in its file.
    pub fn name(&self, joint: usize) -> &str {
        &self.names[joint]
    }

    /// Returns the index of the first joint with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    /// Returns the parent of a joint, which always has a smaller index.
    pub fn parent(&self, joint: usize) -> Option<usize> {
        self.parents[joint].map(usize::from)
    }

    /// Returns the number of skin joints above a joint: 0 for the skeleton's root and for the nodes
    /// above it.
    pub fn depth(&self, joint: usize) -> usize {
        usize::from(self.depths[joint])
    }

    /// Returns the local transforms of the rest pose.
    pub fn rest_pose(&self) -> &LocalPose {
        &self.rest
    }

    /// Returns, for each joint, the greatest extent of the figure at rest along a model axis in the
    /// units of the joint's translation.
    ///
    /// The extent is that of the joints of skins, or of all joints if there is no such joint. A figure
    /// without extent counts as 1 m tall.
    pub fn local_extents(&self) -> Vec<f32> {
        let joint = |j| RestJoint {
            parent: self.parent(j),
            rest: self.rest.get(j),
            in_skin: self.in_skin.contains(j),
        };
        local_extents(&(0..self.len()).map(joint).collect::<Vec<_>>())
    }

    /// Returns the H-Anim name, level and region of each joint.
    pub fn articulation(&self) -> &Articulation {
        &self.articulation
    }

    /// Returns the joints that belong to a skin; the others are plain nodes.
    pub fn skin_joints(&self) -> &JointSet {
        &self.in_skin
    }

    /// Returns the skeleton's root: the first skin joint.
    pub fn root(&self) -> usize {
        self.root
    }

    /// Returns the set of all joints.
    pub fn all(&self) -> JointSet {
        JointSet::first(self.len())
    }

    /// Returns whether `joint` is `ancestor` or a descendant of it.
    pub fn is_at_or_below(&self, joint: usize, ancestor: usize) -> bool {
        let mut at = Some(joint);
        while let Some(j) = at {
            if j == ancestor {
                return true;
            }
            // Parents have smaller indices, so the walk ends below the ancestor's index.
            at = self.parent(j).filter(|p| *p >= ancestor);
        }
        false
    }
}

fn depths(parents: &[Option<u16>], in_skin: &JointSet) -> Vec<u16> {
    let mut depths = vec![0; parents.len()];
    for (j, parent) in parents.iter().enumerate() {
        if let Some(p) = parent {
            let p = usize::from(*p);
            depths[j] = depths[p] + u16::from(in_skin.contains(p));
        }
    }
    depths
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::articulation::{JointArticulation, Region};
    use crate::math::Transform;
    use crate::source::Joint;
    use glam::Vec3;

    /// A rig from `(parent, offset, level)` rows; every row is a skin joint.
    pub(crate) fn rig_of(rows: &[(Option<usize>, Vec3, u8)]) -> Rig {
        let skeleton = Skeleton {
            joints: rows
                .iter()
                .enumerate()
                .map(|(j, (parent, offset, _))| Joint {
                    name: format!("j{j}"),
                    parent: *parent,
                    rest: Transform::from_translation(*offset),
                    in_skin: true,
                })
                .collect(),
        };
        let joints = rows
            .iter()
            .map(|(_, _, level)| JointArticulation {
                hanim: None,
                level: *level,
                region: Region::Torso,
            })
            .collect();
        let articulation = Articulation {
            profile: String::new(),
            joints,
        };
        Rig::new(&skeleton, articulation).unwrap()
    }

    #[test]
    fn refuses_what_cannot_be_a_rig() {
        let empty = Rig::new(&Skeleton::default(), Articulation::default());
        assert_eq!(empty.unwrap_err().at, "joints");
        let mut skeleton = Skeleton {
            joints: vec![Joint {
                name: "a".into(),
                parent: Some(0),
                rest: Transform::IDENTITY,
                in_skin: true,
            }],
        };
        let one = Articulation {
            profile: String::new(),
            joints: vec![JointArticulation {
                hanim: None,
                level: 0,
                region: Region::Pelvis,
            }],
        };
        let cycle = Rig::new(&skeleton, one.clone()).unwrap_err();
        assert_eq!(cycle.at, "joints[0].parent");
        skeleton.joints[0].parent = None;
        skeleton.joints[0].rest.translation.x = f32::NAN;
        assert_eq!(Rig::new(&skeleton, one).unwrap_err().at, "joints[0].rest");
    }

    #[test]
    fn a_rig_beyond_the_limit_is_refused_and_one_at_it_is_not() {
        let of = |count: usize| {
            let joint = |j: usize| Joint {
                name: String::new(),
                parent: j.checked_sub(1),
                rest: Transform::IDENTITY,
                in_skin: true,
            };
            let skeleton = Skeleton {
                joints: (0..count).map(joint).collect(),
            };
            let known = JointArticulation {
                hanim: None,
                level: 0,
                region: Region::Torso,
            };
            let articulation = Articulation {
                profile: String::new(),
                joints: vec![known; count],
            };
            Rig::new(&skeleton, articulation)
        };
        assert_eq!(of(MAX_JOINTS).unwrap().len(), MAX_JOINTS);
        assert_eq!(of(MAX_JOINTS + 1).unwrap_err().at, "joints");
    }

    #[test]
    fn ancestors_and_depths_by_hand() {
        // 0 root(0) ─ 1 sacrum(2) ─ 2 hip(0) ; 0 ─ 3 finger(5) ; 0 ─ 4 neck(1)
        let rig = rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::Y, 2),
            (Some(1), Vec3::Y, 0),
            (Some(0), Vec3::Y, 5),
            (Some(0), Vec3::Y, 1),
        ]);
        assert!(rig.is_at_or_below(2, 1) && rig.is_at_or_below(2, 0));
        assert!(!rig.is_at_or_below(3, 1));
        assert_eq!(rig.depth(2), 2);
    }
}
