//! Arrays of a document as they are stored.

use super::element::Elements;
use super::role::Role;

/// An array, or a part of it, and the accessor that describes it.
pub(super) struct Array {
    pub(super) accessor: usize,
    pub(super) role: Role,
    pub(super) part: Part,
    pub(super) elements: Elements,
}

/// What an array is of its accessor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Whole,
    /// Places of the elements of a sparse accessor that are not zero.
    Indices,
    /// Those elements.
    Values,
}
