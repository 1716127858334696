//! What a decision keeps of an item.

use super::regions::Regions;

/// What is kept of an item.
#[derive(Debug, Clone, PartialEq)]
pub enum ItemCut {
    /// Some layers.
    Layers {
        /// For each part of the item and each of its layers, whether it is kept.
        kept: Vec<Vec<bool>>,
        /// Regions of motions that are kept.
        regions: Regions,
    },
    /// The form in 2D of this index, in place of all layers.
    Flat(usize),
}
