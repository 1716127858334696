//! The joint above the hips that carries root motion.

use super::super::similarity::Similarity;
use super::super::subject::{EditSubject, Posed};
use articula_core::JointSet;
use articula_core::source::RawClip;

/// A joint that carries a trajectory, or the world itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Carrier {
    /// Index of the joint; `None` for the world.
    pub(super) joint: Option<usize>,
    /// Its children.
    pub(super) children: Vec<usize>,
}

impl Carrier {
    /// Finds the topmost joint of the skin above the hips, or else the nearest node above them,
    /// from which all of the skin hangs and which, like all nodes above it, neither stretches nor
    /// mirrors.
    pub(super) fn find(subject: &EditSubject<'_>, clip: &RawClip) -> Option<Self> {
        let above: Vec<usize> = above(subject, subject.hips());
        let skin = subject.rig.skin_joints();
        let (of_skin, nodes): (Vec<usize>, Vec<usize>) =
            above.iter().partition(|j| skin.contains(**j));
        let joints = of_skin.iter().rev().chain(&nodes);
        joints
            .copied()
            .find(|j| carries_all(subject, *j) && is_even(subject, clip, *j))
            .map(|joint| Self {
                joint: Some(joint),
                children: children(subject, Some(joint)),
            })
    }

    /// The world, from which the roots hang.
    pub(super) fn world(subject: &EditSubject<'_>) -> Self {
        Self {
            joint: None,
            children: children(subject, None),
        }
    }

    /// Model-from-parent and model-from-carrier in a pose.
    pub(super) fn placed(
        &self,
        subject: &EditSubject<'_>,
        posed: &Posed,
    ) -> (Similarity, Similarity) {
        let Some(joint) = self.joint else {
            return (Similarity::IDENTITY, Similarity::IDENTITY);
        };
        let locals = above(subject, joint)
            .into_iter()
            .map(|j| posed.local.get(j));
        let parent = locals.fold(Similarity::IDENTITY, |p, t| Similarity::of(t) * p);
        (parent, parent * Similarity::of(posed.local.get(joint)))
    }

    /// The children below which something moves.
    pub(super) fn moving_children(&self, subject: &EditSubject<'_>, clip: &RawClip) -> Vec<usize> {
        let keyed = clip.channels.iter().filter(|c| c.property.is_of_joint());
        let keyed: JointSet = keyed.map(|c| c.target).collect();
        let moves = |child: &usize| keyed.iter().any(|j| subject.rig.is_at_or_below(j, *child));
        self.children.iter().copied().filter(moves).collect()
    }
}

/// The joints above one, nearest first.
fn above(subject: &EditSubject<'_>, joint: usize) -> Vec<usize> {
    std::iter::successors(subject.rig.parent(joint), |j| subject.rig.parent(*j)).collect()
}

fn children(subject: &EditSubject<'_>, joint: Option<usize>) -> Vec<usize> {
    let rig = &subject.rig;
    (0..rig.len()).filter(|j| rig.parent(*j) == joint).collect()
}

fn carries_all(subject: &EditSubject<'_>, joint: usize) -> bool {
    let mut skin = subject.rig.skin_joints().iter();
    skin.all(|j| subject.rig.is_at_or_below(j, joint))
}

/// Whether the joint and all above it are similarities, at rest and at each of their keys.
fn is_even(subject: &EditSubject<'_>, clip: &RawClip, joint: usize) -> bool {
    let chain: Vec<usize> = std::iter::once(joint)
        .chain(above(subject, joint))
        .collect();
    let even = |posed: &Posed| {
        let mut locals = chain.iter().map(|j| posed.local.get(*j));
        locals.all(Similarity::is)
    };
    let mut posed = subject.rest();
    let keyed = clip.channels.iter().filter(|c| chain.contains(&c.target));
    even(&posed)
        && keyed
            .filter(|c| c.property.is_of_joint())
            .flat_map(|c| &c.times_secs)
            .all(|t| {
                subject.pose(clip, *t, &mut posed);
                even(&posed)
            })
}
