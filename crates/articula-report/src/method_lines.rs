//! Rows of evaluated methods as lines of contact sheets.

use crate::motion_sheet::MotionLine;
use articula::evaluate::{MethodRow, MethodTable};

/// Returns one line of a contact sheet for each distance of a table.
pub fn lines_by_distance(table: &MethodTable) -> Vec<MotionLine<'_>> {
    let line = |row: &MethodRow| line(table, format!("{} m", row.distance_m), row);
    table.rows.iter().map(line).collect()
}

/// Returns one line of a contact sheet for each method, all at the distance of an index.
pub fn lines_by_method(tables: &[MethodTable], distance: usize) -> Vec<MotionLine<'_>> {
    let rows = tables
        .iter()
        .filter_map(|t| Some((t, t.rows.get(distance)?)));
    rows.map(|(t, row)| line(t, t.method.label(), row))
        .collect()
}

fn line<'a>(table: &'a MethodTable, label: String, row: &MethodRow) -> MotionLine<'a> {
    MotionLine {
        label,
        method: &table.method.method,
        parameter: row.parameter,
        distance_m: row.distance_m,
    }
}
