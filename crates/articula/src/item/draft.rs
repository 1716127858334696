//! An item that is being made.

use super::figure::StrippedFigure;
use super::files::{Item, NewFiles};
use super::manifest::{FORMAT, FigureEntry, FlatEntry, Manifest, VERSION, WholeFile};
use super::part::ItemPart;
use super::sent::FileEntry;
use crate::error::Result;
use crate::figure::Figure;
use articula_flat::Bounds;
use std::collections::BTreeMap;

/// Name of the figure's file.
const FIGURE: &str = "figure.glb";

/// An item that is being made.
#[derive(Debug, Clone)]
pub(super) struct Draft {
    title: String,
    figure: FigureEntry,
    pub(super) mesh: Vec<ItemPart>,
    pub(super) motions: Vec<ItemPart>,
    pub(super) faces: Vec<ItemPart>,
    pub(super) textures: Vec<ItemPart>,
    pub(super) flat: Vec<FlatEntry>,
    pub(super) whole: Vec<WholeFile>,
    pub(super) files: NewFiles,
    pub(super) warnings: Vec<String>,
}

impl Draft {
    /// An item of a figure's file.
    pub(super) fn new(title: String, figure: &Figure, stripped: &StrippedFigure) -> Result<Self> {
        let mut files = NewFiles::default();
        let mesh = &figure.asset.mesh;
        let entry = FigureEntry {
            file: FIGURE.to_owned(),
            joints: figure.asset.rig.len() as u64,
            vertices: mesh.len() as u64,
            triangles: mesh.triangles.len() as u64,
            morph_targets: mesh.morph_weights.len() as u64,
            size_m: size(figure),
            bytes: files.put(FIGURE, stripped.glb.clone())?,
        };
        Ok(Self {
            title,
            figure: entry,
            mesh: Vec::new(),
            motions: Vec::new(),
            faces: Vec::new(),
            textures: Vec::new(),
            flat: Vec::new(),
            whole: Vec::new(),
            files,
            warnings: stripped.left_out.clone(),
        })
    }

    /// Takes the mesh and the motions of another draft if it has none.
    pub(super) fn fill(&mut self, base: &Self) {
        let of_base = [
            (&mut self.mesh, &base.mesh),
            (&mut self.motions, &base.motions),
        ];
        for (own, of_base) in of_base.into_iter().filter(|(own, _)| own.is_empty()) {
            own.clone_from(of_base);
            let names = own.iter().flat_map(|part| [&part.file, &part.index]);
            for name in names.flatten() {
                let bytes = base.files.0.get(name).cloned();
                self.files.0.insert(name.clone(), bytes.unwrap_or_default());
            }
        }
    }

    /// The item; `known` tells how files travel, as far as they have not changed.
    pub(super) fn item(self, known: BTreeMap<String, FileEntry>) -> Item {
        let parts = [self.mesh, self.motions, self.faces, self.textures];
        let mut manifest = Manifest {
            format: FORMAT.to_owned(),
            version: VERSION,
            generator: concat!("articula ", env!("CARGO_PKG_VERSION")).to_owned(),
            name: self.title,
            figure: self.figure,
            parts: parts.into_iter().flatten().collect(),
            flat: self.flat,
            whole: self.whole,
            files: known,
            warnings: self.warnings,
        };
        manifest.round_errors();
        Item::new(manifest, self.files.0)
    }
}

/// Longest side of the bounding box of the mesh at rest, or of the joints without one.
fn size(figure: &Figure) -> f64 {
    let asset = &figure.asset;
    let mut posed = articula_core::PosedMesh::new(&asset.rig, &asset.mesh);
    posed.pose(asset.rig.rest_pose());
    let skinned = posed.skinned(&asset.mesh.morph_weights);
    let joints = (0..asset.rig.len()).map(|joint| posed.model.position(joint));
    let points = skinned.positions.iter().copied();
    let bounds = match skinned.positions.is_empty() {
        true => Bounds::around(joints.map(|p| (p, p))),
        false => Bounds::around(points.map(|p| (p, p))),
    };
    bounds.map_or(0.0, |b| f64::from((b.high - b.low).max_element()))
}
