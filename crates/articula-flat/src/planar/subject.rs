//! Who is shown: joints, vertices, triangles, materials and a clip.

use crate::appearance::Appearance;
use articula_core::{Clip, Mesh, Rig};

/// Who is shown, and what it does.
#[derive(Debug, Clone, Copy)]
pub struct PlanarSubject<'a> {
    /// Its joints.
    pub rig: &'a Rig,
    /// Its vertices.
    pub mesh: &'a Mesh,
    /// The triangles that are shown, over the mesh's vertices: the mesh's own, or a coarser
    /// level of them.
    pub triangles: &'a [[u32; 3]],
    /// Its materials and textures.
    pub look: &'a Appearance,
    /// What it does; the rest pose without one.
    pub clip: Option<&'a Clip>,
    /// Shape at rest, and what morph tracks do not drive.
    pub morph_weights: &'a [f32],
}
