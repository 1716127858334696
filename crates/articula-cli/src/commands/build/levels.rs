//! The report of `build` about mesh levels for people.

use crate::table::{Table, counted, millimetres};
use articula::{CodedMeshLevels, MeshLevelBytes, MeshLevelRow};

/// Describes the poses on which errors in motion were measured.
pub(crate) fn measured(made: &CodedMeshLevels) -> String {
    let on = made.levels.measured;
    let parts: Vec<String> = [
        (on.clips, "of its clips"),
        (on.bends, "of bent joints"),
        (on.morphs, "of its morph targets"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{} {what}", counted(count, "pose", "poses")))
    .collect();
    match parts.is_empty() {
        true => "the rest pose only, since no other pose is left for measuring".to_owned(),
        false => format!("{} not used for simplification", parts.join(" and ")),
    }
}

/// Formats the levels for people.
pub(crate) fn text(levels: &[MeshLevelRow], bytes: &MeshLevelBytes, measured: &str) -> String {
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "error at rest",
        "error in motion",
        "p99 in motion",
        "ranges",
        "bytes alone",
        "bytes added",
    ]);
    for level in levels {
        table.row([
            level.level.to_string(),
            level.triangles.to_string(),
            level.vertices.to_string(),
            millimetres(level.error_rest_m),
            millimetres(level.error_motion_m),
            millimetres(level.error_motion_p99_m),
            level.ranges.to_string(),
            level.bytes_direct.to_string(),
            level.bytes_added.to_string(),
        ]);
    }
    format!(
        "{}errors: maximum distance from the original surface to the level, in motion over {measured}\n\
         stream: {} bytes for all levels, {} for the finest level alone, {} for all levels each coded alone; {} in the asset\n",
        table.text(),
        bytes.clustered,
        bytes.finest_alone,
        bytes.discrete_sum,
        bytes.store
    )
}
