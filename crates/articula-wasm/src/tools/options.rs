//! Options of preparation and conversion.

use crate::error::{Fault, Result};
use crate::long_options::mesh_levels;
use articula::convert::{AddClipsOptions, ConvertOptions, JointReduction, MovingJoints};
use articula::core::joint_state::PassivePolicy;
use articula::core::loa::LoaExpression;
use articula::{MeshLevelOptions, PrepareOptions, PreparedMeshLevels};
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
            mesh_levels: match levels {
                None => PreparedMeshLevels::ForCrowds,
                Some(1) => PreparedMeshLevels::OfFile,
                Some(levels) => PreparedMeshLevels::New(MeshLevelOptions::levels(levels)),
            },
            ..PrepareOptions::default()
        })
    }
}

/// Options of `convert`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Convert {
    clip: Option<String>,
    loa: Option<String>,
    passive: Passive,
}

/// Pose of joints that do not move.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Passive {
    Hold,
    Rest,
    #[default]
    KeyPose,
}

impl Convert {
    pub(super) fn options(self) -> Result<ConvertOptions> {
        let reduction = self.loa.as_deref().map(|loa| {
            let moving = loa.parse::<LoaExpression>();
            let moving = moving.map_err(|e| Fault::argument(format!("options: loa: {e}")))?;
            Ok(JointReduction {
                moving: MovingJoints::LoaExpression(moving),
                with_ancestors: false,
                passive: self.passive.policy(),
            })
        });
        Ok(ConvertOptions {
            clip: self.clip,
            reduction: reduction.transpose()?,
            ..ConvertOptions::default()
        })
    }
}

impl Passive {
    fn policy(self) -> PassivePolicy {
        match self {
            Self::Hold => PassivePolicy::HoldLast,
            Self::Rest => PassivePolicy::Rest,
            Self::KeyPose => PassivePolicy::KeyPose,
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
