//! Which stored data of a file belongs to its character.

use super::hash::SourceHashes;
use articula_core::Articulation;
use articula_core::source::{Character, RawMesh};
use articula_formats::gltf::{Document, PreparedState};

/// What follows from stored data that cannot be used, and how to renew it.
pub(super) const MEND: &str = "it is computed again; `articula build` renews it";

/// Which stored data of a file belongs to its character.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct StoredState {
    /// All parts may be read.
    pub(crate) is_current: bool,
    /// The order of vertices may be read.
    pub(crate) has_order: bool,
    /// What is stale, as text for the user.
    pub(crate) stale: Vec<String>,
}

/// The state of a file's stored data before meshes were removed from the character.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct KeptMeshes {
    pub(crate) state: StoredState,
    /// Whether each primitive of all meshes is kept.
    pub(crate) primitives: Vec<bool>,
}

impl StoredState {
    /// Compares the hashes of a document with the character beside it. Clips that were changed on
    /// purpose make its data unusable, but not stale.
    pub(crate) fn of(
        document: &Document,
        character: &Character,
        articulation: &Articulation,
        clips_changed: bool,
    ) -> Self {
        let mut state = Self::default();
        let header = match document.prepared() {
            PreparedState::Absent => return state,
            PreparedState::Unreadable(what) => {
                state
                    .stale
                    .push(format!("the prepared data cannot be read ({what}); {MEND}"));
                return state;
            }
            PreparedState::Present(header) => header,
        };
        let found = SourceHashes::of(character, articulation);
        let stored = |name: &str| header.hashes.iter().find(|h| h.0 == name).map(|h| h.1);
        if stored("clips").is_none() {
            // The clips were replaced, and what was computed from them is gone.
            state.has_order = stored("mesh") == Some(found.mesh);
            return state;
        }
        let differs = |(name, hash): &(&'static str, u64)| stored(name) != Some(*hash);
        let changed: Vec<&str> = found
            .named()
            .iter()
            .filter(|h| differs(h))
            .map(|h| h.0)
            .collect();
        state.has_order = !changed.contains(&"mesh");
        state.is_current = changed.is_empty() && !clips_changed;
        if !clips_changed && !changed.is_empty() {
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
    /// Remembers which of these meshes are about to be kept, and the state of the stored data; all of
    /// that but the order of vertices is of the whole character. `before` is what was remembered when
    /// meshes were removed already.
    pub(crate) fn of(
        before: Option<&Self>,
        state: StoredState,
        meshes: &[RawMesh],
        kept: &[bool],
    ) -> Self {
        let each = meshes.iter().zip(kept);
        let mut now = each.flat_map(|(mesh, kept)| mesh.primitives.iter().map(|_| *kept));
        let primitives = match before {
            None => now.collect(),
            Some(before) => {
                let before = before.primitives.iter();
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
