//! Triangles of the levels that preparation makes.

use super::{KeptFace, MeshLevelOptions, parts_of_meshes_of};
use crate::error::{Context, Result};
use crate::face::FoundFace;
use crate::figure::Figure;
use crate::open::GltfSource;
use articula_build::{Asset, LevelTriangles, mesh_level_triangles};
use articula_formats::prepared::SourceOrder;

/// Triangles of the levels that preparation makes with these options, over the vertices of the
/// figure's mesh.
pub(crate) fn triangles(figure: &Figure, options: &MeshLevelOptions) -> Result<Vec<Vec<[u32; 3]>>> {
    let classes = match figure.opened.gltf() {
        Some(gltf) => vertex_classes(figure, gltf, figure.orders())?,
        None => Vec::new(),
    };
    let face = match options.keep_face {
        true => FoundFace::of(figure, &[]).ok(),
        false => None,
    };
    let face = face.and_then(|face| KeptFace::of(figure, &face));
    made(&figure.asset, options, classes, face.as_ref())
}

/// The same for an asset without a file; its face is not known.
pub(crate) fn triangles_of(
    asset: &Asset,
    options: &MeshLevelOptions,
) -> Result<Vec<Vec<[u32; 3]>>> {
    made(asset, options, Vec::new(), None)
}

/// Triangles of levels of a mesh whose vertices have the given classes.
fn made(
    asset: &Asset,
    options: &MeshLevelOptions,
    classes: Vec<u32>,
    face: Option<&KeptFace>,
) -> Result<Vec<Vec<[u32; 3]>>> {
    let options = options.of(&asset.mesh, &asset.rig, classes, face)?;
    let made = mesh_level_triangles(asset, &options).context("mesh levels")?;
    let triangles = |level: LevelTriangles| level.triangles;
    Ok(made.into_iter().map(triangles).collect())
}

/// Returns for each vertex of the character's mesh the first vertex with equal attributes in the
/// document; vertices of different parts are never equal.
pub(super) fn vertex_classes(
    figure: &Figure,
    gltf: &GltfSource,
    orders: Option<&[SourceOrder]>,
) -> Result<Vec<u32>> {
    let mut classes = Vec::with_capacity(figure.asset.mesh.len());
    for (m, parts) in parts_of_meshes(figure).into_iter().enumerate() {
        for (p, part) in parts.enumerate() {
            let first = figure.asset.mesh.parts[part].vertices.start as u32;
            let mut of_part = gltf.document.vertex_classes(gltf.node_of_mesh[m], p)?;
            if let Some(order) = orders.and_then(|orders| orders.get(part)) {
                of_part = classes_in_order(&of_part, &order.vertices);
            }
            classes.extend(of_part.iter().map(|class| first + class));
        }
    }
    Ok(classes)
}

/// Classes of stored vertices as classes of source vertices; `order` is the source of each.
fn classes_in_order(stored: &[u32], order: &[u32]) -> Vec<u32> {
    let mut first = vec![u32::MAX; stored.len()];
    for (class, source) in stored.iter().zip(order) {
        let least = &mut first[*class as usize];
        *least = (*least).min(*source);
    }
    let mut classes = vec![0; stored.len()];
    for (class, source) in stored.iter().zip(order) {
        classes[*source as usize] = first[*class as usize];
    }
    classes
}

/// Range of parts of the character's mesh for each source mesh.
pub(super) fn parts_of_meshes(figure: &Figure) -> Vec<std::ops::Range<usize>> {
    parts_of_meshes_of(&figure.opened.character().meshes)
}
