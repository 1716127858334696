//! The selectors of a level of articulation and the two rules that combine them.
//!
//! Source: thesis 5.1 (depth, complexity, zone, single joints; annex E's property) and 3.1.3
//! (stream adaptation keeps a joint only if it passes level and region mask). Differences: both
//! rules are named, `minus` always wins, and an absent selector is distinguished from one that
//! selects nothing.

use crate::articulation::{Complexity, Zone};
use crate::hanim_table;
use crate::joint_set::JointSet;
use crate::rig::Rig;

/// How the selectors of a [`Selection`] combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rule {
    /// `(depth | complexity | hanim | zone | plus) - minus`: for authoring and at run time.
    #[default]
    Sum,
    /// `((depth & complexity & hanim & zone) | plus) - minus`: for the adaptation of streams.
    Restrict,
}

/// A combination of selectors; [`Selection::joints`] resolves its names against a rig.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Selection {
    /// Rule by which the selectors combine.
    pub rule: Rule,
    /// Selects the joints of smaller depth; 1 is the root alone.
    pub depth: Option<u32>,
    /// Selects the joints of this level of articulation.
    pub complexity: Option<Complexity>,
    /// Selects the joints of this official H-Anim level, 0 to [`MAX_HANIM_LEVEL`].
    pub hanim: Option<u8>,
    /// Selects the joints of these regions.
    pub zone: Option<Zone>,
    /// Joints that are always included, by their names in the rig or their H-Anim names.
    pub plus: Vec<String>,
    /// Joints that are always excluded, by their names in the rig or their H-Anim names.
    pub minus: Vec<String>,
}

/// The error for a joint name that the rig does not have; holds the name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownJoint(pub String);

impl std::fmt::Display for UnknownJoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the rig has no joint \"{}\" (by its own name or its H-Anim name)",
            self.0
        )
    }
}

impl std::error::Error for UnknownJoint {}

impl Selection {
    /// Returns the joints of a rig that may move: all of them if there is no selector.
    ///
    /// # Errors
    /// [`UnknownJoint`] if `plus` or `minus` names a joint that the rig does not have.
    pub fn joints(&self, rig: &Rig) -> Result<JointSet, UnknownJoint> {
        let plus = named(rig, &self.plus)?;
        let minus = named(rig, &self.minus)?;
        let selectors = [
            self.depth.map(|k| depth(rig, k)),
            self.complexity.map(|c| complexity(rig, c)),
            self.hanim.map(|l| hanim(rig, l)),
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

/// Returns the joints with fewer than `k` skin joints above them, including nodes above the root.
pub fn depth(rig: &Rig, k: u32) -> JointSet {
    (0..rig.len())
        .filter(|&j| rig.depth(j) < k as usize)
        .collect()
}

/// Returns the joints whose data level is included in the complexity.
pub fn complexity(rig: &Rig, complexity: Complexity) -> JointSet {
    let joints = &rig.articulation().joints;
    match complexity.level() {
        None => JointSet::EMPTY,
        Some(level) => (0..rig.len())
            .filter(|&j| joints[j].level <= level)
            .collect(),
    }
}

/// Highest official H-Anim level of articulation; it includes every joint.
pub const MAX_HANIM_LEVEL: u8 = 3;

/// Returns the joints of an official level of articulation of H-Anim 1.1, LOA-0 to LOA-3: those
/// whose [`HanimJoint::hanim_level`](crate::hanim_table::HanimJoint::hanim_level) is at most
/// `level`.
///
/// A joint below the humanoid root that the standard does not name has the level above that of its
/// parent, at most 3; nodes above the root have its level, 0, and joints beside it have 3. In a rig
/// without any H-Anim name the level is the depth, at most 3.
pub fn hanim(rig: &Rig, level: u8) -> JointSet {
    let levels = hanim_levels(rig);
    (0..rig.len()).filter(|&j| levels[j] <= level).collect()
}

/// Official level of each joint.
fn hanim_levels(rig: &Rig) -> Vec<u8> {
    let of_table = |j: usize| {
        let name = rig.articulation().joints[j].hanim.as_deref()?;
        Some(hanim_table::JOINTS[hanim_table::find(name)?].hanim_level)
    };
    let named: Vec<Option<u8>> = (0..rig.len()).map(of_table).collect();
    if named.iter().all(Option::is_none) {
        let depth = |j| rig.depth(j).min(usize::from(MAX_HANIM_LEVEL)) as u8;
        return (0..rig.len()).map(depth).collect();
    }
    let mut is_above = vec![false; rig.len()];
    for j in (0..rig.len()).rev() {
        if let Some(p) = rig.parent(j) {
            is_above[p] |= is_above[j] || named[j].is_some();
        }
    }
    let mut levels: Vec<u8> = Vec::with_capacity(rig.len());
    let mut is_human = vec![false; rig.len()];
    for j in 0..rig.len() {
        let parent = rig.parent(j).filter(|p| is_human[*p]);
        is_human[j] = named[j].is_some() || parent.is_some();
        levels.push(match (named[j], parent) {
            (Some(level), _) => level,
            (None, Some(p)) => MAX_HANIM_LEVEL.min(levels[p] + 1),
            (None, None) if is_above[j] => 0,
            (None, None) => MAX_HANIM_LEVEL,
        });
    }
    levels
}

/// Returns the joints whose region is part of the zone.
pub fn zone(rig: &Rig, zone: Zone) -> JointSet {
    let joints = &rig.articulation().joints;
    (0..rig.len())
        .filter(|&j| zone.contains(joints[j].region))
        .collect()
}

/// Returns the joint with this name in the rig or, failing that, with this H-Anim name.
///
/// # Errors
/// [`UnknownJoint`] if there is no such joint.
pub fn joint(rig: &Rig, name: &str) -> Result<usize, UnknownJoint> {
    rig.find(name)
        .or_else(|| rig.articulation().find(name))
        .ok_or_else(|| UnknownJoint(name.to_owned()))
}

/// Returns a set extended by all ancestors of its joints: for close-ups, where a held ancestor
/// would be visible.
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
