//! The part `bounds`: bounds of the skin in each second of each clip.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::{Bound, ClipBounds, MotionBounds};

/// Encodes bounds.
pub fn write_motion_bounds(bounds: &MotionBounds) -> Vec<u8> {
    let mut out = Writer::default();
    out.float(bounds.reach_metres);
    out.count(bounds.clips.len());
    for clip in &bounds.clips {
        out.float(clip.duration_secs());
        out.sphere(clip.anchors());
        out.count(clip.seconds().len());
        for second in clip.seconds() {
            out.sphere(second.sphere);
            out.vector(second.least);
            out.vector(second.greatest);
        }
    }
    out.0
}

/// Decodes the output of [`write_motion_bounds`].
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_motion_bounds(bytes: &[u8], limits: &Limits) -> Result<MotionBounds, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let reach_metres = r.float()?;
    let count = r.count(61, "clips")?;
    let mut clips = Vec::with_capacity(count);
    for _ in 0..count {
        let duration_secs = r.float()?;
        let anchors = r.sphere()?;
        let count = r.count(40, "seconds")?;
        let mut seconds = Vec::with_capacity(count);
        for _ in 0..count {
            seconds.push(Bound {
                sphere: r.sphere()?,
                least: r.vector()?,
                greatest: r.vector()?,
            });
        }
        let bounds = ClipBounds::new(duration_secs, seconds, anchors);
        clips.push(bounds.map_err(|e| r.bytes.bad(e.to_string()))?);
    }
    r.bytes.end()?;
    Ok(MotionBounds {
        clips,
        reach_metres,
    })
}
