//! The character of a crowd: its levels with their skins and errors, and its bounds.

use super::in_place::{put_in_place, root_path};
use super::mesh_lods::MeshLods;
use super::options::{CrowdOptions, JointLodMethod, PaletteMatrices, RootMotionPolicy};
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::open::choose;
use crate::work::Executor;
use articula_build::ClipOptions;
use articula_build::clip_edit::TrajectoryKey;
use articula_build::motion_bounds;
use articula_build::{Asset, character};
use articula_build::{CacheOptions, cached_poses};
use articula_build::{
    JointLodOptions, LevelSkins, MergedLevels, joint_lods, level_skins, lod_errors, mean_pose,
    named_joint_lods, skin_of,
};
use articula_core::crowd::{CrowdModel, CrowdParts, RootTrajectory};
use articula_core::source::{Character, Property};
use articula_core::{Clip, ClipSet, JointLods, Mesh, MotionBounds, PaletteMap, Tracks};
use std::sync::Arc;

/// Root motion of a clip, relative to its start.
type RootTrack = Vec<TrajectoryKey>;

const PREPARING: &str = "preparing levels";

/// A character prepared for crowds. Cheap to clone: clones share the data.
#[derive(Debug, Clone)]
pub struct CrowdAsset(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    full: Asset,
    skins: LevelSkins,
    meshes: Vec<Mesh>,
    mesh_lods: Option<MeshLods>,
    model: CrowdModel,
    matrices: PaletteMatrices,
    has_mesh: bool,
    travels: Vec<bool>,
    warnings: Vec<String>,
}

/// Properties of one level of a crowd's character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CrowdLevel {
    /// Number of joints that the level keeps.
    pub joints: usize,
    /// Number of matrices in one palette.
    pub matrices: usize,
    /// Number of skinned vertices; 0 without a mesh.
    pub vertices: usize,
    /// Number of triangles drawn.
    pub triangles: usize,
    /// Maximum number of influences per vertex.
    pub influences: usize,
}

impl CrowdAsset {
    /// Computes levels, their meshes, their error in every clip, and bounds.
    ///
    /// A character without a clip stands in its rest pose; the error of a character without a mesh
    /// is measured at points on its bones. Both cases are reported by [`warnings`](Self::warnings).
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the file: a clip named in the options does not exist,
    /// the options do not fit the character, or [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn new(figure: &Figure, options: &CrowdOptions, work: &Executor<'_>) -> Result<Self> {
        Self::of_figure(figure, options, work).with_context(|| &figure.opened.name)
    }

    fn of_figure(figure: &Figure, options: &CrowdOptions, work: &Executor<'_>) -> Result<Self> {
        let (mut asset, mut ways, mut warnings) = on_the_spot(figure, options.root_motion)?;
        let kept = kept_clips(&asset.clips, &options.clips)?;
        keep(&mut asset.clips, &kept);
        keep(&mut ways, &kept);
        warnings.extend(morphs_at_rest(&figure.opened.character));
        warnings.extend(unmapped(&asset, &options.joints));
        Self::prepared(asset, (&ways, warnings), options, work)
    }

    /// Prepares an [`Asset`] that is already built; all clips are used as they are.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) if the options do not fit the character, or
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn from_asset(asset: Asset, options: &CrowdOptions, work: &Executor<'_>) -> Result<Self> {
        Self::prepared(asset, (&[], Vec::new()), options, work)
    }

    /// Prepares the asset; `ways` is empty or has one entry per clip, its root motion if any.
    fn prepared(
        mut asset: Asset,
        (ways, mut warnings): (&[Option<RootTrack>], Vec<String>),
        options: &CrowdOptions,
        work: &Executor<'_>,
    ) -> Result<Self> {
        work.step(PREPARING, 0, 5)?;
        if asset.clips.is_empty() {
            warnings.push("the file has no clip: all characters show the rest pose".to_owned());
            asset.clips.push(rest(asset.rig.len())?);
        }
        let has_mesh = !asset.mesh.is_empty();
        // Before points replace a missing mesh, since bounds from joints are better than from
        // points.
        let bounds = motion_bounds(&asset, 0.0).context("bounds")?;
        work.step(PREPARING, 1, 5)?;
        if !has_mesh {
            warnings.push("the file has no mesh: points on the bones replace the skin".to_owned());
            asset.mesh = skin_of(&asset).into_owned();
        }
        let opts = JointLodOptions {
            seed: options.seed,
            ..JointLodOptions::default()
        };
        let levels = lods_with_skins(&asset, &options.joints, &opts, work)?;
        let (mesh_lods, levels, meshes) = if options.mesh_levels > 1 && has_mesh {
            let most = options.mesh_levels;
            let (lods, levels, meshes) = MeshLods::new(&asset, &levels, most, &opts)?;
            (Some(lods), levels, meshes)
        } else {
            let all = 0..levels.joint_lods.levels();
            let meshes = all.map(|l| levels.skins.mesh(l, &asset.mesh)).collect();
            (None, levels, meshes)
        };
        let mut paths = vec![None; asset.clips.len()];
        if options.root_motion == RootMotionPolicy::Extracted {
            for (path, (way, clip)) in paths.iter_mut().zip(ways.iter().zip(&asset.clips)) {
                if let Some(way) = way {
                    *path = Some(root_path(way, clip)?);
                }
            }
        }
        let model = model(&asset, &levels, (bounds, paths), options)?;
        work.step(PREPARING, 5, 5)?;
        Ok(Self(Arc::new(Shared {
            travels: ways.iter().map(Option::is_some).collect(),
            full: asset,
            skins: levels.skins,
            meshes,
            mesh_lods,
            model,
            matrices: options.matrices,
            has_mesh,
            warnings,
        })))
    }

    /// Returns the data that a frame reads: clips, levels, palettes, errors, bounds, cached poses.
    pub fn model(&self) -> &CrowdModel {
        &self.0.model
    }

    /// Returns rig, clips and mesh in full detail; the mesh is points on the bones if the file has
    /// none.
    pub fn full(&self) -> &Asset {
        &self.0.full
    }

    /// Returns the clips of the crowd.
    pub fn clips(&self) -> &[Clip] {
        &self.0.full.clips
    }

    /// Returns the index of the clip called `name`.
    ///
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) if no clip has this name; the message lists the
    /// clips.
    pub fn clip(&self, name: &str) -> Result<usize> {
        choose("clip", name, self.clips().iter().map(|c| c.name.as_str()))
    }

    /// Returns whether a clip had root motion before it was put in place.
    pub fn travels(&self, clip: usize) -> bool {
        self.0.travels.get(clip).is_some_and(|t| *t)
    }

    /// Returns the number of levels; 0 is full detail.
    pub fn levels(&self) -> usize {
        self.0.model.parts().clips.joint_lods().levels()
    }

    /// Returns the mesh of a level; its bindings are the first matrices of a skinning palette.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn mesh(&self, level: usize) -> &Mesh {
        &self.0.meshes[level]
    }

    /// Returns the properties of a level.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn level(&self, level: usize) -> CrowdLevel {
        let shared = &*self.0;
        let mesh = &shared.full.mesh;
        let (vertices, triangles) = match &shared.mesh_lods {
            _ if !shared.has_mesh => (0, 0),
            Some(lods) => (lods.levels[level].vertices, lods.levels[level].triangles),
            None => (mesh.len(), mesh.triangles.len()),
        };
        CrowdLevel {
            joints: self.joint_lods().joint_count(level),
            matrices: shared.model.parts().palette.len(level),
            vertices,
            triangles,
            influences: shared.skins.levels[level].influences,
        }
    }

    /// Returns whether levels have their own meshes.
    pub fn has_mesh_lods(&self) -> bool {
        self.0.mesh_lods.is_some()
    }

    /// Returns whether the mesh comes from the file, as opposed to points on the bones.
    pub fn has_mesh(&self) -> bool {
        self.0.has_mesh
    }

    /// Returns which matrices the palettes hold.
    pub fn matrices(&self) -> PaletteMatrices {
        self.0.matrices
    }

    /// Returns the warnings of the preparation, as text for the user.
    pub fn warnings(&self) -> &[String] {
        &self.0.warnings
    }

    /// Returns joint order and levels.
    pub(super) fn joint_lods(&self) -> &JointLods {
        self.0.model.parts().clips.joint_lods()
    }

    /// Returns the pairs of joint and mesh LODs, if there are coarser meshes.
    pub(super) fn mesh_lods(&self) -> Option<&MeshLods> {
        self.0.mesh_lods.as_ref()
    }
}

/// Returns the asset with the clips to be played, the root motion of each clip that travelled, and
/// warnings.
fn on_the_spot(
    figure: &Figure,
    root_motion: RootMotionPolicy,
) -> Result<(Asset, Vec<Option<RootTrack>>, Vec<String>)> {
    if root_motion == RootMotionPolicy::AsAuthored {
        let ways = vec![None; figure.asset.clips.len()];
        return Ok((figure.asset.clone(), ways, Vec::new()));
    }
    let opened = &figure.opened;
    let mut source = opened.character.clone();
    let articulation = opened.articulation();
    let (ways, faults) = put_in_place(&mut source, articulation.clone(), &opened.end_sites);
    let asset = if ways.iter().any(Option::is_some) {
        character(&source, Some(articulation), &ClipOptions::default())?
    } else {
        figure.asset.clone()
    };
    Ok((asset, ways, faults))
}

/// Returns which clips are selected by name; all of them without names.
fn kept_clips(clips: &[Clip], names: &[String]) -> Result<Vec<bool>> {
    let mut kept = vec![names.is_empty(); clips.len()];
    for name in names {
        let known = clips.iter().map(|c| c.name.as_str());
        kept[choose("clip", name, known)?] = true;
    }
    Ok(kept)
}

fn keep<T>(all: &mut Vec<T>, kept: &[bool]) {
    let mut each = kept.iter();
    all.retain(|_| each.next().is_some_and(|kept| *kept));
}

/// Returns a warning that morph targets stay at rest, if they are all that the clips animate.
fn morphs_at_rest(source: &Character) -> Option<String> {
    let mut channels = source.clips.iter().flat_map(|c| &c.channels).peekable();
    channels.peek()?;
    let stand = channels.all(|c| c.property == Property::Weights);
    stand.then(|| {
        "the clips animate morph targets only, which a crowd does not play; play the file as a \
         single figure"
            .to_owned()
    })
}

/// Returns a warning that a named level has little effect, if no joint is known by its name.
fn unmapped(asset: &Asset, wanted: &JointLodMethod) -> Option<String> {
    let mut joints = asset.rig.articulation().joints.iter();
    let is_named = matches!(wanted, JointLodMethod::Named(_));
    (is_named && joints.all(|j| j.hanim.is_none())).then(|| {
        "no joint name is known, so the named levels keep joints by their depth in the hierarchy; \
         give a joint map or choose levels merged by motion"
            .to_owned()
    })
}

/// Joint levels with their skins and errors.
fn lods_with_skins(
    asset: &Asset,
    wanted: &JointLodMethod,
    opts: &JointLodOptions,
    work: &Executor<'_>,
) -> Result<MergedLevels> {
    let joint_lods = match wanted {
        JointLodMethod::Whole => JointLods::whole(&asset.rig),
        JointLodMethod::Merged => joint_lods(asset, &mean_pose(asset), opts),
        JointLodMethod::Named(expression) => {
            named_joint_lods(asset, &mean_pose(asset), std::slice::from_ref(expression))
        }
    };
    let joint_lods = joint_lods.context("levels")?;
    work.step(PREPARING, 2, 5)?;
    let skins = level_skins(asset, &joint_lods, opts).context("skins")?;
    work.step(PREPARING, 3, 5)?;
    let errors = lod_errors(asset, &joint_lods, &skins, opts).context("errors")?;
    work.step(PREPARING, 4, 5)?;
    Ok(MergedLevels {
        joint_lods,
        skins,
        far: None,
        errors,
    })
}

/// Builds the data that all characters share: clips, palettes, errors and, on request, cached
/// poses.
fn model(
    asset: &Asset,
    levels: &MergedLevels,
    (bounds, paths): (MotionBounds, Vec<Option<RootTrajectory>>),
    options: &CrowdOptions,
) -> Result<CrowdModel> {
    let palette = match options.matrices {
        PaletteMatrices::Joints => PaletteMap::joints(&levels.joint_lods),
        PaletteMatrices::Skin => levels.skins.palette.clone(),
    };
    let joint_lods = levels.joint_lods.clone();
    let clips = ClipSet::new(&asset.rig, joint_lods, &asset.clips, options.storage)?;
    let cache = if options.pose_cache {
        let opts = CacheOptions {
            form: options.form,
            seed: options.seed,
            ..CacheOptions::default()
        };
        Some(
            cached_poses(asset, levels, &clips, &opts)
                .context("cache")?
                .cache,
        )
    } else {
        None
    };
    Ok(CrowdModel::new(CrowdParts {
        clips,
        palette,
        form: options.form,
        backend: options.backend,
        errors: levels.errors.clone(),
        bounds,
        events: Vec::new(),
        paths,
        attention: Vec::new(),
        cache,
    })?)
}

/// A clip of one frame without channels.
fn rest(joints: usize) -> Result<Clip> {
    Ok(Clip::new("rest pose", 1.0, 1, joints, Tracks::default())?)
}
