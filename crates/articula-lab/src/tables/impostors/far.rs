//! Far levels of a character, each as a character of its own.

use super::played::Played;
use super::{Row, Subject};
use anyhow::Result;
use articula::Executor;
use articula::crowd::{CrowdAsset, CrowdOptions, JointLodMethod};
use articula_build::{Asset, FarLevels, JointLodOptions, far_levels, far_order, mean_pose};
use articula_core::LodErrors;

/// Numbers of joints that far levels keep.
const COUNTS: [u16; 7] = [16, 12, 8, 6, 4, 2, 1];

/// The far levels of a character; none if its chains shear.
pub(super) struct FarSubject {
    levels: Option<(FarLevels, LodErrors)>,
    full: Asset,
}

/// A far level on the coarsest mesh that near levels use.
pub(super) struct FarLevel {
    pub(super) crowd: CrowdAsset,
    pub(super) joints: usize,
    /// Error of the joints alone, over the clips, metres: with the original mesh.
    pub(super) error_m: f32,
}

impl FarSubject {
    pub(super) fn new(subject: &Subject) -> Result<Self> {
        let full = subject.crowd.full().clone();
        let opts = JointLodOptions::default();
        let mean = mean_pose(&full);
        let order = far_order(&full, &mean, &opts)?;
        let counts: Vec<u16> = COUNTS
            .into_iter()
            .filter(|n| usize::from(*n) < full.rig.len())
            .collect();
        let levels = far_levels(&full, &order, &counts, &mean, &opts)?;
        Ok(Self { levels, full })
    }

    /// The level with the fewest joints within a tolerance.
    pub(super) fn level(&self, tolerance_m: f32) -> Option<FarLevel> {
        let (far, errors) = self.levels.as_ref()?;
        let error = |level: usize| {
            let of = errors
                .clips
                .iter()
                .filter_map(|c| c.judged().nth(level + 1));
            of.fold(0.0, f32::max)
        };
        let level = (0..far.joint_lods.levels()).rfind(|l| error(*l) <= tolerance_m)?;
        let asset = Asset {
            rig: far.rig.clone().into(),
            mesh: far.skins.mesh(level, &self.full.mesh).into(),
            clips: far.clips.clone(),
        };
        let options = CrowdOptions {
            joints: JointLodMethod::Whole,
            pose_cache: true,
            ..CrowdOptions::default()
        };
        let crowd = CrowdAsset::from_asset(asset, &options, &Executor::default()).ok()?;
        Some(FarLevel {
            crowd,
            joints: far.joint_lods.joint_count(level),
            error_m: error(level),
        })
    }
}

impl FarLevel {
    /// A row of what was played. Vertices and triangles are those of the coarsest mesh level, which a
    /// far level could be bound to as near levels are.
    pub(super) fn row(
        &self,
        played: &Played,
        subject: &Subject,
        height_px: f32,
        way: &'static str,
    ) -> Row {
        let last = subject.crowd.level(subject.crowd.levels() - 1);
        Row {
            joints: self.joints,
            error_px: self.error_m * height_px / subject.height_m,
            vertices: last.vertices as f64,
            triangles: last.triangles as f64,
            ..played.row(subject, height_px, way)
        }
    }
}
