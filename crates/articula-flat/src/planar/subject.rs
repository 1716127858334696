//! The subject of a conversion: joints, vertices, triangles, materials and a clip.

use crate::appearance::Appearance;
use articula_core::{Clip, Mesh, Rig};

/// A character with its triangles and motion, as input of a bake.
#[derive(Debug, Clone, Copy)]
pub struct PlanarSubject<'a> {
    /// Joints of the character.
    pub rig: &'a Rig,
    /// Vertices of the character.
    pub mesh: &'a Mesh,
    /// Triangles that are shown, over the mesh's vertices: the mesh's own, or a coarser level.
    pub triangles: &'a [[u32; 3]],
    /// Materials and textures.
    pub appearance: &'a Appearance,
    /// Motion; the rest pose without one.
    pub clip: Option<&'a Clip>,
    /// Morph weights at rest, also used for targets that no track drives.
    pub morph_weights: &'a [f32],
}
