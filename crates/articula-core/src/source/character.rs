//! A whole character as a file describes it.

use super::{Credits, Expression, RawClip, RawMesh, Skeleton};
use crate::articulation::Articulation;
use crate::level_table::LevelTable;
use glam::Vec4;

/// How a surface looks, reduced to what a preview needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name as the file has it.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// Index into the character's images; its colours are sRGB.
    pub base_color_image: Option<usize>,
    /// Fragments below this alpha are not drawn; 0 draws all.
    pub alpha_cutoff: f32,
    /// Whether both sides are drawn.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_image: None,
            alpha_cutoff: 0.0,
            double_sided: false,
        }
    }
}

/// An encoded picture (PNG, JPEG, ...), not decoded.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Image {
    /// Name as the file has it.
    pub name: String,
    /// Media type such as `image/png`, or empty if unknown.
    pub mime_type: String,
    /// The encoded bytes.
    pub bytes: Vec<u8>,
}

/// Everything that one file says of one character.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Character {
    /// Name as the file has it, or empty.
    pub name: String,
    /// Joint tree at rest.
    pub skeleton: Skeleton,
    /// H-Anim level and region of each joint, if the file stores them.
    pub articulation: Option<Articulation>,
    /// Meshes, in the order of the file's nodes.
    pub meshes: Vec<RawMesh>,
    /// What the levels of [`RawMesh::clustered`] lose, if the file stores them.
    pub mesh_levels: Option<LevelTable>,
    /// Motions, in the order of the file.
    pub clips: Vec<RawClip>,
    /// Named expressions that clips may drive.
    pub expressions: Vec<Expression>,
    /// Origin and licence, if the file says anything of them.
    pub credits: Option<Credits>,
    /// Materials that primitives name.
    pub materials: Vec<Material>,
    /// Pictures that materials name.
    pub images: Vec<Image>,
}
