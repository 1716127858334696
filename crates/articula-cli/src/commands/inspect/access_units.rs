//! Access units of a stream of a motion: bytes by level of articulation and by region.

use crate::files;
use crate::table::{Table, counted};
use articula::inspect::{AccessUnitsInspection, StreamShare, inspect_access_units};
use articula_stream::StreamLimits;
use std::path::Path;

/// Reads the file again and lists its access units.
pub(super) fn of(path: &Path) -> anyhow::Result<AccessUnitsInspection> {
    let limits = StreamLimits::default();
    let bytes = files::read(path, limits.bytes)?;
    Ok(inspect_access_units(&bytes, &files::shown(path), &limits)?)
}

/// Formats the tables; `items` is what is counted.
pub(super) fn text(found: &AccessUnitsInspection, items: &str) -> String {
    let shares = |of: &str, rows: &[StreamShare]| {
        let mut table = Table::new(&[of, items, "bytes"]);
        for row in rows {
            table.row([
                row.name.clone(),
                row.items.to_string(),
                format!("{:.0}", row.bytes),
            ]);
        }
        table.text()
    };
    format!(
        "\nstream {}: {}, {:.0} bytes beside the {items}\n{}{}",
        found.profile,
        counted(found.access_units, "access unit", "access units"),
        found.bytes_common,
        shares("LoA", &found.loa),
        shares("region", &found.regions),
    )
}
