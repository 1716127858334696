//! Mesh levels of an asset: what is asked for, what is made, how it is stored.

mod arguments;
pub(crate) mod report;
mod transport;

pub(crate) use arguments::MeshLevelArgs;

use crate::console::Console;
use crate::load::Behind;
use crate::prepared::Prepared;
use anyhow::Context;
use articula_build::SkinPose;
use articula_build::{MeshLevels, mesh_levels};
use articula_flat::Bounds;
use articula_formats::gltf::Document;
use articula_formats::gltf::{LevelNodes, MeshParts, PartLevels};
use glam::Vec3;
use transport::Transport;

/// The levels of a character, and the same coded for the wire.
#[derive(Debug)]
pub(crate) struct Levels {
    pub(crate) made: MeshLevels,
    pub(crate) transport: Transport,
    /// What was lost on the way.
    pub(crate) warnings: Vec<String>,
}

/// Makes the levels of a character that was read, and puts them into its document.
pub(crate) fn add(
    prepared: &Prepared,
    document: &mut Document,
    args: &MeshLevelArgs,
    targets: Vec<f64>,
    console: &Console,
) -> anyhow::Result<Levels> {
    let behind = prepared.loaded.behind.as_ref();
    let behind = behind.context("the character has no document")?;
    let asset = &prepared.asset;
    if asset.mesh.triangles.is_empty() {
        anyhow::bail!("no mesh with triangles to make levels of; leave --levels out");
    }
    let classes = vertex_classes(prepared, behind)?;
    let options = args.options(targets, (&asset.mesh, &asset.rig), classes)?;
    let bar = console.progress("making mesh levels", 3);
    let mut made = mesh_levels(asset, &options)?;
    made.table.regions = args.region_names();
    bar.inc(1);
    let transport = transport::coded(prepared, &made, &options.simplify.regions)?;
    bar.inc(1);
    store(document, prepared, &made, &behind.node_of_mesh)?;
    if args.msft_lod {
        let rest = SkinPose::rest(asset).positions(asset);
        for (parts, node) in parts_of_meshes(prepared)
            .into_iter()
            .zip(&behind.node_of_mesh)
        {
            let parts = &asset.mesh.parts[parts];
            let vertices = parts.iter().flat_map(|p| &rest[p.vertices.clone()]);
            let nodes = LevelNodes::new(radius_metres(vertices));
            document.add_level_nodes(*node, &made.table, &nodes)?;
        }
    }
    bar.finish_and_clear();
    let meshes = &prepared.loaded.character.meshes;
    let replaced =
        |m: &&articula_core::source::Mesh| !m.levels.is_empty() && m.clustered.is_empty();
    let warning = |m: &articula_core::source::Mesh| {
        format!(
            "mesh \"{}\": the coarser levels of the file are replaced",
            m.name
        )
    };
    Ok(Levels {
        warnings: meshes.iter().filter(replaced).map(warning).collect(),
        made,
        transport,
    })
}

/// Radius of the ball around a mesh at rest.
fn radius_metres<'a>(vertices: impl Iterator<Item = &'a Vec3>) -> f32 {
    let bounds = Bounds::around(vertices.filter(|p| p.is_finite()).map(|p| (*p, *p)));
    bounds.map_or(1.0, |b| 0.5 * b.low.distance(b.high))
}

/// For each vertex of the character's mesh the first that is like it in all that the document
/// has; vertices of different parts are never alike.
fn vertex_classes(prepared: &Prepared, behind: &Behind) -> anyhow::Result<Vec<u32>> {
    let mut classes = Vec::with_capacity(prepared.asset.mesh.len());
    for (m, parts) in parts_of_meshes(prepared).into_iter().enumerate() {
        for (p, part) in parts.enumerate() {
            let first = prepared.asset.mesh.parts[part].vertices.start as u32;
            let of_part = behind.document.vertex_classes(behind.node_of_mesh[m], p)?;
            classes.extend(of_part.iter().map(|class| first + class));
        }
    }
    Ok(classes)
}

/// Writes the levels into a document.
fn store(
    document: &mut Document,
    prepared: &Prepared,
    made: &MeshLevels,
    node_of_mesh: &[usize],
) -> anyhow::Result<()> {
    let object = |part: usize| {
        let object = &made.objects[part];
        PartLevels {
            vertices: &object.vertices,
            triangles: &object.triangles,
            clusters: &object.clusters,
        }
    };
    let meshes: Vec<MeshParts<'_>> = parts_of_meshes(prepared)
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

/// Parts of the character's mesh that each source mesh has.
fn parts_of_meshes(prepared: &Prepared) -> Vec<std::ops::Range<usize>> {
    let mut first = 0;
    let meshes = prepared.loaded.character.meshes.iter();
    let range = |mesh: &articula_core::source::Mesh| {
        let range = first..first + mesh.primitives.len();
        first = range.end;
        range
    };
    meshes.map(range).collect()
}
