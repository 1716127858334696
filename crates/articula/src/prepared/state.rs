//! Which stored data of a file belongs to its character.

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
