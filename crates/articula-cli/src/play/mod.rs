//! A clip played under motion level of detail: what `lod` and `demo` have in common.
//!
//! - [`camera_path`]: the same before a moving camera
//! - [`methods`]: which method, with which parameters
//! - [`saved`]: what a level leaves of the stored animation
//! - [`rows`]: gain and error over distance
//! - [`costs`]: what each zone, depth and level of complexity costs
//! - [`plots`]: the same as curves and bars
//! - [`artist`], [`sheet`]: the same as pictures

pub(crate) mod artist;
pub(crate) mod camera_path;
pub(crate) mod costs;
pub(crate) mod methods;
pub(crate) mod plots;
pub(crate) mod rows;
pub(crate) mod sheet;

use articula::Figure;
use articula_build::evaluate::{MethodOptions, Setup, Stage};

/// What is played: a clip of a character, before these viewers.
#[derive(Debug, Clone)]
pub(crate) struct Scene<'a> {
    pub(crate) figure: &'a Figure,
    /// Index of the clip.
    pub(crate) clip: usize,
    pub(crate) setup: Setup,
    pub(crate) options: MethodOptions,
}

impl Scene<'_> {
    /// Works out the truth of the clip; one for each thread.
    pub(crate) fn stage(&self) -> Stage<'_> {
        let asset = &self.figure.asset;
        let clip = &asset.clips[self.clip];
        Stage::new(asset, clip, self.setup.clone(), self.options)
    }

    /// Pixels that a metre spans at a distance.
    pub(crate) fn pixels_per_metre(&self, distance_m: f32) -> f32 {
        self.setup.viewport.pixels_per_metre(distance_m)
    }
}
