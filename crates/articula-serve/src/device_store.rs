//! Results of benchmarks by what the device is, as files: the last runs of each, one a line.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::error::ServeError;
use crate::objects::{ObjectName, read, write};
use articula::device::{DeviceDescription, DeviceReport};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Runs that are kept of a device; of more the oldest go.
const MOST_RUNS: usize = 31;
/// Most devices.
pub(crate) const MOST_DEVICES: usize = 1000;
/// Extension of the files: JSON, one report a line.
const EXTENSION: &str = "jsonl";

/// All that is known of a device.
#[derive(Debug)]
pub(crate) struct KnownDevice {
    pub(crate) name: ObjectName,
    /// Its runs as one.
    pub(crate) report: DeviceReport,
    pub(crate) runs: usize,
}

/// A folder of results.
#[derive(Debug)]
pub(crate) struct DeviceStore {
    folder: PathBuf,
}

impl DeviceStore {
    pub(crate) fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Adds a run to those of its device; `None` if there are too many devices. Not for two threads at
    /// once.
    pub(crate) fn put(&self, run: DeviceReport) -> Result<Option<KnownDevice>, ServeError> {
        let name = name_of(&run.device);
        let mut runs = self.runs(&name)?;
        if runs.is_empty() && self.names()?.len() >= MOST_DEVICES {
            return Ok(None);
        }
        runs.push(run);
        let surplus = runs.len().saturating_sub(MOST_RUNS);
        runs.drain(..surplus);
        let mut text = Vec::new();
        for run in &runs {
            // Numbers and texts cannot fail.
            text.extend(serde_json::to_vec(run).unwrap_or_default());
            text.push(b'\n');
        }
        write(&self.path(&name), &text)?;
        Ok(known(name, &runs))
    }

    /// A device by its name.
    pub(crate) fn get(&self, name: &ObjectName) -> Result<Option<KnownDevice>, ServeError> {
        Ok(known(name.clone(), &self.runs(name)?))
    }

    /// All devices, by name.
    pub(crate) fn all(&self) -> Result<Vec<KnownDevice>, ServeError> {
        let all = self.names()?.into_iter().take(MOST_DEVICES);
        let all = all.map(|name| self.get(&name));
        Ok(all
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .flatten()
            .collect())
    }

    /// The runs of a device, the oldest first; lines that are no reports are left out.
    fn runs(&self, name: &ObjectName) -> Result<Vec<DeviceReport>, ServeError> {
        let text = read(&self.path(name))?.unwrap_or_default();
        let lines = text.split(|byte| *byte == b'\n');
        Ok(lines
            .filter_map(|line| DeviceReport::read(line).ok())
            .collect())
    }

    fn names(&self) -> Result<Vec<ObjectName>, ServeError> {
        let fault = |error: std::io::Error| ServeError::store(&self.folder, &error);
        let entries = match std::fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(fault(error)),
        };
        let mut names = Vec::new();
        for entry in entries {
            let path = entry.map_err(fault)?.path();
            let is_ours = path.extension().is_some_and(|e| e == EXTENSION);
            let stem = path.file_stem().and_then(|stem| stem.to_str());
            names.extend(stem.filter(|_| is_ours).and_then(ObjectName::parse));
        }
        names.sort();
        Ok(names)
    }

    fn path(&self, name: &ObjectName) -> PathBuf {
        Path::new(&self.folder).join(format!("{}.{EXTENSION}", name.as_str()))
    }
}

fn known(name: ObjectName, runs: &[DeviceReport]) -> Option<KnownDevice> {
    Some(KnownDevice {
        name,
        report: DeviceReport::combined(runs)?,
        runs: runs.len(),
    })
}

/// The hash of a description.
fn name_of(device: &DeviceDescription) -> ObjectName {
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

    #[test]
    fn a_wrong_run_among_several_changes_little_and_old_runs_go() {
        let folder = tempfile::tempdir().unwrap();
        let store = DeviceStore::new(folder.path().join("devices"));
        assert!(store.all().unwrap().is_empty(), "there is no folder yet");
        for value in [30.0, 32.0, 1e6] {
            store.put(report("a", value)).unwrap();
        }
        let known = store.put(report("a", 31.0)).unwrap().unwrap();
        assert_eq!((known.runs, fps(&known)), (4, 31.5));
        for _ in 0..40 {
            store.put(report("a", 50.0)).unwrap();
        }
        let known = store.get(&known.name).unwrap().unwrap();
        assert_eq!((known.runs, fps(&known)), (MOST_RUNS, 50.0));
        store.put(report("b", 1.0)).unwrap();
        assert_eq!(store.all().unwrap().len(), 2);
    }

    #[test]
    fn damaged_lines_and_foreign_files_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let store = DeviceStore::new(folder.path().to_path_buf());
        let known = store.put(report("a", 30.0)).unwrap().unwrap();
        let path = store.path(&known.name);
        let mut text = std::fs::read(&path).unwrap();
        text.extend(b"{\"device\": 1}\n\xff\xfe\n");
        std::fs::write(&path, text).unwrap();
        std::fs::write(folder.path().join("readme.jsonl"), b"x").unwrap();
        let all = store.all().unwrap();
        assert_eq!((all.len(), all[0].runs), (1, 1));
    }
}
