//! Measured mesh levels, coded as a stream and stored in a document.

mod stream;

pub use stream::MeshLevelStream;

use super::made::{parts_of_meshes, vertex_classes};
use super::{KeptFace, MeshLevelOptions, options};
use crate::error::{Error, Result};
use crate::face::FoundFace;
use crate::figure::Figure;
use crate::open::GltfSource;
use crate::work::Executor;
use articula_build::{Clustered, LeftOutLevel, LeftOutReason, MeshLevels, mesh_levels};
use articula_core::{Part, PosedMesh};
use articula_formats::gltf::Document;
use articula_formats::gltf::{MeshParts, PartLevels};
use articula_formats::prepared::SourceOrder;
use glam::Vec3;

/// Name of the step in progress reports.
const BUILDING: &str = "building mesh levels";

/// Measured mesh levels of a character, and the transport stream that encodes them.
#[derive(Debug)]
pub struct CodedMeshLevels {
    /// The levels and their errors.
    pub levels: MeshLevels,
    /// The levels as a stream of chunks.
    pub stream: MeshLevelStream,
    /// What every level keeps of the face; `None` if no face was found, or it was not to be kept.
    pub face: Option<KeptFace>,
    /// Warnings about lost data, as text for the user.
    pub warnings: Vec<String>,
}

/// Makes the levels of a figure and stores them in its document. `orders` is the order of the
/// document's vertices, if it is not that of the figure; `face` is the figure's face.
pub(crate) fn add(
    figure: &Figure,
    (gltf, orders): (&mut GltfSource, Option<&[SourceOrder]>),
    face: Option<&FoundFace>,
    wanted: &MeshLevelOptions,
    work: &Executor<'_>,
) -> Result<CodedMeshLevels> {
    let made = coded(figure, (gltf, orders), face, wanted, work)?;
    let asset = &figure.asset;
    let levels = &made.levels;
    store(
        (&mut gltf.document, orders),
        figure,
        levels,
        &gltf.node_of_mesh,
    )?;
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
    work.step(BUILDING, 3, 3)?;
    Ok(made)
}

/// Makes the levels of a figure and codes them; the arguments are those of [`add`].
pub(crate) fn coded(
    figure: &Figure,
    (gltf, orders): (&GltfSource, Option<&[SourceOrder]>),
    face: Option<&FoundFace>,
    wanted: &MeshLevelOptions,
    work: &Executor<'_>,
) -> Result<CodedMeshLevels> {
    let asset = &figure.asset;
    if asset.mesh.triangles.is_empty() {
        let what = "no mesh has triangles; build without mesh levels";
        return Err(Error::unsuited(what));
    }
    work.step(BUILDING, 0, 3)?;
    let classes = vertex_classes(figure, gltf, orders)?;
    let kept = face.filter(|_| wanted.keep_face);
    let kept = kept.and_then(|face| KeptFace::of(figure, face));
    let options = wanted.of(&asset.mesh, &asset.rig, classes, kept.as_ref())?;
    let mut levels = mesh_levels(asset, &options)?;
    levels.table.regions = region_names(wanted);
    work.step(BUILDING, 1, 3)?;
    let stream = stream::coded(
        figure,
        &levels,
        &options.simplify.regions,
        wanted.sizes_alone,
    )?;
    work.step(BUILDING, 2, 3)?;
    let meshes = &figure.opened.character().meshes;
    let replaced =
        |m: &&articula_core::source::RawMesh| !m.levels.is_empty() && m.clustered.is_empty();
    let warning = |m: &articula_core::source::RawMesh| {
        format!(
            "mesh \"{}\": the coarser levels of the file are replaced",
            m.name
        )
    };
    let mut warnings: Vec<String> = meshes.iter().filter(replaced).map(warning).collect();
    warnings.extend(left_out(&levels, wanted.targets.len()));
    if wanted.max_error.is_none() {
        warnings.extend(coarse(&levels));
    }
    Ok(CodedMeshLevels {
        warnings,
        levels,
        stream,
        face: kept,
    })
}

/// Names of the zones that may have independent levels.
fn region_names(wanted: &MeshLevelOptions) -> Vec<String> {
    if wanted.split.is_empty() {
        return Vec::new();
    }
    let names = wanted.split.iter().map(|(name, _)| name.clone());
    names.chain(["rest".to_owned()]).collect()
}

/// Describes the levels that are not made.
fn left_out(made: &MeshLevels, wanted: usize) -> Vec<String> {
    let count = made.table.levels.len();
    let text = |level: &LeftOutLevel| {
        let why = match level.reason {
            LeftOutReason::Empty => "it has no triangles".to_owned(),
            LeftOutReason::Equal => "it equals the next finer level".to_owned(),
            LeftOutReason::TooCoarse(share) => format!(
                "its error in motion is {:.1} % of the size of the figure, at most {:.0} % is allowed",
                100.0 * share,
                100.0 * options::MAX_ERROR
            ),
        };
        let instead = level.instead.map_or_else(String::new, |triangles| {
            format!("; one of {triangles} triangles is made instead")
        });
        format!(
            "{count} of {wanted} mesh levels are made: the level of {} triangles ({} %) is left out, since {why}{instead}",
            level.triangles,
            (1e4 * level.target).round() / 100.0
        )
    };
    made.left_out.iter().map(text).collect()
}

/// Describes the levels that are made as wanted, though their errors are large.
fn coarse(made: &MeshLevels) -> Vec<String> {
    let levels = 0..made.table.levels.len();
    let coarse = levels.filter(|l| made.error_share(*l) > options::MAX_ERROR);
    let text = |l| {
        format!(
            "mesh level {l}: its error in motion is {:.1} % of the size of the figure; parts may come apart",
            100.0 * made.error_share(l)
        )
    };
    coarse.map(text).collect()
}

/// Radius of a mesh at rest: half the diagonal of its bounding box.
fn radius_metres<'a>(vertices: impl Iterator<Item = &'a Vec3>) -> f32 {
    let corners = vertices.filter(|p| p.is_finite()).map(|p| (*p, *p));
    let corners = corners.reduce(|(low, high), (p, _)| (low.min(p), high.max(p)));
    corners.map_or(1.0, |(low, high)| 0.5 * low.distance(high))
}

/// Order of the vertices and triangles of a figure, once its document has the given levels.
pub(crate) fn source_orders(figure: &Figure, made: &MeshLevels) -> Vec<SourceOrder> {
    let mesh = &figure.asset.mesh;
    let parts = mesh.parts.iter().zip(&made.objects);
    let order = |(part, object): (&Part, &Clustered)| {
        let first = part.vertices.start as u32;
        let triangles = mesh.triangles[part.triangles.clone()].iter();
        SourceOrder {
            vertices: object.vertices.clone(),
            triangles: triangles.map(|t| t.map(|v| v - first)).collect(),
        }
    };
    parts.map(order).collect()
}

/// Writes the levels into a document.
fn store(
    (document, orders): (&mut Document, Option<&[SourceOrder]>),
    figure: &Figure,
    made: &MeshLevels,
    node_of_mesh: &[usize],
) -> Result<()> {
    // Vertices of the document in the order of each object.
    let mut places = Vec::with_capacity(made.objects.len());
    for (part, object) in made.objects.iter().enumerate() {
        places.push(match orders.and_then(|orders| orders.get(part)) {
            None => object.vertices.clone(),
            Some(order) => {
                let place = order.places(object.vertices.len())?;
                object.vertices.iter().map(|v| place[*v as usize]).collect()
            }
        });
    }
    let object = |part: usize| PartLevels {
        vertices: &places[part],
        triangles: &made.objects[part].triangles,
        clusters: &made.objects[part].clusters,
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
