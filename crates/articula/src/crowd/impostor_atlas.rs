//! The impostors of a crowd and their pictures, as a renderer reads them.

use super::asset::CrowdAsset;
use super::impostors::{CrowdImpostors, drawn, source};
use crate::error::Result;
use crate::work::Executor;
use articula_flat::impostor::ImpostorPlan;
use articula_flat::{Appearance, Picture};

impl CrowdAsset {
    /// Returns which impostors there are, if the options ask for them.
    pub fn impostors(&self) -> Option<&ImpostorPlan> {
        self.own_impostors().map(CrowdImpostors::plan)
    }

    /// Draws the pictures of the impostors; `None` if there are none. `appearance` has the materials and
    /// textures of the character.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) if the atlas would be too large, or
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn impostor_atlas(
        &self,
        appearance: &Appearance,
        work: &Executor<'_>,
    ) -> Result<Option<Picture>> {
        let source = source(self.full(), appearance);
        let plan = self.impostors();
        plan.map(|plan| drawn(plan, &source, work)).transpose()
    }
}
