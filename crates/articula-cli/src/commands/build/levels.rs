//! The report of `build` about mesh levels.

use crate::table::{Table, counted, millimetres};
use articula::CodedMeshLevels;
use serde::Serialize;

/// One level in the JSON report. Errors are null for a level without triangles.
#[derive(Debug, Serialize)]
pub(crate) struct Level {
    /// Number of the level; 0 is the finest.
    level: usize,
    pub(crate) triangles: u64,
    pub(crate) vertices: u64,
    /// Maximum distance from the original surface to the level at rest, metres.
    pub(crate) error_rest_m: Option<f32>,
    /// The same over poses that were not used for simplification.
    pub(crate) error_motion_m: Option<f32>,
    error_motion_p99_m: Option<f32>,
    error_motion_mean_m: Option<f32>,
    /// Bytes of this level coded alone.
    pub(crate) bytes_direct: usize,
    /// Bytes that this level adds to the next coarser one in the stream.
    pub(crate) bytes_added: usize,
    /// Number of index ranges that show the level, over all parts.
    ranges: usize,
}

/// Bytes of all levels together.
#[derive(Debug, Serialize)]
pub(crate) struct Bytes {
    /// The whole stream: its header and the additions of every level.
    pub(crate) clustered: usize,
    /// The finest level, coded alone.
    pub(crate) finest_alone: usize,
    /// Sum of all levels, each coded alone.
    pub(crate) discrete_sum: usize,
    /// The meshes in the asset, not coded: vertices once, triangles of all levels.
    pub(crate) store: usize,
}

/// The levels, finest first.
pub(crate) fn levels(made: &CodedMeshLevels) -> Vec<Level> {
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let rows = made.levels.table.levels.iter().enumerate();
    rows.map(|(l, row)| Level {
        level: l,
        triangles: row.triangles,
        vertices: row.vertices,
        error_rest_m: finite(row.rest.max_metres),
        error_motion_m: finite(row.motion.max_metres),
        error_motion_p99_m: finite(row.motion.p99_metres),
        error_motion_mean_m: finite(row.motion.mean_metres),
        bytes_direct: made.stream.direct[l],
        bytes_added: made.stream.chunks[l],
        ranges: made
            .levels
            .objects
            .iter()
            .map(|o| o.clusters.ranges(l).count())
            .sum(),
    })
    .collect()
}

/// Sizes of the levels; `store` is the size of the meshes in the document.
pub(crate) fn bytes(made: &CodedMeshLevels, store: usize) -> Bytes {
    let direct = &made.stream.direct;
    Bytes {
        clustered: made.stream.bytes.len(),
        finest_alone: direct.first().copied().unwrap_or(0),
        discrete_sum: direct.iter().sum(),
        store,
    }
}

/// Number of poses on which errors in motion were measured.
pub(crate) fn poses_measured(made: &CodedMeshLevels) -> usize {
    let on = made.levels.measured;
    on.clips + on.bends + on.morphs
}

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
pub(crate) fn text(levels: &[Level], bytes: &Bytes, measured: &str) -> String {
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
