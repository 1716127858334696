//! Options of preparation and conversion.

use crate::error::Result;
use crate::long_options::mesh_levels;
use articula::convert::{AddClipsOptions, ConvertOptions};
use articula::{MeshLevelOptions, PrepareOptions};
use serde::Deserialize;

/// Options of `prepare`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Prepare {
    mesh_levels: Option<usize>,
}

impl Prepare {
    pub(super) fn options(self) -> Result<PrepareOptions> {
        let levels = self.mesh_levels.map(mesh_levels).transpose()?;
        Ok(PrepareOptions {
            mesh_levels: levels.map(MeshLevelOptions::levels),
            ..PrepareOptions::default()
        })
    }
}

/// Options of `convert`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Convert {
    clip: Option<String>,
}

impl Convert {
    pub(super) fn options(self) -> ConvertOptions {
        ConvertOptions {
            clip: self.clip,
            ..ConvertOptions::default()
        }
    }
}

/// Options of `addClips`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct AddClips {
    clip: Option<String>,
    keep_own: Option<bool>,
    prefix: String,
}

impl AddClips {
    pub(super) fn options(self) -> AddClipsOptions {
        let usual = AddClipsOptions::default();
        AddClipsOptions {
            clip: self.clip,
            keep_own: self.keep_own.unwrap_or(usual.keep_own),
            prefix: self.prefix,
            ..usual
        }
    }
}
