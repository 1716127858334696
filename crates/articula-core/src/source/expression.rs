//! Named expressions: one number each that drives morph targets and joints together.
//!
//! Source: VRM 1.0 `expressions` (and 0.x `blendShapeMaster`), the draft `KHR_character_expression`
//! with its masks. Differs: curves between 0 and 1 are straight lines.

use crate::math::Transform;

/// A morph target that an expression drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MorphBinding {
    /// Index into the character's meshes.
    pub mesh: usize,
    /// Index into the morph targets of the mesh.
    pub target: usize,
    /// What the full expression adds to the weight of the target.
    pub weight: f32,
}

/// A joint that an expression drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointBinding {
    /// Index into the joints of the skeleton.
    pub joint: usize,
    /// Local transform that the full expression shows; parts that equal the rest are not driven.
    pub full: Transform,
}

/// How strongly a mask acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MaskKind {
    /// In proportion to the value of the masking expression.
    Blend,
    /// Wholly as soon as that value is above a threshold, 0 to 1.
    Block {
        /// The value that must be exceeded.
        above: f32,
    },
}

/// How one expression weakens another while both are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mask {
    /// Index of the weakened expression.
    pub target: usize,
    /// How the weakening follows the value.
    pub kind: MaskKind,
    /// Share that is taken away at most, 0 to 1.
    pub amount: f32,
    /// Whether the shares of several such masks are added up to 1 at most (overrides of VRM);
    /// otherwise what each leaves is multiplied (`KHR_character_expression_mask`).
    pub adds: bool,
}

/// An expression of a face or body, driven by one number from 0 (off) to 1 (full).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expression {
    /// Name by which motions find it; presets of VRM 0.x go by their names in VRM 1.0.
    pub name: String,
    /// Morph targets that it drives.
    pub morphs: Vec<MorphBinding>,
    /// Joints that it drives.
    pub joints: Vec<JointBinding>,
    /// How many bindings to materials and textures the file has beside these; they are not
    /// applied.
    pub unapplied: usize,
    /// Whether values above 0.5 count as 1 and all others as 0.
    pub is_binary: bool,
    /// Which expressions it weakens.
    pub masks: Vec<Mask>,
}
