//! What is shown of a character that arrives.

use super::Client;
use crate::asset::Asset;
use crate::matrix_rows::{IDENTITY, Rows, offset, rows};
use articula::Figure;
use articula::core::{ModelPose, local_to_model, palette};
use articula::glam::Affine3A;
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// What is shown of a character until finer bytes replace it: meshes and pictures that do not change, and the pose of
/// the last frame.
///
/// After `pose`, the methods that end in `At` are byte offsets into the memory of the module. Make views anew after
/// every call into the module, since its memory may have grown.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Arrival {
    figure: Arc<Figure>,
    model: ModelPose,
    matrices: Vec<Affine3A>,
    palette: Vec<Rows>,
    joints: Vec<Rows>,
    morphs: Vec<f32>,
}

impl Arrival {
    pub(super) fn new(figure: Arc<Figure>) -> Self {
        let (joints, mesh) = (figure.asset.rig.len(), &figure.asset.mesh);
        let bindings = mesh.bindings.len();
        Self {
            model: ModelPose::new(joints),
            matrices: vec![Affine3A::IDENTITY; bindings],
            palette: vec![IDENTITY; bindings],
            joints: vec![IDENTITY; joints],
            morphs: mesh.morph_weights.clone(),
            figure,
        }
    }
}

#[wasm_bindgen]
impl Arrival {
    /// Meshes, materials and pictures.
    pub fn asset(&self) -> Asset {
        Asset::of(self.figure.clone())
    }

    /// Poses it as the client plays its character, also if the client shows a finer one by now. Returns false, and
    /// stays as it is, if the finer one has another skeleton.
    pub fn pose(&mut self, client: &Client, character: usize) -> bool {
        let of = client.client.character(character);
        let Some(player) = of.and_then(|of| of.player()) else {
            return false;
        };
        let rig = &self.figure.asset.rig;
        if **player.model().rig() != **rig {
            return false;
        }
        local_to_model(rig, player.pose(), &mut self.model);
        palette(&self.figure.asset.mesh, &self.model, &mut self.matrices);
        let written = self.palette.iter_mut().chain(&mut self.joints);
        let matrices = self.matrices.iter().chain(&self.model.matrices);
        written.zip(matrices).for_each(|(to, m)| *to = rows(m));
        let weights = player.morph_weights();
        if weights.len() == self.morphs.len() {
            self.morphs.copy_from_slice(weights);
        }
        true
    }

    /// Byte offset of its palette, as that of a `Figure`.
    #[wasm_bindgen(js_name = paletteAt)]
    pub fn palette_at(&self) -> usize {
        offset(&self.palette)
    }

    /// Byte offset of a matrix of twelve floats for each joint: from its own space to model space.
    #[wasm_bindgen(js_name = jointsAt)]
    pub fn joints_at(&self) -> usize {
        offset(&self.joints)
    }

    /// Byte offset of the weight of each morph target, one float each.
    #[wasm_bindgen(js_name = morphsAt)]
    pub fn morphs_at(&self) -> usize {
        offset(&self.morphs)
    }
}
