//! Figure levels: a joint LOD and a mesh level that are shown together.
//!
//! Every combination of joint LOD, mesh level and number of influences is compared with the full
//! character in motion, and the cheapest within each tolerance is taken. From level to level
//! neither joints nor triangles nor influences grow, so that a stream only appends. Errors are
//! measured at the points of the skin (`docs/metrics.md`) and are comparable with those of joint
//! LODs alone.
//!
//! Source: thesis 5.1 (levels for bodies of several resolutions), `docs/methods/clustered-mesh.md`,
//! `docs/methods/motion-lod.md` part 8.

mod bounds;
mod chain;
mod measure;

use crate::character::Asset;
use crate::influences::limit;
use crate::joint_lods::{self, JointLodOptions, MAX_FRAMES, MergedLevels, Tally, Watched, rising};
use crate::simplify::extent;
use crate::surface_distance::{Borders, SkinPoint, attach};
use articula_core::{
    ClipLodErrors, FigureLevel, JointLods, LevelSkin, LevelSkins, LocalPose, LodErrors, Mesh,
    Mismatch, PaletteMap, lod_error_metres,
};
use chain::Candidate;
use glam::{Affine3A, Vec3};
use measure::{DisplayedLevel, LevelMeasurement};

/// Maximum number of levels beyond those of joints alone, since there are meshes to choose from too.
const MORE_LEVELS: usize = 8;

/// Error within which the farthest of a crowd are shown, relative to the size of the figure: a pixel where it is ten
/// pixels high.
const FAR: f32 = 0.1;

/// Limits on influences that are tried, besides the number that the joint LOD has.
const INFLUENCES: [usize; 3] = [4, 2, 1];

/// Levels of a figure, the full character first.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureLevels {
    /// Contents of each level; neither joints nor triangles nor influences grow from level to
    /// level.
    pub levels: Vec<FigureLevel>,
    /// The same levels in the form of a crowd: joint LODs (successive ones may keep the same
    /// joints), skins, and the errors of joints and mesh together.
    pub merged: MergedLevels,
}

impl FigureLevels {
    /// Returns the mesh of a level: the skin of its joints with the triangles of its mesh level.
    ///
    /// # Panics
    /// If the level does not exist, or mesh and mesh levels are not those it was made from.
    pub fn mesh(&self, level: usize, full: &Mesh, mesh_levels: &[&[[u32; 3]]]) -> Mesh {
        let mut mesh = self.merged.skins.mesh(level, full);
        mesh.triangles = mesh_levels[self.levels[level].mesh_level].to_vec();
        mesh.parts = chain::parts(full, &mesh.triangles);
        mesh
    }
}

/// Selects joint LODs and mesh levels that are shown together.
///
/// `merged` holds the joint LODs (far levels are ignored), and `mesh_levels` the triangles of each
/// mesh level over the vertices of the asset's mesh, the original first. `poses` are positions of
/// all vertices, the rest pose first; they determine which point of a level corresponds to which
/// vertex ([`attach`]). Tolerances start at `opts.first_metres` and grow by a quarter of an octave; there
/// are at most eight levels more than `opts.max_levels`, and fewer, down to six, where a level has many materials.
///
/// # Errors
/// A [`Mismatch`] if an argument belongs to another character, or a level has no triangle.
pub fn figure_levels(
    asset: &Asset,
    merged: &MergedLevels,
    mesh_levels: &[&[[u32; 3]]],
    poses: &[Vec<Vec3>],
    opts: &JointLodOptions,
) -> Result<FigureLevels, Mismatch> {
    check(asset, merged, mesh_levels, poses)?;
    let mesh = &asset.mesh;
    let some = Watched::draw(mesh, asset.rig.len(), opts.vertices, opts.seed);
    let some = some.of_triangles(&mesh.triangles);
    let borders = Borders::of(mesh, &poses[0]);
    let points_of = |watched: &Watched, level: usize| match level {
        0 => watched.vertices.iter().map(|v| SkinPoint::at(*v)).collect(),
        _ => attach(
            mesh_levels[level],
            &watched.vertices,
            poses,
            &mesh.parts,
            &borders,
        ),
    };
    let levels = 0..mesh_levels.len();
    let points: Vec<Vec<SkinPoint>> = levels.map(|l| points_of(&some, l)).collect();
    let skins = all_skins(&merged.skins, mesh);
    let mut candidates = candidates(merged, &skins, (mesh, mesh_levels));
    let parts = skins.iter().map(|s| &s.skin).collect::<Vec<_>>();
    let bindings = &merged.skins.bindings;
    let scene = LevelMeasurement::new(asset, &some, &parts, bindings, &points);
    let shown: Vec<DisplayedLevel> = candidates.iter().map(DisplayedLevel::of).collect();
    for clip in scene.measure(&shown, opts.frames) {
        for (candidate, tally) in candidates.iter_mut().zip(clip) {
            let error = lod_error_metres(tally.percentile_metres, tally.worst_metres);
            candidate.error_metres = candidate.error_metres.max(error);
        }
    }
    let chosen = chain::choose(
        candidates,
        (opts.first_metres, extent(&poses[0]) * FAR),
        (opts.max_levels.saturating_add(MORE_LEVELS)).min(JointLods::MAX_LEVELS),
    );
    // A sample decides which levels there are; their errors are those of every vertex.
    let every = Watched::every(mesh, opts.vertices, opts.seed).of_triangles(&mesh.triangles);
    let points: Vec<Vec<SkinPoint>> = (0..mesh_levels.len())
        .map(|l| match chosen.iter().any(|c| c.level.mesh_level == l) {
            true => points_of(&every, l),
            false => Vec::new(),
        })
        .collect();
    let scene = LevelMeasurement::new(asset, &every, &parts, bindings, &points);
    let (drawn, points) = drawn(&every, &points);
    let of_drawn = LevelMeasurement::new(asset, &drawn, &parts, bindings, &points);
    let shown: Vec<DisplayedLevel> = chosen.iter().map(DisplayedLevel::of).collect();
    let tallies = scene.measure_with_worst(&of_drawn, &shown, MAX_FRAMES);
    let errors = table(merged, &tallies);
    let of_levels = chosen.iter().map(|c| skins[c.skin].skin.clone()).collect();
    let levels: Vec<FigureLevel> = chosen.iter().map(|c| c.level).collect();
    errors.check(asset.clips.len(), levels.len())?;
    Ok(FigureLevels {
        merged: stacked(asset, merged, &levels, of_levels, errors)?,
        levels,
    })
}

/// The vertices of the uniform random sample, and the points of each level at these.
fn drawn(watched: &Watched, points: &[Vec<SkinPoint>]) -> (Watched, Vec<Vec<SkinPoint>>) {
    let at = |level: &Vec<SkinPoint>| {
        let all = level.iter().zip(&watched.drawn);
        all.filter(|(_, drawn)| **drawn).map(|(p, _)| *p).collect()
    };
    (
        watched.only_drawn_or(|_| false),
        points.iter().map(at).collect(),
    )
}

/// Combines known levels, such as those that an asset stores, with the skins of their joint LODs.
///
/// `levels` and `errors` are those of an earlier [`figure_levels`] for the same arguments.
///
/// # Errors
/// A [`Mismatch`] if a level names a joint LOD that does not exist, or errors and levels do not
/// belong to the character.
pub fn paired_levels(
    asset: &Asset,
    merged: &MergedLevels,
    levels: Vec<FigureLevel>,
    errors: LodErrors,
) -> Result<FigureLevels, Mismatch> {
    errors.check(asset.clips.len(), levels.len())?;
    let mut skins = Vec::with_capacity(levels.len());
    for (l, level) in levels.iter().enumerate() {
        let Some(skin) = merged.skins.levels.get(level.joint_level) else {
            let what = format!("there is no joint LOD {}", level.joint_level);
            return Err(Mismatch::new(format!("levels[{l}]"), what));
        };
        skins.push(if level.influences < skin.influences {
            let mesh = merged.skins.mesh(level.joint_level, &asset.mesh);
            limited(skin, mesh, level.influences)
        } else {
            skin.clone()
        });
    }
    Ok(FigureLevels {
        merged: stacked(asset, merged, &levels, skins, errors)?,
        levels,
    })
}

fn check(
    asset: &Asset,
    merged: &MergedLevels,
    mesh_levels: &[&[[u32; 3]]],
    poses: &[Vec<Vec3>],
) -> Result<(), Mismatch> {
    joint_lods::check(asset)?;
    joint_lods::check_tolerances(asset, &merged.joint_lods)?;
    let count = asset.mesh.len();
    let skins = &merged.skins.levels;
    let fits = |s: &LevelSkin| s.positions.len() == count;
    if count == 0 || skins.len() != merged.joint_lods.levels() || !skins.iter().all(fits) {
        return Err(Mismatch::new(
            "merged.skins",
            "must belong to this character",
        ));
    }
    if poses.is_empty() {
        return Err(Mismatch::new(
            "poses",
            "must not be empty: the rest pose is required",
        ));
    }
    if let Some(p) = poses.iter().position(|p| p.len() != count) {
        let what = format!("{} vertices, the mesh has {count}", poses[p].len());
        return Err(Mismatch::new(format!("poses[{p}]"), what));
    }
    if mesh_levels.is_empty() {
        return Err(Mismatch::new(
            "mesh_levels",
            "must not be empty: the original mesh is required",
        ));
    }
    for (l, level) in mesh_levels.iter().enumerate() {
        let outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= count);
        if level.is_empty() || level.iter().any(outside) {
            let what = format!(
                "has no triangle, or one that names a vertex out of range: the mesh has {count} \
                 vertices"
            );
            return Err(Mismatch::new(format!("mesh_levels[{l}]"), what));
        }
    }
    Ok(())
}

/// Every combination of skin and mesh level.
fn candidates(
    merged: &MergedLevels,
    skins: &[Dressed],
    (full, mesh_levels): (&Mesh, &[&[[u32; 3]]]),
) -> Vec<Candidate> {
    let vertices: Vec<usize> = mesh_levels.iter().map(|l| chain::vertices(l)).collect();
    let materials = mesh_levels.iter().map(|l| chain::materials(full, l));
    let materials: Vec<usize> = materials.collect();
    let mut all = Vec::with_capacity(skins.len() * mesh_levels.len());
    for (s, skin) in skins.iter().enumerate() {
        // Of two equally good ones the coarser mesh is taken: it comes first.
        for (mesh_level, triangles) in mesh_levels.iter().enumerate().rev() {
            let level = FigureLevel {
                joint_level: skin.joint_level,
                mesh_level,
                joints: merged.joint_lods.joint_count(skin.joint_level),
                triangles: triangles.len(),
                vertices: vertices[mesh_level],
                influences: skin.skin.influences,
                cost: 0.0,
            };
            all.push(Candidate {
                skin: s,
                level,
                error_metres: 0.0,
                materials: materials[mesh_level],
            });
        }
    }
    all
}

/// A candidate skin.
struct Dressed {
    joint_level: usize,
    skin: LevelSkin,
}

/// Skins of all joint LODs, with all influences and with fewer.
fn all_skins(skins: &LevelSkins, full: &Mesh) -> Vec<Dressed> {
    let mut out = Vec::new();
    for (joint_level, skin) in skins.levels.iter().enumerate() {
        let fewer = INFLUENCES.iter().filter(|n| **n < skin.influences);
        let limited = fewer.map(|n| limited(skin, skins.mesh(joint_level, full), *n));
        for skin in std::iter::once(skin.clone()).chain(limited) {
            out.push(Dressed { joint_level, skin });
        }
    }
    out
}

fn limited(skin: &LevelSkin, mut mesh: Mesh, most: usize) -> LevelSkin {
    limit(&mut mesh, most);
    LevelSkin {
        influences: mesh.influences,
        binding_indices: mesh.binding_indices,
        weights: mesh.weights,
        ..skin.clone()
    }
}

/// Errors of the levels in each clip, which never fall; speed and seam are those of the full
/// character.
fn table(merged: &MergedLevels, tallies: &[Vec<Tally>]) -> LodErrors {
    let clips = merged.errors.clips.iter().zip(tallies);
    let clips = clips.map(|(own, levels)| ClipLodErrors {
        levels_metres: rising(levels[1..].iter().map(|t| t.percentile_metres)),
        worst_metres: rising(levels[1..].iter().map(|t| t.worst_metres)),
        ..own.clone()
    });
    LodErrors {
        clips: clips.collect(),
    }
}

/// The levels as joint LODs of a crowd.
fn stacked(
    asset: &Asset,
    merged: &MergedLevels,
    levels: &[FigureLevel],
    skins: Vec<LevelSkin>,
    errors: LodErrors,
) -> Result<MergedLevels, Mismatch> {
    let from = &merged.joint_lods;
    let mean: LocalPose = (0..asset.rig.len())
        .map(|j| from.mean()[from.place(j)])
        .collect();
    let kept = levels.iter().map(|l| l.joints as u16).collect();
    let joint_lods = JointLods::new(&asset.rig, from.joints().to_vec(), kept, &mean)?;
    let bindings = &merged.skins.bindings;
    let place = |joint: u16| from.place(usize::from(joint)) as u16;
    let placed = bindings.iter().map(|b| (place(b.joint), b.inverse_bind));
    let placed: Vec<(u16, Affine3A)> = placed.collect();
    Ok(MergedLevels {
        skins: LevelSkins {
            palette: PaletteMap::skin(&joint_lods, &placed)?,
            bindings: bindings.clone(),
            levels: skins,
        },
        joint_lods,
        far: None,
        errors,
    })
}
