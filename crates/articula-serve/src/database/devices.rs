//! Devices that were benchmarked, and the last runs of each.

use rusqlite::{Connection, params};

/// A device and the reports of its runs, the oldest first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DeviceRows {
    /// BLAKE3 of the description.
    pub(crate) device: String,
    pub(crate) reports: Vec<String>,
}

/// The reports of a device, the oldest first.
pub(crate) fn reports(db: &Connection, device: &str) -> rusqlite::Result<Vec<String>> {
    let select = "SELECT report FROM device_runs WHERE device = ? ORDER BY run";
    let mut rows = db.prepare(select)?;
    rows.query_map([device], |row| row.get(0))?.collect()
}

/// All devices, by their hashes.
pub(crate) fn all(db: &Connection) -> rusqlite::Result<Vec<DeviceRows>> {
    let mut rows = db.prepare("SELECT device FROM devices ORDER BY device")?;
    let devices = rows.query_map([], |row| row.get(0))?;
    devices
        .map(|device| {
            let device: String = device?;
            let reports = reports(db, &device)?;
            Ok(DeviceRows { device, reports })
        })
        .collect()
}

/// Adds a run to a device and removes the oldest of more than `most_runs`; `false` for a new device if there are
/// `most_devices`.
pub(crate) fn put(
    db: &Connection,
    (device, description): (&str, &str),
    report: &str,
    (most_runs, most_devices): (usize, usize),
) -> rusqlite::Result<bool> {
    let known: usize = db.query_row(
        "SELECT count(*) FROM devices WHERE device != ?",
        [device],
        |row| row.get(0),
    )?;
    let insert = "INSERT INTO devices SELECT ?1, ?2 WHERE ?3 ON CONFLICT DO NOTHING";
    let is_new = params![device, description, known < most_devices];
    db.execute(insert, is_new)?;
    let insert = "INSERT INTO device_runs SELECT ?1, ifnull(max(run), 0) + 1, ?2 FROM device_runs \
         WHERE device = ?1 HAVING EXISTS (SELECT 1 FROM devices WHERE device = ?1)";
    let added = db.execute(insert, params![device, report])?;
    let surplus = "DELETE FROM device_runs WHERE device = ?1 AND run <= \
         (SELECT max(run) FROM device_runs WHERE device = ?1) - ?2";
    db.execute(surplus, params![device, most_runs])?;
    Ok(added > 0)
}
