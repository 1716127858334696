//! Results of benchmarks by what the device is: the last runs of each, in the catalogue.

use crate::database::Database;
use crate::database::devices::{self, DeviceRows};
use crate::error::ServeError;
use crate::objects::ObjectName;
use articula::device::{DeviceDescription, DeviceReport};
use rusqlite::Connection;

/// Runs that are kept of a device; of more the oldest go.
const MOST_RUNS: usize = 31;
/// Most devices.
pub(crate) const MOST_DEVICES: usize = 1000;

/// All that is known of a device.
#[derive(Debug)]
pub(crate) struct KnownDevice {
    pub(crate) name: ObjectName,
    /// Its runs as one.
    pub(crate) report: DeviceReport,
    pub(crate) runs: usize,
}

/// Adds a run to those of its device; `None` if there are too many devices.
pub(crate) fn put(
    database: &Database,
    run: &DeviceReport,
) -> Result<Option<KnownDevice>, ServeError> {
    let rows = database.write(|db| match put_row(db, run)? {
        Some(device) => Ok(Some(DeviceRows {
            reports: devices::reports(db, &device)?,
            device,
        })),
        None => Ok(None),
    })?;
    Ok(rows.and_then(known))
}

/// The same as one of several changes; returns the hash of the device.
pub(crate) fn put_row(db: &Connection, run: &DeviceReport) -> rusqlite::Result<Option<String>> {
    // Numbers and texts cannot fail.
    let description = serde_json::to_string(&run.device).unwrap_or_default();
    let report = serde_json::to_string(run).unwrap_or_default();
    let device = name_of(&run.device);
    let of = (device.as_str(), &*description);
    let is_put = devices::put(db, of, &report, (MOST_RUNS, MOST_DEVICES))?;
    Ok(is_put.then(|| device.as_str().to_owned()))
}

/// A device by its name.
pub(crate) fn get(
    database: &Database,
    name: &ObjectName,
) -> Result<Option<KnownDevice>, ServeError> {
    let reports = database.read(|db| devices::reports(db, name.as_str()))?;
    Ok(known(DeviceRows {
        device: name.as_str().to_owned(),
        reports,
    }))
}

/// All devices, by name.
pub(crate) fn all(database: &Database) -> Result<Vec<KnownDevice>, ServeError> {
    let all = database.read(devices::all)?;
    Ok(all.into_iter().filter_map(known).collect())
}

/// The runs of a device as one; those that are no reports are left out.
fn known(rows: DeviceRows) -> Option<KnownDevice> {
    let reports = rows.reports.iter();
    let runs: Vec<DeviceReport> = reports
        .filter_map(|text| DeviceReport::read(text.as_bytes()).ok())
        .collect();
    Some(KnownDevice {
        name: ObjectName::parse(&rows.device)?,
        report: DeviceReport::combined(&runs)?,
        runs: runs.len(),
    })
}

/// The hash of a description.
pub(crate) fn name_of(device: &DeviceDescription) -> ObjectName {
    // Numbers and texts cannot fail.
    ObjectName::of(&serde_json::to_vec(device).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(cpu: &str, fps: f64) -> DeviceReport {
        let json = serde_json::json!({
            "device": {"cpu": cpu, "cores": 2, "os": "linux", "arch": "x86_64", "program": "1",
                "backend": "avx2", "threads": 1},
            "results": [{"application": "body", "grades": [{"grade": 5, "fps": fps, "runs": 6}]}],
        });
        DeviceReport::read(json.to_string().as_bytes()).unwrap()
    }

    fn fps(known: &KnownDevice) -> f64 {
        known.report.results[0].grades[0].fps
    }

    fn opened(folder: &std::path::Path) -> Database {
        let place = folder.join("catalogue.sqlite3");
        Database::open(&place, true).unwrap().database
    }

    #[test]
    fn a_wrong_run_among_several_changes_little_and_old_runs_go() {
        let folder = tempfile::tempdir().unwrap();
        let store = opened(folder.path());
        assert!(all(&store).unwrap().is_empty());
        for value in [30.0, 32.0, 1e6] {
            put(&store, &report("a", value)).unwrap();
        }
        let known = put(&store, &report("a", 31.0)).unwrap().unwrap();
        assert_eq!((known.runs, fps(&known)), (4, 31.5));
        for _ in 0..40 {
            put(&store, &report("a", 50.0)).unwrap();
        }
        let known = get(&store, &known.name).unwrap().unwrap();
        assert_eq!((known.runs, fps(&known)), (MOST_RUNS, 50.0));
        put(&store, &report("b", 1.0)).unwrap();
        assert_eq!(all(&store).unwrap().len(), 2);
    }

    #[test]
    fn rows_that_are_no_reports_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let store = opened(folder.path());
        let device = put(&store, &report("a", 30.0)).unwrap().unwrap().name;
        let wrong = |device: &str, text: &str| {
            let of = (device, "{}");
            let put = store.write(|db| devices::put(db, of, text, (MOST_RUNS, MOST_DEVICES)));
            assert!(put.unwrap());
        };
        wrong(device.as_str(), "{\"device\": 1}");
        wrong(&"0".repeat(64), "no report");
        let all = all(&store).unwrap();
        assert_eq!((all.len(), all[0].runs), (1, 1));
    }
}
