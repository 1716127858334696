//! The selectors of one level of articulation and the two rules that combine them.
//!
//! Source: thesis 5.1 (depth, complexity, zone, single joints; annex E's property) and 3.1.3
//! (stream adaptation keeps a joint only if it passes level and region mask).
//! Differs: both rules are named, `minus` always wins, and a selector that is absent is told
//! from one that selects nothing.

use crate::articulation::{Complexity, Zone};
use crate::joint_set::JointSet;
use crate::rig::Rig;

/// How the selectors of a [`Selection`] combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rule {
    /// `(depth | complexity | zone | plus) - minus`: authoring and run time.
    #[default]
    Sum,
    /// `((depth & complexity & zone) | plus) - minus`: adaptation of streams.
    Restrict,
}

/// What an author asked for; names are resolved against a rig by [`Selection::joints`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Selection {
    /// How the selectors combine.
    pub rule: Rule,
    /// Joints of smaller depth; 1 is the root alone.
    pub depth: Option<u32>,
    /// Joints of this level of articulation complexity.
    pub complexity: Option<Complexity>,
    /// Joints of these regions.
    pub zone: Option<Zone>,
    /// Joints that are always on, by name of the rig or of H-Anim.
    pub plus: Vec<String>,
    /// Joints that are always off, by name of the rig or of H-Anim.
    pub minus: Vec<String>,
}

/// A joint that a selection names and the rig does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownJoint(pub String);

impl std::fmt::Display for UnknownJoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the rig has no joint \"{}\" (neither by its own nor by its H-Anim name)",
            self.0
        )
    }
}

impl std::error::Error for UnknownJoint {}

impl Selection {
    /// The joints of a rig that may move. Without any selector every joint may.
    ///
    /// # Errors
    /// [`UnknownJoint`] if `plus` or `minus` names a joint that the rig does not have.
    pub fn joints(&self, rig: &Rig) -> Result<JointSet, UnknownJoint> {
        let plus = named(rig, &self.plus)?;
        let minus = named(rig, &self.minus)?;
        let selectors = [
            self.depth.map(|k| depth(rig, k)),
            self.complexity.map(|c| complexity(rig, c)),
            self.zone.map(|z| zone(rig, z)),
        ];
        if selectors.iter().all(Option::is_none) && self.plus.is_empty() {
            return Ok(rig.all().difference(&minus));
        }
        let chosen = selectors.into_iter().flatten();
        let base = match self.rule {
            Rule::Sum => chosen.fold(JointSet::EMPTY, |a, b| a.union(&b)),
            Rule::Restrict => chosen.fold(rig.all(), |a, b| a.intersection(&b)),
        };
        Ok(base.union(&plus).difference(&minus))
    }
}

/// Joints with fewer than `k` skin joints above them, and the nodes above the root with them.
pub fn depth(rig: &Rig, k: u32) -> JointSet {
    (0..rig.len())
        .filter(|&j| rig.depth(j) < k as usize)
        .collect()
}

/// Joints whose data level the complexity includes.
pub fn complexity(rig: &Rig, complexity: Complexity) -> JointSet {
    let joints = &rig.articulation().joints;
    match complexity.level() {
        None => JointSet::EMPTY,
        Some(level) => (0..rig.len())
            .filter(|&j| joints[j].level <= level)
            .collect(),
    }
}

/// Joints of the zone's regions.
pub fn zone(rig: &Rig, zone: Zone) -> JointSet {
    let joints = &rig.articulation().joints;
    (0..rig.len())
        .filter(|&j| zone.contains(joints[j].region))
        .collect()
}

/// The joint of this rig name or, failing that, of this H-Anim name.
///
/// # Errors
/// [`UnknownJoint`] if there is none.
pub fn joint(rig: &Rig, name: &str) -> Result<usize, UnknownJoint> {
    let by_hanim = || {
        let joints = &rig.articulation().joints;
        joints.iter().position(|j| j.hanim.as_deref() == Some(name))
    };
    rig.find(name)
        .or_else(by_hanim)
        .ok_or_else(|| UnknownJoint(name.to_owned()))
}

/// A set with all ancestors of its joints: for close-ups, where a held ancestor would show.
pub fn with_ancestors(rig: &Rig, set: &JointSet) -> JointSet {
    let mut out = *set;
    for joint in set.iter() {
        let mut at = rig.parent(joint);
        while let Some(p) = at {
            if out.contains(p) {
                break;
            }
            out.insert(p);
            at = rig.parent(p);
        }
    }
    out
}

fn named(rig: &Rig, names: &[String]) -> Result<JointSet, UnknownJoint> {
    names.iter().map(|n| joint(rig, n)).collect()
}
