//! Morph level of every character of a section.

use super::model::CrowdModel;

/// The morph levels of a section's characters; none where no clip moves morph targets.
#[derive(Debug, Clone)]
pub(crate) struct MorphLevels(Vec<u8>);

impl MorphLevels {
    /// Those of so many characters, all targets shown.
    pub(super) fn new(model: &CrowdModel, len: usize) -> Self {
        let (levels, _) = model.morphs();
        Self(vec![0; if levels > 0 { len } else { 0 }])
    }

    #[inline]
    pub(super) fn get(&self, character: usize) -> usize {
        self.0.get(character).copied().map_or(0, usize::from)
    }

    #[inline]
    pub(super) fn set(&mut self, character: usize, level: u8) {
        if let Some(kept) = self.0.get_mut(character) {
            *kept = level;
        }
    }
}
