//! What poses a character at one instant.

/// What poses a character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Moment {
    Rest,
    /// One morph target at a weight, and all else at rest.
    Morph {
        slot: usize,
        weight: f32,
    },
    /// A clip at a time in seconds.
    Clip {
        index: usize,
        secs: f32,
    },
}
