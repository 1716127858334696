//! Impostors of the character of a crowd in a build without the feature `flat`: there are none.

use super::options::CrowdOptions;
use crate::error::Result;
use crate::work::Executor;
use articula_build::Asset;
use articula_core::{Impostors, Mismatch};
use glam::{Affine3A, Vec3};

/// The impostors of a crowd's character, which nothing makes.
#[derive(Debug)]
pub(super) enum CrowdImpostors {}

impl CrowdImpostors {
    pub(super) fn chosen(_: &Asset, _: &CrowdOptions, _: &Executor<'_>) -> Result<Option<Self>> {
        Ok(None)
    }

    pub(super) fn table(&self) -> Result<Impostors, Mismatch> {
        match *self {}
    }

    pub(super) fn error_metres(&self) -> f32 {
        match *self {}
    }

    pub(super) fn bytes(&self) -> usize {
        match *self {}
    }

    pub(super) fn matrices(&self, _: &Asset, _: usize, _: Vec3, _: &mut Vec<Affine3A>) {
        match *self {}
    }
}
