//! What the joint names of a kind of rig mean, as values: profiles are data files that formats
//! parses, and that `articula-build` matches a skeleton with.
//!
//! Case and separators of a name carry no meaning, a namespace (`Armature|`, `mixamorig:`)
//! neither. Source: thesis 3.1.3; H-Anim 1.1 and 2 (ISO/IEC 19774).

use crate::articulation::Region;
use crate::hanim_table::HanimJoint;
use std::collections::BTreeMap;

/// What part of a human the rigs of a profile have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RigScope {
    /// A whole human: hips, legs and arms are required.
    #[default]
    Body,
    /// One hand: a wrist and fingers are required.
    Hand,
}

/// One side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The figure's left, +X.
    Left,
    /// Its right.
    Right,
}

impl Side {
    /// Left, then right.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The letter that H-Anim names start with.
    pub fn letter(self) -> &'static str {
        match self {
            Self::Left => "l",
            Self::Right => "r",
        }
    }

    /// The side of an H-Anim name, if it has one.
    pub fn of(hanim: &str) -> Option<Self> {
        Self::BOTH.into_iter().find(|s| {
            hanim
                .strip_prefix(s.letter())
                .is_some_and(|r| r.starts_with('_'))
        })
    }
}

/// A joint of the standard with its place in the levels of articulation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandardJoint {
    /// Its name in H-Anim 1.1, or in 2 if the older one lacks it.
    pub name: String,
    /// Level of articulation, 0 to 5.
    pub level: u8,
    /// Part of the body.
    pub region: Region,
}

impl StandardJoint {
    /// The joint of the same name on the other side; itself if it has no side.
    pub fn mirrored(&self) -> Self {
        let name = match Side::of(&self.name) {
            Some(Side::Left) => format!("r{}", &self.name[1..]),
            Some(Side::Right) => format!("l{}", &self.name[1..]),
            None => self.name.clone(),
        };
        Self {
            name,
            ..self.clone()
        }
    }
}

impl From<&HanimJoint> for StandardJoint {
    fn from(row: &HanimJoint) -> Self {
        Self {
            name: row.name.to_owned(),
            level: row.level,
            region: row.region,
        }
    }
}

/// What a profile says of one joint name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JointTarget {
    /// A joint of the standard.
    Joint(StandardJoint),
    /// A joint of a lone hand; the left one stands for both.
    HandJoint(StandardJoint),
    /// A spine joint; which one depends on how many there are.
    Spine,
    /// No joint of the standard, but known to belong to a region's finest detail.
    Helper(Region),
    /// Known and left out: takes level and region from its parent.
    Ignored,
}

/// The joint names of one kind of rig.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct JointMap {
    /// Short name, unique among profiles.
    pub name: String,
    /// What the rig is called by people.
    pub title: String,
    /// Where the names come from.
    pub source: String,
    /// What part of a human it covers.
    pub scope: RigScope,
    /// Folded beginnings that a name may have besides, with digits that number its copies.
    pub prefixes: Vec<String>,
    /// Folded ends that a name may have besides.
    pub suffixes: Vec<String>,
    /// What each [`folded`] name means.
    pub targets: BTreeMap<String, JointTarget>,
}

impl JointMap {
    /// What the profile says of a joint name, if anything.
    pub fn target(&self, name: &str) -> Option<&JointTarget> {
        let folded = folded(name);
        self.targets.get(&folded).or_else(|| {
            let core = stripped(&folded, &self.prefixes, &self.suffixes);
            self.targets.get(core)
        })
    }
}

/// What segments that stand side by side are, for readers of formats without a hierarchy.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Segments {
    /// Name of the profile that knows them as a human.
    pub profile: String,
    /// The row of [`hanim_table::JOINTS`](crate::hanim_table::JOINTS) that each segment is, if any.
    pub joints: Vec<Option<usize>>,
    /// Segments of the spine that are none of them yet, since their order is not told by names.
    pub spine: Vec<usize>,
    /// Rows that those of the spine stand for, lowest first; as many or fewer.
    pub vertebrae: Vec<usize>,
}

/// The name without namespace, case and separators.
pub fn folded(name: &str) -> String {
    let own = name.rsplit([':', '|']).find(|part| !part.is_empty());
    own.unwrap_or_default()
        .chars()
        .filter(|c| !matches!(c, ' ' | '-' | '_' | '.'))
        .flat_map(char::to_lowercase)
        .collect()
}

/// The folded name without a prefix (and the digits that number its copies) or a suffix.
fn stripped<'a>(folded: &'a str, prefixes: &[String], suffixes: &[String]) -> &'a str {
    let after_prefix = prefixes
        .iter()
        .find_map(|p| folded.strip_prefix(p.as_str()));
    let core = after_prefix.map_or(folded, |rest| {
        rest.trim_start_matches(|c: char| c.is_ascii_digit())
    });
    let before_suffix = suffixes.iter().find_map(|s| core.strip_suffix(s.as_str()));
    before_suffix.unwrap_or(core)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fold_to_their_letters() {
        for name in [
            "Armature|mixamorig:Left_Up.Leg",
            "left up-leg",
            "LEFTUPLEG",
            "leftUpLeg",
        ] {
            assert_eq!(folded(name), "leftupleg");
        }
        assert_eq!(folded("Left:"), "left", "an empty last part is no name");
        assert_eq!(folded(""), "");
    }

    #[test]
    fn prefix_number_and_suffix_are_dropped() {
        let list = |s: &str| vec![s.to_owned()];
        assert_eq!(stripped("mixamorig12hips", &list("mixamorig"), &[]), "hips");
        assert_eq!(stripped("thighlarmature", &[], &list("armature")), "thighl");
        assert_eq!(stripped("spine1", &list("mixamorig"), &[]), "spine1");
    }

    #[test]
    fn sides_of_standard_names() {
        assert_eq!(Side::of("l_hip"), Some(Side::Left));
        assert_eq!(Side::of("r_hip"), Some(Side::Right));
        assert_eq!(Side::of("sacroiliac"), None);
        let mirrored = |name: &str| {
            let joint = StandardJoint {
                name: name.to_owned(),
                level: 0,
                region: Region::Torso,
            };
            joint.mirrored().name
        };
        assert_eq!(mirrored("r_index0"), "l_index0");
        assert_eq!(mirrored("vl5"), "vl5");
    }
}
