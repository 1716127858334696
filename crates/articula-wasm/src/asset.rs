//! Opened characters.

use crate::error::{Fault, Result, index};
use crate::expression_names::known_names;
use crate::geometry::Geometry;
use crate::materials::materials;
use crate::morphs;
use crate::opening::open_alone;
use articula::glam::Vec3;
use articula::{PosedMesh, SkinnedMesh};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// An opened character: skeleton, mesh, clips, materials and pictures of a file. Figures and crowds of it share
/// its data and outlive it.
///
/// The play module opens GLB and VRM files; the tools module all formats of the library.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Asset {
    figure: Arc<articula::Figure>,
}

#[wasm_bindgen]
impl Asset {
    /// Opens a file that is whole in memory; `name` stands in errors, and its ending helps to tell the format.
    ///
    /// Throws an `ArticulaError` for a file that is malformed, too large or of an unknown format, and for one that
    /// needs another file beside it.
    pub fn open(bytes: &[u8], name: &str) -> Result<Asset> {
        let thrown = |error| Fault::of_file(&error, name);
        let opened = open_alone(bytes, name).map_err(thrown)?;
        let figure = articula::Figure::new(opened).map_err(thrown)?;
        Ok(Self::of(Arc::new(figure)))
    }

    /// Name of the file, as given.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.figure.opened.name().to_owned()
    }

    /// Names of the joints, in the order of their indices.
    #[wasm_bindgen(getter)]
    pub fn joints(&self) -> Vec<String> {
        let rig = &self.figure.asset.rig;
        (0..rig.len())
            .map(|joint| rig.name(joint).to_owned())
            .collect()
    }

    /// Parent of each joint; -1 without one. Parents come before their children.
    #[wasm_bindgen(getter)]
    pub fn parents(&self) -> Vec<i32> {
        let rig = &self.figure.asset.rig;
        let parent = |joint| rig.parent(joint).map_or(-1, |parent| parent as i32);
        (0..rig.len()).map(parent).collect()
    }

    /// Names of the clips.
    #[wasm_bindgen(getter)]
    pub fn clips(&self) -> Vec<String> {
        let clips = self.figure.asset.clips.iter();
        clips.map(|clip| clip.name.clone()).collect()
    }

    /// Duration of each clip in seconds.
    #[wasm_bindgen(getter, js_name = clipSecs)]
    pub fn clip_secs(&self) -> Vec<f32> {
        let clips = self.figure.asset.clips.iter();
        clips.map(|clip| clip.duration_secs()).collect()
    }

    /// What is odd about the file, a line each.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        let warnings = self.figure.opened.warnings().iter();
        warnings.map(|w| format!("{}: {}", w.at, w.what)).collect()
    }

    /// Whether the file stores tables for crowds. A crowd of a file without them computes them, which takes
    /// seconds: `Tools.prepare` makes such a file in a worker.
    #[wasm_bindgen(getter, js_name = isPrepared)]
    pub fn is_prepared(&self) -> bool {
        self.figure.is_prepared()
    }

    /// Least x, y, z and greatest x, y, z of the rest pose in model space, metres; of the joints if there is no
    /// mesh.
    #[wasm_bindgen(getter)]
    pub fn bounds(&self) -> Vec<f32> {
        let (rig, mesh) = (&*self.figure.asset.rig, &*self.figure.asset.mesh);
        let mut posed = PosedMesh::new(rig, mesh);
        let mut skinned = SkinnedMesh::new(mesh);
        posed.pose(rig.rest_pose());
        posed.skin(&mesh.morph_weights, &mut skinned);
        let mut points = skinned.positions;
        if points.is_empty() {
            points.extend((0..rig.len()).map(|joint| posed.model.position(joint)));
        }
        let least = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let greatest = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
        [least.to_array(), greatest.to_array()].concat()
    }

    /// Names of the morph targets of all meshes, in the order of their indices; empty where the file has none.
    #[wasm_bindgen(getter, js_name = morphNames)]
    pub fn morph_names(&self) -> Vec<String> {
        morphs::names(&self.figure)
    }

    /// Weight of each morph target where nothing drives it.
    #[wasm_bindgen(getter, js_name = morphDefaults)]
    pub fn morph_defaults(&self) -> Vec<f32> {
        self.figure.asset.mesh.morph_weights.clone()
    }

    /// Names that `Figure.setExpression` knows: expressions of the file (VRM), then morph targets that are named as
    /// blend shapes of ARKit or as visemes.
    #[wasm_bindgen(getter)]
    pub fn expressions(&self) -> Vec<String> {
        known_names(&self.figure)
    }

    /// Materials as JSON: `{"materials": […], "textures": [{"image": 0, "sampler": {…}}], "images":
    /// [{"name": "skin", "mimeType": "image/png"}]}`. Materials are those of glTF as in the file, and their textures
    /// index `textures`; but the mesh has one set of texture coordinates, those of the base colour with its
    /// transform applied. So materials name neither sets nor transforms, and no texture with other coordinates.
    /// `variants` are those of `KHR_materials_variants`, `{"name", "materials": [[usual, shown]], "mixed": [usual]}`: the
    /// materials that it shows in place of others, -1 for none, and those of which not all parts show it.
    pub fn materials(&self) -> String {
        materials(&self.figure).to_string()
    }

    /// Encoded bytes of a picture, such as those of a PNG file.
    ///
    /// Throws if there is no such picture.
    pub fn image(&self, image: usize) -> Result<Vec<u8>> {
        let images = &self.figure.opened.character().images;
        let image = index("picture", image, images.len())?;
        Ok(images[image].bytes.clone())
    }

    /// The finest mesh, which figures are drawn with. It has no vertices if the file has no mesh.
    pub fn mesh(&self) -> Geometry {
        Geometry::of(self.figure.asset.mesh.clone())
    }
}

impl Asset {
    pub(crate) fn of(figure: Arc<articula::Figure>) -> Self {
        Self { figure }
    }

    /// The figure, to share it.
    #[cfg(feature = "play")]
    pub(crate) fn figure(&self) -> &Arc<articula::Figure> {
        &self.figure
    }
}
