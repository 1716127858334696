//! Names by which a document stores the parts of an asset's preparation.

use articula_formats::prepared::CACHE_KEYS_VERSION;

/// Version of the layout of an entry.
pub(crate) fn version(entry: &str) -> u64 {
    match entry {
        POSE_CACHE | PAIRED_POSE_CACHE => CACHE_KEYS_VERSION,
        _ => 1,
    }
}

/// Names of the tables of animations.
pub(crate) const SEGS: &str = "segs";
pub(crate) const POSE_KEYS: &str = "posekeys";
pub(crate) const ERROR_MATRIX: &str = "errors";
pub(crate) const CONTACTS: &str = "contacts";
pub(crate) const COMPACT: &str = "compact";

/// Names of the entries of `ARTICULA_prepared`.
pub(crate) const VERTEX_ORDER: &str = "vertexOrder";
pub(crate) const MESH_LEVELS: &str = "meshLevels";
pub(crate) const CLIPS: &str = "clips";
pub(crate) const CLIPS_IN_PLACE: &str = "clipsInPlace";
pub(crate) const JOINT_LEVELS: &str = "jointLevels";
pub(crate) const SKINS: &str = "skins";
pub(crate) const BOUNDS: &str = "bounds";
pub(crate) const PAIRED_LEVELS: &str = "pairedLevels";
pub(crate) const POSE_CACHE: &str = "poseCache";
pub(crate) const PAIRED_POSE_CACHE: &str = "pairedPoseCache";
