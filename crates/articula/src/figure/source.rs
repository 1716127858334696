//! Figures that are computed from the source data alone, to be prepared.

use super::Figure;
use crate::error::Result;
use crate::open::{CharacterFile, GltfSource};
use crate::prepared::state::StoredState;
use articula_core::source::{Character, RawMesh};
use articula_formats::prepared::SourceOrder;

/// A figure in the order of its source, and its document.
pub(crate) struct SourceFigure {
    pub(crate) figure: Figure,
    pub(crate) gltf: Option<GltfSource>,
    /// Order of the document's vertices, if it differs.
    pub(crate) orders: Option<Vec<SourceOrder>>,
    /// Triangles of the mesh levels of the document.
    pub(crate) mesh_levels: Option<Vec<Vec<[u32; 3]>>>,
}

impl Figure {
    /// Builds rig, mesh and clips from the source data alone, as a preparation does.
    pub(crate) fn computed(opened: CharacterFile) -> Result<Self> {
        let state = StoredState {
            is_current: false,
            stale: Vec::new(),
            ..opened.stored_state()
        };
        Self::with_stored(opened, state)
    }

    /// The figure with the meshes of its character in the order of the source too, and what its
    /// document is made of.
    pub(crate) fn into_source(mut self) -> SourceFigure {
        let mesh_levels = self.stored_mesh_levels();
        let gltf = self.opened.detach_document();
        if let Some(meshes) = self.source_meshes.take() {
            let edit = |character: &mut Character| character.meshes = meshes;
            self.opened.edit_character(edit);
        }
        SourceFigure {
            gltf,
            orders: self.orders.take(),
            mesh_levels,
            figure: self,
        }
    }

    /// The figure of a document whose vertices have another order than the mesh.
    pub(crate) fn with_orders(self, orders: Option<&[SourceOrder]>, source: Vec<RawMesh>) -> Self {
        Self {
            source_meshes: orders.map(|_| source),
            orders: orders.map(<[SourceOrder]>::to_vec),
            ..self
        }
    }
}
