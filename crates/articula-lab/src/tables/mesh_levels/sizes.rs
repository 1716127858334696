//! Bytes of levels: Articula and other codecs on the same meshes.

use super::characters::Subject;
use super::progressive::{PartLevel, Progressive};
use crate::peers::{draco, meshopt};
use crate::wire_mesh::{PRECISION, WireMesh};
use anyhow::{Context, Result, ensure};
use articula_build::LevelTriangles;
use articula_build::{ClusterOrder, cluster};
use articula_core::source::Primitive;
use articula_report::thread_ns;
use articula_stream::StreamLimits;
use articula_stream::mesh::{Grid, Quantised, QuantisedMesh, decode_level, encode_level, quantise};

/// Bytes of all parts of a character at one level.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    pub(super) triangles: usize,
    /// Number of vertices on a GPU.
    pub(super) vertices: usize,
    /// Number of positions: a split of a progressive mesh adds one.
    pub(super) points: usize,
    /// Articula, the level alone.
    pub(super) direct: usize,
    /// Articula, the addition of the level to the next coarser one; the coarsest alone.
    pub(super) chunk: usize,
    /// Draco; `None` without node.
    pub(super) draco: Option<usize>,
    pub(super) meshopt: usize,
    /// Vertices and indices uncoded in a buffer.
    pub(super) plain: usize,
    /// Number of ranges that show the level in the written form, for the part with most: one of
    /// vertices and those of triangles.
    pub(super) ranges: usize,
}

/// Bytes of a character.
#[derive(Debug, Clone, Default)]
pub(super) struct Sizes {
    /// Coarsest first.
    pub(super) levels: Vec<Level>,
    /// All levels in the written form, uncoded in a buffer.
    pub(super) store: usize,
    pub(super) progressive: Progressive,
    /// Articula with morph targets: all chunks, and the finest level alone. `None` without any.
    pub(super) with_morphs: Option<(usize, usize)>,
    /// Draco's finest level by kind of value: position, normal, ...
    pub(super) draco_kinds: Vec<(&'static str, usize)>,
    /// Minimum processor time for all chunks, without morph targets.
    pub(super) seconds: Seconds,
}

/// Seconds of one thread.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seconds {
    /// Rounding to whole numbers.
    pub(super) rounding: f64,
    pub(super) encoding: f64,
    pub(super) decoding: f64,
}

impl Sizes {
    /// Bytes of all chunks.
    pub(super) fn whole(&self) -> usize {
        self.levels.iter().map(|l| l.chunk).sum()
    }
}

/// A part of a character with its levels, quantised.
struct Object {
    levels: Vec<Vec<[u32; 3]>>,
    vertices: usize,
    /// Without morph targets, which no other codec supports.
    bare: Quantised,
    /// With morph targets, if there are any.
    full: Option<Quantised>,
}

/// Measures the levels of a character.
pub(super) fn sizes(subject: &Subject, levels: &[LevelTriangles], rounds: usize) -> Result<Sizes> {
    let start = thread_ns();
    let objects = objects(subject, levels)?;
    let mut sizes = Sizes {
        levels: vec![Level::default(); levels.len()],
        ..Sizes::default()
    };
    sizes.seconds.rounding = 1e-9 * (thread_ns() - start) as f64;
    add_ours(&objects, rounds, &mut sizes)?;
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
            let full = if primitive.morphs.is_empty() {
                None
            } else {
                Some(in_order(primitive, &levels, &grid)?)
            };
            objects.push(Object {
                full,
                bare: in_order(&bare, &levels, &grid)?,
                vertices: part.vertices.len(),
                levels,
            });
        }
    }
    Ok(objects)
}

/// The levels of a part, quantised, in coding order.
fn in_order(part: &Primitive, levels: &[Vec<[u32; 3]>], grid: &Grid) -> Result<Quantised> {
    let finest_first: Vec<_> = levels.iter().rev().cloned().collect();
    let mut coded = quantise(part, &finest_first, grid, &PRECISION)?;
    coded.levels.reverse();
    Ok(coded)
}

/// Adds the bytes of Articula's codec, and its time.
fn add_ours(objects: &[Object], rounds: usize, sizes: &mut Sizes) -> Result<()> {
    for object in objects {
        let chunks = chunks(&object.bare)?;
        for (l, chunk) in chunks.iter().enumerate() {
            sizes.levels[l].chunk += chunk.len();
        }
        let full = object.full.as_ref().unwrap_or(&object.bare);
        let finest = full.levels.last().context("no level")?;
        let finest = encode_level(None, finest, &full.layout)?.len();
        let whole = match &object.full {
            Some(full) => self::chunks(full)?.iter().map(Vec::len).sum(),
            None => chunks.iter().map(Vec::len).sum::<usize>(),
        };
        let sum = sizes.with_morphs.get_or_insert((0, 0));
        *sum = (sum.0 + whole, sum.1 + finest);
    }
    if objects.iter().all(|o| o.full.is_none()) {
        sizes.with_morphs = None;
    }
    let mut least = [f64::INFINITY; 2];
    for _ in 0..rounds {
        let taken = race(objects)?;
        least = [least[0].min(taken[0]), least[1].min(taken[1])];
    }
    [sizes.seconds.encoding, sizes.seconds.decoding] = least;
    Ok(())
}

/// The coarsest level, then the addition of each level.
fn chunks(part: &Quantised) -> Result<Vec<Vec<u8>>> {
    let layout = &part.layout;
    let mut chunks = Vec::new();
    for (l, fine) in part.levels.iter().enumerate() {
        chunks.push(match l.checked_sub(1) {
            Some(coarse) => encode_level(Some(&part.levels[coarse]), fine, layout)?,
            None => encode_level(None, fine, layout)?,
        });
    }
    Ok(chunks)
}

/// Seconds for coding and decoding all chunks; the decoded mesh must have the same size.
fn race(objects: &[Object]) -> Result<[f64; 2]> {
    let start = thread_ns();
    let coded: Result<Vec<_>> = objects.iter().map(|o| chunks(&o.bare)).collect();
    let coded = coded?;
    let middle = thread_ns();
    let mut back = Vec::new();
    for (object, chunks) in objects.iter().zip(&coded) {
        let layout = &object.bare.layout;
        let mut level: Option<QuantisedMesh> = None;
        for chunk in chunks {
            level = Some(match level {
                Some(coarse) => {
                    decode_level(Some(&coarse), chunk, layout, &StreamLimits::default())?
                }
                None => decode_level(None, chunk, layout, &StreamLimits::default())?,
            });
        }
        back.push(level.context("no level")?);
    }
    let end = thread_ns();
    for (object, mesh) in objects.iter().zip(&back) {
        let finest = object.bare.levels.last().context("no level")?;
        let same = (mesh.faces.len(), mesh.wedge_points.len())
            == (finest.faces.len(), finest.wedge_points.len());
        ensure!(same, "another mesh comes back");
    }
    Ok([middle - start, end - middle].map(|ns| 1e-9 * ns as f64))
}

/// Adds the bytes of the other codecs but Draco, which takes all meshes at once.
fn add_object(object: &Object, wire: &[WireMesh], sizes: &mut Sizes) -> Result<()> {
    let layout = &object.bare.layout;
    let mut own = Vec::with_capacity(wire.len());
    for (mesh, coded) in wire.iter().zip(&object.bare.levels) {
        own.push(PartLevel {
            points: coded.positions.len(),
            vertices: mesh.vertices(),
            plain: plain(mesh, mesh.vertices(), mesh.triangles.len()),
            direct: encode_level(None, coded, layout)?.len(),
        });
    }
    for ((mesh, own), level) in wire.iter().zip(&own).zip(&mut sizes.levels) {
        level.triangles += mesh.triangles.len();
        level.vertices += own.vertices;
        level.points += own.points;
        level.direct += own.direct;
        level.meshopt += meshopt::coded_bytes(mesh)?;
        level.plain += own.plain;
    }
    let finest_first: Vec<_> = object.levels.iter().rev().collect();
    let stored = cluster(&finest_first, object.vertices, &[], ClusterOrder::Store)?;
    for (l, level) in sizes.levels.iter_mut().rev().enumerate() {
        let ranges = stored.clusters.ranges(l).count();
        level.ranges = level.ranges.max(ranges + usize::from(ranges > 0));
    }
    if let Some(finest) = wire.last() {
        sizes.store += plain(finest, finest.vertices(), stored.triangles.len());
        if finest.vertices() > 0 {
            let vertex_bytes = meshopt::record(finest, 0).len();
            sizes.progressive.add(&own, vertex_bytes);
        }
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

/// Adds the bytes of each kind of value, as differences to the kinds before it.
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
