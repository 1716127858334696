//! H-Anim level of articulation and body region of every joint of a rig.
//!
//! Source: thesis 3.1.3 and 5.1, `docs/methods/hanim.md` parts 3 to 5. The levels and regions of
//! the joints are data, not code: they come from [`crate::hanim_table`] and from the joint maps
//! that `articula-formats` reads.

use crate::Mismatch;
use std::fmt;
use std::str::FromStr;

/// Highest level of articulation of a joint; selecting up to it includes every joint.
pub const MAX_LEVEL: u8 = 5;

/// The seven named levels of articulation of a humanoid, each including the joints of those before.
///
/// The discriminant minus one is the data level, the number that tables and joint maps give for a
/// joint: `VeryLow` is level 0, `VeryHigh` level 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Complexity {
    /// No joint.
    None,
    /// Root, hips, shoulders.
    VeryLow,
    /// Adds neck, elbows, knees.
    Low,
    /// Adds one spine joint, collars, hands, feet and toes.
    Medium,
    /// Adds further spine joints.
    High,
    /// Adds the main finger joints.
    Fingers,
    /// Every joint.
    VeryHigh,
}

impl Complexity {
    /// All levels in ascending order.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::VeryLow,
        Self::Low,
        Self::Medium,
        Self::High,
        Self::Fingers,
        Self::VeryHigh,
    ];

    /// Returns the highest data level that is included; `None` if no joint is.
    pub(crate) fn level(self) -> Option<u8> {
        (self as u8).checked_sub(1)
    }

    fn name(self) -> &'static str {
        match self {
            Self::None => "None",
            Self::VeryLow => "VeryLow",
            Self::Low => "Low",
            Self::Medium => "Medium",
            Self::High => "High",
            Self::Fingers => "Fingers",
            Self::VeryHigh => "VeryHigh",
        }
    }
}

/// Writes the name as in the expression language.
impl fmt::Display for Complexity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Parses a name; case, spaces, `-` and `_` are ignored.
impl FromStr for Complexity {
    type Err = Mismatch;

    fn from_str(name: &str) -> Result<Self, Mismatch> {
        let wanted = folded(name);
        let found = Self::ALL.into_iter().find(|c| folded(c.name()) == wanted);
        found.ok_or_else(|| unknown("complexity", name))
    }
}

/// An elementary region of the body; each joint belongs to exactly one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Region {
    /// Eyes, jaw, brows, tongue.
    Face,
    /// Collars to wrists.
    Arms,
    /// Spine, neck and skull.
    Torso,
    /// Root, sacroiliac, hips.
    Pelvis,
    /// Knees and ankles.
    Legs,
    /// Below the ankles.
    Feet,
    /// Below the wrists.
    Hands,
}

impl Region {
    /// All regions, in the order of their numbers 1 to 7.
    pub const ALL: [Self; 7] = [
        Self::Face,
        Self::Arms,
        Self::Torso,
        Self::Pelvis,
        Self::Legs,
        Self::Feet,
        Self::Hands,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Arms => "arms",
            Self::Torso => "torso",
            Self::Pelvis => "pelvis",
            Self::Legs => "legs",
            Self::Feet => "feet",
            Self::Hands => "hands",
        }
    }
}

/// Writes the name as in the expression language.
impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Parses a name; case, spaces, `-` and `_` are ignored.
impl FromStr for Region {
    type Err = Mismatch;

    fn from_str(name: &str) -> Result<Self, Mismatch> {
        let wanted = folded(name);
        let found = Self::ALL.into_iter().find(|r| r.name() == wanted);
        found.ok_or_else(|| unknown("region", name))
    }
}

/// A set of regions as a bit mask, empty by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct Zone(u8);

impl Zone {
    /// All regions.
    pub const ALL: Self = Self(127);
    /// Face, arms, torso and hands.
    pub const UPPER: Self = Self(71);
    /// Pelvis, legs and feet.
    pub const LOWER: Self = Self(56);
    /// Face, arms and torso.
    pub const FACE_SHOULDERS: Self = Self(7);

    /// Returns whether the region is part of the zone.
    pub fn contains(self, region: Region) -> bool {
        self.0 & Self::from(region).0 != 0
    }
}

/// Returns the union of two zones.
impl std::ops::BitOr for Zone {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Parses the name of a region or of a composite (`upper`, `lower`, `face-shoulders`, `all`); case,
/// spaces, `-` and `_` are ignored.
impl FromStr for Zone {
    type Err = Mismatch;

    fn from_str(name: &str) -> Result<Self, Mismatch> {
        match folded(name).as_str() {
            "all" => Ok(Self::ALL),
            "upper" | "upperbody" => Ok(Self::UPPER),
            "lower" | "lowerbody" => Ok(Self::LOWER),
            "faceshoulders" => Ok(Self::FACE_SHOULDERS),
            other => match other.parse::<Region>() {
                Ok(region) => Ok(region.into()),
                Err(_) => Err(unknown("zone", name)),
            },
        }
    }
}

impl From<Region> for Zone {
    fn from(region: Region) -> Self {
        Self(1 << region as u8)
    }
}

/// The H-Anim classification of one joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointArticulation {
    /// H-Anim 1.1 joint name, if the joint is mapped.
    pub hanim: Option<String>,
    /// Lowest data level (0 to 5) that includes the joint.
    pub level: u8,
    /// Region of the joint.
    pub region: Region,
}

/// Level and region of every joint of one skeleton, in the skeleton's order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Articulation {
    /// Name of the joint map that matched the most joints, for display.
    pub profile: String,
    /// One entry for each joint.
    pub joints: Vec<JointArticulation>,
}

impl Articulation {
    /// Joints of which nothing is known, where only their hierarchy matters.
    pub fn unmapped(joints: usize) -> Self {
        let unknown = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Pelvis,
        };
        Self {
            profile: String::new(),
            joints: vec![unknown; joints],
        }
    }

    /// Returns the index of the first joint that is mapped to an H-Anim joint, by its name.
    pub fn find(&self, hanim: &str) -> Option<usize> {
        self.joints
            .iter()
            .position(|j| j.hanim.as_deref() == Some(hanim))
    }

    /// Returns the number of joints that are mapped to an H-Anim joint.
    pub fn mapped(&self) -> usize {
        self.joints.iter().filter(|j| j.hanim.is_some()).count()
    }
}

fn unknown(at: &str, name: &str) -> Mismatch {
    Mismatch::new(at, format!("unknown name \"{name}\""))
}

fn folded(name: &str) -> String {
    name.chars()
        .filter(|c| !matches!(c, ' ' | '-' | '_'))
        .map(|c| c.to_ascii_lowercase())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composites_have_the_masks_of_the_standard_table() {
        let of = |names: &[&str]| {
            names
                .iter()
                .map(|n| n.parse().unwrap())
                .fold(Zone::default(), |all, zone: Zone| all | zone)
        };
        assert_eq!(of(&["face", "arms", "torso", "hands"]), Zone::UPPER);
        assert_eq!(of(&["pelvis", "legs", "feet"]), Zone::LOWER);
        assert_eq!(of(&["face", "arms", "torso"]), Zone::FACE_SHOULDERS);
        assert_eq!(of(&["upper", "lower"]), Zone::ALL);
        assert!("tail".parse::<Zone>().is_err());
    }

    #[test]
    fn names_are_read_in_any_spelling() {
        assert_eq!("very_low".parse(), Ok(Complexity::VeryLow));
        assert_eq!("Very High".parse(), Ok(Complexity::VeryHigh));
        assert_eq!(Complexity::None.level(), None);
        assert_eq!(Complexity::VeryHigh.level(), Some(MAX_LEVEL));
    }
}
