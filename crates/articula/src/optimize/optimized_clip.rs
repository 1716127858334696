//! A clip as it is written.

use articula_core::source::RawClip;
use articula_formats::gltf::KeySteps;

/// A clip with fewer keys, and the steps of its values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OptimizedClip {
    pub(super) clip: RawClip,
    /// The steps of the keys of each channel. Empty if all are exact.
    pub(super) steps: Vec<KeySteps>,
}
