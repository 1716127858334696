//! A clip played under motion level of detail, for `lod`, and what `crowd` shares with it.
//!
//! - [`methods`]: the method and its parameters
//! - [`selection`]: the joints of a fixed level

pub(crate) mod methods;
mod selection;

use crate::files;
use anyhow::Context;
use articula::build::evaluate::CameraKey;
use articula::formats::Limits;
use std::path::Path;

/// Reads the key frames of a camera path from a JSON list.
pub(crate) fn read_camera_path(path: &Path, display_hz: f64) -> anyhow::Result<Vec<CameraKey>> {
    let bytes = files::read(path, Limits::default().bytes)?;
    articula::read_camera_path(&bytes, display_hz).with_context(|| files::shown(path))
}
