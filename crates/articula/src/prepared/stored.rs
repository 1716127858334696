//! Stored data of a document, checked against the character beside it.

use super::hash::{self, SourceHashes};
use super::part;
use super::state::{KeptMeshes, StoredState};
use crate::open::CharacterFile;
use articula_core::source::{RawClip, RawMesh};
use articula_core::{Clip, JointLods, LevelSkins, Mesh, MotionBounds, Rig};
use articula_formats::gltf::{Document, PreparedHeader, PreparedState};
use articula_formats::prepared::{
    CacheKeys, ClipsInPlace, JointLevels, PairedLevels, SourceOrder, read_cache_keys, read_clips,
    read_clips_in_place, read_joint_levels, read_level_skins, read_motion_bounds,
    read_paired_levels, read_source_orders, restore_order,
};
use articula_formats::{Limits, ReadError};
use std::cell::RefCell;

/// Version of the layout of every part.
pub(crate) const PART_VERSION: u64 = 1;

/// How to mend what is told about stored data.
const MEND: &str = "it is computed again; `articula build` renews it";

/// Stored data that belongs to the character of its document.
#[derive(Debug)]
pub(crate) struct Stored<'a> {
    document: &'a Document,
    header: PreparedHeader,
    /// Warnings about parts that were asked for and could not be used.
    warnings: RefCell<Vec<String>>,
}

impl StoredState {
    /// Compares the hashes of a document with its character.
    pub(crate) fn of(opened: &CharacterFile) -> Self {
        let mut state = Self::default();
        let Some(gltf) = &opened.gltf else {
            return state;
        };
        let header = match gltf.document.prepared() {
            PreparedState::Absent => return state,
            PreparedState::Unreadable(what) => {
                state
                    .stale
                    .push(format!("the prepared data cannot be read ({what}); {MEND}"));
                return state;
            }
            PreparedState::Present(header) => header,
        };
        let found = SourceHashes::of(&opened.character, &opened.articulation());
        let stored = |name: &str| header.hashes.iter().find(|h| h.0 == name).map(|h| h.1);
        let differs = |(name, hash): &(&'static str, u64)| stored(name) != Some(*hash);
        let changed: Vec<&str> = found
            .named()
            .iter()
            .filter(|h| differs(h))
            .map(|h| h.0)
            .collect();
        state.has_order = !changed.contains(&"mesh");
        // The caller knows that it has changed the clips.
        state.is_current = changed.is_empty() && !opened.clips_changed;
        if !opened.clips_changed && !changed.is_empty() {
            let of = |name: &&str| match *name {
                "rig" => "skeleton",
                "mesh" => "mesh",
                _ => "clips",
            };
            let changed: Vec<&str> = changed.iter().map(of).collect();
            state.stale.push(format!(
                "the prepared data does not belong to the {} of this file; {MEND}",
                changed.join(" and ")
            ));
        }
        state
    }
}

impl KeptMeshes {
    /// Remembers which meshes are about to be kept; stored data but the order of vertices is of the
    /// whole character.
    pub(crate) fn of(opened: &CharacterFile, is_kept: impl Fn(&str) -> bool) -> Self {
        let known = opened.gltf.as_ref().and_then(|g| g.kept_meshes.as_ref());
        let state = known.map_or_else(|| StoredState::of(opened), |known| known.state.clone());
        let each = opened.character.meshes.iter();
        let each = each.flat_map(|m| m.primitives.iter().map(|_| is_kept(&m.name)));
        let mut now = each.collect::<Vec<_>>().into_iter();
        let primitives = match known {
            None => now.collect(),
            Some(known) => {
                let before = known.primitives.iter();
                before
                    .map(|kept| *kept && now.next().unwrap_or(false))
                    .collect()
            }
        };
        Self {
            state: StoredState {
                is_current: false,
                ..state
            },
            primitives,
        }
    }
}

impl<'a> Stored<'a> {
    /// The stored data of a file whose [`StoredState`] is current.
    pub(crate) fn of(opened: &'a CharacterFile) -> Option<Self> {
        let document = &opened.gltf.as_ref()?.document;
        match document.prepared() {
            PreparedState::Present(header) => Some(Self {
                document,
                header,
                warnings: RefCell::default(),
            }),
            _ => None,
        }
    }

    pub(crate) fn seed(&self) -> u64 {
        self.header.seed
    }

    /// Number of mesh levels that joint levels were paired with, or 0.
    pub(crate) fn mesh_levels(&self) -> usize {
        self.header.mesh_levels
    }

    pub(crate) fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }

    /// Decodes a part; a damaged one is told, an absent one is not.
    fn read<T>(
        &self,
        name: &str,
        decode: impl FnOnce(&'a [u8], &Limits) -> Result<T, ReadError>,
    ) -> Option<T> {
        let part = self.document.prepared_part(name)?;
        let found = if part.version != PART_VERSION {
            Err(format!(
                "version {}, this program reads {PART_VERSION}",
                part.version
            ))
        } else if hash::bytes(part.bytes) != part.hash {
            Err("its bytes have changed".to_owned())
        } else {
            decode(part.bytes, &Limits::default()).map_err(|e| e.to_string())
        };
        match found {
            Ok(value) => Some(value),
            Err(what) => {
                let what = format!("the prepared part {name} cannot be used ({what}); {MEND}");
                self.warnings.borrow_mut().push(what);
                None
            }
        }
    }

    /// Whether mesh levels have reordered the vertices of the document. The hash of the order is
    /// among those of the source, so that its absence is noticed.
    pub(crate) fn is_reordered(&self) -> bool {
        self.header.hashes.iter().any(|h| h.0 == part::VERTEX_ORDER)
    }

    /// Meshes in the order of the source file, with that order for each primitive. `kept` tells for
    /// each mesh of the file whether it is among `meshes`.
    pub(crate) fn source_meshes(
        &self,
        meshes: &[RawMesh],
        kept: Option<&KeptMeshes>,
    ) -> Option<(Vec<SourceOrder>, Vec<RawMesh>)> {
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
            let levels = read_joint_levels(bytes, rig, limits)?;
            same_count("errors.clips", levels.errors.clips.len(), clips)?;
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
            let bounds = read_motion_bounds(bytes, limits)?;
            same_count("clips", bounds.clips.len(), clips.len())?;
            Ok(bounds)
        })
    }

    pub(crate) fn paired_levels(&self) -> Option<PairedLevels> {
        self.read(part::PAIRED_LEVELS, read_paired_levels)
    }

    /// Keys of the pose cache of joint LODs, or of their pairs with mesh levels.
    pub(crate) fn cache_keys(&self, is_paired: bool) -> Option<CacheKeys> {
        let name = if is_paired {
            part::PAIRED_POSE_CACHE
        } else {
            part::POSE_CACHE
        };
        self.read(name, read_cache_keys)
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
