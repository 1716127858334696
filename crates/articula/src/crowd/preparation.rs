//! The steps of preparing a character for crowds. Each uses what the asset stores, and computes it
//! otherwise; the result is the same, of all clips. Of a choice of them the levels that are stored are those for all.

use super::cache_places::close_gaps;
use super::in_place::{put_in_place, root_path};
use super::options::{JointLodMethod, RootMotionPolicy};
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::prepared::stored::Stored;
use crate::work::Executor;
use articula_build::{Asset, ClipOptions, sampled_clip};
use articula_build::{
    CacheOptions, JointLodOptions, MergedLevels, cache_of_keys, cached_poses, joint_lods,
    level_skins, lod_errors, mean_pose, motion_bounds, named_joint_lods, reach_bounds,
};
use articula_core::crowd::RootTrajectory;
use articula_core::{
    ClipLodErrors, ClipSet, JointLods, LodErrors, MotionBounds, PaletteForm, PaletteMap, PoseCache,
};
use articula_formats::prepared::ClipsInPlace;

pub(crate) const PREPARING: &str = "preparing levels";

/// A character with its travelling clips in place.
#[derive(Debug)]
pub(crate) struct CharacterInPlace {
    pub(crate) asset: Asset,
    /// Root motion of each clip that travelled, relative to its start.
    pub(crate) paths: Vec<Option<RootTrajectory>>,
    /// Warnings about clips that could not be put in place.
    pub(crate) warnings: Vec<String>,
}

impl CharacterInPlace {
    /// The clips as they are.
    pub(crate) fn authored(asset: Asset) -> Self {
        Self {
            paths: vec![None; asset.clips.len()],
            asset,
            warnings: Vec::new(),
        }
    }

    fn of_stored(asset: &Asset, stored: ClipsInPlace) -> Self {
        let each = asset.clips.iter().zip(stored.travelling);
        let (clips, paths) = each
            .map(|(clip, travelling)| match travelling {
                Some((in_place, root_motion)) => (in_place, Some(root_motion)),
                None => (clip.clone(), None),
            })
            .unzip();
        Self {
            asset: Asset {
                rig: asset.rig.clone(),
                mesh: asset.mesh.clone(),
                clips,
            },
            paths,
            warnings: stored.warnings,
        }
    }
}

/// Removes the root motion of travelling clips.
pub(crate) fn in_place(
    figure: &Figure,
    root_motion: RootMotionPolicy,
    stored: Option<&Stored<'_>>,
) -> Result<CharacterInPlace> {
    let authored = &figure.asset;
    if root_motion == RootMotionPolicy::AsAuthored {
        return Ok(CharacterInPlace::authored(authored.clone()));
    }
    let found =
        stored.and_then(|s| s.clips_in_place(&authored.clips, &authored.rig, &authored.mesh));
    if let Some(found) = found {
        return Ok(CharacterInPlace::of_stored(authored, found));
    }
    let mut source = figure.source_character();
    let articulation = figure.opened.articulation();
    let ends = figure.opened.end_sites();
    let (ways, warnings) = put_in_place(&mut source, articulation, ends);
    if ways.iter().all(Option::is_none) {
        let mut own = CharacterInPlace::authored(authored.clone());
        own.warnings = warnings;
        return Ok(own);
    }
    let (mut clips, mut paths) = (Vec::new(), Vec::new());
    let each = ways.iter().zip(&source.clips).zip(&authored.clips);
    for ((way, in_place), authored_clip) in each {
        let Some(way) = way else {
            clips.push(authored_clip.clone());
            paths.push(None);
            continue;
        };
        let options = ClipOptions::default();
        let clip = sampled_clip(&source, in_place, &authored.mesh, &options)?;
        paths.push(Some(root_path(way, &clip)?));
        clips.push(clip);
    }
    Ok(CharacterInPlace {
        asset: Asset {
            rig: authored.rig.clone(),
            mesh: authored.mesh.clone(),
            clips,
        },
        paths,
        warnings,
    })
}

/// Bounds of a character in its clips, without a pose.
pub(crate) fn bounds_at_once(asset: &Asset) -> Result<MotionBounds> {
    reach_bounds(asset).context("bounds")
}

/// The full character as the only level.
pub(crate) fn level_at_once(asset: &Asset, opts: &JointLodOptions) -> Result<MergedLevels> {
    let joint_lods = JointLods::whole(&asset.rig).context("levels")?;
    let skins = level_skins(asset, &joint_lods, opts).context("skins")?;
    // Speed and seam decide about cached poses alone, of which there are none.
    let exact = ClipLodErrors {
        levels_metres: vec![0.0],
        worst_metres: vec![0.0],
        speed_metres_per_sec: 0.0,
        seam_metres: 0.0,
    };
    let errors = LodErrors {
        clips: vec![exact; asset.clips.len()],
    };
    Ok(MergedLevels {
        joint_lods,
        skins,
        far: None,
        errors,
    })
}

/// Bounds of a character in its clips.
pub(crate) fn bounds(asset: &Asset, stored: Option<&Stored<'_>>) -> Result<MotionBounds> {
    match stored.and_then(|s| s.bounds(&asset.clips)) {
        Some(bounds) => Ok(bounds),
        None => motion_bounds(asset, 0.0).context("bounds"),
    }
}

/// Joint LODs with their skins and errors, and the stored data that belongs to them: none where
/// they were computed.
pub(crate) fn joint_levels<'s, 'a>(
    asset: &Asset,
    wanted: &JointLodMethod,
    opts: &JointLodOptions,
    stored: Option<&'s Stored<'a>>,
    work: &Executor<'_>,
) -> Result<(MergedLevels, Option<&'s Stored<'a>>)> {
    let known = match wanted {
        JointLodMethod::Named(_) => None,
        _ => stored.and_then(|s| s.joint_levels(&asset.rig, asset.clips.len())),
    };
    let (joint_lods, errors) = match (wanted, known) {
        (JointLodMethod::Merged, Some(known)) => (known.joint_lods, Some(known.errors)),
        (JointLodMethod::Merged, None) => {
            let made = joint_lods(asset, &mean_pose(asset), opts);
            (made.context("levels")?, None)
        }
        (JointLodMethod::Whole, known) => {
            let errors = known.map(|known| of_full_detail(known.errors));
            (JointLods::whole(&asset.rig).context("levels")?, errors)
        }
        (JointLodMethod::Named(expression), _) => {
            let expressions = std::slice::from_ref(expression);
            let made = named_joint_lods(asset, &mean_pose(asset), expressions);
            (made.context("levels")?, None)
        }
    };
    work.step(PREPARING, 2, 5)?;
    // Skins and everything that follows from levels are those of the stored levels.
    let stored = stored.filter(|_| *wanted == JointLodMethod::Merged && errors.is_some());
    let skins = match stored.and_then(|s| s.skins(&asset.mesh, &joint_lods)) {
        Some(skins) => skins,
        None => level_skins(asset, &joint_lods, opts).context("skins")?,
    };
    work.step(PREPARING, 3, 5)?;
    let errors = match errors {
        Some(errors) => errors,
        None => lod_errors(asset, &joint_lods, &skins, opts).context("errors")?,
    };
    work.step(PREPARING, 4, 5)?;
    let levels = MergedLevels {
        joint_lods,
        skins,
        far: None,
        errors,
    };
    Ok((levels, stored))
}

/// Errors of level 0 alone.
fn of_full_detail(mut errors: LodErrors) -> LodErrors {
    for clip in &mut errors.clips {
        clip.levels_metres.truncate(1);
        clip.worst_metres.truncate(1);
    }
    errors
}

/// The pose cache of joint levels, or of their pairs with mesh levels.
pub(crate) fn pose_cache(
    asset: &Asset,
    levels: &MergedLevels,
    (clips, map): (&ClipSet, &PaletteMap),
    opts: &CacheOptions,
    stored: Option<(&Stored<'_>, bool)>,
) -> Result<PoseCache> {
    // Keys are chosen for the errors of palettes in full precision, and for as much room as is usual.
    let is_usual = opts.form == PaletteForm::Matrix
        && opts.palette_bytes >= CacheOptions::default().palette_bytes;
    if let Some((stored, is_paired)) = stored.filter(|_| is_usual) {
        let counts = (clips.clips(), levels.joint_lods.levels());
        let mut keys = stored.cache_keys(is_paired, counts);
        if let Some(keys) = keys.as_mut().filter(|_| stored.leaves_clips_out()) {
            close_gaps(keys, map);
        }
        match keys.map(|k| cache_of_keys(clips, map, (&k.keys, &k.steps), opts)) {
            Some(Ok(cache)) => return Ok(cache),
            Some(Err(error)) => stored.refuse("poseCache", &error.to_string()),
            None => {}
        }
    }
    let made = cached_poses(asset, levels, clips, opts).context("cache")?;
    Ok(made.cache)
}
