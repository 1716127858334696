//! The part `poseCache`: times and errors of the poses that a pose cache holds.
//!
//! The palettes themselves follow from clip, level and time and are evaluated when the cache is
//! opened, which takes less time than reading them.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::{CachedKeys, JointLods};

/// Stands for an error that was not measured.
const UNKNOWN: f32 = -1.0;

/// Keys of each clip at each level; `None` where poses are evaluated.
pub type CacheKeys = Vec<Vec<Option<CachedKeys>>>;

/// Version of the layout that is written: the second one has the error of stepped palettes.
pub const CACHE_KEYS_VERSION: u64 = 2;

/// Encodes the keys of a pose cache.
pub fn write_cache_keys(keys: &[Vec<Option<CachedKeys>>]) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(keys.len());
    for levels in keys {
        out.count(levels.len());
        for keys in levels {
            let times = keys.as_ref().map_or(&[][..], |k| &k.times_secs);
            out.count(times.len());
            if let Some(keys) = keys {
                out.count(keys.first_matrix as usize);
                out.float(keys.error_metres);
                out.float(keys.step_error_metres.unwrap_or(UNKNOWN));
                out.floats(times);
            }
        }
    }
    out.0
}

/// Decodes the output of [`write_cache_keys`], or keys of version 1, which have no error of stepped
/// palettes.
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
    let mut keys = Vec::with_capacity(clips);
    for _ in 0..clips {
        let levels = r.at_most(JointLods::MAX_LEVELS, "a number of levels")?;
        let mut of_clip = Vec::with_capacity(levels);
        for _ in 0..levels {
            let count = r.count(4, "keys")?;
            of_clip.push(match count {
                0 => None,
                _ => Some(CachedKeys {
                    first_matrix: r.at_most(u32::MAX as usize, "a matrix")? as u32,
                    error_metres: r.float()?,
                    step_error_metres: match version {
                        1 => None,
                        _ => Some(r.float()?).filter(|e| *e != UNKNOWN),
                    },
                    times_secs: r.groups(count, |[secs]| secs)?,
                }),
            });
        }
        keys.push(of_clip);
    }
    r.bytes.end()?;
    Ok(keys)
}
