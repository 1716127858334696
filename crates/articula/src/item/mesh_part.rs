//! The meshes of an item: mesh levels by region as one stream, with the errors of what a client
//! decodes.

use super::decoded_mesh::{DecodedMeshes, decoded};
use super::files::NewFiles;
use super::motion_part::keep;
use super::options::PackageOptions;
use super::part::{ItemLayer, ItemPart, MeshLevelEntry, PartKind, RegionEntry};
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::mesh_levels::{CodedMeshLevels, coded};
use crate::work::Executor;
use articula_build::{
    Asset, DistanceOptions, LevelDistances, MeasurementPoses, MeshLevelOptions, PoseOptions,
    measure_mesh,
};
use articula_core::source::RawMesh;
use articula_core::{Mesh, Mismatch};
use articula_stream::mesh::{MeshStream, Receiver};
use articula_stream::{Cut, StreamLimits, Unit, cut};
use std::collections::BTreeSet;

/// Name of the stream.
const FILE: &str = "mesh.ams";
/// Most poses that errors are measured on.
const MEASURED_POSES: usize = 96;
/// Of how many of them one counts for means and percentiles.
const FULL_EVERY: usize = 4;
/// Most poses that those of the base are measured on.
const MEASURED_POSES_OF_BASE: usize = 24;

/// Triangles that are measured, and where the result belongs.
struct Triangles {
    of: CutOf,
    triangles: Vec<[u32; 3]>,
}

/// What a cut shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CutOf {
    /// Everything at one level.
    Level(usize),
    /// A region at a level, the others at another one.
    Region {
        region: u32,
        level: usize,
        others: usize,
    },
}

impl CutOf {
    /// The finest level that is shown.
    fn finest(self) -> usize {
        match self {
            Self::Level(level) => level,
            Self::Region { level, others, .. } => level.min(others),
        }
    }
}

/// The cuts whose errors are measured: all levels, and each region at each of its own levels beside
/// others at the finest and at the coarsest of these.
fn wanted(count: usize, base: usize, regions: &BTreeSet<u32>) -> Vec<CutOf> {
    let mut wanted: Vec<CutOf> = (0..count).map(CutOf::Level).collect();
    for region in regions {
        for level in 0..base {
            let mix = |others| CutOf::Region {
                region: *region,
                level,
                others,
            };
            wanted.extend([mix(0), mix(base)]);
        }
    }
    wanted
}

/// Cuts with their errors.
struct Measured {
    cuts: Vec<Triangles>,
    distances: Vec<LevelDistances>,
}

impl Measured {
    fn found(&self, of: CutOf) -> Option<(&Triangles, &LevelDistances)> {
        let found = self.cuts.iter().position(|cut| cut.of == of);
        found.map(|i| (&self.cuts[i], &self.distances[i]))
    }

    /// The layer that makes a cut of what it needs; `None` if the cut was not measured.
    fn layer(&self, of: CutOf, name: String, markers: &[(&str, u32)]) -> Option<ItemLayer> {
        let (cut, distances) = self.found(of)?;
        Some(ItemLayer {
            name,
            keep: keep(markers),
            error_m: greatest(distances),
            error_mean_m: Some(f64::from(distances.motion.mean_metres)),
            triangles: Some(cut.triangles.len() as u64),
            vertices: Some(vertices(&cut.triangles)),
            ..ItemLayer::default()
        })
    }

    /// The layers: levels of all regions at once, coarsest first, then those of each region.
    fn layers(
        &self,
        count: usize,
        base: usize,
        regions: &BTreeSet<u32>,
        names: &[String],
    ) -> Vec<ItemLayer> {
        let mut layers = Vec::new();
        for (i, level) in (base..count).rev().enumerate() {
            let name = format!("level {level}");
            let layer = self.layer(CutOf::Level(level), name, &[("level", level as u32)]);
            layers.extend(layer.map(|layer| ItemLayer {
                needs: i.checked_sub(1).into_iter().collect(),
                ..layer
            }));
        }
        let combined = count - base;
        for (r, region) in regions.iter().enumerate() {
            for (step, level) in (0..base).rev().enumerate() {
                let below = match step {
                    0 => combined - 1,
                    _ => combined + r * base + step - 1,
                };
                let of = |others| CutOf::Region {
                    region: *region,
                    level,
                    others,
                };
                let alone = self.found(of(0)).map(|(_, distances)| greatest(distances));
                let name = format!("level {level}, {}", region_name(names, *region));
                let markers = [("level", level as u32), ("region", *region)];
                let layer = self.layer(of(base), name, &markers);
                layers.extend(layer.map(|layer| ItemLayer {
                    needs: vec![below],
                    error_alone_m: alone,
                    ..layer
                }));
            }
        }
        layers
    }
}

/// Adds the stream of a character's mesh levels, and measures its layers.
pub(super) fn part(
    figure: &Figure,
    clips: &[usize],
    made: &CodedMeshLevels,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<ItemPart> {
    let bytes = made.stream.bytes.clone();
    let unit = MeshStream::open(&bytes, &StreamLimits::default())?.unit();
    let whole = Stage {
        stream: Cut { bytes, unit },
        finest: 0,
        poses: MEASURED_POSES,
        full_every: FULL_EVERY,
    };
    measured_part(figure, clips, (made, whole), files, work)
}

/// Adds the coarsest level alone, and measures it.
pub(super) fn base(
    figure: &Figure,
    clips: &[usize],
    made: &CodedMeshLevels,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<ItemPart> {
    let bytes = &made.stream.bytes;
    let unit = MeshStream::open(bytes, &StreamLimits::default())?.unit();
    let coarsest = made.levels.table.levels.len().saturating_sub(1);
    let is_kept = |unit: &Unit| unit.marker("level").is_none_or(|l| l as usize >= coarsest);
    let base = Stage {
        stream: cut(bytes, &unit, is_kept).context(FILE)?,
        finest: coarsest,
        poses: MEASURED_POSES_OF_BASE,
        full_every: usize::MAX,
    };
    measured_part(figure, clips, (made, base), files, work)
}

/// A stream, or a cut of it.
struct Stage {
    stream: Cut,
    /// Its finest level.
    finest: usize,
    /// Most poses that it is measured on, and of how many of them one counts for means and percentiles.
    poses: usize,
    full_every: usize,
}

/// Adds the stream of a stage, and measures its layers in frames of these clips.
fn measured_part(
    figure: &Figure,
    clips: &[usize],
    (made, stage): (&CodedMeshLevels, Stage),
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<ItemPart> {
    const WHAT: &str = "measuring meshes";
    let limits = StreamLimits::default();
    let Cut { bytes, unit } = stage.stream;
    let shown = Shown::new(figure, &bytes, &limits).context(FILE)?;
    let table = &made.levels.table;
    let count = table.levels.len();
    let regions: BTreeSet<u32> = shown.decoded.objects.iter().map(|o| o.region).collect();
    // Coarser levels than this one are shown by all regions at once.
    let base = if regions.len() > 1 {
        table.mixable_to.min(count - 1)
    } else {
        0
    };
    let wanted = wanted(count, base, &regions).into_iter();
    let wanted = wanted.filter(|of| of.finest() >= stage.finest);
    let cuts: Vec<Triangles> = wanted.map(|of| shown.cut(of)).collect();
    work.step(WHAT, 0, 1)?;
    let (distances, poses) =
        shown.measured(figure, clips, &cuts, (stage.poses, stage.full_every))?;
    work.step(WHAT, 1, 1)?;
    let measured = Measured { cuts, distances };
    let layers = measured.layers(count, base, &regions, &table.regions);
    let mut part = ItemPart {
        frames_measured: Some((poses.clips + poses.bends + poses.morphs) as u64),
        layers,
        regions: regions
            .iter()
            .map(|number| RegionEntry {
                number: *number,
                name: region_name(&table.regions, *number),
                bytes_without: None,
                error_without_m: None,
            })
            .collect(),
        ..ItemPart::new("mesh", PartKind::Mesh)
    };
    part.put_stream(FILE, bytes, &unit, files)?;
    let levels = (0..count).filter_map(|level| {
        let (cut, distances) = measured.found(CutOf::Level(level))?;
        Some(MeshLevelEntry {
            level: level as u32,
            triangles: cut.triangles.len() as u64,
            vertices: vertices(&cut.triangles),
            bytes: bytes_to(&unit, level).saturating_add(part.base_bytes),
            error_rest_m: f64::from(distances.rest.max_metres),
            error_motion_m: f64::from(distances.motion.max_metres),
            error_motion_p95_m: f64::from(distances.motion.p95_metres),
        })
    });
    part.levels = levels.collect();
    Ok(part)
}

/// Options of the levels, and the levels of a character of an item.
pub(super) fn coded(
    figure: &Figure,
    (gltf, orders): (
        &crate::open::GltfSource,
        Option<&[articula_formats::prepared::SourceOrder]>,
    ),
    face: Option<&crate::face::FoundFace>,
    options: &PackageOptions,
    work: &Executor<'_>,
) -> Result<CodedMeshLevels> {
    coded::coded(figure, (gltf, orders), face, &options.of_mesh(), work)
}

/// Name of a region by its number.
fn region_name(names: &[String], number: u32) -> String {
    names
        .get(number as usize)
        .cloned()
        .unwrap_or_else(|| "all".to_owned())
}

/// The greatest error of a cut, at rest or in motion.
fn greatest(distances: &LevelDistances) -> f64 {
    f64::from(distances.rest.max_metres.max(distances.motion.max_metres))
}

/// Number of vertices in use.
fn vertices(triangles: &[[u32; 3]]) -> u64 {
    triangles.iter().flatten().collect::<BTreeSet<_>>().len() as u64
}

/// Bytes of the chunks from the coarsest level to this one.
fn bytes_to(unit: &Unit, level: usize) -> u64 {
    let mut sum = 0;
    unit.visit(&mut |unit| {
        let is_chunk = unit.marker("object").is_some();
        let is_kept = unit.marker("level").is_some_and(|l| l as usize >= level);
        sum += if is_chunk && is_kept { unit.bytes() } else { 0 };
    });
    sum
}

/// The decoded meshes in the form that is skinned.
struct Shown {
    decoded: DecodedMeshes,
    mesh: Mesh,
}

impl Shown {
    fn new(figure: &Figure, bytes: &[u8], limits: &StreamLimits) -> Result<Self> {
        let source = &figure.opened.character().meshes;
        let decoded = decoded(&Receiver::read(bytes, limits)?, source, limits)?;
        let mut meshes: Vec<RawMesh> = Vec::with_capacity(source.len());
        for (m, mesh) in source.iter().enumerate() {
            let primitive = |p: usize| {
                let decoded = decoded.primitives.get(&(m, p));
                decoded
                    .cloned()
                    .unwrap_or_else(|| articula_formats::gltf::placeholder(&mesh.primitives[p]))
            };
            meshes.push(RawMesh {
                primitives: (0..mesh.primitives.len()).map(primitive).collect(),
                levels: Vec::new(),
                clustered: Vec::new(),
                ..mesh.clone()
            });
        }
        let mesh = Mesh::new(&meshes, figure.asset.rig.len())?;
        Ok(Self { decoded, mesh })
    }

    /// The triangles of a cut over all vertices.
    fn cut(&self, of: CutOf) -> Triangles {
        let level_of = |own: u32| match of {
            CutOf::Level(level) => level,
            CutOf::Region {
                region,
                level,
                others,
            } => {
                if own == region {
                    level
                } else {
                    others
                }
            }
        };
        let mut firsts = Vec::new();
        for part in &self.mesh.parts {
            firsts.push((part.mesh, part.vertices.start as u32));
        }
        let mut triangles = Vec::new();
        for object in &self.decoded.objects {
            let mut of_mesh = firsts.iter().filter(|(mesh, _)| *mesh == object.mesh);
            let Some((_, first)) = of_mesh.nth(object.primitive) else {
                continue;
            };
            let own = object.at_level(level_of(object.region));
            triangles.extend(own.map(|t| t.map(|v| v + first)));
        }
        Triangles { of, triangles }
    }

    /// Measures cuts in frames of the packaged clips, since no others are shown.
    fn measured(
        &self,
        figure: &Figure,
        clips: &[usize],
        cuts: &[Triangles],
        (most_poses, full_every): (usize, usize),
    ) -> Result<(Vec<LevelDistances>, MeasurementPoses), Mismatch> {
        let triangles: Vec<&[[u32; 3]]> = cuts.iter().map(|c| c.triangles.as_slice()).collect();
        let of_figure = &figure.asset.clips;
        let packaged = Asset {
            clips: clips.iter().map(|clip| of_figure[*clip].clone()).collect(),
            ..figure.asset.clone()
        };
        let poses = PoseOptions {
            // Frames that shaped the levels are shown too.
            shaping: 0,
            morphs: 0,
            measuring: most_poses,
            ..PoseOptions::default()
        };
        let opts = MeshLevelOptions {
            poses,
            distance: DistanceOptions {
                full_every,
                ..DistanceOptions::default()
            },
            ..MeshLevelOptions::default()
        };
        measure_mesh(&packaged, &self.mesh, &triangles, &opts)
    }
}
