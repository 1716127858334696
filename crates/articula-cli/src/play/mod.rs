//! A clip played under motion level of detail, shared by `lod` and `demo`.
//!
//! - [`methods`]: the method and its parameters
//! - [`selection`]: the joints of a fixed level
//! - [`drawn`]: the results as contact sheets and plots
//! - [`motion_plots`]: updates saved, error and cost as line and bar plots

pub(crate) mod drawn;
pub(crate) mod methods;
pub(crate) mod motion_plots;
mod selection;

use crate::files;
use anyhow::Context;
use articula::build::evaluate::CameraKey;
use articula::formats::Limits;
use std::path::Path;
use std::time::Instant;

/// Reads the key frames of a camera path from a JSON list.
pub(crate) fn read_camera_path(path: &Path, display_hz: f64) -> anyhow::Result<Vec<CameraKey>> {
    let bytes = files::read(path, Limits::default().bytes)?;
    articula::read_camera_path(&bytes, display_hz).with_context(|| files::shown(path))
}

/// Runs a closure once; returns its wall-clock time in nanoseconds.
pub(crate) fn nanoseconds(run: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_nanos() as f64
}
