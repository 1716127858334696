//! Files of motion alone: nodes that move, without a skin or a mesh.

use articula_core::source::{Character, Skeleton};

/// Declares the joints of a file that has neither skin nor mesh: the nodes at and below the lowest
/// node above all that move, of each tree with a moving node.
pub(super) fn mark_skeleton(character: &mut Character) {
    let skeleton = &character.skeleton;
    if !character.meshes.is_empty() || skeleton.joints.iter().any(|j| j.in_skin) {
        return;
    }
    let channels = character.clips.iter().flat_map(|c| &c.channels);
    let of_joints = channels.filter(|c| c.property.is_of_joint());
    let mut moves = vec![false; skeleton.joints.len()];
    for channel in of_joints {
        moves[channel.target] = true;
    }
    let tops = tops(skeleton, &moves);
    let joints = &mut character.skeleton.joints;
    for index in 0..joints.len() {
        let is_below = joints[index].parent.is_some_and(|p| joints[p].in_skin);
        joints[index].in_skin = is_below || tops[index];
    }
}

/// The lowest joint of each tree with all moving joints at or below it.
pub(super) fn tops(skeleton: &Skeleton, moves: &[bool]) -> Vec<bool> {
    let joints = &skeleton.joints;
    // Number of children with a moving joint at or below them.
    let mut branches = vec![0; joints.len()];
    for index in (0..joints.len()).rev() {
        if let Some(parent) = joints[index]
            .parent
            .filter(|_| moves[index] || branches[index] > 0)
        {
            branches[parent] += 1;
        }
    }
    let mut is_above = vec![false; joints.len()];
    let mut tops = vec![false; joints.len()];
    for index in 0..joints.len() {
        let may_be = joints[index].parent.is_none_or(|p| is_above[p]);
        let leads_on = !moves[index] && branches[index] == 1;
        is_above[index] = may_be && leads_on;
        tops[index] = may_be && !leads_on && (moves[index] || branches[index] > 0);
    }
    tops
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{Channel, Interpolation, Joint, Property, RawClip};

    /// Joints of a file with these parents, of which some move.
    fn marked(parents: &[Option<usize>], moving: &[usize]) -> Vec<usize> {
        let joint = |parent: &Option<usize>| Joint {
            name: String::new(),
            parent: *parent,
            rest: Transform::IDENTITY,
            in_skin: false,
        };
        let channel = |target: &usize| Channel {
            target: *target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: vec![0.0, 0.0, 0.0, 1.0],
        };
        let mut character = Character {
            skeleton: Skeleton {
                joints: parents.iter().map(joint).collect(),
            },
            clips: vec![RawClip {
                channels: moving.iter().map(channel).collect(),
                ..RawClip::default()
            }],
            ..Character::default()
        };
        mark_skeleton(&mut character);
        let joints = character.skeleton.joints.iter().enumerate();
        joints.filter(|(_, j)| j.in_skin).map(|(i, _)| i).collect()
    }

    #[test]
    fn the_skeleton_begins_where_all_that_moves_comes_together() {
        // A scene node, an armature, hips with two legs and a tip; beside it a camera.
        let parents = [None, Some(0), Some(1), Some(2), Some(2), Some(3), Some(0)];
        assert_eq!(marked(&parents, &[3, 4]), [2, 3, 4, 5]);
        assert_eq!(marked(&parents, &[2, 3]), [2, 3, 4, 5]);
        assert_eq!(marked(&parents, &[3]), [3, 5]);
        assert_eq!(marked(&parents, &[1]), [1, 2, 3, 4, 5]);
        assert!(marked(&parents, &[]).is_empty());
    }

    #[test]
    fn every_tree_has_its_own() {
        let parents = [None, Some(0), None, Some(2), Some(3), None];
        assert_eq!(marked(&parents, &[1, 3]), [1, 3, 4]);
    }
}
