//! What a frame of a figure did, as counts.

use crate::joint_set::JointSet;

/// Work and detail of the last frame of a [`FigurePlayer`](super::FigurePlayer).
///
/// Counts are exact and the same on every machine; the time of a stage is measured by the caller
/// around the call of that stage.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrameReport {
    /// Joints whose transform was sampled: those due that a clip or a layer moves.
    pub sampled: JointSet,
    /// Joints whose shown transform was renewed by the controller, or that are pinned.
    pub updated: JointSet,
    /// Joints in transition between a held and a sampled transform.
    pub in_transition: JointSet,
    /// Joints that show what they showed in the frame before.
    pub held: JointSet,
    /// Upper bound of the displacement of the skin by any one joint in pixels, if the controller
    /// has one. Changes of the pose after the controller are not part of it.
    pub bound_px: Option<f32>,
    /// Work of sampling: transforms evaluated in clips and layers, and stored keys read.
    pub transforms_sampled: usize,
    /// Work of the hierarchy: model matrices computed.
    pub matrices: usize,
}
