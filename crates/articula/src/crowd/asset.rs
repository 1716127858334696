//! The character of a crowd: its levels with their skins and errors, and its bounds.

use super::impostors::CrowdImpostors;
use super::material_ranges::{MaterialRange, material_ranges};
use super::mesh_choice::{levelled, mesh_levels};
use super::mesh_lods::{LevelledMeshes, MeshLods};
use super::options::{CrowdOptions, JointLodMethod, PaletteMatrices, RootMotionPolicy};
use super::preparation::{
    CharacterInPlace, PREPARING, bounds, bounds_at_once, in_place, joint_levels, level_at_once,
};
use super::shared_model::{Shown, drawn_triangles, model};
use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use crate::open::choose;
use crate::prepared::stored::Stored;
use crate::work::Executor;
use articula_build::{Asset, JointLodOptions, skin_of};
use articula_core::crowd::CrowdModel;
use articula_core::{Clip, Impostors, JointLods, LevelSkins, Mesh, Tracks};
use std::sync::Arc;

/// A character prepared for crowds. Cheap to clone: clones share the data.
#[derive(Debug, Clone)]
pub struct CrowdAsset(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    full: Asset,
    skins: LevelSkins,
    meshes: Vec<Mesh>,
    /// Triangles of the mesh of each level by material.
    ranges: Vec<Vec<MaterialRange>>,
    mesh_lods: Option<MeshLods>,
    model: CrowdModel,
    matrices: PaletteMatrices,
    impostors: Option<CrowdImpostors>,
    has_mesh: bool,
    travels: Vec<bool>,
    warnings: Vec<String>,
}

/// What an asset is made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Effort {
    /// All that its options ask for.
    Whole,
    /// What needs no measurement.
    AtOnce,
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

impl CrowdLevel {
    /// An impostor: two triangles without joints.
    pub(super) const IMPOSTOR: Self = Self {
        joints: 0,
        matrices: 0,
        vertices: 4,
        triangles: 2,
        influences: 0,
    };
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
        Self::of_figure(figure, (options, Effort::Whole), work)
            .with_context(|| figure.opened.name())
    }

    /// A character of full detail, each with a pose of its own, for the first frames: nothing is measured or
    /// simplified, so it is made in a fraction of the time. [`new`](Self::new) with the same options makes
    /// the asset that [`CrowdPlayer::set_asset`](super::CrowdPlayer::set_asset) replaces it by. Bounds are
    /// wider than those, so that more is drawn of who is nearly in view.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn at_once(figure: &Figure, options: &CrowdOptions) -> Result<Self> {
        let plain = CrowdOptions {
            joints: JointLodMethod::Whole,
            mesh_levels: Some(1),
            pose_cache: false,
            #[cfg(feature = "flat")]
            impostors: None,
            baked_impostors: None,
            ..options.clone()
        };
        let made = Self::of_figure(figure, (&plain, Effort::AtOnce), &Executor::default());
        made.with_context(|| figure.opened.name())
    }

    fn of_figure(
        figure: &Figure,
        (options, effort): (&CrowdOptions, Effort),
        work: &Executor<'_>,
    ) -> Result<Self> {
        let mut stored = figure.stored();
        let mut character = in_place(figure, options.root_motion, stored.as_ref())?;
        let kept = kept_clips(&character.asset.clips, &options.clips)?;
        keep(&mut character.asset.clips, &kept);
        keep(&mut character.paths, &kept);
        if let Some(stored) = &mut stored {
            stored.keep_clips(kept);
        }
        character
            .warnings
            .extend(unmapped(&character.asset, &options.joints));
        // Stored levels are those of clips in place.
        let levels = stored.as_ref().filter(|s| {
            s.seed() == options.seed && options.root_motion != RootMotionPolicy::AsAuthored
        });
        let mut crowd = Self::prepared(character, (Some(figure), levels), (options, effort), work)?;
        if let (Some(shared), Some(stored)) = (Arc::get_mut(&mut crowd.0), stored) {
            shared.warnings.extend(stored.into_warnings());
        }
        Ok(crowd)
    }

    /// Prepares an [`Asset`] that is already built; all clips are used as they are.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) if the options do not fit the character, or
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn from_asset(asset: Asset, options: &CrowdOptions, work: &Executor<'_>) -> Result<Self> {
        let character = CharacterInPlace::authored(asset);
        Self::prepared(character, (None, None), (options, Effort::Whole), work)
    }

    fn prepared(
        character: CharacterInPlace,
        (figure, stored): (Option<&Figure>, Option<&Stored<'_>>),
        (options, effort): (&CrowdOptions, Effort),
        work: &Executor<'_>,
    ) -> Result<Self> {
        let CharacterInPlace {
            mut asset,
            mut paths,
            mut warnings,
        } = character;
        work.step(PREPARING, 0, 5)?;
        // A clip is added to a character without one, so what is stored does not fit.
        let stored = stored.filter(|_| !asset.clips.is_empty());
        if asset.clips.is_empty() {
            warnings.push("the file has no clip: all characters show the rest pose".to_owned());
            asset.clips.push(rest(asset.rig.len())?);
            paths.push(None);
        }
        let has_mesh = !asset.mesh.is_empty();
        // Before points replace a missing mesh, since bounds from joints are better than from
        // points.
        let bounds = match effort {
            Effort::Whole => bounds(&asset, stored)?,
            Effort::AtOnce => bounds_at_once(&asset)?,
        };
        work.step(PREPARING, 1, 5)?;
        if !has_mesh {
            warnings.push("the file has no mesh: points on the bones replace the skin".to_owned());
            asset.mesh = skin_of(&asset).into_owned().into();
        }
        let stored = stored.filter(|_| has_mesh);
        let opts = JointLodOptions {
            seed: options.seed,
            ..JointLodOptions::default()
        };
        let (levels, stored) = match effort {
            Effort::Whole => joint_levels(&asset, &options.joints, &opts, stored, work)?,
            Effort::AtOnce => (level_at_once(&asset, &opts)?, None),
        };
        let triangles = match has_mesh {
            true => mesh_levels(figure, &asset, options, stored.is_some(), &mut warnings)?,
            false => None,
        };
        let levelled = levelled(&asset, levels, triangles, &opts, stored)?;
        let LevelledMeshes {
            mesh_lods,
            levels,
            mut meshes,
            is_stored,
        } = levelled;
        let ranges = meshes.iter_mut().map(material_ranges).collect();
        let travels = paths.iter().map(Option::is_some).collect();
        if options.root_motion != RootMotionPolicy::Extracted {
            paths.fill(None);
        }
        let stored = stored.filter(|_| is_stored);
        let stored = stored.map(|stored| (stored, mesh_lods.is_some()));
        let (impostors, table) = match has_mesh {
            true => impostors(&asset, options, work)?,
            false => (None, None),
        };
        let shown = Shown {
            bounds,
            paths,
            impostors: table,
            triangles: drawn_triangles(mesh_lods.as_ref()),
        };
        let model = model(&asset, &levels, shown, options, stored)?;
        work.step(PREPARING, 5, 5)?;
        Ok(Self(Arc::new(Shared {
            travels,
            full: asset,
            skins: levels.skins,
            meshes,
            ranges,
            mesh_lods,
            model,
            matrices: options.matrices,
            impostors,
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

    /// Returns the clips of which no level has cached poses to blend, so that all who play them are
    /// evaluated: they jump from frame to frame, or there is no room. Empty without a cache.
    pub fn uncached_clips(&self) -> impl Iterator<Item = &Clip> {
        let cache = self.0.model.parts().cache.as_ref();
        let levels = self.levels();
        let is_cached = move |clip: usize| match cache {
            Some(cache) => (0..levels).any(|level| cache.error_metres(clip, level).is_some()),
            None => true,
        };
        let clips = self.clips().iter().enumerate();
        clips.filter_map(move |(i, clip)| (!is_cached(i)).then_some(clip))
    }

    /// Returns whether a clip had root motion before it was put in place.
    pub fn travels(&self, clip: usize) -> bool {
        self.0.travels.get(clip).is_some_and(|t| *t)
    }

    /// Returns the number of levels; 0 is full detail.
    pub fn levels(&self) -> usize {
        self.0.model.parts().clips.joint_lods().levels()
    }

    /// Returns the mesh of a level; its bindings are the first matrices of a skinning palette, and its
    /// triangles are sorted by material.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn mesh(&self, level: usize) -> &Mesh {
        &self.0.meshes[level]
    }

    /// Returns the triangles of a level by material: what is drawn in one call each, or together with the range before
    /// where [`joins_previous`](MaterialRange::joins_previous).
    ///
    /// # Panics
    /// If there is no such level.
    pub fn material_ranges(&self, level: usize) -> &[MaterialRange] {
        &self.0.ranges[level]
    }

    /// Number of draws of a level: of its materials those that differ in colour alone are one.
    pub(super) fn draws(&self, level: usize) -> usize {
        let ranges = self.0.ranges[level].iter();
        ranges.filter(|range| !range.joins_previous).count()
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

    /// Returns the impostors, if the options ask for them.
    pub(super) fn own_impostors(&self) -> Option<&CrowdImpostors> {
        self.0.impostors.as_ref()
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

/// The impostors that the options ask for, with the table that a frame reads.
fn impostors(
    asset: &Asset,
    options: &CrowdOptions,
    work: &Executor<'_>,
) -> Result<(Option<CrowdImpostors>, Option<Impostors>)> {
    if let Some(baked) = &options.baked_impostors {
        if options.root_motion == RootMotionPolicy::AsAuthored {
            let what = "impostors show clips on the spot; root motion cannot be as authored";
            return Err(Error::unsuited(what));
        }
        return Ok((None, Some(baked.table(&asset.clips)?)));
    }
    let chosen = CrowdImpostors::chosen(asset, options, work)?;
    let table = chosen.as_ref().map(CrowdImpostors::table).transpose()?;
    Ok((chosen, table))
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

/// A clip of one frame without channels.
fn rest(joints: usize) -> Result<Clip> {
    Ok(Clip::new("rest pose", 1.0, 1, joints, Tracks::default())?)
}
