//! Devices made of one machine: frame rates of tests and applications, and which tests predict an
//! application (the thesis' 3.2.2 and 6.1.3).
//!
//! Source: table 6.5 and figure 6.8 of the thesis; `docs/methods/adaptation.md` part 8. One module
//! measures, one predicts, one writes the page.

mod measure;
mod page;
mod predict;

use super::Run;
use anyhow::Result;
use clap::Args;
use measure::{DEVICES, Device, Making, Programs, Rate};
use std::path::{Path, PathBuf};

/// Programs that are measured.
#[derive(Debug, Args)]
pub(crate) struct Builds {
    /// Folder of the builds, which the page names [default: target]
    #[arg(long, value_name = "DIR")]
    builds: Option<PathBuf>,
}

impl Builds {
    /// The folder.
    pub(crate) fn folder(&self) -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        self.builds.clone().unwrap_or_else(|| root.join("target"))
    }
}

/// An application with the grades of the mannequin that are its tests.
const TESTS: [(&str, [usize; 3]); 3] = [
    ("body", [4, 7, 10]),
    ("face", [4, 7, 10]),
    ("crowd", [4, 7, 10]),
];

/// Something that is played with a character of its own.
struct Application {
    name: &'static str,
    kind: &'static str,
    grade: usize,
    file: &'static str,
}

const APPLICATIONS: [Application; 3] = [
    Application {
        name: "pab, drawn at 480x640",
        kind: "body",
        grade: 5,
        file: "glb/pab_arnaud.glb",
    },
    Application {
        name: "ICT head, drawn at 480x480",
        kind: "face",
        grade: 5,
        file: "glb/ict_head_talk_554.glb",
    },
    Application {
        name: "4000 robots, posed",
        kind: "crowd",
        grade: 6,
        file: "glb/RobotExpressive.glb",
    },
];

/// The rates of one device.
struct Measured {
    device: Device,
    /// Of the tests, in their order.
    tests: Vec<Rate>,
    applications: Vec<Rate>,
}

/// Runs the table and writes it. A device that cannot be made is named with the reason.
pub(crate) fn write(run: &Run, builds: &Builds) -> Result<()> {
    let programs = Programs(builds.folder());
    let (mut measured, mut missing) = (Vec::new(), Vec::new());
    for device in DEVICES {
        if run.small && !matches!(device.making, Making::Flags(_)) {
            continue;
        }
        eprintln!("devices: {}", device.name);
        match measure(run, &programs, device) {
            Ok(rates) => measured.push(rates),
            Err(why) => missing.push((device.name, format!("{why:#}"))),
        }
    }
    let page = page::page(&measured, &missing)?;
    run.save("devices", &page, &page::csv(&measured)?)?;
    run.save_text("devices", "svg", &page::plot(&measured))
}

fn measure(run: &Run, programs: &Programs, device: Device) -> Result<Measured> {
    let mut tests = Vec::new();
    for (application, grades) in TESTS {
        tests.extend(programs.rates(&device, application, &grades, None)?);
    }
    let mut applications = Vec::new();
    for application in APPLICATIONS {
        let (file, grades) = (run.data.join(application.file), [application.grade]);
        applications.extend(programs.rates(&device, application.kind, &grades, Some(&file))?);
    }
    Ok(Measured {
        device,
        tests,
        applications,
    })
}

/// Names of the tests.
fn test_names() -> Vec<String> {
    let of = |(application, grades): &(&str, [usize; 3])| {
        grades.map(|grade| format!("{application} {grade}"))
    };
    TESTS.iter().flat_map(of).collect()
}

/// Logarithms of a rate of every device.
fn logs(measured: &[Measured], of: impl Fn(&Measured) -> f64) -> Vec<f64> {
    measured.iter().map(|m| of(m).ln()).collect()
}
