//! Mesh levels of an asset: options, computation and storage.

mod face;
mod options;
mod show;
mod stream;

pub use face::KeptFace;
pub use options::MeshLevelOptions;
pub(crate) use show::show;
pub use show::{
    LevelChoice, MeshView, ShownInView, ShownLevelOptions, ShownLevels, ShownLevelsReport,
    ShownRegion,
};
pub use stream::MeshLevelStream;

use crate::error::{Context, Error, Result};
use crate::face::FoundFace;
use crate::figure::Figure;
use crate::open::GltfSource;
use crate::work::Executor;
use articula_build::{
    Asset, Clustered, LeftOutLevel, LeftOutReason, LevelTriangles, MeshLevels,
    mesh_level_triangles, mesh_levels,
};
use articula_core::{Part, PosedMesh};
use articula_flat::Bounds;
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
    levels.table.regions = wanted.region_names();
    work.step(BUILDING, 1, 3)?;
    let stream = stream::coded(figure, &levels, &options.simplify.regions)?;
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
        format!(
            "{count} of {wanted} mesh levels are made: the level of {} triangles ({} %) is left out, since {why}",
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

/// Triangles of the levels that [`add`] makes with default options, over the vertices of the
/// figure's mesh.
pub(crate) fn triangles(figure: &Figure, levels: usize) -> Result<Vec<Vec<[u32; 3]>>> {
    let classes = match figure.opened.gltf() {
        Some(gltf) => vertex_classes(figure, gltf, figure.orders())?,
        None => Vec::new(),
    };
    let face = FoundFace::of(figure, &[]).ok();
    let face = face.and_then(|face| KeptFace::of(figure, &face));
    made(&figure.asset, levels, classes, face.as_ref())
}

/// The same for an asset without a file; its face is not known.
pub(crate) fn triangles_of(asset: &Asset, levels: usize) -> Result<Vec<Vec<[u32; 3]>>> {
    made(asset, levels, Vec::new(), None)
}

/// Triangles of levels of a mesh whose vertices have the given classes.
fn made(
    asset: &Asset,
    levels: usize,
    classes: Vec<u32>,
    face: Option<&KeptFace>,
) -> Result<Vec<Vec<[u32; 3]>>> {
    let options = MeshLevelOptions::levels(levels).of(&asset.mesh, &asset.rig, classes, face)?;
    let made = mesh_level_triangles(asset, &options).context("mesh levels")?;
    let triangles = |level: LevelTriangles| level.triangles;
    Ok(made.into_iter().map(triangles).collect())
}

/// Radius of a mesh at rest: half the diagonal of its bounding box.
fn radius_metres<'a>(vertices: impl Iterator<Item = &'a Vec3>) -> f32 {
    let bounds = Bounds::around(vertices.filter(|p| p.is_finite()).map(|p| (*p, *p)));
    bounds.map_or(1.0, |b| 0.5 * b.low.distance(b.high))
}

/// Returns for each vertex of the character's mesh the first vertex with equal attributes in the
/// document; vertices of different parts are never equal.
fn vertex_classes(
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

/// Range of parts of the character's mesh for each source mesh.
fn parts_of_meshes(figure: &Figure) -> Vec<std::ops::Range<usize>> {
    parts_of_meshes_of(&figure.opened.character().meshes)
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
