//! The parts of an asset's preparation.

use crate::prepared::part::{
    BOUNDS, CLIPS, CLIPS_IN_PLACE, COMPACT, CONTACTS, ERROR_MATRIX, JOINT_LEVELS, PAIRED_LEVELS,
    PAIRED_POSE_CACHE, POSE_CACHE, POSE_KEYS, SEGS, SKINS,
};
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// A part of an asset's preparation, which may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PreparedPart {
    /// Clips at a uniform rate, and those whose root motion was removed.
    Clips,
    /// Joint LODs and their errors in each clip.
    JointLevels,
    /// Skin of each joint LOD.
    Skins,
    /// Bounds of the skin in each second of each clip.
    Bounds,
    /// Pairs of joint and mesh levels, with their errors; only with mesh levels.
    PairedLevels,
    /// Keys of the pose cache.
    PoseCache,
    /// Keys of each joint for a series of tolerances (`segs`).
    JointKeys,
    /// Keys of the whole pose for a series of tolerances (`posekeys`).
    PoseKeys,
    /// Error of each joint at each frame, after the thesis.
    ErrorMatrix,
    /// Intervals in which feet stand still.
    Contacts,
    /// Motion streams; only if they are asked for.
    CompactClips,
}

impl PreparedPart {
    /// All parts, in the order of reports.
    pub const ALL: [Self; 11] = [
        Self::Clips,
        Self::JointLevels,
        Self::Skins,
        Self::Bounds,
        Self::PairedLevels,
        Self::PoseCache,
        Self::JointKeys,
        Self::PoseKeys,
        Self::ErrorMatrix,
        Self::Contacts,
        Self::CompactClips,
    ];

    /// Name of the part on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clips => "clips",
            Self::JointLevels => "joint-levels",
            Self::Skins => "skins",
            Self::Bounds => "bounds",
            Self::PairedLevels => "paired-levels",
            Self::PoseCache => "pose-cache",
            Self::JointKeys => "joint-keys",
            Self::PoseKeys => "pose-keys",
            Self::ErrorMatrix => "error-matrix",
            Self::Contacts => "contacts",
            Self::CompactClips => "compact-clips",
        }
    }

    /// Names of its entries in `ARTICULA_prepared`; empty for tables of animations.
    pub(crate) fn entries(self) -> &'static [&'static str] {
        match self {
            Self::Clips => &[CLIPS, CLIPS_IN_PLACE],
            Self::JointLevels => &[JOINT_LEVELS],
            Self::Skins => &[SKINS],
            Self::Bounds => &[BOUNDS],
            Self::PairedLevels => &[PAIRED_LEVELS],
            Self::PoseCache => &[POSE_CACHE, PAIRED_POSE_CACHE],
            _ => &[],
        }
    }

    /// Name of its table in `ARTICULA_articulation` of each animation, if it is one.
    pub(crate) fn table(self) -> Option<&'static str> {
        match self {
            Self::JointKeys => Some(SEGS),
            Self::PoseKeys => Some(POSE_KEYS),
            Self::ErrorMatrix => Some(ERROR_MATRIX),
            Self::Contacts => Some(CONTACTS),
            Self::CompactClips => Some(COMPACT),
            _ => None,
        }
    }
}

/// Writes the name.
impl fmt::Display for PreparedPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Parses a name.
impl FromStr for PreparedPart {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|p| p.name() == name);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("unknown part \"{name}\"; expected one of {names}")
        })
    }
}

/// Size of a part in an asset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PartBytes {
    /// Name of the part.
    pub part: &'static str,
    /// Number of bytes that it takes in the file, over all clips.
    pub bytes: usize,
}
