//! What is shown of a character, in numbers.

use serde::Serialize;

/// What is shown of a character, in numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CharacterReport {
    /// Level of quality of what plays, 1 to `levels`; 0 before anything is shown.
    pub level: usize,
    /// Level of quality that the bandwidth carries.
    pub target: usize,
    /// Number of levels of quality.
    pub levels: usize,
    /// Finest level of articulation of the access unit that plays.
    pub loa: Option<u32>,
    /// Finest tier of that level.
    pub tier: Option<u32>,
    /// Joints that its layers move.
    pub joints: Option<u64>,
    /// Finest level of the mesh that is there everywhere.
    pub mesh_level: Option<u32>,
    /// Longer side of the coarsest texture, pixels.
    pub texture_px: Option<u32>,
    /// Bound of the error of what plays, pixels.
    pub error_px: Option<f64>,
    /// Bytes that arrived, without manifests.
    pub bytes: u64,
    /// Number of times at which playback waits.
    pub stalls: u64,
    /// Whether all that the context asks for is there.
    pub is_complete: bool,
}
