//! What levels take: ours and what others make of the same meshes.

use super::characters::Subject;
use crate::peers::{draco, meshopt};
use crate::wire_mesh::{PRECISION, WireMesh};
use anyhow::{Context, Result};
use articula_build::clusters::{Order, cluster};
use articula_build::simplify::LevelTriangles;
use articula_core::source::Primitive;
use articula_formats::mesh_codec::{Grid, Quantised, quantise};

/// Bytes of all parts of a character at one level.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    pub(super) triangles: usize,
    /// Vertices as a GPU has them.
    pub(super) vertices: usize,
    /// Draco; `None` without node.
    pub(super) draco: Option<usize>,
    pub(super) meshopt: usize,
    /// Vertices and indices as they lie in a buffer.
    pub(super) plain: usize,
    /// Ranges that show the level: one of vertices and those of triangles, of the part that has
    /// most, in the written form.
    pub(super) ranges: usize,
}

/// Bytes of a character.
#[derive(Debug, Clone, Default)]
pub(super) struct Sizes {
    /// Coarsest first.
    pub(super) levels: Vec<Level>,
    /// All levels in the written form, as they lie in a buffer.
    pub(super) store: usize,
    /// Draco's finest level by kind: position, normal, ...
    pub(super) draco_kinds: Vec<(&'static str, usize)>,
}

/// A part of a character with its levels, and the same in whole numbers.
struct Object {
    levels: Vec<Vec<[u32; 3]>>,
    vertices: usize,
    /// Without morph targets, which no other codec has.
    bare: Quantised,
}

/// Measures the levels of a character.
pub(super) fn sizes(subject: &Subject, levels: &[LevelTriangles]) -> Result<Sizes> {
    let objects = objects(subject, levels)?;
    let mut sizes = Sizes {
        levels: vec![Level::default(); levels.len()],
        ..Sizes::default()
    };
    let mut meshes = Vec::new();
    for object in &objects {
        let wire = (0..levels.len()).map(|l| WireMesh::new(&object.bare, l));
        let wire = wire.collect::<Result<Vec<_>>>()?;
        add_object(object, &wire, &mut sizes)?;
        meshes.push(wire);
    }
    add_draco(&meshes, &mut sizes)?;
    Ok(sizes)
}

fn objects(subject: &Subject, levels: &[LevelTriangles]) -> Result<Vec<Object>> {
    let mut parts = subject.asset.mesh.parts.iter().enumerate();
    let mut objects = Vec::new();
    for mesh in &subject.source.meshes {
        let grid = Grid::new(&mesh.primitives, PRECISION.position_bits)?;
        for primitive in &mesh.primitives {
            let (p, part) = parts.next().context("a part of the mesh is missing")?;
            let first = part.vertices.start as u32;
            let of = |l: &LevelTriangles| {
                let triangles = &l.triangles[l.parts[p].clone()];
                triangles.iter().map(|t| t.map(|v| v - first)).collect()
            };
            let levels: Vec<Vec<[u32; 3]>> = levels.iter().map(of).collect();
            let bare = Primitive {
                morphs: Vec::new(),
                ..primitive.clone()
            };
            objects.push(Object {
                bare: quantise(&bare, &levels, &grid, &PRECISION)?,
                vertices: part.vertices.len(),
                levels,
            });
        }
    }
    Ok(objects)
}

/// Everything but Draco, which takes all meshes at once.
fn add_object(object: &Object, wire: &[WireMesh], sizes: &mut Sizes) -> Result<()> {
    for (mesh, level) in wire.iter().zip(&mut sizes.levels) {
        level.triangles += mesh.triangles.len();
        level.vertices += mesh.vertices();
        level.meshopt += meshopt::coded_bytes(mesh)?;
        level.plain += plain(mesh, mesh.vertices(), mesh.triangles.len());
    }
    let stored = cluster(&object.levels, object.vertices, &[], Order::Store)?;
    for (l, level) in sizes.levels.iter_mut().enumerate() {
        let ranges = stored.clusters.ranges(l).count();
        level.ranges = level.ranges.max(ranges + usize::from(ranges > 0));
    }
    if let Some(finest) = wire.last() {
        sizes.store += plain(finest, finest.vertices(), stored.triangles.len());
    }
    Ok(())
}

/// Bytes of vertices like those of a mesh, and of triangles.
fn plain(like: &WireMesh, vertices: usize, triangles: usize) -> usize {
    if triangles == 0 {
        return 0;
    }
    let index = if vertices <= 1 << 16 { 2 } else { 4 };
    vertices * meshopt::record(like, 0).len() + 3 * triangles * index
}

fn add_draco(meshes: &[Vec<WireMesh>], sizes: &mut Sizes) -> Result<()> {
    let finest = sizes.levels.len() - 1;
    let all = || meshes.iter().flat_map(|object| object.iter().enumerate());
    let filled = || all().filter(|(_, mesh)| !mesh.triangles.is_empty());
    let tasks: Vec<draco::Task<'_>> = filled()
        .map(|(l, mesh)| draco::Task {
            mesh,
            steps: l == finest,
        })
        .collect();
    let Some(coded) = draco::code(&tasks)? else {
        return Ok(());
    };
    for ((l, mesh), found) in filled().zip(&coded) {
        *sizes.levels[l].draco.get_or_insert(0) += found.bytes;
        if l == finest {
            add_kinds(mesh, found, &mut sizes.draco_kinds);
        }
    }
    Ok(())
}

/// The bytes of each kind, as more than those before it take.
fn add_kinds(mesh: &WireMesh, found: &draco::Coded, kinds: &mut Vec<(&'static str, usize)>) {
    let mut add =
        |kind: &'static str, bytes: usize| match kinds.iter_mut().find(|(k, _)| *k == kind) {
            Some((_, sum)) => *sum += bytes,
            None => kinds.push((kind, bytes)),
        };
    add("connectivity", found.connectivity);
    let mut before = found.connectivity;
    for (kind, &bytes) in draco::kinds(mesh).into_iter().zip(&found.steps) {
        add(kind, bytes.saturating_sub(before));
        before = bytes;
    }
}
