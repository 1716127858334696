//! The mesh levels of a file as a text table.

use crate::table::{Table, millimetres};
use articula::inspect::MeshLevelsInspection;

/// The table of levels.
pub(super) fn table(found: &MeshLevelsInspection) -> Table {
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "error at rest",
        "error in motion",
        "ranges",
    ]);
    for level in &found.levels {
        let [rest, motion] = [level.error_rest_m, level.error_motion_m].map(millimetres);
        table.row([
            level.level.to_string(),
            level.triangles.to_string(),
            level.vertices.to_string(),
            rest,
            motion,
            level.ranges.to_string(),
        ]);
    }
    table
}
