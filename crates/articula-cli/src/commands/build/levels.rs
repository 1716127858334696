//! What `build` says of mesh levels.

use crate::table::{Table, counted, millimetres};
use articula::CodedMeshLevels;
use serde::Serialize;

/// One level, as scripts read it. Errors are null for a level without triangles.
#[derive(Debug, Serialize)]
pub(crate) struct Level {
    /// Its number: 0 is the finest.
    level: usize,
    pub(crate) triangles: u64,
    pub(crate) vertices: u64,
    /// Greatest distance of the original from it at rest.
    pub(crate) error_rest_m: Option<f32>,
    /// The same over poses that it was not made by.
    pub(crate) error_motion_m: Option<f32>,
    error_motion_p99_m: Option<f32>,
    error_motion_mean_m: Option<f32>,
    /// Bytes of this level alone, coded for the wire.
    pub(crate) bytes_direct: usize,
    /// Bytes of what it adds to the next coarser level on the wire.
    pub(crate) bytes_added: usize,
    /// Index ranges that show it, over all parts.
    ranges: usize,
}

/// Bytes of all levels together.
#[derive(Debug, Serialize)]
pub(crate) struct Bytes {
    /// The whole stream: its head and what every level adds.
    pub(crate) clustered: usize,
    /// The finest level, coded alone.
    pub(crate) finest_alone: usize,
    /// All levels, each coded alone.
    pub(crate) discrete_sum: usize,
    /// What the meshes take in the asset, not coded: vertices once, triangles of all levels.
    pub(crate) store: usize,
}

/// The levels, the finest first.
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

/// What they weigh; `store` is what the document says of its meshes.
pub(crate) fn bytes(made: &CodedMeshLevels, store: usize) -> Bytes {
    let direct = &made.stream.direct;
    Bytes {
        clustered: made.stream.bytes.len(),
        finest_alone: direct.first().copied().unwrap_or(0),
        discrete_sum: direct.iter().sum(),
        store,
    }
}

/// How many poses errors in motion were measured on.
pub(crate) fn poses_measured(made: &CodedMeshLevels) -> usize {
    let on = made.levels.measured;
    on.clips + on.bends + on.morphs
}

/// What errors in motion were measured on, in words.
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
        true => "the rest pose alone, since no other is left to measure on".to_owned(),
        false => format!("{} that the levels were not made by", parts.join(" and ")),
    }
}

/// The same for people.
pub(crate) fn text(levels: &[Level], bytes: &Bytes, measured: &str) -> String {
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "off at rest",
        "in motion",
        "99 %",
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
        "{}errors: the greatest distance of the original surface, in motion over {measured}\n\
         on the wire: {} bytes for all levels, {} for the finest alone, {} for each level alone; in the asset {}\n",
        table.text(),
        bytes.clustered,
        bytes.finest_alone,
        bytes.discrete_sum,
        bytes.store
    )
}
