//! Where a frame of a crowd lies in memory.

use crate::crowd::Crowd;
use crate::matrix_rows::offset;
use articula::core::CachedRows;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Crowd {
    /// Byte offset of the groups of draws, six unsigned integers each: kind (0 palette, 1 record, 2 step, 3
    /// impostor), level, first draw of that kind, number of draws, first set of morph target weights, number of
    /// draws with a set. The draws of a group are one instanced draw call for each part of the level's mesh.
    #[wasm_bindgen(js_name = groupsAt)]
    pub fn groups_at(&self) -> usize {
        offset(&self.groups)
    }

    /// Number of groups.
    #[wasm_bindgen(getter)]
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// Byte offset of the palettes of this frame: matrices of twelve floats, three rows of four.
    #[wasm_bindgen(js_name = palettesAt)]
    pub fn palettes_at(&self) -> usize {
        offset(self.player.palettes().bytes())
    }

    /// Number of matrices of all palettes.
    #[wasm_bindgen(getter, js_name = paletteMatrices)]
    pub fn palette_matrices(&self) -> usize {
        self.player.crowd().draw_list().matrices
    }

    /// Byte offset of the draws of kind 0, two unsigned integers each: character, first matrix among the palettes.
    #[wasm_bindgen(js_name = drawsAt)]
    pub fn draws_at(&self) -> usize {
        offset(&self.player.crowd().draw_list().draws)
    }

    /// Number of draws of kind 0.
    #[wasm_bindgen(getter)]
    pub fn draws(&self) -> usize {
        self.player.crowd().draw_list().draws.len()
    }

    /// Byte offset of the draws of kind 1, 16 bytes each: first matrices of two cached palettes, unsigned integers,
    /// the blend between them, a float, and the character.
    #[wasm_bindgen(js_name = recordsAt)]
    pub fn records_at(&self) -> usize {
        offset(self.player.records())
    }

    /// Number of draws of kind 1.
    #[wasm_bindgen(getter)]
    pub fn records(&self) -> usize {
        self.player.records().len()
    }

    /// Byte offset of the draws of kind 2, two unsigned integers each: character, first matrix among the cached
    /// ones.
    #[wasm_bindgen(js_name = steppedAt)]
    pub fn stepped_at(&self) -> usize {
        offset(self.player.stepped())
    }

    /// Number of draws of kind 2.
    #[wasm_bindgen(getter)]
    pub fn stepped(&self) -> usize {
        self.player.stepped().len()
    }

    /// Byte offset of the draws of kind 3, two unsigned integers each: character, pose among those of all clips.
    #[wasm_bindgen(js_name = impostorsAt)]
    pub fn impostors_at(&self) -> usize {
        offset(self.player.impostors())
    }

    /// Number of draws of kind 3.
    #[wasm_bindgen(getter)]
    pub fn impostors(&self) -> usize {
        self.player.impostors().len()
    }

    /// Byte offset of the cached palettes, matrices of twelve floats; they never change.
    #[wasm_bindgen(js_name = cachedAt)]
    pub fn cached_at(&self) -> usize {
        offset(self.cached())
    }

    /// Number of matrices of all cached palettes; 0 without a cache.
    #[wasm_bindgen(getter, js_name = cachedMatrices)]
    pub fn cached_matrices(&self) -> usize {
        self.cached().len() / 3
    }

    /// Byte offset of the world transform of each character: twelve floats, three rows of four.
    #[wasm_bindgen(js_name = transformsAt)]
    pub fn transforms_at(&self) -> usize {
        offset(&self.transforms)
    }

    /// Byte offset of the sets of morph target weights, a float a target.
    #[wasm_bindgen(js_name = morphWeightsAt)]
    pub fn morph_weights_at(&self) -> usize {
        offset(self.player.morph_weights())
    }

    /// Number of sets of morph target weights.
    #[wasm_bindgen(getter, js_name = morphSets)]
    pub fn morph_sets(&self) -> usize {
        self.player.crowd().draw_list().morph_sets()
    }
}

impl Crowd {
    fn cached(&self) -> &[[f32; 4]] {
        let cache = self.player.asset().model().parts().cache.as_ref();
        match cache.map(|cache| cache.rows()) {
            Some(CachedRows::Float(rows)) => rows,
            Some(CachedRows::Half(_)) | None => &[],
        }
    }
}
