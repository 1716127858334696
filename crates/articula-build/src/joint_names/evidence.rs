//! How a joint was recognised, and how far that can be relied on.

/// What told that a joint of a rig is a joint of the standard, most reliable first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MappingEvidence {
    /// The humanoid map of the file names the joint.
    FileMap,
    /// A joint map has its name.
    JointMap,
    /// The words in its name have one meaning.
    Words,
    /// The words in its name have two meanings, such as `shoulder`, and its place in the tree decides.
    WordsAndTree,
    /// The shape of the whole tree at rest, in a rig whose names tell nothing.
    Shape,
    /// Its name tells nothing; it is where the joint of the standard must be, between or beside
    /// joints that are known.
    Tree,
}

impl MappingEvidence {
    /// Returns the confidence in a joint that has no doubt against it.
    pub fn confidence(self) -> MappingConfidence {
        match self {
            Self::FileMap | Self::JointMap | Self::Words => MappingConfidence::High,
            Self::WordsAndTree | Self::Shape => MappingConfidence::Medium,
            Self::Tree => MappingConfidence::Low,
        }
    }
}

/// Confidence in the mapping of one joint. Every [`JointDoubt`](super::JointDoubt) lowers it by one
/// step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MappingConfidence {
    /// To be checked by a person.
    Low,
    /// Likely right.
    Medium,
    /// Right, unless the file itself is wrong.
    High,
}

impl MappingConfidence {
    pub(crate) fn lowered(self) -> Self {
        match self {
            Self::High => Self::Medium,
            Self::Medium | Self::Low => Self::Low,
        }
    }
}
