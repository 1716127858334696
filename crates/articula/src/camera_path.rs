//! Camera paths as JSON: `[{"t": 0, "eye": [0, 1.6, 25], "target": [0, 1, 0]}, …]`, in seconds and
//! metres.

use crate::error::{Error, Result};
use articula_build::evaluate::CameraKey;
use articula_formats::ReadError;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Maximum number of display frames of a path.
const MAX_FRAMES: f64 = 36_000.0;

/// A key frame as written in files.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Key {
    t: f64,
    eye: [f32; 3],
    target: [f32; 3],
}

impl From<&CameraKey> for Key {
    fn from(key: &CameraKey) -> Self {
        Self {
            t: key.secs,
            eye: key.eye.to_array(),
            target: key.target.to_array(),
        }
    }
}

/// Reads a camera path from a JSON list of key frames with `t`, `eye` and `target`; `display_hz` is
/// the frame rate by which the length of the path is limited.
///
/// # Errors
/// An [`Error`] that names the line or key frame that is wrong.
pub fn read_camera_path(bytes: &[u8], display_hz: f64) -> Result<Vec<CameraKey>> {
    let keys: Vec<Key> = serde_json::from_slice(bytes).map_err(|e| {
        let form = "expected a list of {\"t\", \"eye\": [x, y, z], \"target\": [x, y, z]}";
        malformed(&e, form)
    })?;
    checked(&keys, display_hz)
}

/// Converts a JSON error into an [`Error`], with advice.
pub(crate) fn malformed(error: &serde_json::Error, mend: &str) -> Error {
    let at = format!("line {} column {}", error.line(), error.column());
    let what = format!("{error}; {mend}");
    ReadError::Malformed { at, what }.into()
}

/// Returns an error unless `holds`.
pub(crate) fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<()> {
    if holds {
        Ok(())
    } else {
        Err(Error::unsuited(what()))
    }
}

/// Checks key frames and converts them.
pub(crate) fn checked(keys: &[Key], display_hz: f64) -> Result<Vec<CameraKey>> {
    check(keys, display_hz)?;
    let key = |key: &Key| CameraKey {
        secs: key.t,
        eye: Vec3::from(key.eye),
        target: Vec3::from(key.target),
    };
    Ok(keys.iter().map(key).collect())
}

fn check(keys: &[Key], display_hz: f64) -> Result<()> {
    let (Some(first), Some(last)) = (keys.first(), keys.last()) else {
        return Err(Error::unsuited(
            "the camera path has no key frame; give at least one",
        ));
    };
    for (i, key) in keys.iter().enumerate() {
        let finite = key.t.is_finite() && key.eye.iter().chain(&key.target).all(|v| v.is_finite());
        ensure(finite, || {
            format!("[{i}]: all values must be finite; give seconds and metres")
        })?;
        ensure(key.eye != key.target, || {
            format!("[{i}]: eye and target are the same point; move the target to the subject")
        })?;
        let before = keys
            .get(i.wrapping_sub(1))
            .map_or(f64::NEG_INFINITY, |k| k.t);
        ensure(key.t >= before, || {
            let t = key.t;
            format!("[{i}].t: {t} comes after {before}; sort the key frames by time")
        })?;
    }
    let frames = (last.t - first.t) * display_hz;
    ensure(frames <= MAX_FRAMES, || {
        format!(
            "{frames:.0} frames at {display_hz} Hz, the limit is {MAX_FRAMES}; shorten the path"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(t: f64) -> Key {
        Key {
            t,
            eye: [0.0, 1.0, 5.0],
            target: [0.0; 3],
        }
    }

    #[test]
    fn paths_are_checked_at_the_door() {
        let why = |keys: &[Key]| check(keys, 60.0).unwrap_err().to_string();
        assert!(why(&[]).contains("at least one"));
        assert!(why(&[key(1.0), key(0.0)]).contains("[1].t"));
        assert!(why(&[key(f64::NAN)]).contains("[0]"));
        assert!(why(&[key(0.0), key(1e9)]).contains("limit"));
        assert!(check(&[key(0.0), key(0.0), key(2.0)], 60.0).is_ok());
    }
}
