//! Level and region of joints without a counterpart in H-Anim.
//!
//! Source: `docs/methods/motion-lod.md` 1.1: such a joint takes the region of its parent and the
//! level above that of its parent, so helper, twist and cloth joints drop first. A joint map may
//! assign known helpers (tongue, finger tips) to the last level of their own region; branches
//! outside the human (controls, props) are at the last level too.

use super::gap::UnmappedReason;
use articula_core::joint_names::JointTarget;
use articula_core::loa::MAX_LEVEL;
use articula_core::source::Skeleton;
use articula_core::{JointArticulation, Region};

/// Derives level and region of every joint from the mapped ones.
pub(super) fn articulated(
    skeleton: &Skeleton,
    meanings: &[Result<JointTarget, UnmappedReason>],
) -> Vec<JointArticulation> {
    let above_mapped = above_mapped(skeleton, meanings);
    let mut joints: Vec<JointArticulation> = Vec::with_capacity(meanings.len());
    let mut on_human: Vec<bool> = Vec::with_capacity(meanings.len());
    for (index, meaning) in meanings.iter().enumerate() {
        let parent = skeleton.joints[index].parent;
        let below_human = parent.is_some_and(|p| on_human[p]);
        let (hanim, level, region) = match (meaning, parent) {
            (Ok(JointTarget::Joint(joint)), _) => {
                (Some(joint.name.clone()), joint.level, joint.region)
            }
            (Ok(JointTarget::Helper(region)), _) => (None, MAX_LEVEL, *region),
            (_, Some(p)) if below_human => {
                (None, MAX_LEVEL.min(joints[p].level + 1), joints[p].region)
            }
            _ if above_mapped[index] => (None, 0, Region::Pelvis),
            _ => (None, MAX_LEVEL, Region::Pelvis),
        };
        on_human.push(hanim.is_some() || below_human);
        joints.push(JointArticulation {
            hanim,
            level,
            region,
        });
    }
    joints
}

/// For rigs that are no humanoid: each joint's depth in the tree, and one region for all.
pub(super) fn by_depth(skeleton: &Skeleton) -> Vec<JointArticulation> {
    let mut joints: Vec<JointArticulation> = Vec::with_capacity(skeleton.joints.len());
    for joint in &skeleton.joints {
        let level = joint
            .parent
            .map_or(0, |p| MAX_LEVEL.min(joints[p].level + 1));
        joints.push(JointArticulation {
            hanim: None,
            level,
            region: Region::Torso,
        });
    }
    joints
}

fn above_mapped(
    skeleton: &Skeleton,
    meanings: &[Result<JointTarget, UnmappedReason>],
) -> Vec<bool> {
    let mut above = vec![false; meanings.len()];
    for index in (0..meanings.len()).rev() {
        let mapped = matches!(meanings[index], Ok(JointTarget::Joint(_)));
        if let Some(parent) = skeleton.joints[index].parent {
            above[parent] |= mapped || above[index];
        }
    }
    above
}
