//! An option of a decision, and what it keeps of an item.

use articula_stream::decide::PartOption;

/// Layers of the parts of an item that an option keeps: index of the part, and for each of its layers
/// whether it is kept.
pub type PartLayers = Vec<(usize, Vec<bool>)>;

/// An option with the layers that it keeps.
pub(super) struct OptionOfPart {
    pub(super) option: PartOption,
    pub(super) layers: PartLayers,
    /// Whether a table can name it: one level for all regions of a mesh, one level and tier for all
    /// motions.
    pub(super) is_even: bool,
}
