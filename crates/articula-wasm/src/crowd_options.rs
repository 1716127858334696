//! Options of a crowd, from JSON.

use crate::clip_events::ClipEvents;
use crate::error::{Fault, Result};
use articula::Figure;
use articula::crowd::{BakedImpostors, CrowdOptions, MAX_MESH_LEVELS, RootMotionPolicy};
use serde::Deserialize;

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Options {
    clips: Vec<String>,
    events: ClipEvents,
    impostors: Option<BakedImpostors>,
    mesh_levels: Option<usize>,
    pose_cache: Option<bool>,
    root_motion: Option<String>,
}

/// Reads the treatment of root motion.
pub(crate) fn root_motion(word: &str) -> Result<RootMotionPolicy> {
    match word {
        "in-place" => Ok(RootMotionPolicy::OnTheSpot),
        "as-authored" => Ok(RootMotionPolicy::AsAuthored),
        "extracted" => Ok(RootMotionPolicy::Extracted),
        _ => Err(Fault::argument(format!(
            "rootMotion: \"{word}\"; known are \"in-place\", \"as-authored\" and \"extracted\""
        ))),
    }
}

/// Reads the options of a crowd. Mesh levels are those of the file: to make them is a part of its
/// preparation, which belongs into a worker.
pub(crate) fn crowd_options(json: Option<&str>, figure: &Figure) -> Result<CrowdOptions> {
    let options: Options = match json {
        Some(json) => serde_json::from_str(json)
            .map_err(|error| Fault::argument(format!("options: {error}")))?,
        None => Options::default(),
    };
    if options
        .mesh_levels
        .is_some_and(|levels| levels > MAX_MESH_LEVELS)
    {
        return Err(Fault::argument(format!(
            "options: meshLevels must be at most {MAX_MESH_LEVELS}"
        )));
    }
    let has_levels = figure.stored_mesh_level_count() > 1;
    if !has_levels && options.mesh_levels.is_some_and(|levels| levels > 1) {
        return Err(Fault::argument(
            "options: the file has no mesh levels for meshLevels; prepare it with them",
        ));
    }
    let usual = CrowdOptions::default();
    Ok(CrowdOptions {
        clips: options.clips,
        events: options.events.named(),
        baked_impostors: options.impostors,
        mesh_levels: if has_levels {
            options.mesh_levels
        } else {
            Some(1)
        },
        pose_cache: options.pose_cache.unwrap_or(usual.pose_cache),
        root_motion: match options.root_motion {
            Some(word) => root_motion(&word)?,
            None => usual.root_motion,
        },
        ..usual
    })
}
