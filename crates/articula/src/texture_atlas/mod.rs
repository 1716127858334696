//! Textures of several materials in one picture each kind, so that a renderer changes textures less often.
//!
//! `cells` finds which materials share a place, `packed` gives places their rectangles, `drawn` draws the pictures.

mod cells;
mod drawn;
mod packed;

use crate::error::{Error, Result};
use crate::open::CharacterFile;
use articula_core::source::{Character, Primitive};
use articula_flat::Averaging;
use articula_formats::Limits;
use articula_formats::gltf::{MeshGeometry, read_document};
use cells::Cells;
use packed::Places;
use std::collections::BTreeSet;

/// What became of the textures of a character.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TextureAtlas {
    /// Materials whose textures are in the atlas. None if fewer than two places would be in it.
    pub materials: Vec<usize>,
    /// Width and height in pixels; 0 without an atlas.
    pub size_px: [u32; 2],
    /// Pictures that were made, one for each kind of texture.
    pub pictures: usize,
    /// Materials with textures that stay as they are, with the reason.
    pub left_out: Vec<(usize, &'static str)>,
}

impl CharacterFile {
    /// Puts the textures of materials into one square picture for each kind of texture (base colour, normals and
    /// others), with sides of a power of two of at most `longest_px` pixels, and lets the texture coordinates
    /// follow. The largest scale at which all fit is used, at most 1. Materials stay; what shows a texture more
    /// than once, or at other than the first coordinates, keeps its textures ([`TextureAtlas::left_out`]). A picture is
    /// filtered as the first texture in it, and a border of 2 pixels keeps textures apart, so small mipmaps mix them.
    /// Stored mesh levels and prepared data are dropped.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a file without a glTF document, a size that is not 64 to 16,384, and if more
    /// textures are there than a picture of this size has room for. The character is then unchanged.
    pub fn merge_textures(&mut self, longest_px: u32) -> Result<TextureAtlas> {
        let Some(gltf) = self.gltf() else {
            let what = "only glTF and VRM files have textures that can be merged; write the character as GLB first";
            return Err(Error::unsuited(what));
        };
        let cells = Cells::of(self.character(), &gltf.document);
        let mut atlas = TextureAtlas {
            left_out: cells.left_out.clone(),
            ..TextureAtlas::default()
        };
        if cells.cells.len() < 2 {
            return Ok(atlas);
        }
        let uses = gltf.document.picture_uses();
        let averaging = |picture: usize| match uses.get(picture).is_some_and(|of| of.numbers) {
            true => Averaging::Numbers,
            false => Averaging::Light,
        };
        let places = Places::new(&drawn::sizes(&cells), longest_px)?;
        let pictures = drawn::pictures(&cells, &places, &averaging)?;
        let mut gltf = gltf.clone();
        let moved = moved(self.character(), &cells, &places);
        let meshes = moved.iter().zip(&gltf.node_of_mesh);
        let geometry: Vec<MeshGeometry<'_>> = meshes
            .filter_map(|(parts, node)| {
                let parts = parts.as_ref()?.iter().collect();
                Some(MeshGeometry { node: *node, parts })
            })
            .collect();
        gltf.document.set_geometry(&geometry)?;
        let merged = pictures.iter();
        let merged: Vec<(BTreeSet<usize>, &[u8])> = merged
            .map(|(old, bytes)| (old.clone(), bytes.as_slice()))
            .collect();
        gltf.document.merge_pictures(&merged)?;
        let read = read_document(gltf.document.clone(), &Limits::default())?.value;
        let mut character = self.character().clone();
        character.images = read.character.images;
        character.materials = read.character.materials;
        for (mesh, parts) in character.meshes.iter_mut().zip(moved) {
            mesh.clustered.clear();
            if let Some(parts) = parts {
                mesh.primitives = parts;
                mesh.levels.clear();
                mesh.screen_coverage = None;
            }
        }
        self.set_meshes(character, Some(gltf));
        atlas.materials = cells.materials().collect();
        atlas.size_px = [places.side_px; 2];
        atlas.pictures = pictures.len();
        Ok(atlas)
    }
}

/// For each mesh of which a part is in the atlas, its parts with their new texture coordinates.
fn moved(character: &Character, cells: &Cells, places: &Places) -> Vec<Option<Vec<Primitive>>> {
    let meshes = character.meshes.iter().map(|mesh| {
        let cell_of = |part: &Primitive| cells.of_material(part.material?);
        if mesh.primitives.iter().all(|part| cell_of(part).is_none()) {
            return None;
        }
        let parts = mesh.primitives.iter().map(|part| {
            let mut part = part.clone();
            if let Some((cell, shift)) = cell_of(&part) {
                for uv in &mut part.texcoords {
                    *uv = places.moved(cell, *uv - shift);
                }
            }
            part
        });
        Some(parts.collect())
    });
    meshes.collect()
}
