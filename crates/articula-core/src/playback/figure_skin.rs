//! Skinning of one figure, limited to the vertices whose joints or morph targets changed.

use crate::mesh::Mesh;
use crate::pose::ModelPose;
use crate::skin::{SkinnedMesh, palette};
use crate::skin_groups::{GroupedSkin, Matrix3x4, MorphedShape, StaleBlocks};
use glam::Affine3A;
use std::sync::Arc;

/// The skinned mesh of one figure, kept from frame to frame.
#[derive(Debug, Clone)]
pub struct FigureSkin {
    mesh: Arc<Mesh>,
    groups: Arc<GroupedSkin>,
    palette: Vec<Affine3A>,
    shown: Vec<Matrix3x4>,
    now: Vec<Matrix3x4>,
    shape: MorphedShape,
    stale: StaleBlocks,
    skinned: SkinnedMesh,
}

impl FigureSkin {
    /// Allocates the buffers of one figure. The mesh and its groups are shared by all figures.
    pub fn new(mesh: impl Into<Arc<Mesh>>, groups: impl Into<Arc<GroupedSkin>>) -> Self {
        let (mesh, groups) = (mesh.into(), groups.into());
        let rows = [[0.0; 4]; 3];
        Self {
            palette: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            shown: vec![rows; mesh.bindings.len()],
            now: vec![rows; mesh.bindings.len()],
            shape: groups.rest().clone(),
            stale: groups.stale(),
            skinned: SkinnedMesh::new(&mesh),
            mesh,
            groups,
        }
    }

    /// Skins the vertices that a changed joint or morph weight moves; returns their number. Does
    /// not allocate.
    ///
    /// # Panics
    /// If the pose, the weights or the groups belong to another mesh.
    pub fn skin(&mut self, model: &ModelPose, morph_weights: &[f32]) -> usize {
        palette(&self.mesh, model, &mut self.palette);
        GroupedSkin::rows(&self.palette, &mut self.now);
        let moved = self.groups.moved(&self.shown, &self.now);
        self.groups.mark_joints(&moved, &mut self.stale);
        self.groups
            .morph(morph_weights, &mut self.shape, &mut self.stale);
        std::mem::swap(&mut self.shown, &mut self.now);
        let (shape, stale, out) = (&self.shape, &mut self.stale, &mut self.skinned);
        self.groups.skin_stale(shape, &self.shown, stale, out)
    }

    /// Positions and normals of the last call of [`FigureSkin::skin`].
    pub fn skinned(&self) -> &SkinnedMesh {
        &self.skinned
    }
}
