//! What decides which joints of a figure move.

use articula::Figure;
use articula::MotionTables;
use articula::core::joint_state::TransitionOptions;
use articula::core::playback::{
    ControlResult, ErrorMatrix, FrameContext, FullDetail, MotionController, StoredKeys,
    TableController, ThesisController, Threshold,
};
use articula::core::{JointSet, LocalPose, Rig};
use std::sync::Arc;

/// All joints, or those whose error is seen.
#[derive(Debug)]
pub(crate) enum Metric {
    Full(FullDetail),
    Keys(TableController),
    Thesis(Box<ThesisController>),
}

/// The error matrix that a figure's file stores for each clip. Reading checks them against the file, which takes longer
/// than a frame.
#[derive(Debug)]
pub(crate) struct StoredErrors(Vec<Option<Arc<ErrorMatrix>>>);

impl StoredErrors {
    pub(crate) fn read(figure: &Figure) -> Self {
        let clips = 0..figure.asset.clips.len();
        let stored = clips.map(|c| MotionTables::stored(figure, c).error_matrix);
        Self(
            stored
                .map(|table| table.map(|table| Arc::new(table.matrix)))
                .collect(),
        )
    }

    /// Sets the errors of a clip, in place of the stored ones.
    pub(crate) fn put(&mut self, clip: usize, errors: ErrorMatrix) {
        self.0[clip] = Some(Arc::new(errors));
    }
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

    /// The errors of a file, by a threshold.
    pub(crate) fn thesis(
        rig: &Rig,
        errors: &StoredErrors,
        threshold: Threshold,
        lookup_every: usize,
        transition: TransitionOptions,
    ) -> Self {
        let matrices = errors.0.clone();
        let thesis = ThesisController::new(rig, matrices, threshold, lookup_every, transition);
        Self::Thesis(Box::new(thesis))
    }

    fn inner(&mut self) -> &mut dyn MotionController {
        match self {
            Self::Full(full) => full,
            Self::Keys(keys) => keys,
            Self::Thesis(thesis) => &mut **thesis,
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
