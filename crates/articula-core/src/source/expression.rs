//! Named expressions: one weight each that drives morph targets and joints together.
//!
//! Sources: VRM 1.0 `expressions` (VRM 0.x `blendShapeMaster`) and the draft
//! `KHR_character_expression` with its masks. Response curves between 0 and 1 are replaced by
//! straight lines.

use crate::math::Transform;

/// A morph target driven by an expression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MorphBinding {
    /// Index into the character's meshes.
    pub mesh: usize,
    /// Index into the morph targets of the mesh.
    pub target: usize,
    /// Weight added to that of the morph target at full expression.
    pub weight: f32,
}

/// A joint driven by an expression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointBinding {
    /// Index into the joints of the skeleton.
    pub joint: usize,
    /// Local transform at full expression; components equal to the rest pose are not driven.
    pub full: Transform,
}

/// Dependence of a mask on the weight of the masking expression: proportional or a threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MaskKind {
    /// In proportion to the weight.
    Blend,
    /// Fully, as soon as the weight is above a threshold.
    Block {
        /// The threshold, 0 to 1.
        above: f32,
    },
}

/// The attenuation of one expression by another that is active at the same time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mask {
    /// Index of the attenuated expression.
    pub target: usize,
    /// How the attenuation depends on the weight of the masking expression.
    pub kind: MaskKind,
    /// Maximum fraction by which the target is reduced, 0 to 1.
    pub amount: f32,
    /// Whether the fractions of several such masks are summed, up to 1 (overrides of VRM); if not,
    /// the remaining fractions are multiplied (`KHR_character_expression_mask`).
    pub adds: bool,
}

/// An expression of a face or body, driven by one weight from 0 (off) to 1 (full).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expression {
    /// Name by which clips refer to it; presets of VRM 0.x have their VRM 1.0 names.
    pub name: String,
    /// The driven morph targets.
    pub morphs: Vec<MorphBinding>,
    /// The driven joints.
    pub joints: Vec<JointBinding>,
    /// Number of bindings to materials and textures in the file; these are not applied.
    pub unapplied: usize,
    /// Whether weights above 0.5 count as 1 and all others as 0.
    pub is_binary: bool,
    /// The expressions that this one attenuates.
    pub masks: Vec<Mask>,
}
