//! Mesh levels of an asset: options, computation and storage.

mod options;
mod show;
mod stream;

pub use options::MeshLevelOptions;
pub(crate) use show::show;
pub use show::{
    LevelChoice, MeshView, ShownInView, ShownLevelOptions, ShownLevels, ShownLevelsReport,
    ShownRegion,
};
pub use stream::MeshLevelStream;

use crate::error::{Error, Result};
use crate::figure::Figure;
use crate::open::GltfSource;
use crate::work::Executor;
use articula_build::{MeshLevels, mesh_levels};
use articula_core::PosedMesh;
use articula_flat::Bounds;
use articula_formats::gltf::Document;
use articula_formats::gltf::{MeshParts, PartLevels};
use glam::Vec3;

/// Measured mesh levels of a character, and the transport stream that encodes them.
#[derive(Debug)]
pub struct CodedMeshLevels {
    /// The levels and their errors.
    pub levels: MeshLevels,
    /// The levels as a stream of chunks.
    pub stream: MeshLevelStream,
    /// Warnings about lost data, as text for the user.
    pub warnings: Vec<String>,
}

/// Makes the levels of a figure and stores them in its document.
pub(crate) fn add(
    figure: &Figure,
    gltf: &mut GltfSource,
    wanted: &MeshLevelOptions,
    work: &Executor<'_>,
) -> Result<CodedMeshLevels> {
    const WHAT: &str = "building mesh levels";
    let asset = &figure.asset;
    if asset.mesh.triangles.is_empty() {
        let what = "no mesh has triangles; build without mesh levels";
        return Err(Error::unsuited(what));
    }
    work.step(WHAT, 0, 3)?;
    let classes = vertex_classes(figure, gltf)?;
    let options = wanted.of(&asset.mesh, &asset.rig, classes)?;
    let mut levels = mesh_levels(asset, &options)?;
    levels.table.regions = wanted.region_names();
    work.step(WHAT, 1, 3)?;
    let stream = stream::coded(figure, &levels, &options.simplify.regions)?;
    work.step(WHAT, 2, 3)?;
    store(&mut gltf.document, figure, &levels, &gltf.node_of_mesh)?;
    if wanted.msft_lod {
        let rest = PosedMesh::new(&asset.rig, &asset.mesh)
            .pose(asset.rig.rest_pose())
            .skinned(&asset.mesh.morph_weights)
            .positions;
        for (parts, node) in parts_of_meshes(figure).into_iter().zip(&gltf.node_of_mesh) {
            let parts = &asset.mesh.parts[parts];
            let vertices = parts.iter().flat_map(|p| &rest[p.vertices.clone()]);
            let radius = radius_metres(vertices);
            gltf.document
                .add_level_nodes(*node, &levels.table, radius)?;
        }
    }
    work.step(WHAT, 3, 3)?;
    let meshes = &figure.opened.character.meshes;
    let replaced =
        |m: &&articula_core::source::RawMesh| !m.levels.is_empty() && m.clustered.is_empty();
    let warning = |m: &articula_core::source::RawMesh| {
        format!(
            "mesh \"{}\": the coarser levels of the file are replaced",
            m.name
        )
    };
    Ok(CodedMeshLevels {
        warnings: meshes.iter().filter(replaced).map(warning).collect(),
        levels,
        stream,
    })
}

/// Radius of a mesh at rest: half the diagonal of its bounding box.
fn radius_metres<'a>(vertices: impl Iterator<Item = &'a Vec3>) -> f32 {
    let bounds = Bounds::around(vertices.filter(|p| p.is_finite()).map(|p| (*p, *p)));
    bounds.map_or(1.0, |b| 0.5 * b.low.distance(b.high))
}

/// Returns for each vertex of the character's mesh the first vertex with equal attributes in the
/// document; vertices of different parts are never equal.
fn vertex_classes(figure: &Figure, gltf: &GltfSource) -> Result<Vec<u32>> {
    let mut classes = Vec::with_capacity(figure.asset.mesh.len());
    for (m, parts) in parts_of_meshes(figure).into_iter().enumerate() {
        for (p, part) in parts.enumerate() {
            let first = figure.asset.mesh.parts[part].vertices.start as u32;
            let of_part = gltf.document.vertex_classes(gltf.node_of_mesh[m], p)?;
            classes.extend(of_part.iter().map(|class| first + class));
        }
    }
    Ok(classes)
}

/// Writes the levels into a document.
fn store(
    document: &mut Document,
    figure: &Figure,
    made: &MeshLevels,
    node_of_mesh: &[usize],
) -> Result<()> {
    let object = |part: usize| {
        let object = &made.objects[part];
        PartLevels {
            vertices: &object.vertices,
            triangles: &object.triangles,
            clusters: &object.clusters,
        }
    };
    let meshes: Vec<MeshParts<'_>> = parts_of_meshes(figure)
        .into_iter()
        .zip(node_of_mesh)
        .map(|(parts, node)| MeshParts {
            node: *node,
            parts: parts.map(object).collect(),
        })
        .collect();
    document.set_mesh_levels(&made.table, &meshes)?;
    Ok(())
}

/// Range of parts of the character's mesh for each source mesh.
fn parts_of_meshes(figure: &Figure) -> Vec<std::ops::Range<usize>> {
    parts_of_meshes_of(&figure.opened.character.meshes)
}

/// Range of primitives, counted over all meshes, for each mesh.
fn parts_of_meshes_of(meshes: &[articula_core::source::RawMesh]) -> Vec<std::ops::Range<usize>> {
    let mut first = 0;
    let range = |mesh: &articula_core::source::RawMesh| {
        let range = first..first + mesh.primitives.len();
        first = range.end;
        range
    };
    meshes.iter().map(range).collect()
}
