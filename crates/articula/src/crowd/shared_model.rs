//! The data that all characters of a crowd share.

use super::face_levels::morph_clips;
use super::mesh_lods::MeshLods;
use super::named_events::events_by_clip;
use super::options::{CrowdOptions, PaletteMatrices};
use super::preparation::pose_cache;
use crate::error::Result;
use crate::prepared::stored::Stored;
use articula_build::{Asset, CacheOptions, MergedLevels};
use articula_core::crowd::{CrowdModel, CrowdParts, RootTrajectory};
use articula_core::{ClipSet, ClipStorage, Impostors, MotionBounds, PaletteForm, PaletteMap};

/// What is known of a character beside its levels.
pub(super) struct Shown {
    pub(super) bounds: MotionBounds,
    pub(super) paths: Vec<Option<RootTrajectory>>,
    pub(super) impostors: Option<Impostors>,
    /// Triangles of each level; empty where all draw the same.
    pub(super) triangles: Vec<u32>,
}

/// Triangles of each level; none without mesh levels.
pub(super) fn drawn_triangles(mesh_lods: Option<&MeshLods>) -> Vec<u32> {
    let levels = mesh_lods.map_or(&[][..], |lods| &lods.levels);
    levels.iter().map(|level| level.triangles as u32).collect()
}

/// Builds the data that all characters share: clips, palettes, errors and, on request, cached
/// poses.
pub(super) fn model(
    asset: &Asset,
    levels: &MergedLevels,
    shown: Shown,
    options: &CrowdOptions,
    stored: Option<(&Stored<'_>, bool)>,
) -> Result<CrowdModel> {
    let palette = match options.matrices {
        PaletteMatrices::Joints => PaletteMap::joints(&levels.joint_lods),
        PaletteMatrices::Skin => levels.skins.palette.clone(),
    };
    let joint_lods = levels.joint_lods.clone();
    let clips = ClipSet::new(&asset.rig, joint_lods, &asset.clips, options.storage)?;
    let is_cacheable = options.matrices == PaletteMatrices::Skin
        && matches!(options.form, PaletteForm::Matrix | PaletteForm::HalfMatrix);
    let cache = if options.pose_cache && is_cacheable {
        let opts = CacheOptions {
            form: options.form,
            seed: options.seed,
            palette_bytes: options.cache_bytes,
            ..CacheOptions::default()
        };
        // Keys are chosen for clips as they are sampled.
        let stored = stored.filter(|_| options.storage == ClipStorage::Float);
        let map = &levels.skins.palette;
        Some(pose_cache(asset, levels, (&clips, map), &opts, stored)?)
    } else {
        None
    };
    let mut errors = levels.errors.clone();
    let morphs = morph_clips(asset, &mut errors)?;
    Ok(CrowdModel::new(CrowdParts {
        events: events_by_clip(&options.events, &asset.clips)?,
        form: options.form,
        backend: options.backend,
        paths: shown.paths,
        cache,
        impostors: shown.impostors,
        triangles: shown.triangles,
        morphs,
        ..CrowdParts::new(clips, palette, errors, shown.bounds)
    })?)
}
