//! Evaluates motion level of detail on a clip: gain and error of methods over distance and along a
//! camera path, and the cost of joint sets.
//!
//! In the order of the work:
//!
//! - `methods`: methods with their names in reports
//! - `rows`: gain and error of each method at each distance
//! - `path`: a controller of the live playback with a moving camera
//! - `schedule`: levels of articulation that change over time
//! - `layers`: the error of leaving out parts of a motion stream
//! - `shown_error`: the error of a frame that is shown
//! - `costs`: cost of each zone, depth and level of complexity
//!
//! Field names are stable, since scripts read them as JSON (`docs/commands.md`).

mod costs;
#[cfg(feature = "streams")]
mod layers;
mod methods;
mod path;
mod rows;
mod schedule;
mod shown_error;

pub use costs::{Cost, Costs};
#[cfg(feature = "streams")]
pub use layers::{LayerOptions, LayerReport, LayersReport, WorstVertex, layers};
pub use methods::NamedMethod;
pub use path::{CameraPath, PathSummary, PlayedPath};
pub use rows::{DISTANCES_M, ErrorPx, MethodRow, MethodTable, ParameterChoice, rows};
pub use schedule::{
    ChangeError, ScheduleChange, ScheduleEntry, ScheduleOptions, ScheduleReport, ScheduleRow,
    play_lod_schedule, read_lod_schedule,
};
pub use shown_error::{ShownError, ShownErrorMeter};

use crate::face::face_vertices;
use crate::figure::Figure;
use crate::motion_tables::MotionTables;
use articula_build::evaluate::{ClipEvaluator, EvaluationSetup, MethodOptions};

/// The clip to be evaluated, with camera setup and method options.
#[derive(Debug, Clone)]
pub struct EvaluatedClip<'a> {
    /// The character.
    pub figure: &'a Figure,
    /// Index of the clip.
    pub clip: usize,
    /// Cameras, and the sample of vertices on which error is measured.
    pub setup: EvaluationSetup,
    /// Options of the methods besides their parameter.
    pub options: MethodOptions,
}

impl EvaluatedClip<'_> {
    /// Computes the reference playback of the clip; use one per thread. Tables that are
    /// stored in the file, and fit, are played.
    pub fn stage(&self) -> ClipEvaluator<'_> {
        let asset = &self.figure.asset;
        let clip = &asset.clips[self.clip];
        let stage = ClipEvaluator::new(asset, clip, self.setup.clone(), self.options)
            .with_face(face_vertices(self.figure));
        let stored = MotionTables::stored(self.figure, self.clip);
        let stage = match stored.joint_keys {
            Some(table) => stage.with_key_table(table),
            None => stage,
        };
        let frames = stage.clip.frames();
        let stage = match stored.contacts.filter(|t| t.frames as usize == frames) {
            Some(table) => stage.with_contacts(table.contacts),
            None => stage,
        };
        match stored.error_matrix {
            Some(table) => stage.with_error_matrix(table.matrix),
            None => stage,
        }
    }
}
