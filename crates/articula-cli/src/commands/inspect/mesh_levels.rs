//! The mesh levels that a file brings, for people.

use crate::table::{Table, millimetres};
use articula::inspect::Levels;

/// The same for people.
pub(super) fn table(found: &Levels) -> Table {
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "off at rest",
        "in motion",
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
