//! Joint maps: the meaning of the joint names of one kind of rig, as data.
//!
//! `articula-formats` reads joint maps from files (`docs/formats/joint-map.md`), `articula-build`
//! matches skeletons with them. Case, separators and namespace (`Armature|`, `mixamorig:`) of a
//! name are not significant. Source: thesis 3.1.3; H-Anim 1.1 and 2 (ISO/IEC 19774).

use crate::articulation::Region;
use crate::hanim_table::{self, HanimJoint};
use std::collections::BTreeMap;

/// The part of a human that the rigs of a joint map cover.
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
    /// The left side of the figure, +X.
    Left,
    /// The right side of the figure, -X.
    Right,
}

impl Side {
    /// Left, then right.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Returns the letter with which H-Anim names of the side begin.
    pub fn letter(self) -> &'static str {
        match self {
            Self::Left => "l",
            Self::Right => "r",
        }
    }

    /// Returns the side of an H-Anim name, if it has one.
    pub fn of(hanim: &str) -> Option<Self> {
        Self::BOTH.into_iter().find(|s| {
            hanim
                .strip_prefix(s.letter())
                .is_some_and(|r| r.starts_with('_'))
        })
    }
}

/// A joint of the standard with its level of articulation and region.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandardJoint {
    /// Name in H-Anim 1.1, or in H-Anim 2 if 1.1 does not have the joint.
    pub name: String,
    /// Level of articulation, 0 to 5.
    pub level: u8,
    /// Region of the body.
    pub region: Region,
}

impl StandardJoint {
    /// Returns the corresponding joint of the opposite side; the joint itself if it has no side.
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

/// The entry of a [`JointMap`] for one joint name: an H-Anim joint, a helper or no mapping.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JointTarget {
    /// A joint of the standard.
    Joint(StandardJoint),
    /// A joint of a rig of one hand; the left joint is stored for both sides.
    HandJoint(StandardJoint),
    /// A spine joint; the number of spine joints decides which one.
    Spine,
    /// No joint of the standard, but a joint of the finest detail of a region.
    Helper(Region),
    /// A known joint that is not mapped: it takes level and region from its parent.
    Ignored,
}

impl JointTarget {
    /// Returns the joint of the standard, or of a joint scheme, with an H-Anim name; `None` if there
    /// is none.
    pub fn standard(hanim: &str) -> Option<Self> {
        let row = hanim_table::named(hanim);
        row.map(|row| Self::Joint(StandardJoint::from(row)))
    }
}

/// Mapping of the joint names of one kind of rig, such as VRM 1.0, to H-Anim joints.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct JointMap {
    /// Short name, unique among joint maps.
    pub name: String,
    /// Name for display.
    pub title: String,
    /// Origin of the names.
    pub source: String,
    /// The part of a human that the rigs cover.
    pub scope: RigScope,
    /// Folded prefixes that a name may have, optionally followed by the digits of a copy.
    pub prefixes: Vec<String>,
    /// Folded suffixes that a name may have.
    pub suffixes: Vec<String>,
    /// Meaning of each [`folded`] name.
    pub targets: BTreeMap<String, JointTarget>,
}

impl JointMap {
    /// Returns the meaning of a joint name, if the map has one.
    pub fn target(&self, name: &str) -> Option<&JointTarget> {
        let folded = folded(name);
        self.targets.get(&folded).or_else(|| {
            let core = stripped(&folded, &self.prefixes, &self.suffixes);
            self.targets.get(core)
        })
    }
}

/// Mapping of body segments to H-Anim joints, for file formats without a hierarchy.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Segments {
    /// Name of the joint map that matched the segments.
    pub profile: String,
    /// Index in [`hanim_table::JOINTS`] of the joint of each segment, if any.
    pub joints: Vec<Option<usize>>,
    /// Indices of the spine segments, which have no joint yet because their names do not give their
    /// order.
    pub spine: Vec<usize>,
    /// Indices of the joints of the spine segments, lowest first; at most one for each segment.
    pub vertebrae: Vec<usize>,
}

/// Returns a joint name as joint maps compare it: lower case, without namespace and separators.
pub fn folded(name: &str) -> String {
    let own = name.rsplit([':', '|']).find(|part| !part.is_empty());
    let own = own.unwrap_or_default();
    let is_kept = |c: &char| !matches!(c, ' ' | '-' | '_' | '.');
    let mut out = String::with_capacity(own.len());
    // A character is compared with many maps when it is opened, and most names are plain.
    if own.is_ascii() {
        let letters = own.chars().filter(is_kept);
        letters.for_each(|c| out.push(c.to_ascii_lowercase()));
    } else {
        out.extend(own.chars().filter(is_kept).flat_map(char::to_lowercase));
    }
    out
}

/// The folded name without a prefix (and the digits of a copy) or a suffix.
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
        // By letters beyond ASCII as well, of which some have two small ones.
        assert_eq!(folded("rig:ÄRMEL_L.001"), "ärmell001");
        assert_eq!(folded("İ-K"), "i\u{307}k");
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
