//! What decides which joints of a figure move.

use articula::Figure;
use articula::MotionTables;
use articula::core::playback::{
    ControlResult, FrameContext, FullDetail, MotionController, StoredKeys, TableController,
};
use articula::core::{JointSet, LocalPose};

/// All joints, or those whose error is seen.
#[derive(Debug)]
pub(crate) enum Metric {
    Full(FullDetail),
    Keys(TableController),
}

impl Metric {
    /// All joints.
    pub(crate) fn full() -> Self {
        Self::Full(FullDetail::default())
    }

    /// The keys that a figure's file stores, by a tolerance in pixels.
    pub(crate) fn keys(figure: &Figure, px: f32) -> Self {
        let asset = &figure.asset;
        let keys = asset.clips.iter().enumerate().map(|(c, clip)| {
            let table = MotionTables::stored(figure, c).joint_keys?;
            StoredKeys::new(clip, table).ok()
        });
        let shares = vec![1.0; asset.rig.len()];
        Self::Keys(TableController::new(keys.collect(), shares, px))
    }

    fn inner(&mut self) -> &mut dyn MotionController {
        match self {
            Self::Full(full) => full,
            Self::Keys(keys) => keys,
        }
    }
}

impl MotionController for Metric {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        self.inner().due(frame)
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        self.inner().control(frame, due, wanted, shown)
    }
}
