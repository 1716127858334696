//! Options of long operations, from JSON.

use crate::error::{Fault, Result};
use serde::de::DeserializeOwned;

/// Most mesh levels that may be asked for.
const MOST_LEVELS: usize = 16;

/// Reads options; none are the default.
pub(crate) fn read<T: DeserializeOwned + Default>(json: Option<&str>) -> Result<T> {
    match json {
        None | Some("") => Ok(T::default()),
        Some(json) => {
            serde_json::from_str(json).map_err(|error| Fault::argument(format!("options: {error}")))
        }
    }
}

/// Returns a number of mesh levels, if it may be asked for.
pub(crate) fn mesh_levels(count: usize) -> Result<usize> {
    if (1..=MOST_LEVELS).contains(&count) {
        return Ok(count);
    }
    let what = format!("options: meshLevels must be 1 to {MOST_LEVELS}, found {count}");
    Err(Fault::argument(what))
}
