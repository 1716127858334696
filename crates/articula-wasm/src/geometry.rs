//! Vertices of a mesh.

use crate::error::{Result, index};
use articula::core::Mesh;
#[cfg(feature = "play")]
use articula::crowd::CrowdAsset;
use articula::glam::{Vec3, Vec4};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// Vertices, skin and triangles of a mesh. Each method copies its array; call it once and `free` the object.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Geometry {
    source: Source,
}

#[derive(Debug)]
enum Source {
    Figure(Arc<Mesh>),
    #[cfg(feature = "play")]
    Level(CrowdAsset, usize),
}

impl Geometry {
    pub(crate) fn of(mesh: Arc<Mesh>) -> Self {
        Self {
            source: Source::Figure(mesh),
        }
    }

    /// The mesh of a level, which exists.
    #[cfg(feature = "play")]
    pub(crate) fn of_level(asset: CrowdAsset, level: usize) -> Self {
        Self {
            source: Source::Level(asset, level),
        }
    }

    fn mesh_data(&self) -> &Mesh {
        match &self.source {
            Source::Figure(mesh) => mesh,
            #[cfg(feature = "play")]
            Source::Level(asset, level) => asset.mesh(*level),
        }
    }

    /// The influences of all vertices in rows of [`Self::influences`], filled up.
    fn padded<T: Copy>(&self, of: &[T], fill: T) -> Vec<T> {
        let (own, room) = (self.mesh_data().influences, self.influences());
        let rows = of.chunks_exact(own);
        let padded = rows.flat_map(|row| {
            let fill = std::iter::repeat_n(fill, room - own);
            row.iter().copied().chain(fill)
        });
        padded.collect()
    }

    /// Offsets of a morph target, three numbers a vertex.
    fn offsets(
        &self,
        target: usize,
        of: impl Fn(&articula::core::Morph) -> &[Vec3],
    ) -> Result<Option<Vec<f32>>> {
        let mesh = self.mesh_data();
        let target = index("morph target", target, mesh.morph_weights.len())?;
        let mut dense: Option<Vec<f32>> = None;
        for morph in mesh.morphs.iter().filter(|m| usize::from(m.slot) == target) {
            let dense = dense.get_or_insert_with(|| vec![0.0; 3 * mesh.len()]);
            for (vertex, offset) in morph.vertices.iter().zip(of(morph)) {
                let at = 3 * *vertex as usize;
                dense[at..at + 3].copy_from_slice(&offset.to_array());
            }
        }
        Ok(dense)
    }
}

#[wasm_bindgen]
impl Geometry {
    /// Number of vertices.
    #[wasm_bindgen(getter)]
    pub fn vertices(&self) -> usize {
        self.mesh_data().len()
    }

    /// Number of influences of a vertex, a multiple of 4.
    #[wasm_bindgen(getter)]
    pub fn influences(&self) -> usize {
        self.mesh_data().influences.next_multiple_of(4)
    }

    /// Number of matrices of its palette, which `entries` count.
    #[wasm_bindgen(getter)]
    pub fn bindings(&self) -> usize {
        self.mesh_data().bindings.len()
    }

    /// Rest positions, three numbers a vertex; a palette takes them to model space.
    pub fn positions(&self) -> Vec<f32> {
        let positions = self.mesh_data().positions.iter();
        positions.flat_map(|v| v.to_array()).collect()
    }

    /// Rest normals, three numbers a vertex.
    pub fn normals(&self) -> Vec<f32> {
        let normals = self.mesh_data().normals.iter();
        normals.flat_map(|v| v.to_array()).collect()
    }

    /// Texture coordinates of the base colour, two numbers a vertex.
    pub fn texcoords(&self) -> Vec<f32> {
        let texcoords = self.mesh_data().texcoords.iter();
        texcoords.flat_map(|v| v.to_array()).collect()
    }

    /// Linear RGBA colours, four numbers a vertex; `undefined` if all are white.
    pub fn colors(&self) -> Option<Vec<f32>> {
        let colors = &self.mesh_data().colors;
        let is_white = colors.iter().all(|color| *color == Vec4::ONE);
        (!is_white).then(|| colors.iter().flat_map(|color| color.to_array()).collect())
    }

    /// Indices of matrices of a palette, `influences` a vertex; 0 where the weight is 0.
    pub fn entries(&self) -> Vec<u16> {
        self.padded(&self.mesh_data().binding_indices, 0)
    }

    /// Weights of `entries`, with the sum 1 for each vertex.
    pub fn weights(&self) -> Vec<f32> {
        self.padded(&self.mesh_data().weights, 0.0)
    }

    /// Three vertex indices a triangle, counter-clockwise.
    pub fn triangles(&self) -> Vec<u32> {
        self.mesh_data().triangles.as_flattened().to_vec()
    }

    /// Three numbers a part: index of its material or -1, first triangle, number of triangles.
    pub fn parts(&self) -> Vec<i32> {
        let parts = self.mesh_data().parts.iter();
        let parts = parts.flat_map(|part| {
            let material = part.material.map_or(-1, |material| material as i32);
            let triangles = &part.triangles;
            [material, triangles.start as i32, triangles.len() as i32]
        });
        parts.collect()
    }

    /// For each part the material by which it is drawn together with parts of other colours, or -1: the first from which
    /// its own differs in base colour alone; its own where there is none.
    #[wasm_bindgen(js_name = drawMaterials)]
    pub fn draw_materials(&self) -> Vec<i32> {
        let parts = self.mesh_data().parts.iter();
        let of = |material: Option<usize>| material.map_or(-1, |material| material as i32);
        parts.map(|part| of(part.draw_material)).collect()
    }

    /// Number of morph targets.
    pub fn morphs(&self) -> usize {
        self.mesh_data().morph_weights.len()
    }

    /// Offsets of positions of a morph target at weight 1, three numbers a vertex; `undefined` if it moves none
    /// of these vertices.
    ///
    /// Throws if there is no such target.
    #[wasm_bindgen(js_name = morphPositions)]
    pub fn morph_positions(&self, target: usize) -> Result<Option<Vec<f32>>> {
        self.offsets(target, |morph| &morph.positions)
    }

    /// The same of normals.
    #[wasm_bindgen(js_name = morphNormals)]
    pub fn morph_normals(&self, target: usize) -> Result<Option<Vec<f32>>> {
        self.offsets(target, |morph| &morph.normals)
    }
}
