//! How fast a device is, as a flag.

use crate::arguments::number;
use crate::files;
use anyhow::Context as _;
use articula::device::DeviceReport;
use articula::stream::DescriptionLimits;
use articula::stream::description::{Benchmark, Context};
use std::path::{Path, PathBuf};

/// Name of the benchmark of a score without a report.
const DEVICE: &str = "device";

/// How fast a device is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum DeviceScore {
    /// In percent of the reference machine.
    Percent(f64),
    /// As a benchmark has reported it.
    Report(PathBuf),
}

/// Parses a score or the name of a report.
pub(crate) fn device_score(text: &str) -> Result<DeviceScore, String> {
    if text.to_lowercase().ends_with(".json") {
        return Ok(DeviceScore::Report(text.into()));
    }
    let what = "a number from 0 on, or a report (.json) of articula bench device";
    number(text, |n| n >= 0.0, what).map(DeviceScore::Percent)
}

impl DeviceScore {
    /// The file of the report.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::Report(path) => Some(path),
            Self::Percent(_) => None,
        }
    }

    /// Puts it in the place of the benchmarks of a context.
    pub(crate) fn add_to(&self, context: &mut Context) -> anyhow::Result<()> {
        match self {
            Self::Percent(score) => {
                context.terminal.benchmarks = vec![Benchmark {
                    name: DEVICE.to_owned(),
                    score: Some(*score),
                    ..Benchmark::default()
                }];
            }
            Self::Report(path) => {
                let bytes = files::read(path, DescriptionLimits::default().bytes)?;
                let report = DeviceReport::read(&bytes).with_context(|| files::shown(path))?;
                context.terminal.benchmarks.clear();
                report.add_to(context);
            }
        }
        Ok(())
    }
}
