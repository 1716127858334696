//! Access units of a stream of a motion: bytes by level of articulation and by region.

use crate::table::{Table, counted};
use crate::{files, open};
use articula::inspect::{AccessUnitsInspection, StreamShare, inspect_access_units};
use articula::stream::StreamLimits;
use std::path::Path;

/// Reads the file again and lists its access units, in an MP4 file those of the first stream of a body.
pub(super) fn of(path: &Path) -> anyhow::Result<AccessUnitsInspection> {
    let stream = open::stream(path, false)?;
    Ok(inspect_access_units(
        &stream.bytes,
        &files::shown(path),
        &StreamLimits::default(),
    )?)
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
