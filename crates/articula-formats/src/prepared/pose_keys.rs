//! The part `poseCache`: times and errors of the poses that a pose cache holds.
//!
//! The palettes themselves follow from clip, level and time and are evaluated when the cache is
//! opened, which takes less time than reading them.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::{CachedKeys, CachedSteps, JointLods};

/// Version of the layout that is written: the second one has palettes that are shown as they are, in the
/// third one levels may share palettes, in the fourth one the latter have errors of blends too.
pub const CACHE_KEYS_VERSION: u64 = 4;

/// Stands for the error of a blend that was not measured.
const NOT_MEASURED: f32 = -1.0;

/// What a pose cache holds, for each clip and in it for each level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CacheKeys {
    /// Keys of palettes to be blended; `None` where poses are evaluated.
    pub keys: Vec<Vec<Option<CachedKeys>>>,
    /// Palettes that are shown as they are; `None` where none is.
    pub steps: Vec<Vec<Option<CachedSteps>>>,
}

/// Encodes the keys of a pose cache. A level that is in one of the lists alone has nothing of the other.
pub fn write_cache_keys(
    keys: &[Vec<Option<CachedKeys>>],
    steps: &[Vec<Option<CachedSteps>>],
) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(keys.len());
    for (clip, levels) in keys.iter().enumerate() {
        out.count(levels.len());
        for (level, keys) in levels.iter().enumerate() {
            let times = keys.as_ref().map_or(&[][..], |k| &k.times_secs);
            out.count(times.len());
            if let Some(keys) = keys {
                out.count(keys.first_matrix as usize);
                out.float(keys.error_metres);
                out.floats(times);
            }
            let steps = steps.get(clip).and_then(|of_clip| *of_clip.get(level)?);
            out.count(steps.map_or(0, |s| s.count as usize));
            if let Some(steps) = steps {
                out.count(steps.first_matrix as usize);
                out.float(steps.error_metres);
                out.float(steps.blend_error_metres.unwrap_or(NOT_MEASURED));
            }
        }
    }
    out.0
}

/// Decodes the output of [`write_cache_keys`], keys of version 1, which have no steps, or those of
/// versions 2 and 3, whose steps have no errors of blends.
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_cache_keys(
    bytes: &[u8],
    version: u64,
    limits: &Limits,
) -> Result<CacheKeys, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let clips = r.count(1, "clips")?;
    let mut found = CacheKeys::default();
    for _ in 0..clips {
        let levels = r.at_most(JointLods::MAX_LEVELS, "a number of levels")?;
        let mut keys = Vec::with_capacity(levels);
        let mut steps = Vec::with_capacity(levels);
        for _ in 0..levels {
            let count = r.count(4, "keys")?;
            keys.push(match count {
                0 => None,
                _ => Some(CachedKeys {
                    first_matrix: r.at_most(u32::MAX as usize, "a matrix")? as u32,
                    error_metres: r.float()?,
                    times_secs: r.groups(count, |[secs]| secs)?,
                }),
            });
            let count = match version {
                1 => 0,
                // What their palettes take is checked before they are evaluated.
                _ => r.at_most(u32::MAX as usize, "a number of steps")?,
            };
            steps.push(match count {
                0 => None,
                _ => Some(CachedSteps {
                    count: count as u32,
                    first_matrix: r.at_most(u32::MAX as usize, "a matrix")? as u32,
                    error_metres: r.float()?,
                    blend_error_metres: match version {
                        2 | 3 => None,
                        _ => Some(r.float()?).filter(|e| *e != NOT_MEASURED),
                    },
                }),
            });
        }
        found.keys.push(keys);
        found.steps.push(steps);
    }
    r.bytes.end()?;
    Ok(found)
}
