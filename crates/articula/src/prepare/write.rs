//! Computation and storage of the parts of `ARTICULA_prepared`.

use super::options::PrepareOptions;
use super::part::PreparedPart;
use crate::crowd::RootMotionPolicy;
use crate::crowd::mesh_lods::{MeshLods, canonical};
use crate::crowd::preparation::{CharacterInPlace, bounds, in_place, joint_levels};
use crate::crowd::{ClipStorage, JointLodMethod, MAX_MESH_LEVELS, PaletteForm};
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::prepared::hash::{self, SourceHashes};
use crate::prepared::part;
use crate::work::Executor;
use articula_build::{
    Asset, CacheOptions, JointLodOptions, MergedLevels, cached_poses, hash_bytes,
};
use articula_core::source::Character;
use articula_core::{Articulation, ClipSet};
use articula_formats::gltf::{Document, PreparedEntry, PreparedHeader};
use articula_formats::prepared::{
    ClipsInPlace, JointLevels, PairedLevels, SourceOrder, write_cache_keys, write_clips,
    write_clips_in_place, write_joint_levels, write_level_skins, write_motion_bounds,
    write_paired_levels, write_source_orders,
};

/// The parts of an asset as bytes.
#[derive(Debug, Default)]
pub(super) struct Parts {
    entries: Vec<(&'static str, Vec<u8>)>,
    seed: u64,
    mesh_levels: usize,
    /// Size of the palettes that the keys of the pose cache stand for.
    pub(super) pose_cache_bytes: usize,
}

impl Parts {
    /// Number of bytes of a part.
    pub(super) fn bytes(&self, part: PreparedPart) -> usize {
        let own = self
            .entries
            .iter()
            .filter(|e| part.entries().contains(&e.0));
        own.map(|e| e.1.len()).sum()
    }

    /// Stores the parts beside the character that the document shows.
    pub(super) fn store(&self, document: &mut Document, shown: &ShownHashes) {
        let mut hashes: Vec<(String, u64)> = Vec::new();
        let named = shown.source.named();
        hashes.extend(named.map(|(name, hash)| (name.to_owned(), hash)));
        let entry = |(name, bytes): &(&'static str, Vec<u8>)| (*name, hash_bytes(bytes));
        let sums: Vec<(&str, u64)> = self.entries.iter().map(entry).collect();
        let order = sums.iter().find(|(name, _)| *name == part::VERTEX_ORDER);
        hashes.extend(order.map(|(name, hash)| ((*name).to_owned(), *hash)));
        if self.mesh_levels > 0 {
            hashes.push((part::MESH_LEVELS.to_owned(), shown.mesh_levels));
        }
        let header = PreparedHeader {
            generator: concat!("Articula ", env!("CARGO_PKG_VERSION")).to_owned(),
            seed: self.seed,
            hashes,
            mesh_levels: self.mesh_levels,
        };
        let entries = self.entries.iter().zip(&sums);
        let entries = entries.map(|((name, bytes), (_, hash))| PreparedEntry {
            name,
            version: part::version(name),
            hash: *hash,
            bytes,
        });
        document.set_prepared(&header, &entries.collect::<Vec<_>>());
    }
}

/// Hashes of a character as a reader of its document finds it.
#[derive(Debug)]
pub(super) struct ShownHashes {
    source: SourceHashes,
    mesh_levels: u64,
}

impl ShownHashes {
    /// The hashes of a character that was read from a document; `articulation` is stored beside it, if
    /// it is not already.
    pub(super) fn of(character: &Character, articulation: &Articulation) -> Self {
        let read = character.articulation.as_ref().unwrap_or(articulation);
        Self {
            source: SourceHashes::of(character, read),
            mesh_levels: hash::mesh_levels(&character.meshes),
        }
    }
}

/// Mesh levels of the document that parts are stored in.
pub(super) struct DocumentLevels<'a> {
    /// Triangles of each level over the vertices of the figure's mesh.
    pub(super) triangles: Option<Vec<Vec<[u32; 3]>>>,
    /// Order of the figure's vertices in the document, if the levels have changed it.
    pub(super) orders: Option<&'a [SourceOrder]>,
}

/// Whether mesh levels are paired with joint levels: there are several, as many as a crowd takes at
/// most, and each has triangles.
pub(super) fn can_be_paired(triangles: &[Vec<[u32; 3]>]) -> bool {
    (2..=MAX_MESH_LEVELS).contains(&triangles.len()) && !triangles.iter().any(Vec::is_empty)
}

/// Computes the parts for a figure in the order of its source.
pub(super) fn parts(
    figure: &Figure,
    levels: DocumentLevels<'_>,
    options: &PrepareOptions,
    work: &Executor<'_>,
) -> Result<Parts> {
    let mut parts = Parts {
        seed: options.seed,
        ..Parts::default()
    };
    let is_wanted = |part| options.wants(part);
    if let Some(orders) = levels.orders {
        parts
            .entries
            .push((part::VERTEX_ORDER, write_source_orders(orders)));
    }
    let clips = &figure.asset.clips;
    if clips.is_empty() {
        return Ok(parts);
    }
    let character = in_place(figure, RootMotionPolicy::OnTheSpot, None)?;
    if is_wanted(PreparedPart::Clips) {
        parts.entries.push((
            part::CLIPS,
            write_clips(clips, &figure.opened.character().clips),
        ));
        let in_place = write_clips_in_place(&stored_form(&character), clips);
        parts.entries.push((part::CLIPS_IN_PLACE, in_place));
    }
    if is_wanted(PreparedPart::Bounds) {
        let bounds = bounds(&character.asset, None)?;
        parts
            .entries
            .push((part::BOUNDS, write_motion_bounds(&bounds)));
    }
    let of_levels = [
        PreparedPart::JointLevels,
        PreparedPart::Skins,
        PreparedPart::PairedLevels,
        PreparedPart::PoseCache,
    ];
    if !character.asset.mesh.is_empty() && of_levels.into_iter().any(is_wanted) {
        parts.levels(&character, levels.triangles, options, work)?;
    }
    Ok(parts)
}

impl Parts {
    /// Adds the levels of joints, and their pairs with mesh levels.
    fn levels(
        &mut self,
        character: &CharacterInPlace,
        triangles: Option<Vec<Vec<[u32; 3]>>>,
        options: &PrepareOptions,
        work: &Executor<'_>,
    ) -> Result<()> {
        let is_wanted = |part| options.wants(part);
        let asset = &character.asset;
        let opts = JointLodOptions {
            seed: options.seed,
            ..JointLodOptions::default()
        };
        let (levels, _) = joint_levels(asset, &JointLodMethod::Merged, &opts, None, work)?;
        if is_wanted(PreparedPart::JointLevels) {
            let stored = JointLevels {
                joint_lods: levels.joint_lods.clone(),
                errors: levels.errors.clone(),
            };
            self.entries
                .push((part::JOINT_LEVELS, write_joint_levels(&stored)));
        }
        if is_wanted(PreparedPart::Skins) {
            let skins = write_level_skins(&levels.skins, &asset.mesh);
            self.entries.push((part::SKINS, skins));
        }
        if is_wanted(PreparedPart::PoseCache) {
            self.cache(part::POSE_CACHE, asset, &levels, options)?;
        }
        let pairs = [PreparedPart::PairedLevels, PreparedPart::PoseCache];
        let Some(triangles) = triangles.filter(|_| pairs.into_iter().any(is_wanted)) else {
            return Ok(());
        };
        if !can_be_paired(&triangles) {
            return Ok(());
        }
        self.mesh_levels = triangles.len();
        let made = MeshLods::paired(asset, &levels, canonical(triangles), &opts, None)?;
        let (lods, paired) = (made.mesh_lods, made.levels);
        if is_wanted(PreparedPart::PairedLevels) {
            let stored = PairedLevels {
                levels: lods.map(|lods| lods.levels).unwrap_or_default(),
                errors: paired.errors.clone(),
            };
            self.entries
                .push((part::PAIRED_LEVELS, write_paired_levels(&stored)));
        }
        if is_wanted(PreparedPart::PoseCache) {
            self.cache(part::PAIRED_POSE_CACHE, asset, &paired, options)?;
        }
        Ok(())
    }

    fn cache(
        &mut self,
        name: &'static str,
        asset: &Asset,
        levels: &MergedLevels,
        options: &PrepareOptions,
    ) -> Result<()> {
        let joint_lods = levels.joint_lods.clone();
        let clips = ClipSet::new(&asset.rig, joint_lods, &asset.clips, ClipStorage::Float)?;
        let opts = CacheOptions {
            form: PaletteForm::Matrix,
            seed: options.seed,
            ..CacheOptions::default()
        };
        let cached = cached_poses(asset, levels, &clips, &opts).context("cache")?;
        self.pose_cache_bytes += cached.cache.bytes();
        let keys = write_cache_keys(&cached.keys, &cached.steps);
        self.entries.push((name, keys));
        Ok(())
    }
}

/// The form in which an asset stores clips in place.
fn stored_form(character: &CharacterInPlace) -> ClipsInPlace {
    let clips = character.paths.iter().zip(&character.asset.clips);
    let travelling = clips.map(|(path, clip)| Some((clip.clone(), path.clone()?)));
    ClipsInPlace {
        travelling: travelling.collect(),
        warnings: character.warnings.clone(),
    }
}
