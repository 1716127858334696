//! Joints of a rig without a counterpart in H-Anim.

/// Reason why a joint of a rig maps to no H-Anim joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum UnmappedReason {
    /// The joint map has no entry for the name.
    NoEntry,
    /// Another joint is already mapped to the same H-Anim joint.
    Duplicate,
    /// The joint map lists it as a detail of a region, such as a finger tip or the tongue.
    Helper,
    /// The joint map lists it as ignored, such as a twist joint.
    Ignored,
}

/// A joint of a rig that maps to no H-Anim joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnmappedJoint {
    /// Index in the skeleton.
    pub joint: usize,
    /// Name of the joint.
    pub name: String,
    /// Reason why it is not mapped.
    pub reason: UnmappedReason,
}
