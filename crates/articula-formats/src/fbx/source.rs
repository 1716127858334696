//! The scene that is being read, what it may cost, and what was odd about it.

use super::kinds::Kinds;
use super::scene::Scene;
use crate::error::ReadError;
use crate::limits::Limits;

/// A scene while it becomes a character.
pub(super) struct Reader<'s> {
    pub(super) scene: &'s Scene,
    pub(super) limits: &'s Limits,
    pub(super) kinds: Kinds,
    spent: u64,
}

impl<'s> Reader<'s> {
    pub(super) fn new(scene: &'s Scene, limits: &'s Limits, kinds: Kinds) -> Self {
        Self {
            scene,
            limits,
            kinds,
            spent: 0,
        }
    }

    /// Charges numbers before they are allocated.
    pub(super) fn charge(&mut self, at: &str, numbers: usize) -> Result<(), ReadError> {
        self.spent = self.spent.saturating_add(numbers as u64);
        Limits::check(at, "numbers in arrays", self.spent, self.limits.elements)
    }
}
