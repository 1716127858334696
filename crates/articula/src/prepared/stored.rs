//! Stored data of a document, checked against the character beside it.

use super::hash;
use super::part;
use super::state::{KeptMeshes, MEND};
use articula_build::hash_bytes;
use articula_core::source::{RawClip, RawMesh};
use articula_core::{Clip, FigureLevel, JointLods, LevelSkins, Mesh, MotionBounds, Rig};
use articula_formats::gltf::{Document, PreparedHeader, PreparedState};
use articula_formats::prepared::{
    CacheKeys, ClipsInPlace, JointLevels, PairedLevels, SourceOrder, read_cache_keys, read_clips,
    read_clips_in_place, read_joint_levels, read_level_skins, read_motion_bounds,
    read_paired_levels, read_source_orders, restore_order,
};
use articula_formats::{Limits, ReadError};
use std::cell::RefCell;

/// Data that a document stores; whether it belongs to the character is a
/// [`StoredState`](super::state::StoredState).
#[derive(Debug)]
pub(crate) struct Stored<'a> {
    document: &'a Document,
    meshes: &'a [RawMesh],
    header: PreparedHeader,
    /// Which of its clips are played; all without.
    kept: Option<Vec<bool>>,
    /// Warnings about parts that were asked for and could not be used.
    warnings: RefCell<Vec<String>>,
}

impl<'a> Stored<'a> {
    /// The data that a document stores beside these meshes, if it can be read.
    pub(crate) fn of(document: &'a Document, meshes: &'a [RawMesh]) -> Option<Self> {
        match document.prepared() {
            PreparedState::Present(header) => Some(Self {
                document,
                meshes,
                header,
                kept: None,
                warnings: RefCell::default(),
            }),
            _ => None,
        }
    }

    /// Leaves out clips from what is read from now on.
    pub(crate) fn keep_clips(&mut self, kept: Vec<bool>) {
        self.kept = Some(kept);
    }

    /// Whether any clip is left out.
    pub(crate) fn leaves_clips_out(&self) -> bool {
        let mut kept = self.kept.iter().flatten();
        kept.any(|kept| !kept)
    }

    /// Checks a list with an entry for each stored clip, and leaves out those of clips that are not kept.
    fn kept<T>(&self, at: &str, entries: &mut Vec<T>, clips: usize) -> Result<(), ReadError> {
        if let Some(kept) = &self.kept {
            same_count(at, entries.len(), kept.len())?;
            let mut each = kept.iter();
            entries.retain(|_| each.next().is_some_and(|kept| *kept));
        }
        same_count(at, entries.len(), clips)
    }

    pub(crate) fn seed(&self) -> u64 {
        self.header.seed
    }

    /// Number of mesh levels that joint levels were paired with; 0 if there are none, or the meshes
    /// have other levels now.
    pub(crate) fn mesh_levels(&self) -> usize {
        if self.header.mesh_levels == 0 {
            return 0;
        }
        if self.hash(part::MESH_LEVELS) != Some(hash::mesh_levels(self.meshes)) {
            let what = format!(
                "the prepared data does not belong to the mesh levels of this file; {MEND}"
            );
            self.warn(what);
            return 0;
        }
        self.header.mesh_levels
    }

    /// A hash of the source.
    fn hash(&self, name: &str) -> Option<u64> {
        let found = self.header.hashes.iter().find(|h| h.0 == name);
        found.map(|h| h.1)
    }

    /// Adds a warning once.
    fn warn(&self, what: String) {
        let mut warnings = self.warnings.borrow_mut();
        if !warnings.contains(&what) {
            warnings.push(what);
        }
    }

    /// Adds a warning that a part cannot be used.
    pub(crate) fn refuse(&self, name: &str, why: &str) {
        self.warn(format!(
            "the prepared part {name} cannot be used ({why}); {MEND}"
        ));
    }

    pub(crate) fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }

    /// Decodes a part; `None` with a warning if it is damaged, without one if it is not listed.
    fn read<T>(
        &self,
        name: &str,
        decode: impl FnOnce(&'a [u8], &Limits) -> Result<T, ReadError>,
    ) -> Option<T> {
        self.read_version(name, |bytes, _, limits| decode(bytes, limits))
    }

    /// Decodes a part of which earlier versions are read too.
    fn read_version<T>(
        &self,
        name: &str,
        decode: impl FnOnce(&'a [u8], u64, &Limits) -> Result<T, ReadError>,
    ) -> Option<T> {
        let Some(part) = self.document.prepared_part(name) else {
            if self.document.lists_prepared_part(name) {
                self.refuse(name, "its entry is malformed, or its bytes are missing");
            }
            return None;
        };
        let known = part::version(name);
        let found = if !(1..=known).contains(&part.version) {
            let found = part.version;
            Err(match known {
                1 => format!("version {found}, this program reads 1"),
                _ => format!("version {found}, this program reads 1 to {known}"),
            })
        } else if hash_bytes(part.bytes) != part.hash {
            Err("its bytes have changed".to_owned())
        } else {
            decode(part.bytes, part.version, &Limits::default()).map_err(|e| e.to_string())
        };
        match found {
            Ok(value) => Some(value),
            Err(what) => {
                self.refuse(name, &what);
                None
            }
        }
    }

    /// Whether mesh levels have reordered the vertices of the document. The hash of the order is
    /// among those of the source, so that its absence is noticed.
    pub(crate) fn is_reordered(&self) -> bool {
        self.hash(part::VERTEX_ORDER).is_some()
    }

    /// Meshes in the order of the source file, with that order for each primitive. `kept` tells for
    /// each mesh of the file whether it is among `meshes`.
    pub(crate) fn source_meshes(
        &self,
        meshes: &[RawMesh],
        kept: Option<&KeptMeshes>,
    ) -> Option<(Vec<SourceOrder>, Vec<RawMesh>)> {
        let part = self.document.prepared_part(part::VERTEX_ORDER);
        if part.map(|p| p.hash) != self.hash(part::VERTEX_ORDER) {
            self.refuse(
                part::VERTEX_ORDER,
                "it is missing or belongs to another file",
            );
            return None;
        }
        self.read(part::VERTEX_ORDER, |bytes, limits| {
            let mut orders = read_source_orders(bytes, limits)?;
            if let Some(kept) = kept {
                let mut is_kept = kept.primitives.iter();
                orders.retain(|_| is_kept.next().is_some_and(|kept| *kept));
            }
            let meshes = restore_order(meshes, &orders);
            let meshes = meshes.map_err(|e| malformed(e.at, e.what))?;
            Ok((orders, meshes))
        })
    }

    /// The clips at a uniform rate, if they are of this rig and as many as the source has.
    pub(crate) fn clips(&self, sources: &[RawClip], rig: &Rig, mesh: &Mesh) -> Option<Vec<Clip>> {
        self.read(part::CLIPS, |bytes, limits| {
            let clips = read_clips(bytes, sources, limits)?;
            check_clips(clips.iter(), rig, mesh)?;
            same_count("clips", clips.len(), sources.len())?;
            Ok(clips)
        })
    }

    pub(crate) fn clips_in_place(
        &self,
        authored: &[Clip],
        rig: &Rig,
        mesh: &Mesh,
    ) -> Option<ClipsInPlace> {
        self.read(part::CLIPS_IN_PLACE, |bytes, limits| {
            let found = read_clips_in_place(bytes, authored, limits)?;
            check_clips(found.travelling.iter().flatten().map(|t| &t.0), rig, mesh)?;
            same_count("clips", found.travelling.len(), authored.len())?;
            Ok(found)
        })
    }

    pub(crate) fn joint_levels(&self, rig: &Rig, clips: usize) -> Option<JointLevels> {
        self.read(part::JOINT_LEVELS, |bytes, limits| {
            let mut levels = read_joint_levels(bytes, rig, limits)?;
            self.kept("errors.clips", &mut levels.errors.clips, clips)?;
            Ok(levels)
        })
    }

    pub(crate) fn skins(&self, mesh: &Mesh, joint_lods: &JointLods) -> Option<LevelSkins> {
        self.read(part::SKINS, |bytes, limits| {
            read_level_skins(bytes, mesh, joint_lods, limits)
        })
    }

    pub(crate) fn bounds(&self, clips: &[Clip]) -> Option<MotionBounds> {
        self.read(part::BOUNDS, |bytes, limits| {
            let mut bounds = read_motion_bounds(bytes, limits)?;
            self.kept("clips", &mut bounds.clips, clips.len())?;
            Ok(bounds)
        })
    }

    /// Pairs of these joint LODs with mesh levels.
    pub(crate) fn paired_levels(
        &self,
        joint_lods: &JointLods,
        clips: usize,
        mesh_levels: usize,
    ) -> Option<PairedLevels> {
        self.read(part::PAIRED_LEVELS, |bytes, limits| {
            let mut paired = read_paired_levels(bytes, limits)?;
            self.kept("errors.clips", &mut paired.errors.clips, clips)?;
            let fits = |level: &FigureLevel| {
                level.joint_level < joint_lods.levels()
                    && level.joints == joint_lods.joint_count(level.joint_level)
                    && level.mesh_level < mesh_levels
                    && level.influences > 0
            };
            let is_full = |level: &FigureLevel| (level.joint_level, level.mesh_level) == (0, 0);
            if !paired.levels.first().is_some_and(is_full) || !paired.levels.iter().all(fits) {
                return Err(malformed("levels", "belong to other joint or mesh levels"));
            }
            Ok(paired)
        })
    }

    /// Keys of the pose cache of joint LODs, or of their pairs with mesh levels.
    pub(crate) fn cache_keys(
        &self,
        is_paired: bool,
        (clips, levels): (usize, usize),
    ) -> Option<CacheKeys> {
        let name = match is_paired {
            true => part::PAIRED_POSE_CACHE,
            false => part::POSE_CACHE,
        };
        self.read_version(name, |bytes, version, limits| {
            let mut keys = read_cache_keys(bytes, version, limits)?;
            self.kept("clips", &mut keys.keys, clips)?;
            self.kept("clips", &mut keys.steps, clips)?;
            for of_clip in &keys.keys {
                same_count("levels", of_clip.len(), levels)?;
            }
            Ok(keys)
        })
    }
}

fn same_count(at: &str, found: usize, expected: usize) -> Result<(), ReadError> {
    if found == expected {
        return Ok(());
    }
    Err(malformed(
        at,
        format!("{found} entries, expected {expected}"),
    ))
}

fn check_clips<'a>(
    clips: impl Iterator<Item = &'a Clip>,
    rig: &Rig,
    mesh: &Mesh,
) -> Result<(), ReadError> {
    let slots = mesh.morph_weights.len();
    for clip in clips {
        let mut morphs = clip.tracks().morphs.iter();
        if clip.joints() != rig.len() || morphs.any(|t| usize::from(t.target) >= slots) {
            let what = "belongs to another rig or mesh";
            return Err(malformed(format!("clip \"{}\"", clip.name), what));
        }
    }
    Ok(())
}

fn malformed(at: impl Into<String>, what: impl Into<String>) -> ReadError {
    ReadError::Malformed {
        at: at.into(),
        what: what.into(),
    }
}
