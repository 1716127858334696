//! Joints of a rig that the standard does not have, or not twice.

/// Why a joint of a rig maps to no joint of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum GapReason {
    /// The profile does not know the name.
    NoEntry,
    /// Another joint already stands for the same joint of the standard.
    Duplicate,
    /// The profile knows it as a detail of a region, such as a finger tip or the tongue.
    Helper,
    /// The profile leaves it out, such as a twist joint.
    Ignored,
}

/// A joint of a rig that maps to no joint of the standard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gap {
    /// Index in the skeleton.
    pub joint: usize,
    /// Its name.
    pub name: String,
    /// Why it maps to nothing.
    pub reason: GapReason,
}
