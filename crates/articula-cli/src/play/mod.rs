//! A clip played under motion level of detail: what `lod` and `demo` have in common.
//!
//! - [`methods`]: which method, with which parameters
//! - [`drawn`]: what was played as pictures and curves
//! - [`motion_plots`]: what such a clip saves and costs, as curves and bars

pub(crate) mod drawn;
pub(crate) mod methods;
pub(crate) mod motion_plots;

use crate::files;
use anyhow::Context;
use articula_build::evaluate::CameraKey;
use articula_formats::Limits;
use std::path::Path;
use std::time::Instant;

/// Reads the key frames of a camera path, a JSON list.
pub(crate) fn read_camera_path(path: &Path, display_hz: f64) -> anyhow::Result<Vec<CameraKey>> {
    let bytes = files::read(path, Limits::default().bytes)?;
    articula::read_camera_path(&bytes, display_hz).with_context(|| files::shown(path))
}

/// Runs something once; how long it took by the clock.
pub(crate) fn nanoseconds(run: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_nanos() as f64
}
