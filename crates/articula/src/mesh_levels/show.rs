//! The meshes of a file with levels, with each region of the body at one of them.

use super::parts_of_meshes_of;
use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use crate::work::Executor;
use articula_build::{
    Asset, ClipOptions, MeasurementPoses, MeshLevelOptions, RegionMix, character, measure_levels,
};
use articula_core::source::RawMesh;
use articula_core::{ClusteredTriangles, LevelTable, Viewport, lod_error_metres};
use articula_formats::gltf::{MeshParts, PartLevels};
use serde::Serialize;

/// Which of the stored mesh levels a conversion writes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShownLevelOptions {
    /// Level of each region of the body.
    pub level: LevelChoice,
    /// The view in whose pixels the error is reported.
    pub view: Option<MeshView>,
}

/// Level of each region of the body.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum LevelChoice {
    /// The coarsest level of the whole body whose error is within the tolerance of the view; the
    /// finest without a view.
    #[default]
    ByError,
    /// One level of the whole body.
    Whole(u16),
    /// Levels by the names of regions, which the file lists. The name `rest` also stands for all
    /// regions that are not named; without it they are at level 0.
    Regions(Vec<(String, u16)>),
}

/// Distance and picture in whose pixels an error is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshView {
    /// Distance from the camera in metres, above 0.
    pub distance_m: f32,
    /// Tolerated error in pixels.
    pub epsilon_px: f32,
    /// Size and field of view of the picture.
    pub viewport: Viewport,
}

/// Meshes that were reduced to one choice of levels.
#[derive(Debug)]
pub struct ShownLevels {
    /// What was shown, in numbers.
    pub report: ShownLevelsReport,
    /// The character as stored, its mesh at level 0.
    pub asset: Asset,
    /// Triangles of level 0 with their regions, over the vertices of `asset`.
    pub original: Vec<(u16, [u32; 3])>,
    /// Triangles of the choice with their regions, over the same vertices.
    pub shown: Vec<(u16, [u32; 3])>,
}

/// Size and error of the meshes with each region at a level.
#[derive(Debug, Clone, Serialize)]
pub struct ShownLevelsReport {
    /// Regions of the body in the order of the file; one, `all`, where the file has none.
    pub regions: Vec<ShownRegion>,
    /// Number of triangles at level 0.
    pub triangles_before: usize,
    /// Number of triangles that are written.
    pub triangles: usize,
    /// Number of vertices at level 0.
    pub vertices_before: usize,
    /// Number of vertices that are written.
    pub vertices: usize,
    /// Number of vertices that an engine skins to draw this choice from the asset itself, whose
    /// vertices are in the order of levels: those of the finest level that a region has.
    pub vertices_in_asset: usize,
    /// Maximum distance of the original surface from the written one at rest, metres; null where
    /// nothing is left.
    pub error_rest_m: Option<f32>,
    /// The same over poses of the character's motions.
    pub error_motion_m: Option<f32>,
    /// The error by which levels are chosen: the larger of the 95th percentile in motion and half
    /// of the maximum, metres.
    pub error_lod_m: Option<f32>,
    /// Number of poses on which errors in motion were measured.
    pub poses_measured: usize,
    /// The error in a view, where one was given.
    pub view: Option<ShownInView>,
}

/// One region and its level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShownRegion {
    /// Name of the region.
    pub region: String,
    /// Its level; 0 is the finest.
    pub level: u16,
    /// Number of its triangles at level 0.
    pub triangles_before: usize,
    /// Number of its triangles at its level.
    pub triangles: usize,
}

/// The error of the shown levels in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShownInView {
    /// Distance from the camera, metres.
    pub distance_m: f32,
    /// Tolerated error, pixels.
    pub epsilon_px: f32,
    /// Error by which levels are chosen, at this distance in pixels; null where nothing is left.
    pub error_px: Option<f32>,
    /// Nearest distance at which a character that shows this level keeps it at the tolerance,
    /// metres; null unless the level was chosen by its error.
    pub from_m: Option<f32>,
    /// Farthest such distance; null also for the coarsest level, which has none.
    pub to_m: Option<f32>,
}

/// Reduces the meshes of a character to one choice of its levels, also in its glTF document, and
/// measures the result. Motion tables of the document are removed, since they hold for the vertices
/// of the original.
pub(crate) fn show(
    opened: &mut CharacterFile,
    options: &ShownLevelOptions,
    work: &Executor<'_>,
) -> Result<ShownLevels> {
    const WHAT: &str = "measuring mesh levels";
    let Some(table) = opened.character().mesh_levels.clone() else {
        let what = "the meshes have no levels to choose from; make them by building the file with \
                    mesh levels";
        return Err(Error::unsuited(what));
    };
    work.step(WHAT, 0, 1)?;
    let levels = levels(&table, options)?;
    let mix = RegionMix::new(opened.character(), &levels).context("mesh levels")?;
    let asset = character(
        opened.character(),
        Some(opened.articulation()),
        &ClipOptions::default(),
    )?;
    let finest = vec![0; levels.len()];
    let [original, shown] = [&finest, &levels].map(|levels| triangles(opened, &asset, levels));
    let (original, shown) = (original?, shown?);
    let bare: Vec<[u32; 3]> = shown.iter().map(|(_, t)| *t).collect();
    let (distances, poses) = measure_levels(&asset, &[&bare], &MeshLevelOptions::default())?;
    let distances = distances.into_iter().next().unwrap_or_default();
    let vertices_in_asset = vertices_in_asset(&opened.character().meshes, &levels);
    put(opened, &mix)?;
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let error = lod_error_metres(distances.motion.p95_metres, distances.motion.max_metres);
    let MeasurementPoses {
        clips,
        bends,
        morphs,
    } = poses;
    let report = ShownLevelsReport {
        regions: regions(&table, &levels, &original, &shown),
        triangles_before: original.len(),
        triangles: shown.len(),
        vertices_before: asset.mesh.len(),
        vertices_in_asset,
        vertices: mix.objects.iter().map(|o| o.vertices.len()).sum(),
        error_rest_m: finite(distances.rest.max_metres),
        error_motion_m: finite(distances.motion.max_metres),
        error_lod_m: finite(error),
        poses_measured: clips + bends + morphs,
        view: match &options.view {
            None => None,
            Some(view) => Some(in_view(view, &table, options, &levels, error)?),
        },
    };
    work.step(WHAT, 1, 1)?;
    Ok(ShownLevels {
        report,
        asset,
        original,
        shown,
    })
}

/// Vertices that are in use when the stored levels are drawn as they are.
fn vertices_in_asset(meshes: &[RawMesh], levels: &[u16]) -> usize {
    let objects = meshes.iter().flat_map(|m| &m.clustered);
    let count = |object: &ClusteredTriangles| {
        let own = levels.get(..object.clusters.regions()).unwrap_or(levels);
        object.clusters.vertices_of(own) as usize
    };
    objects.map(count).sum()
}

/// The level of each region.
fn levels(table: &LevelTable, options: &ShownLevelOptions) -> Result<Vec<u16>> {
    let count = table.regions.len().max(1);
    let named = match &options.level {
        LevelChoice::Whole(level) => return Ok(vec![*level; count]),
        LevelChoice::ByError => {
            let level = match &options.view {
                None => 0,
                Some(view) => {
                    let px_per_metre = view.viewport.pixels_per_metre(view.distance_m);
                    let tolerance = view.epsilon_px / px_per_metre;
                    table.errors()?.choose(tolerance, None, 0).level
                }
            };
            return Ok(vec![level as u16; count]);
        }
        LevelChoice::Regions(named) => named,
    };
    let of = |name: &str| named.iter().find(|(n, _)| n == name).map(|(_, l)| *l);
    let known = |name: &String| name == "rest" || table.regions.contains(name);
    if let Some((name, _)) = named.iter().find(|(n, _)| !known(n)) {
        let regions = match table.regions.is_empty() {
            true => "the file has none, so give one level for the whole mesh".to_owned(),
            false => format!("the file has {}", table.regions.join(", ")),
        };
        return Err(Error::argument(format!(
            "there is no region \"{name}\"; {regions}"
        )));
    }
    let others = of("rest").unwrap_or(0);
    let levels = table.regions.iter().map(|r| of(r).unwrap_or(others));
    let levels: Vec<u16> = levels.collect();
    Ok(match levels.is_empty() {
        true => vec![others],
        false => levels,
    })
}

/// Triangles of a choice of levels with their regions, over the vertices of the whole mesh.
fn triangles(
    opened: &CharacterFile,
    asset: &Asset,
    levels: &[u16],
) -> Result<Vec<(u16, [u32; 3])>> {
    let mut out = Vec::new();
    let meshes = &opened.character().meshes;
    for (mesh, parts) in meshes.iter().zip(parts_of_meshes_of(meshes)) {
        for (p, part) in asset.mesh.parts[parts].iter().enumerate() {
            let first = part.vertices.start as u32;
            let whole = |t: [u32; 3]| t.map(|v| v + first);
            match mesh.clustered.get(p) {
                None => {
                    let own = asset.mesh.triangles[part.triangles.clone()].iter();
                    let last = levels.len().saturating_sub(1) as u16;
                    out.extend(own.map(|t| (last, *t)));
                }
                Some(stored) => {
                    let shown = by_region(stored, levels);
                    out.extend(shown.map(|(region, t)| (region, whole(t))));
                }
            }
        }
    }
    Ok(out)
}

/// Triangles of one object at the levels of its regions.
fn by_region<'a>(
    stored: &'a ClusteredTriangles,
    levels: &'a [u16],
) -> impl Iterator<Item = (u16, [u32; 3])> + 'a {
    let shown = |c: &&articula_core::Cluster| {
        let level = levels.get(usize::from(c.region)).copied().unwrap_or(0);
        c.finest_level <= level && level <= c.coarsest_level
    };
    stored
        .clusters
        .clusters()
        .iter()
        .filter(shown)
        .flat_map(|c| {
            let range = c.triangles.start as usize..c.triangles.end as usize;
            stored.triangles[range].iter().map(|t| (c.region, *t))
        })
}

/// Counts of each region.
fn regions(
    table: &LevelTable,
    levels: &[u16],
    original: &[(u16, [u32; 3])],
    shown: &[(u16, [u32; 3])],
) -> Vec<ShownRegion> {
    let count = |list: &[(u16, [u32; 3])], region: usize| {
        list.iter()
            .filter(|(r, _)| usize::from(*r) == region)
            .count()
    };
    let row = |(r, level): (usize, &u16)| ShownRegion {
        region: table.regions.get(r).map_or("all", String::as_str).into(),
        level: *level,
        triangles_before: count(original, r),
        triangles: count(shown, r),
    };
    levels.iter().enumerate().map(row).collect()
}

fn in_view(
    view: &MeshView,
    table: &LevelTable,
    options: &ShownLevelOptions,
    levels: &[u16],
    error_metres: f32,
) -> Result<ShownInView> {
    let px = error_metres * view.viewport.pixels_per_metre(view.distance_m);
    let (mut from_m, mut to_m) = (None, None);
    if options.level == LevelChoice::ByError {
        let [least, most] = table
            .errors()?
            .level_range(usize::from(levels[0]), view.epsilon_px);
        // One metre at a distance of one metre; pixels per metre fall as one over the distance.
        let at_one = view.viewport.pixels_per_metre(1.0);
        let finite = |metres: f32| metres.is_finite().then_some(metres);
        from_m = Some(at_one / most);
        to_m = finite(at_one / least);
    }
    Ok(ShownInView {
        distance_m: view.distance_m,
        epsilon_px: view.epsilon_px,
        error_px: px.is_finite().then_some(px),
        from_m,
        to_m,
    })
}

/// Puts the triangles into the character and its document.
fn put(opened: &mut CharacterFile, mix: &RegionMix) -> Result<()> {
    let character = mix.character(opened.character())?;
    let mut gltf = opened.gltf().cloned();
    if let Some(gltf) = &mut gltf {
        let part = |part: usize| {
            let object = &mix.objects[part];
            PartLevels {
                vertices: &object.vertices,
                triangles: &object.triangles,
                clusters: &object.clusters,
            }
        };
        let meshes: Vec<MeshParts<'_>> = parts_of_meshes_of(&opened.character().meshes)
            .into_iter()
            .zip(&gltf.node_of_mesh)
            .map(|(parts, node)| MeshParts {
                node: *node,
                parts: parts.map(part).collect(),
            })
            .collect();
        gltf.document.set_single_level(&meshes)?;
        gltf.document.remove_motion_tables();
    }
    opened.set_meshes(character, gltf);
    Ok(())
}
