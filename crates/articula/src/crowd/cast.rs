//! The character of a crowd: its levels, their skins and errors, its bounds, ready to be played.

use super::figure::Figure;
use crate::console::Console;
use anyhow::Context;
use articula_build::Asset;
use articula_build::motion_bounds;
use articula_build::scene::{Way, root_path};
use articula_build::{CacheOptions, cached_poses};
use articula_build::{
    LevelOptions, LevelSkins, MergedLevels, joint_ladder, level_errors, level_skins, mean_pose,
    named_ladder, skin_of,
};
use articula_core::crowd::{CrowdModel, CrowdParts};
use articula_core::loa::Expression;
use articula_core::{
    Backend, Clip, ClipSet, Ladder, Mesh, MotionBounds, PaletteForm, PaletteMap, Storage, Tracks,
};

/// Which levels a crowd has.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Levels {
    /// Every joint, and nothing else.
    Whole,
    /// Merged by what the skin loses.
    Merged,
    /// Every joint, and the joints that the user names.
    Named(Expression),
}

/// Which matrices are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Matrices {
    /// Of each joint that a level keeps, without the inverse bind.
    Joints,
    /// Of each binding of the skin, with it.
    Skin,
}

/// How a character is prepared.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CastOptions {
    pub(crate) levels: Levels,
    pub(crate) matrices: Matrices,
    pub(crate) form: PaletteForm,
    pub(crate) storage: Storage,
    pub(crate) backend: Backend,
    pub(crate) seed: u64,
    /// Whether poses are cached.
    pub(crate) is_cached: bool,
    /// Levels of the mesh, the original counted; with 1 everyone has the original.
    pub(crate) mesh_levels: usize,
}

/// A character that is ready for a crowd.
#[derive(Debug)]
pub(crate) struct Cast {
    /// Rig, clips and mesh; points on the bones where there is no mesh.
    pub(crate) asset: Asset,
    pub(crate) skins: LevelSkins,
    /// The mesh of each level, on the first matrices of one palette.
    pub(crate) meshes: Vec<Mesh>,
    /// Which joints and triangles go together, if there are coarser meshes.
    pub(crate) figure: Option<Figure>,
    pub(crate) model: CrowdModel,
    pub(crate) matrices: Matrices,
    /// Whether the mesh is the file's.
    pub(crate) has_mesh: bool,
    /// What was odd, for people.
    pub(crate) warnings: Vec<String>,
}

impl Cast {
    /// Prepares levels, skins, errors and bounds.
    ///
    /// `ways` has one entry for each clip, or none: how it carried its character, if it did.
    pub(crate) fn new(
        mut asset: Asset,
        ways: &[Option<Way>],
        options: &CastOptions,
        console: &Console,
    ) -> anyhow::Result<Self> {
        let bar = console.progress("preparing levels", 5);
        let mut warnings = Vec::new();
        if asset.clips.is_empty() {
            warnings.push("the file has no clip: everyone stands in the rest pose".to_owned());
            asset.clips.push(rest(asset.rig.len())?);
        }
        let has_mesh = !asset.mesh.is_empty();
        // Before points stand for the skin: without a mesh bounds know more than points do.
        let bounds = motion_bounds(&asset, 0.0).context("bounds")?;
        bar.inc(1);
        if !has_mesh {
            warnings.push("no mesh: points on the bones stand for the skin".to_owned());
            asset.mesh = skin_of(&asset).into_owned();
        }
        let opts = LevelOptions {
            seed: options.seed,
            ..LevelOptions::default()
        };
        let ladder = ladder(&asset, &options.levels, &opts)?;
        bar.inc(1);
        let skins = level_skins(&asset, &ladder, &opts).context("skins")?;
        bar.inc(1);
        let errors = level_errors(&asset, &ladder, &skins, &opts).context("errors")?;
        bar.inc(1);
        let levels = MergedLevels {
            ladder,
            skins,
            far: None,
            errors,
        };
        let (figure, levels, meshes) = if options.mesh_levels > 1 && has_mesh {
            let most = options.mesh_levels;
            let (figure, levels, meshes) = Figure::new(&asset, &levels, most, &opts)?;
            (Some(figure), levels, meshes)
        } else {
            let all = 0..levels.ladder.levels();
            let meshes = all.map(|l| levels.skins.mesh(l, &asset.mesh)).collect();
            (None, levels, meshes)
        };
        let mut model = model(&asset, &levels, bounds, options)?;
        bar.finish_and_clear();
        for (c, (way, clip)) in ways.iter().zip(&asset.clips).enumerate() {
            if let Some(way) = way {
                model = model.with_root_path(c, root_path(way, clip)?)?;
            }
        }
        Ok(Self {
            asset,
            skins: levels.skins,
            meshes,
            figure,
            model,
            matrices: options.matrices,
            has_mesh,
            warnings,
        })
    }

    /// Joint order and levels.
    pub(crate) fn ladder(&self) -> &Ladder {
        self.model.clips().ladder()
    }
}

/// What all characters share: clips, palettes, errors, and cached poses if they are asked for.
fn model(
    asset: &Asset,
    levels: &MergedLevels,
    bounds: MotionBounds,
    options: &CastOptions,
) -> anyhow::Result<CrowdModel> {
    let palette = match options.matrices {
        Matrices::Joints => PaletteMap::joints(&levels.ladder),
        Matrices::Skin => levels.skins.palette.clone(),
    };
    let ladder = levels.ladder.clone();
    let clips = ClipSet::new(&asset.rig, ladder, &asset.clips, options.storage)?;
    let cache = if options.is_cached {
        let opts = CacheOptions {
            form: options.form,
            seed: options.seed,
            ..CacheOptions::default()
        };
        Some(cached_poses(asset, levels, &clips, &opts).context("cache")?)
    } else {
        None
    };
    let model = CrowdModel::new(CrowdParts {
        clips,
        palette,
        form: options.form,
        backend: options.backend,
        errors: levels.errors.clone(),
        bounds,
    })?;
    match cache {
        Some(cached) => Ok(model.with_cache(cached.cache).context("cache")?),
        None => Ok(model),
    }
}

fn ladder(asset: &Asset, levels: &Levels, opts: &LevelOptions) -> anyhow::Result<Ladder> {
    let ladder = match levels {
        Levels::Whole => Ladder::whole(&asset.rig),
        Levels::Merged => joint_ladder(asset, &mean_pose(asset), opts),
        Levels::Named(expression) => {
            named_ladder(asset, &mean_pose(asset), std::slice::from_ref(expression))
        }
    };
    ladder.context("levels")
}

/// One frame that drives nothing.
fn rest(joints: usize) -> anyhow::Result<Clip> {
    Ok(Clip::new("rest pose", 1.0, 1, joints, Tracks::default())?)
}
