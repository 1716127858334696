//! Grouping of joints into skeletons: joints connected by a skin or a parent.

use articula_core::source::Character;
use articula_core::{JointSet, Rig};

/// Groups the skin joints of a character, ordered by first joint.
///
/// Joints of one skin form a group even if plain nodes lie between them; several skins on one
/// skeleton form one group.
pub(super) fn of(character: &Character, rig: &Rig) -> Vec<JointSet> {
    let mut groups = Groups::new(rig.len());
    let in_skin = rig.skin_joints();
    for mesh in &character.meshes {
        let joints = mesh.skin.joints.iter().copied();
        let joints: Vec<usize> = joints.filter(|j| in_skin.contains(*j)).collect();
        for pair in joints.windows(2) {
            groups.join(pair[0], pair[1]);
        }
    }
    for joint in in_skin.iter() {
        let mut above = rig.parent(joint);
        while let Some(a) = above.filter(|a| !in_skin.contains(*a)) {
            above = rig.parent(a);
        }
        if let Some(a) = above {
            groups.join(a, joint);
        }
    }
    let mut sets: Vec<(usize, JointSet)> = Vec::new();
    for joint in in_skin.iter() {
        let head = groups.head(joint);
        match sets.iter_mut().find(|(h, _)| *h == head) {
            Some((_, set)) => set.insert(joint),
            None => sets.push((head, JointSet::from_iter([joint]))),
        }
    }
    sets.into_iter().map(|(_, set)| set).collect()
}

/// Disjoint sets; the smallest member represents the set.
struct Groups(Vec<usize>);

impl Groups {
    fn new(members: usize) -> Self {
        Self((0..members).collect())
    }

    fn head(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.head(a), self.head(b));
        self.0[a.max(b)] = a.min(b);
    }
}
