//! A clip played under motion level of detail: gain and error of methods over distance, along a
//! camera path, and what sets of joints cost.
//!
//! In the order of the work:
//!
//! - `methods`: methods with the names that reports use
//! - `rows`: what each method saves and errs at each distance
//! - `path`: the controller of a frame before a moving camera
//! - `costs`: what each zone, depth and level of complexity costs
//!
//! The field names are a promise to scripts that read them as JSON (`docs/commands.md`).

mod costs;
mod methods;
mod path;
mod rows;

pub use costs::{Cost, Costs};
pub use methods::NamedMethod;
pub use path::{CameraPath, PathSummary, PlayedPath};
pub use rows::{ErrorPx, MethodRow, MethodTable, ParameterChoice, rows};

use crate::figure::Figure;
use articula_build::evaluate::{ClipEvaluator, EvaluationSetup, MethodOptions};

/// What is played: a clip of a character, before these viewers.
#[derive(Debug, Clone)]
pub struct EvaluatedClip<'a> {
    /// The character.
    pub figure: &'a Figure,
    /// Index of the clip.
    pub clip: usize,
    /// The viewers, and what they watch.
    pub setup: EvaluationSetup,
    /// What methods need besides their parameter.
    pub options: MethodOptions,
}

impl EvaluatedClip<'_> {
    /// Works out the truth of the clip; one for each thread.
    pub fn stage(&self) -> ClipEvaluator<'_> {
        let asset = &self.figure.asset;
        let clip = &asset.clips[self.clip];
        ClipEvaluator::new(asset, clip, self.setup.clone(), self.options)
    }
}
